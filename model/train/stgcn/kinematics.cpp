#include "model/train/stgcn/kinematics.h"

#include <vector>

namespace styled::train::st_gcn {
namespace {

using body::kJointCount;
using stgcn::kChannels;
using stgcn::kPositionChannels;
using stgcn::kRotationChannels;
using torch::Tensor;

Tensor ToTensor(const stgcn::Features& features, const torch::Device& device) {
  return torch::from_blob(const_cast<float*>(features.data()), {kJointCount, kChannels})
      .clone()
      .to(device);
}

}  // namespace

Kinematics::Kinematics(const Statistics& statistics, const torch::Device& device)
    : mean_(ToTensor(statistics.mean, device)), deviation_(ToTensor(statistics.deviation, device)) {
  std::vector<int64_t> parents;
  Tensor offsets = torch::zeros({kJointCount, 3}),
         ancestors = torch::zeros({kJointCount, kJointCount});
  for (int joint = 0; joint < kJointCount; ++joint) {
    const body::JointRow& row = body::kHumanoid[joint];
    parents.push_back(std::max(row.parent, 0));
    ancestors[joint][joint] = 1;
    if (row.parent < 0) continue;
    ancestors[joint] = ancestors[joint] + ancestors[row.parent];
    offsets[joint] = torch::tensor({row.x_m, row.y_m, row.z_m});
  }
  parents_ = torch::tensor(parents, torch::kInt64).to(device);
  offsets_m_ = offsets.to(device);
  ancestors_ = ancestors.to(device);
  vertical_ = torch::tensor({0.0F, 1.0F, 0.0F}).to(device);
}

Tensor Kinematics::Positions_m(const Tensor& window) const {
  return window.narrow(-1, 0, kPositionChannels) * deviation_.narrow(-1, 0, kPositionChannels) +
         mean_.narrow(-1, 0, kPositionChannels);
}

// Rotations are relative to the heading frame, so a joint's place is the sum of its ancestors'
// offsets, each turned by its parent's rotation: no product along the chain.
Tensor Kinematics::Published(const Tensor& window) const {
  const Tensor raw = window * deviation_ + mean_;
  const Tensor q = torch::nn::functional::normalize(
      raw.narrow(-1, kPositionChannels, kRotationChannels),
      torch::nn::functional::NormalizeFuncOptions().dim(-1).eps(1e-6));
  const Tensor turning = q.index_select(-2, parents_);
  const Tensor u = turning.narrow(-1, 0, 3), w = turning.narrow(-1, 3, 1);
  // v turned by (u, w): v + 2 w (u × v) + 2 u × (u × v)
  const Tensor twice = 2.0 * torch::cross(u, offsets_m_.expand_as(u), -1);
  const Tensor bones = offsets_m_ + w * twice + torch::cross(u, twice, -1);
  const Tensor hips = raw.narrow(-2, body::kHips, 1).narrow(-1, 0, kPositionChannels) * vertical_;
  const Tensor positions = torch::matmul(ancestors_, bones) + hips;
  return (torch::cat({positions, q}, -1) - mean_) / deviation_;
}

}  // namespace styled::train::st_gcn

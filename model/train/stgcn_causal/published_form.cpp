#include "model/train/stgcn_causal/published_form.h"

#include <algorithm>
#include <cmath>

#include "model/net/stgcn/features.h"
#include "model/net/stgcn_causal/stylizer.h"
#include "model/train/geometry.h"

namespace styled::train::st_gcn_causal {
namespace {

using body::kJointCount;
using stgcn::kPositionChannels;
using stgcn::kRotationChannels;
using torch::Tensor;

constexpr int kHeight = 1;  // the channel of a position

// The pose that a change of style is measured from; half-way, the normalized mean is the slerp.
static_assert(stgcn_causal::kTowardInput == 0.5F);
Tensor HalfWay(const Tensor& a, const Tensor& b) {
  const Tensor nearer = torch::where((a * b).sum(-1, true) < 0, -b, b);
  return torch::nn::functional::normalize(
      a + nearer, torch::nn::functional::NormalizeFuncOptions().dim(-1).eps(1e-6));
}

// The values `frames` later in [B, T, ...], interpolated between two frames; the last frame stays.
Tensor AtLater(const Tensor& sequence, double frames) {
  const int64_t last = sequence.size(1) - 1;
  const auto whole = static_cast<int64_t>(std::floor(frames));
  const auto from = [&](int64_t lead) {
    const Tensor at = (torch::arange(last + 1) + lead).clamp_max(last);
    return sequence.index_select(1, at);
  };
  return torch::lerp(from(whole), from(whole + 1), frames - static_cast<double>(whole));
}

// Rotations near the identity, their angle times `gain`.
Tensor Power(const Tensor& q, double gain) {
  const Tensor shortest = torch::where(q.narrow(-1, 3, 1) < 0, -q, q);
  const Tensor axis = shortest.narrow(-1, 0, 3);
  const Tensor sine = axis.norm(2, -1, true).clamp_min(1e-9);
  const Tensor half = gain * torch::atan2(sine, shortest.narrow(-1, 3, 1));
  return torch::cat({axis / sine * half.sin(), half.cos()}, -1);
}

}  // namespace

PublishedForm::PublishedForm(const st_gcn::Statistics& statistics)
    : kinematics_(statistics, torch::kCPU) {
  std::vector<int64_t> parents, order(kJointCount), depth_of(kJointCount), place_of(kJointCount);
  std::vector<std::vector<int64_t>> joints_at;
  for (int joint = 0; joint < kJointCount; ++joint) {
    const int parent = body::kHumanoid[static_cast<std::size_t>(joint)].parent;
    parents.push_back(std::max(parent, 0));
    const auto at = static_cast<std::size_t>(joint);
    depth_of[at] = parent < 0 ? 0 : depth_of[static_cast<std::size_t>(parent)] + 1;
    const auto depth = static_cast<std::size_t>(depth_of[at]);
    joints_at.resize(std::max(joints_at.size(), depth + 1));
    place_of[at] = static_cast<int64_t>(joints_at[depth].size());
    joints_at[depth].push_back(joint);
  }
  int64_t place = 0;
  for (const std::vector<int64_t>& joints : joints_at) {
    std::vector<int64_t> above;
    for (const int64_t joint : joints) {
      above.push_back(place_of[static_cast<std::size_t>(parents[static_cast<std::size_t>(joint)])]);
      order[static_cast<std::size_t>(joint)] = place++;
    }
    depths_.push_back({torch::tensor(joints), torch::tensor(above)});
  }
  parents_ = torch::tensor(parents);
  order_ = torch::tensor(order);
}

PublishedForm::Basis PublishedForm::Basis::Select(const Tensor& samples) const {
  return {rotations.index_select(0, samples), hips_m.index_select(0, samples)};
}

// Of features that are not standardized: unit rotations relative to the parent; the hips' to the
// heading.
Tensor PublishedForm::LocalRotations(const Tensor& raw) const {
  const Tensor q = torch::nn::functional::normalize(
      raw.narrow(-1, kPositionChannels, kRotationChannels),
      torch::nn::functional::NormalizeFuncOptions().dim(-1).eps(1e-6));
  const Tensor below = q.narrow(-2, 1, kJointCount - 1);
  const Tensor above = q.index_select(-2, parents_.narrow(0, 1, kJointCount - 1));
  return torch::cat({q.narrow(-2, 0, 1), Multiply(Conjugate(above), below)}, -2);
}

Tensor PublishedForm::GlobalRotations(const Tensor& local) const {
  std::vector<Tensor> depths;
  for (const Depth& depth : depths_) {
    const Tensor own = local.index_select(-2, depth.joints);
    depths.push_back(depths.empty() ? own
                                    : Multiply(depths.back().index_select(-2, depth.parents), own));
  }
  return torch::cat(depths, -2).index_select(-2, order_);
}

Tensor PublishedForm::OnHemisphere(const Tensor& global) const {
  const Tensor middle = kinematics_.mean().narrow(-1, kPositionChannels, kRotationChannels);
  const Tensor negative = (global * middle).sum(-1, true) < 0;
  return global * torch::where(negative, -1.0, 1.0).to(torch::kFloat32);
}

Tensor PublishedForm::Later(const Tensor& reconstruction, const Tensor& styled, double frames,
                            double gain) const {
  const Tensor rec = reconstruction * kinematics_.deviation() + kinematics_.mean();
  const Tensor sty = styled * kinematics_.deviation() + kinematics_.mean();
  const Tensor own = LocalRotations(rec);
  const Tensor change = Multiply(Conjugate(own), LocalRotations(sty));
  const Tensor shortest = torch::where(change.narrow(-1, 3, 1) < 0, -change, change);
  const Tensor later = torch::nn::functional::normalize(
      AtLater(shortest, frames), torch::nn::functional::NormalizeFuncOptions().dim(-1).eps(1e-6));
  const Tensor rotations = OnHemisphere(GlobalRotations(Multiply(own, Power(later, gain))));
  const Tensor positions = rec.narrow(-1, 0, kPositionChannels) +
                           gain * AtLater((sty - rec).narrow(-1, 0, kPositionChannels), frames);
  return (torch::cat({positions, rotations}, -1) - kinematics_.mean()) / kinematics_.deviation();
}

PublishedForm::Basis PublishedForm::BasisOf(const Tensor& window,
                                            const Tensor& reconstruction) const {
  const Tensor in = window * kinematics_.deviation() + kinematics_.mean();
  const Tensor rec = reconstruction * kinematics_.deviation() + kinematics_.mean();
  const auto height = [](const Tensor& raw) {
    return raw.select(-2, body::kHips).select(-1, kHeight);
  };
  const Tensor own = LocalRotations(in);
  return {Multiply(own, Conjugate(HalfWay(LocalRotations(rec), own))), height(in) - height(rec)};
}

Tensor PublishedForm::operator()(const Basis& basis, const Tensor& styled) const {
  const Tensor raw = styled * kinematics_.deviation() + kinematics_.mean();
  const Tensor q = GlobalRotations(Multiply(basis.rotations, LocalRotations(raw)));
  // Only the hips' height is read of these positions.
  const Tensor height_m = basis.hips_m + raw.select(-2, body::kHips).select(-1, kHeight);
  const Tensor positions =
      height_m.unsqueeze(-1).unsqueeze(-1).expand({-1, -1, kJointCount, kPositionChannels});
  const Tensor pose = torch::cat({positions, OnHemisphere(q)}, -1);
  return kinematics_.Published((pose - kinematics_.mean()) / kinematics_.deviation());
}

}  // namespace styled::train::st_gcn_causal

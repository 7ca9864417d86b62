// A learner's part of a checkpoint.
#include "model/train/stgcn/learner.h"

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

void RestoreFlat(const std::string& name, const Checkpoint& checkpoint, Parameters& parameters) {
  const Tensor& flat = checkpoint.tensors.at(name);
  TORCH_CHECK(flat.sizes() == parameters.flat().sizes(), "is of another width or other styles");
  parameters.flat().copy_(flat);
}

}  // namespace

void Learner::Save(Checkpoint& checkpoint) const {
  auto& t = checkpoint.tensors;
  t["mean"] = kinematics_.mean();
  t["deviation"] = kinematics_.deviation();
  for (const auto& [name, parameters] : networks_.parts()) {
    t[name] = parameters->flat();
  }
  for (const auto& [name, parameters] : average_.parts()) {
    t[std::string("average.") + name] = parameters->flat();
  }
  t["critic"] = critic_.parameters.flat();
  SaveAdam("generator", generator_adam_, checkpoint);
  SaveAdam("encoder", encoder_adam_, checkpoint);
  SaveAdam("mapping", mapping_adam_, checkpoint);
  SaveAdam("critic", critic_adam_, checkpoint);
  t["diversity"] = torch::stack({diversity_[0].weight(), diversity_[1].weight()});
  t["iteration"] = torch::tensor({iteration_}, torch::kInt64);
  checkpoint.strings["sampler"] = batches_.sampler().empty() ? sampler_.Save() : batches_.sampler();
}

Status Learner::Restore(const Checkpoint& checkpoint) {
  const torch::NoGradGuard no_grad;
  try {
    const auto& t = checkpoint.tensors;
    if (!torch::equal(t.at("mean"), kinematics_.mean().cpu()) ||
        !torch::equal(t.at("deviation"), kinematics_.deviation().cpu())) {
      return Status::Error("was made with other data or another heading filter");
    }
    for (const auto& [name, parameters] : networks_.parts()) {
      RestoreFlat(name, checkpoint, *parameters);
    }
    for (const auto& [name, parameters] : average_.parts()) {
      RestoreFlat(std::string("average.") + name, checkpoint, *parameters);
    }
    RestoreFlat("critic", checkpoint, critic_.parameters);
    RestoreAdam("generator", checkpoint, generator_adam_);
    RestoreAdam("encoder", checkpoint, encoder_adam_);
    RestoreAdam("mapping", checkpoint, mapping_adam_);
    RestoreAdam("critic", checkpoint, critic_adam_);
    for (std::size_t turn = 0; turn < diversity_.size(); ++turn) {
      diversity_[turn].Set(t.at("diversity")[static_cast<int64_t>(turn)].item<double>());
    }
    iteration_ = t.at("iteration").item<int64_t>();
    sampler_.Restore(checkpoint.strings.at("sampler"));
  } catch (const std::exception& error) {
    return Status::Error(Reason(error));
  }
  return Status::Ok();
}

}  // namespace styled::train::st_gcn

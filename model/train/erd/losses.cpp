// The losses of the generator and the critic's input.
#include <array>

#include "model/train/erd/learner.h"
#include "model/train/geometry.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

}  // namespace

// The critic's input: standardized positions and velocities, [T, B, 126].
Tensor Learner::Judged(const Tensor& positions, const Tensor& velocities) const {
  const Tensor raw = torch::cat({positions.flatten(2, 3), velocities.flatten(2, 3)}, 2);
  return (raw - mean_.narrow(0, erd::kPositionBegin, kJudgedFeatures)) /
         deviation_.narrow(0, erd::kPositionBegin, kJudgedFeatures);
}

Tensor Learner::Real(const Batch& batch) const {
  return batch.u.narrow(0, 1, frames_ - 1)
      .narrow(2, erd::kPositionBegin, kJudgedFeatures)
      .contiguous();
}

// The mean over windows whose target the critic knows in their content: where a label pair was
// never recorded, "fake" would follow from the labels alone.
Tensor Learner::PairedMean(const Batch& batch, const Tensor& score) const {
  return (score * batch.paired).sum() / batch.paired.sum().clamp_min(1.0);
}

// Eq. 2 and 3, weighted.
Tensor Learner::Reconstruction(const Batch& batch, const Generated& generated) {
  const Tensor rotation =
      SquaredHalfAngle(generated.rec, batch.rotations()).sum(torch::IntArrayRef({0, 2})).mean();
  const Tensor position = (generated.rec_positions - batch.positions()).square().sum(-1).mean();
  const Tensor velocity =
      (generated.rec_velocities - batch.u.narrow(2, erd::kVelocityBegin, erd::kVelocityFeatures))
          .square()
          .mean();
  const Tensor height =
      (generated.rec_height - batch.u.narrow(2, erd::kHipsHeightIndex, 1)).square().mean();
  means_.Add("rec_rad", (rotation / (frames_ * body::kJointCount)).sqrt() * 2.0);
  means_.Add("rec_m", position.sqrt());
  means_.Add("velocity", velocity);
  means_.Add("height", height);
  return config_.w_rotation * rotation + config_.w_position * position +
         config_.w_velocity * velocity + config_.w_height * height;
}

// Eq. 2 and 3, summed as in eq. 8. The head of the hips' height is ours, beside the paper's.
Tensor Learner::SummedReconstruction(const Batch& batch, const Generated& generated) {
  const std::array<int64_t, 2> all_but_batch{0, 2};
  const Tensor rotation =
      SquaredHalfAngle(generated.rec, batch.rotations()).sum(all_but_batch).mean();
  const Tensor position =
      (generated.rec_positions - batch.positions()).square().sum(-1).sum(all_but_batch).mean();
  const Tensor velocities = batch.u.narrow(2, erd::kVelocityBegin, erd::kVelocityFeatures);
  const Tensor off_mps = (generated.rec_velocities - velocities) *
                         deviation_.narrow(0, erd::kVelocityBegin, erd::kVelocityFeatures);
  const Tensor velocity = off_mps.square().sum(all_but_batch).mean();
  const Tensor height =
      (generated.rec_height - batch.u.narrow(2, erd::kHipsHeightIndex, 1)).square().mean();
  const auto terms = static_cast<double>(frames_ * body::kJointCount);
  means_.Add("rec_rad", (rotation / terms).sqrt() * 2.0);
  means_.Add("rec_m", (position / terms).sqrt());
  means_.Add("velocity", velocity);
  means_.Add("height", height);
  return rotation + 0.5 * position + velocity + config_.w_height * height;
}

// The critic's score of transferred windows, whose target is 0 (eq. 5).
Tensor Learner::Adversarial(const Batch& batch, const Generated& generated) {
  const Tensor labels = torch::cat({batch.slots.target_one_hot, batch.content}, 1);
  const Tensor loss = PairedMean(batch, critic_(generated.fake, labels).square());
  means_.Add("adversarial", loss);
  return loss;
}

// Transferred rotations of the judged frames as features, [T - 1, B, 84].
Tensor Learner::OnHemisphere(const Tensor& rotations) const {
  const Tensor mean = mean_.narrow(0, 0, erd::kRotationFeatures).view({body::kJointCount, 4});
  return ToHemisphere(rotations.narrow(0, 1, frames_ - 1), mean).flatten(2, 3);
}

// Eq. 7: the classifier's feature maps before and after the transfer.
Tensor Learner::Perceptual(const Batch& batch, const Generated& generated) const {
  const Tensor rotations =
      (OnHemisphere(generated.rotations) - mean_.narrow(0, 0, erd::kRotationFeatures)) /
      deviation_.narrow(0, 0, erd::kRotationFeatures);
  std::vector<Tensor> before;
  {
    const torch::NoGradGuard no_grad;
    before = classifier_.Maps(batch.u.narrow(0, 1, frames_ - 1).narrow(2, 0, kContentFeatures));
  }
  const std::vector<Tensor> after = classifier_.Maps(torch::cat({rotations, generated.fake}, 2));
  Tensor sum = torch::zeros({}, batch.u.options());
  for (std::size_t i = 0; i < after.size(); ++i) {
    sum = sum + (after[i] - before[i]).square().mean();
  }
  return sum;
}

// The mean effects of each style, in neutral windows that were transferred to it.
Tensor Learner::MomentMatching(const Batch& batch, const Generated& generated) {
  const Tensor mean = mean_.narrow(0, erd::kPositionBegin, erd::kPositionFeatures);
  const Tensor deviation = deviation_.narrow(0, erd::kPositionBegin, erd::kPositionFeatures);
  const Tensor in = batch.features.narrow(0, 1, frames_ - 1).narrow(2, 0, kEffectFeatures);
  const Tensor positions = generated.fake.narrow(2, 0, erd::kPositionFeatures) * deviation + mean;
  const Tensor out = torch::cat({OnHemisphere(generated.rotations), positions}, 2);
  const Tensor loss = moments_.Loss(in, out, batch.slots.target, batch.content.argmax(1),
                                    batch.paired * (1.0 - batch.slots.styled.flatten()));
  means_.Add("moments", moments_.Distance());
  return loss;
}

// The second difference over time of the change of style: reduces jerk of the output.
Tensor Learner::Smoothness(const Generated& generated) {
  const Tensor log_change = LogQuaternion(generated.change);
  const Tensor smooth = log_change.diff(2, 0).square().sum(torch::IntArrayRef({0, 2, 3})).mean();
  means_.Add("smooth", smooth);
  means_.Add("change_rad", log_change.detach().square().sum(-1).sqrt().mean());
  return smooth;
}

Tensor Learner::Teaching(const Batch& batch, const Generated& generated) {
  const Distillation::Distance apart =
      teachers_->Apart(batch, {generated.change, generated.positions, generated.rise_m});
  means_.Add("teacher_rad", (apart.rotation.detach() / (frames_ * body::kJointCount)).sqrt() * 2.0);
  if (generated.positions.defined()) {
    means_.Add("teacher_m", apart.position.detach().sqrt());
    means_.Add("teacher_mps", apart.velocity.detach().sqrt());
  }
  return config_.w_teacher * apart.rotation + config_.w_teacher_position * apart.position +
         config_.w_teacher_velocity * apart.velocity;
}

}  // namespace styled::train::style_erd

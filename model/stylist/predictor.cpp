#include "model/stylist/predictor.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>
#include <utility>

#include "model/body/heading.h"
#include "model/stylist/guard.h"

namespace styled::stylist {
namespace {

using body::kJointCount;
using body::Pose;
using body::Quat;
using body::Vec3;

}  // namespace

Predictor::Predictor(std::shared_ptr<const net::Stylizer> network) : network_(std::move(network)) {
  for (auto& stream : streams_) stream = network_->MakeStream();
}

void Predictor::Adopt(std::shared_ptr<const net::Stylizer> network) noexcept {
  assert(network->SharesStreams(*network_));
  network_ = std::move(network);
}

void Predictor::Restart() noexcept {
  interleaver_.Restart();
  RestartStates();
}

void Predictor::RestartStates() noexcept {
  for (const auto& stream : streams_) network_->Start(*stream);
  stepped_.reset();
  reconstruction_rad_ = 0;
  limb_errors_m_ = {};
}

void Predictor::Carry(Checkpoint& c) noexcept {
  c(interleaver_, stepped_);
  for (std::size_t state = 0; state < streams_.size(); ++state) {
    if (c.reads()) network_->Start(*streams_[state]);
    if (!stepped_.test(state)) continue;
    network_->Carry(*streams_[state], c);
    c(deltas_[state]);
  }
  c(last_styled_, last_heading_rad_, last_input_, has_last_input_, unsound_);
  c.Within(steps_, 0, kMaxStepsPerFrame);
  c(reconstruction_rad_, limb_errors_m_);
}

bool Predictor::Begin(std::int64_t time_ns) noexcept {
  steps_ = 0;
  unsound_ = false;
  return interleaver_.Begin(time_ns, network_->model().rate_hz);
}

void Predictor::Skip() noexcept {
  Interleaver::Tick tick;
  while (interleaver_.Next(tick)) {
  }
  if (any()) RestartStates();
}

void Predictor::End(const Pose& input) noexcept {
  last_input_ = input;
  has_last_input_ = true;
}

bool Predictor::Next(const Pose& input, Step& step) noexcept {
  Interleaver::Tick tick;
  if (!interleaver_.Next(tick)) return false;
  ++steps_;
  const bool exact = tick.share >= 1.0F || !has_last_input_;
  if (!exact) body::Interpolate(last_input_, input, tick.share, step.between);
  step.pose = exact ? &input : &step.between;
  step.state = tick.state;
  return true;
}

net::StepJob Predictor::JobOf(Step& step, const Mixer& mixer) const noexcept {
  return {step.pose,        mixer.input_style(),
          mixer.in_force(), streams_[static_cast<std::size_t>(step.state)].get(),
          &step.out,        mixer.variations(),
          nullptr,          mixer.input_content()};
}

void Predictor::Accept(const Step& step, const Mixer& mixer, const StyleDelta& near) noexcept {
  const net::Prediction& out = step.out;
  if (!IsSound(out)) {
    unsound_ = true;
    return;
  }
  // The hips' rotations of a prediction are relative to the heading: compare the input in that
  // frame.
  const Quat heading_from_world = body::Yaw(-out.heading_rad);
  StyleDelta& delta = deltas_[static_cast<std::size_t>(step.state)];
  std::array<Quat, kJointCount> inputs = step.pose->rotations;
  inputs[body::kHips] = heading_from_world * inputs[body::kHips];
  float error2 = 0;
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    const Quat& reconstruction = out.reconstruction.rotations[joint];
    const Quat& input = inputs[joint];
    delta.col(static_cast<Eigen::Index>(joint)) =
        body::LogNear(reconstruction.conjugate() * out.styled.rotations[joint],
                      near.col(static_cast<Eigen::Index>(joint)));
    // Toes carry no information about a posture, and some rigs' toes turn over.
    const bool toes = joint == body::kLeftToes || joint == body::kRightToes;
    if (!toes) error2 += body::Log(input.conjugate() * reconstruction).squaredNorm();
  }
  delta.col(kRise) << 0, out.styled.hips_height_m - out.reconstruction.hips_height_m, 0;
  // On neutral input a style of weight 0 changes nothing; on styled input it removes that style.
  // Scaled before the low-pass, so that another input style causes no jump.
  if (mixer.input_style() > 0) delta *= mixer.presence();
  stepped_.set(static_cast<std::size_t>(step.state));
  last_styled_ = out.styled.rotations;
  last_heading_rad_ = out.heading_rad;
  limb_errors_m_ = LimbErrors_m(inputs, out.reconstruction.rotations);
  reconstruction_rad_ = std::sqrt(error2 / static_cast<float>(kJointCount - 2));
}

// The mean is a box filter over one period of the network. The states' disagreement makes a ripple
// of that period, which is at the filter's notch.
void Predictor::MeanDelta(StyleDelta& mean) const noexcept {
  mean.setZero();
  int count = 0;
  for (std::size_t state = 0; state < deltas_.size(); ++state) {
    if (!stepped_.test(state)) continue;
    mean += deltas_[state];
    ++count;
  }
  if (count > 0) mean /= static_cast<float>(count);
}

void Predictor::BlendAbsolute(const Pose& input, const Mixer& mixer,
                              StyleDelta& delta) const noexcept {
  const Quat world_from_heading = body::Yaw(last_heading_rad_);
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    Quat styled = last_styled_[joint];
    if (joint == body::kHips) styled = world_from_heading * styled;
    const Vec3 whole = mixer.presence() * body::Log(input.rotations[joint].conjugate() * styled);
    auto column = delta.col(static_cast<Eigen::Index>(joint));
    column += mixer.absolute() * (whole - column);
  }
}

// State i of k is i ticks old.
float Predictor::delay_s() const noexcept {
  const auto k = static_cast<float>(std::max(1, interleaver_.interleaved()));
  return (k - 1) / (2 * k * network_->model().rate_hz);
}

void Predictor::Prefetch() const noexcept {
  constexpr std::size_t kLine = 64;
  const auto used = static_cast<std::size_t>(std::max(1, interleaver_.interleaved()));
  for (std::size_t i = 0; i < used; ++i) {
    const std::span<const std::byte> bytes = streams_[i]->memory();
    for (std::size_t at = 0; at < bytes.size(); at += kLine) __builtin_prefetch(&bytes[at]);
  }
}

}  // namespace styled::stylist

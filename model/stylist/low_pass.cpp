#include "model/stylist/low_pass.h"

#include <cmath>

#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

constexpr float kSineOfPair = 0.8660254F;  // the pair's poles lie at 60 degrees; the cosine is 0.5

}  // namespace

void LowPass::Follow(const StyleDelta& target, double dt_s, float delay_s) noexcept {
  if (delay_s <= 0) {
    first_ = value_ = target;
    rate_.setZero();
    return;
  }
  // The delay of slow changes is 1/w for the real pole plus 2 * 0.5/w for the pair.
  const float w = 2.0F / delay_s;
  const float x = w * static_cast<float>(dt_s);
  // The distance of the real pole's output from the target decays by exp(-x). With the pair's poles
  // at 60 degrees, the pair's forced response to this decay is the decay itself, so its free
  // response is an oscillation about the real pole's output.
  const float left = std::exp(-x);
  const StyleDelta from = first_ - target;
  const StyleDelta offset = value_ - first_;
  const StyleDelta offset_rate = rate_ + w * from;
  const float fall = std::exp(-0.5F * x);
  const float sine = fall * std::sin(kSineOfPair * x) / kSineOfPair;
  const float cosine = fall * std::cos(kSineOfPair * x);
  first_ = target + left * from;
  value_ = first_ + (cosine + 0.5F * sine) * offset + (sine / w) * offset_rate;
  rate_ = (cosine - 0.5F * sine) * offset_rate - (w * sine) * offset - (w * left) * from;
}

void LowPass::SettleAtZero() noexcept {
  const auto below = [](const StyleDelta& of, float most) {
    return of.cwiseAbs().maxCoeff() < most;
  };
  if (!below(value_, tuning::kSettled_rad) || !below(first_, tuning::kSettled_rad) ||
      !below(rate_, tuning::kSettled_rad_s))
    return;
  first_.setZero();
  value_.setZero();
  rate_.setZero();
}

}  // namespace styled::stylist

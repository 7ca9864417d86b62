#include "model/stylist/variation.h"

#include <algorithm>
#include <cmath>

#include "model/base/hash.h"
#include "model/base/smooth.h"

namespace styled::stylist {
namespace {

// 0 .. 1; 1 without a fade.
float Share(double elapsed_s, float duration_s) {
  return duration_s <= 0
             ? 1.0F
             : SmoothStep(static_cast<float>(elapsed_s / static_cast<double>(duration_s)));
}

}  // namespace

void Variation::Carry(Checkpoint& c) noexcept {
  c(from_, point_);
  c.Within(variation_, 0, net::kVariations);
  c(drift_s_, phase_, elapsed_s_, duration_s_, amount_, amount_from_, amount_to_, amount_elapsed_s_,
    amount_duration_s_);
  for (net::VariationWeight& variation : active_) {
    c.Within(variation.variation, 0, net::kVariations);
    c(variation.weight);
  }
  c.Within(count_, 0, active_.size());
  // A knot's number is a whole number of the phase.
  if (!(phase_ >= 0 && phase_ <= kMostKnots)) c.Refuse();
}

void Variation::Aim(const Settings& settings, bool at_once) noexcept {
  const float duration_s = at_once ? 0 : settings.transition_s;
  // The first knots are the variation itself, so that starting causes no jump; stopping does.
  const bool stops = drift_s_ > 0 && settings.drift_s <= 0;
  if (settings.variation != variation_ || stops || at_once) {
    from_ = point_;
    elapsed_s_ = phase_ = 0;
    duration_s_ = duration_s;
    variation_ = settings.variation;
  }
  drift_s_ = settings.drift_s <= 0 ? 0 : std::max(settings.drift_s, tuning::kFastestDrift_s);
  if (settings.vary_amount != amount_to_ || at_once) {
    amount_from_ = amount_;
    amount_to_ = settings.vary_amount;
    amount_elapsed_s_ = 0;
    amount_duration_s_ = duration_s;
  }
}

void Variation::Advance(double dt_s) noexcept {
  dt_s = std::max(0.0, dt_s);
  elapsed_s_ += dt_s;
  amount_elapsed_s_ += dt_s;
  // A drift of almost no time passes more knots than can be numbered.
  if (drift_s_ > 0) {
    phase_ = std::min(phase_ + dt_s / static_cast<double>(drift_s_), kMostKnots);
  }
  amount_ =
      amount_from_ + (amount_to_ - amount_from_) * Share(amount_elapsed_s_, amount_duration_s_);
  const float share = Share(elapsed_s_, duration_s_);
  count_ = 0;
  if (share >= 1 && variation_ == 0 && drift_s_ <= 0) return point_.fill(0);
  for (std::size_t k = 1; k < point_.size(); ++k) point_[k] = (1 - share) * from_[k];
  AddKnots(share);
  for (std::size_t k = 1; k < point_.size(); ++k) {
    const float weight = amount_ * point_[k];
    if (weight > 0) active_[count_++] = {static_cast<std::uint16_t>(k), weight};
  }
}

void Variation::AddKnots(float share) noexcept {
  const double floor = std::floor(phase_);
  const auto number = static_cast<std::int64_t>(floor);
  const auto u = static_cast<float>(phase_ - floor);
  const float v = 1 - u;
  const std::array<float, 4> weights{v * v * v / 6, (4 - 6 * u * u + 3 * u * u * u) / 6,
                                     (4 - 6 * v * v + 3 * v * v * v) / 6, u * u * u / 6};
  for (std::int64_t i = 0; i < 4; ++i) {
    const auto knot = static_cast<std::size_t>(Knot(number - 1 + i));
    if (knot > 0) point_[knot] += share * weights[static_cast<std::size_t>(i)];
  }
}

int Variation::Knot(std::int64_t number) const noexcept {
  if (number <= 1 || drift_s_ <= 0) return variation_;
  Fnv1a hash;
  hash.Number(variation_);
  hash.Number(number);
  return 1 + static_cast<int>(hash.value() % net::kVariations);
}

}  // namespace styled::stylist

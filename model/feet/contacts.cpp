#include "model/feet/contacts.h"

#include <algorithm>
#include <limits>

#include "model/base/smooth.h"
#include "model/feet/tuning.h"

namespace styled::feet {
float Contacts::Speed(Part& part, const Vec3& position_m, float dt_s) noexcept {
  if (started_ && dt_s > 0) {
    const Vec3 velocity = (position_m - part.last_m) / dt_s;
    part.velocity_mps += DecayShare(dt_s, tuning::kSpeed_s) * (velocity - part.velocity_mps);
  }
  part.last_m = position_m;
  return part.velocity_mps.norm();
}

void Contacts::Process(float dt_s, const Legs& legs, std::span<const Placed> placed,
                       const Options& options) noexcept {
  std::array<std::array<float, 2>, kLegs> height{};
  std::array<std::array<float, 2>, kLegs> speed{};
  float lowest_m = std::numeric_limits<float>::max();
  float lowest_speed = 0;
  for (std::size_t side = 0; side < kLegs; ++side) {
    const Legs::Leg& leg = legs.leg(static_cast<int>(side));
    for (std::size_t part = 0; leg.resolved && part < 2; ++part) {
      const int joint = part == 0 ? leg.foot : leg.toes;
      if (joint < 0) continue;
      const Vec3& position_m = placed[static_cast<std::size_t>(joint)].position_m;
      height[side][part] = position_m.y() - (part == 0 ? leg.ankle_above_toes_m : 0.0F);
      speed[side][part] = Speed(parts_[side][part], position_m, dt_s);
      // A tilted foot's ankle does not show where the floor is: only the sole does.
      const bool sole = part == 1 || leg.toes < 0;
      if (sole && height[side][part] < lowest_m) {
        lowest_m = height[side][part];
        lowest_speed = speed[side][part];
      }
    }
  }
  if (lowest_m == std::numeric_limits<float>::max()) return;
  const float floor_m = floor_.Follow(lowest_m, lowest_speed, dt_s);

  for (std::size_t side = 0; side < kLegs; ++side) {
    const Legs::Leg& leg = legs.leg(static_cast<int>(side));
    for (std::size_t part = 0; leg.resolved && part < 2; ++part) {
      if (part == 1 && leg.toes < 0) continue;
      const float low = 1 - SmoothStep(height[side][part] - floor_m, options.contact_low_m,
                                       options.contact_high_m);
      const float slow =
          1 - SmoothStep(speed[side][part], options.contact_slow_mps, options.contact_fast_mps);
      CriticallyDamped& weight = parts_[side][part].weight;
      const float target = low * slow;
      const float tau_s = target > weight.value() ? options.blend_in_s : options.blend_out_s;
      const float value = std::clamp(weight.Follow(target, dt_s, tau_s), 0.0F, 1.0F);
      (part == 0 ? feet_[side].heel : feet_[side].toes) = value;
    }
  }
  started_ = true;
}

std::uint32_t Contacts::bits() const {
  std::uint32_t bits = 0;
  for (std::size_t side = 0; side < kLegs; ++side) {
    if (std::max(feet_[side].heel, feet_[side].toes) > 0.5F) bits |= 1U << side;
  }
  return bits;
}

}  // namespace styled::feet

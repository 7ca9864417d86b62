#pragma once

#include <array>
#include <span>

#include "model/base/realtime.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

// The style weights in force, faded from what they were to what was last set. Time is source
// time. Fixed size, no allocation; one thread.
class Mixer {
 public:
  // Aims at `settings` from the next Advance on, starting from the weights now in force. When more
  // than net::kMaxActive branches would be alive, the faintest of those fading out is dropped.
  STYLED_REALTIME void Aim(const Settings& settings) noexcept;

  // Moves the fade on by `dt_s`, the time since the frame before; a new fade begins there. The
  // first call of all shows the style at once.
  STYLED_REALTIME void Advance(double dt_s) noexcept;

  std::span<const net::StyleWeight> in_force() const { return {active_.data(), count_}; }
  bool fading() const { return fading_; }
  // No style in force and none coming.
  bool empty() const { return count_ == 0 && (input_style_ == 0 || presence_.value == 0); }
  // What the performer is taken to move in: in force at once, but neutral only after the fade.
  int input_style() const { return input_style_; }
  // 0..1: how far a style is there at all, be it neutral; how far the absolute output stands in for
  // the detail-preserving one.
  float presence() const { return presence_.value; }
  float absolute() const { return absolute_.value; }
  // 0..1: how much of the style a part of the body shows; all show all of it if whole().
  float share(body::Part part) const { return parts_[static_cast<std::size_t>(part)].value; }
  bool whole() const { return whole_; }

 private:
  struct Fade {
    float start = 0, target = 0, value = 0;
  };
  struct Slot {
    int style = -1;
    Fade weight;
  };
  static constexpr std::array<Fade, body::kPartCount> AllParts() {
    std::array<Fade, body::kPartCount> parts;
    parts.fill({1, 1, 1});
    return parts;
  }
  Slot& SlotFor(int style) noexcept;

  std::array<Slot, net::kMaxActive> slots_;
  std::array<net::StyleWeight, net::kMaxActive> active_;
  std::size_t count_ = 0;
  int input_style_ = 0, next_input_style_ = 0;
  Fade presence_, absolute_;
  std::array<Fade, body::kPartCount> parts_ = AllParts();
  bool whole_ = true;
  double elapsed_s_ = 0;
  float duration_s_ = 0;
  bool fading_ = false, running_ = false;
};

}  // namespace styled::stylist

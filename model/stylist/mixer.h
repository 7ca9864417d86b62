#pragma once

#include <array>
#include <span>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/stylist/settings.h"
#include "model/stylist/variation.h"

namespace styled::stylist {

// The style weights in effect, and the styles' variation, faded from their values at the last
// change to the requested ones. Time is source time. Fixed size, no allocation; one thread at a
// time. Pinned by tests/unit/stylist/mixer_test.cpp.
class Mixer {
 public:
  // Begins a fade to `settings` at the next Advance, from the weights then in effect. If more than
  // net::kMaxActive branches would be live, the one fading out with the smallest weight is dropped.
  STYLED_REALTIME void Aim(const Settings& settings) noexcept;

  // Advances the fade by `dt_s`, the time since the frame before. A fade that was just requested
  // begins at that frame. The very first call sets the style without a fade.
  STYLED_REALTIME void Advance(double dt_s) noexcept;

  std::span<const net::StyleWeight> in_force() const { return {active_.data(), count_}; }
  // The variations in which these styles are shown.
  std::span<const net::VariationWeight> variations() const { return variation_.in_force(); }
  bool fading() const { return fading_ || variation_.fading(); }
  // No style is in effect and none is fading in.
  bool empty() const { return count_ == 0 && (input_style_ == 0 || presence_.value == 0); }
  // Whether the style is in effect, is faded in or out, or is the performer's own.
  bool Names(int style) const noexcept;
  // The style that the performer is assumed to move in. A new one is used at once; neutral only
  // after the fade.
  int input_style() const { return input_style_; }
  // The content of the performer's motion (Settings::input_content). A new content is used at once.
  int input_content() const { return input_content_; }
  // 0 .. 1: how far any style, even neutral, is in effect; and the share of the absolute output
  // instead of the detail-preserving one.
  float presence() const { return presence_.value; }
  float absolute() const { return faded_[kAbsolute].value; }
  // 0 .. 1: the share of the style's speed that the path over the floor has (Root::kStride).
  float stride() const { return faded_[kStride].value; }
  // 0 .. 1: the share of the style that a part of the body shows. whole(): all parts show all of
  // it.
  float share(body::Part part) const { return parts_[static_cast<std::size_t>(part)].value; }
  bool whole() const { return whole_; }
  // See model/base/checkpoint.h. The counts are the network's.
  STYLED_REALTIME void Carry(Checkpoint& c, int style_count, int content_count) noexcept;

 private:
  struct Fade {
    float start = 0, target = 0, value = 0;
    STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(start, target, value); }
  };
  struct Slot {
    int style = -1;
    Fade weight;
  };
  // Settings that fade as the weights do: a number for each, and its target. Before the first
  // settings they have the targets of Settings().
  enum Faded { kAbsolute, kStride, kFadedCount };
  using FadedTargets = std::array<float, kFadedCount>;
  static FadedTargets TargetsOf(const Settings& settings) {
    return {settings.absolute ? 1.0F : 0.0F, settings.root == Root::kStride ? 1.0F : 0.0F};
  }
  static std::array<Fade, kFadedCount> InitiallyFaded() {
    std::array<Fade, kFadedCount> faded;
    const FadedTargets targets = TargetsOf(Settings());
    for (std::size_t i = 0; i < kFadedCount; ++i) faded[i] = {targets[i], targets[i], targets[i]};
    return faded;
  }
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
  int input_content_ = net::kContentRecognized;
  Fade presence_;
  std::array<Fade, kFadedCount> faded_ = InitiallyFaded();
  std::array<Fade, body::kPartCount> parts_ = AllParts();
  bool whole_ = true;
  Variation variation_;
  double elapsed_s_ = 0;
  float duration_s_ = 0;
  bool fading_ = false, running_ = false;
};

}  // namespace styled::stylist

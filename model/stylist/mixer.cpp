#include "model/stylist/mixer.h"

#include "model/base/smooth.h"

namespace styled::stylist {

Mixer::Slot& Mixer::SlotFor(int style) noexcept {
  for (Slot& slot : slots_) {
    if (slot.style == style) return slot;
  }
  // A free slot, else the one that is fading out with the smallest weight.
  Slot* best = slots_.data();
  for (Slot& slot : slots_) {
    if (slot.style < 0) {
      best = &slot;
      break;
    }
    if (slot.weight.target == 0 &&
        (best->weight.target != 0 || slot.weight.value < best->weight.value)) {
      best = &slot;
    }
  }
  *best = Slot{style, {}};  // at most kMaxMix < kMaxActive slots have a target: one is free
  return *best;
}

bool Mixer::Names(int style) const noexcept {
  return style == input_style_ || style == next_input_style_ ||
         std::ranges::any_of(slots_, [style](const Slot& slot) { return slot.style == style; });
}

void Mixer::Carry(Checkpoint& c, int style_count, int content_count) noexcept {
  for (Slot& slot : slots_) {
    c.Within(slot.style, -1, style_count - 1);
    c(slot.weight);
  }
  for (net::StyleWeight& style : active_) {
    c.Within(style.style, -1, style_count - 1);
    c(style.weight);
  }
  c.Within(count_, 0, active_.size());
  c.Within(input_style_, 0, style_count - 1);
  c.Within(next_input_style_, 0, style_count - 1);
  if (content_count > 0) c.Within(input_content_, net::kContentUnknown, content_count - 1);
  c(presence_, faded_, parts_, whole_, variation_, elapsed_s_, duration_s_, fading_, running_);
}

void Mixer::Aim(const Settings& settings) noexcept {
  for (Slot& slot : slots_) {
    slot.weight.start = slot.weight.value;
    slot.weight.target = 0;
  }
  presence_.start = presence_.value;
  presence_.target = 0;
  const FadedTargets targets = TargetsOf(settings);
  for (std::size_t i = 0; i < faded_.size(); ++i) {
    faded_[i].start = faded_[i].value;
    faded_[i].target = targets[i];
  }
  const bool nothing = empty();  // no style in effect: parts and variation need no fade
  variation_.Aim(settings, nothing || !running_);
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    Fade& fade = parts_[part];
    fade.target = (settings.parts >> part & 1U) != 0 ? 1 : 0;
    fade.start = nothing ? fade.target : fade.value;
  }
  for (const net::StyleWeight& style : settings.mix) {
    const float weight = style.weight * settings.strength;
    if (style.style < 0 || weight <= 0) continue;
    if (style.style > 0) SlotFor(style.style).weight.target = weight;
    presence_.target = 1;
  }
  input_content_ = settings.input_content;
  next_input_style_ = settings.input_style;
  if (next_input_style_ > 0) input_style_ = next_input_style_;
  duration_s_ = settings.transition_s;
  elapsed_s_ = 0;
  fading_ = true;
}

void Mixer::Advance(double dt_s) noexcept {
  const bool at_once = duration_s_ <= 0 || !running_;
  running_ = true;
  if (fading_) {
    elapsed_s_ += dt_s;
    const float u = at_once ? 1.0F : static_cast<float>(elapsed_s_ / duration_s_);
    fading_ = u < 1;
    const float share = SmoothStep(u);
    const auto move = [share](Fade& fade) {
      fade.value = share >= 1 ? fade.target : fade.start + (fade.target - fade.start) * share;
    };
    move(presence_);
    std::ranges::for_each(faded_, move);
    whole_ = true;
    for (Fade& part : parts_) {
      move(part);
      whole_ = whole_ && part.value == 1;
    }
    for (Slot& slot : slots_) {
      move(slot.weight);
      if (!fading_ && slot.weight.target == 0) slot = Slot{};
    }
  }
  variation_.Advance(dt_s);
  if (!fading_) input_style_ = next_input_style_;
  count_ = 0;
  for (const Slot& slot : slots_) {
    if (slot.style >= 1) active_[count_++] = {slot.style, slot.weight.value};
  }
}

}  // namespace styled::stylist

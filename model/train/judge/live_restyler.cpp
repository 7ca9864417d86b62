#include "model/train/judge/live_restyler.h"

#include <cassert>

namespace styled::judge {

LiveRestyler::LiveRestyler(const Styler& styler, const stylist::Options& options, bool any_style)
    : styler_(styler), options_(options), any_style_(any_style) {
  assert(styler_.network->space() != nullptr);
}

bool LiveRestyler::Has(int style) const {
  return any_style_ || styler_.style_of[static_cast<std::size_t>(style)] != kAbsent;
}

Poses LiveRestyler::Restyle(std::span<const body::Pose> clip, const Target& target) const {
  const net::StyleSpace& space = *styler_.network->space();
  net::StyleCode code = space.MakeCode(RequestOf(target, styler_.style_of));
  if (!target.neutral.empty()) {
    net::StyleRequest neutral;
    neutral.sources.push_back({.style = -1, .seed = {}, .reference = target.neutral, .weight = 1});
    code = space.Difference(code, space.MakeCode(neutral));
  }
  return RestyleBy(clip, code);
}

Poses LiveRestyler::RestyleBy(std::span<const body::Pose> clip, const net::StyleCode& code,
                              const neutral::Known* known) const {
  const auto number = static_cast<int>(styler_.network->model().styles.size());
  const auto network = styler_.network->With(number, {.name = "target"}, code);
  Switch all{.frame = 0, .settings = OneStyle(number, false)};
  all.settings.root = styler_.root;
  return StyleStream(network, styler_.binding, options_, {&all, 1}, clip, rate_hz(), known);
}

neutral::Known LiveRestyler::Calibrated(std::span<const body::Pose> clip) const {
  neutral::Known known = LearnNeutral(styler_.network, styler_.binding, options_, clip, rate_hz());
  known.calibrated = known.body_s > 0;
  return known;
}

}  // namespace styled::judge

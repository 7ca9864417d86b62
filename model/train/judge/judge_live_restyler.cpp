#include "model/train/judge/judge_live_restyler.h"

#include <cassert>

namespace styled::judge {

LiveRestyler::LiveRestyler(const Styler& styler, const stylist::Options& options)
    : styler_(styler), options_(options) {
  assert(styler_.network->space() != nullptr);
}

bool LiveRestyler::Has(int style) const {
  return styler_.style_of[static_cast<std::size_t>(style)] != kAbsent;
}

Poses LiveRestyler::Restyle(std::span<const body::Pose> clip, const Target& target) const {
  return RestyleBy(clip,
                   styler_.network->space()->MakeCode(RequestOf(target, styler_.style_of)));
}

Poses LiveRestyler::RestyleBy(std::span<const body::Pose> clip, const net::StyleCode& code) const {
  const auto number = static_cast<int>(styler_.network->model().styles.size());
  const auto network = styler_.network->With(number, {.name = "target"}, code);
  Switch all{.frame = 0, .settings = OneStyle(number, false)};
  all.settings.root = styler_.root;
  return StyleStream(network, styler_.binding, options_, {&all, 1}, clip, rate_hz());
}

}  // namespace styled::judge

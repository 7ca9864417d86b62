#pragma once

#include <span>

#include "model/train/judge/restyler.h"

namespace styled::judge {

// A live network with a space of styles, judged by the output of Stylist at 120 Hz: a target's code
// is added to it as one more style, as the daemon does for an example. Pinned by
// tests/unit/judge/restyler_test.cpp.
class LiveRestyler final : public Restyler {
 public:
  // `styler`: its network has a space. `any_style`: targets have an example in every style, so that
  // the network need not know it.
  LiveRestyler(const Styler& styler, const stylist::Options& options, bool any_style = false);

  double rate_hz() const override { return kStreamRate_hz; }
  bool Has(int style) const override;
  Poses Restyle(std::span<const body::Pose> clip, const Target& target) const override;
  // The same by a code of the network's space. `known`, unless null: the performer's neutral.
  Poses RestyleBy(std::span<const body::Pose> clip, const net::StyleCode& code,
                  const neutral::Known* known = nullptr) const;
  // The neutral of a clip's performer, at rate_hz(), as calibrated: it no longer changes.
  neutral::Known Calibrated(std::span<const body::Pose> clip) const;

 private:
  const Styler& styler_;
  stylist::Options options_;
  bool any_style_;
};

}  // namespace styled::judge

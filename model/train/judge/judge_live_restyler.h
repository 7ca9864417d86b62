#pragma once

#include <memory>
#include <span>
#include <vector>

#include "model/train/judge/judge_restyler.h"

namespace styled::judge {

// The output of Stylist at 120 Hz for a live network that knows a space of styles: a target's code
// is added to it as one more style, as the daemon does for an example. Pinned by
// tests/unit/judge/judge_restyler_test.cpp.
class LiveRestyler final : public Restyler {
 public:
  // `styler`: its network has a space. `any_style`: targets have an example in every style, so that
  // the network need not know it.
  LiveRestyler(const Styler& styler, const stylist::Options& options, bool any_style = false);

  double rate_hz() const override { return kStreamRate_hz; }
  bool Has(int style) const override;
  Poses Restyle(std::span<const body::Pose> clip, const Target& target) const override;
  // The same by a code of the network's space.
  Poses RestyleBy(std::span<const body::Pose> clip, const net::StyleCode& code) const;

 private:
  const Styler& styler_;
  stylist::Options options_;
  bool any_style_;
};

}  // namespace styled::judge

#pragma once

#include "model/base/realtime.h"
#include "model/stylist/low_pass.h"
#include "model/stylist/mixer.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

// The style delta over time, never the performer's motion: a low-pass whose delay depends on what
// happens, and a cross-fade over restarts of the recurrent states. Value type, no allocation; one
// thread at a time. Mathematics: model/README.md, 4. Pinned by
// tests/unit/stylist/change_filter_test.cpp and stylist_test.cpp.
class ChangeFilter {
 public:
  // One frame, `dt_s` after the one before: low-passes toward `target`. The delay is
  // Options::change_tau_s; longer where the network reconstructs badly (`reconstruction_rad`, rms
  // over joints), since there small motions of the performer make large ones of the delta; and
  // while styles are switched, the longer the farther a limb has to go, so that no limb is thrown.
  // The first frame after a restart takes the target as it is.
  STYLED_REALTIME void Follow(const StyleDelta& target, double dt_s, float reconstruction_rad,
                              const Mixer& mixer, const Options& options) noexcept;

  // The second half of the same frame: what is applied becomes `delta` (value(), scaled by what the
  // stylist has to say of it), cross-faded from what was applied at the last restart.
  STYLED_REALTIME void Apply(const StyleDelta& delta, double dt_s, const Options& options) noexcept;

  // What the low-pass holds; of the two, near() is less delayed and less smooth: which way round a
  // turn is counted.
  const StyleDelta& value() const { return low_pass_.value(); }
  const StyleDelta& near() const { return low_pass_.first(); }
  // What is put on the performer's pose in this frame.
  const StyleDelta& applied() const { return applied_; }
  // The low-pass's delay in this frame, s.
  float delay_s() const { return delay_s_; }

  // The recurrent states start anew. `fade`: over what was applied until now.
  STYLED_REALTIME void Restart(bool fade) noexcept;
  // The same where a cross-fade under way goes on: where every frame comes after a gap, as from a
  // rig of 1 Hz, the style would never arrive otherwise.
  STYLED_REALTIME void RestartAfterGap(bool fade, double dt_s, const Options& options) noexcept;
  // Forgets all; the style is faded in from none.
  STYLED_REALTIME void Clear() noexcept;
  // An instant change of style: a switch under way is over.
  STYLED_REALTIME void EndSwitch() noexcept { switching_ = 0; }

 private:
  float UsualDelay_s(float dt_s, float reconstruction_rad, const Mixer& mixer,
                     const Options& options) noexcept;
  float SwitchDelay_s(const StyleDelta& target, float dt_s, float usual_s,
                      const Mixer& mixer) noexcept;

  LowPass low_pass_;
  StyleDelta applied_ = StyleDelta::Zero();
  StyleDelta fade_from_ = StyleDelta::Zero();  // what was applied at the last restart
  float fade_ = 1.0F;                          // 0 at a restart, 1 when its cross-fade is over
  bool started_ = false;                       // since the last restart
  bool first_ = true;                          // this frame is the first since then
  float reconstruction_rad_ = 0;               // smoothed
  float switching_ = 0;                        // 1 while styles are faded, 0 when a switch is over
  float switch_delay_s_ = 0;                   // what the switch asks for
  float delay_s_ = 0;
};

}  // namespace styled::stylist

#pragma once

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/stylist/low_pass.h"
#include "model/stylist/mixer.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

// Filters the style delta over time, never the performer's motion: a low-pass of variable delay,
// and a cross-fade over restarts of the recurrent states. Value type, no allocation; one thread at
// a time. Mathematics: model/README.md, 4. Pinned by tests/unit/stylist/change_filter_test.cpp and
// stylist_test.cpp.
class ChangeFilter {
 public:
  // First half of a frame, `dt_s` after the one before: low-passes toward `target`. The delay is
  // Options::change_tau_s. It is longer while the network reconstructs badly (`reconstruction_rad`,
  // rms over joints), because small motions of the performer then cause large ones of the delta. It
  // is also longer after a restart, because the output of recurrent states that have seen little of
  // the performer is unsteady; and during a switch of styles, the more so the farther a limb has to
  // move, so that no limb is thrown. The first frame after a restart sets the value to the target.
  STYLED_REALTIME void Follow(const StyleDelta& target, double dt_s, float reconstruction_rad,
                              const Mixer& mixer, const Options& options) noexcept;

  // Second half of the same frame: sets applied() to `delta` (value(), scaled by the stylist),
  // cross-faded from the value that was applied at the last restart.
  STYLED_REALTIME void Apply(const StyleDelta& delta, double dt_s, const Options& options) noexcept;

  // The low-passed delta, and its first stage, near(), which is less delayed and less smooth:
  // near() decides which way round a rotation is counted (body::LogNear).
  const StyleDelta& value() const { return low_pass_.value(); }
  const StyleDelta& near() const { return low_pass_.first(); }
  // The delta that is applied to the performer's pose in this frame.
  const StyleDelta& applied() const { return applied_; }
  // The low-pass's delay in this frame, s.
  float delay_s() const { return delay_s_; }

  // The recurrent states restart. `fade`: cross-fade from the delta that was applied until now;
  // false: no cross-fade.
  STYLED_REALTIME void Restart(bool fade) noexcept;
  // The same, but a running cross-fade continues. Otherwise the style would never arrive if every
  // frame comes after a gap, e.g. from a rig of 1 Hz.
  STYLED_REALTIME void RestartAfterGap(bool fade, double dt_s, const Options& options) noexcept;
  // Exchanges left and right of the delta that was applied; a restart must follow.
  STYLED_REALTIME void Mirror() noexcept;
  // Clears everything; the style is faded in from none.
  STYLED_REALTIME void Clear() noexcept;
  // Ends a switch in progress, for an instant change of style.
  STYLED_REALTIME void EndSwitch() noexcept { switching_ = 0; }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    c(low_pass_, applied_, fade_from_, fade_, started_, first_, age_s_, reconstruction_rad_,
      switching_, switch_delay_s_, delay_s_);
  }

 private:
  float UsualDelay_s(float dt_s, float reconstruction_rad, const Mixer& mixer,
                     const Options& options) noexcept;
  float SwitchDelay_s(const StyleDelta& target, float dt_s, float usual_s,
                      const Mixer& mixer) noexcept;

  LowPass low_pass_;
  StyleDelta applied_ = StyleDelta::Zero();
  StyleDelta fade_from_ = StyleDelta::Zero();  // the delta applied at the last restart
  float fade_ = 1.0F;                          // 0 at a restart, 1 when the cross-fade has ended
  bool started_ = false;                       // since the last restart
  bool first_ = true;                          // this frame is the first since the last restart
  float age_s_ = 0;                            // time since the last restart
  float reconstruction_rad_ = 0;               // smoothed
  float switching_ = 0;                        // 1 while style weights fade, then falls to 0
  float switch_delay_s_ = 0;                   // the delay that the switch needs, s
  float delay_s_ = 0;
};

}  // namespace styled::stylist

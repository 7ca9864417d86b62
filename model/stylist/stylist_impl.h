#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "model/base/critically_damped.h"
#include "model/feet/feet.h"
#include "model/neutral/neutral.h"
#include "model/stylist/batch.h"
#include "model/stylist/change_filter.h"
#include "model/stylist/domain.h"
#include "model/stylist/input_guard.h"
#include "model/stylist/mixer.h"
#include "model/stylist/posture.h"
#include "model/stylist/predictor.h"
#include "model/stylist/stride.h"
#include "model/stylist/stylist.h"

namespace styled::stylist {

// For the stylist's sources only: the state of one performer's stylist, and its steps.
struct Stylist::Impl {
  Impl(std::shared_ptr<const net::Stylizer> network, std::shared_ptr<const rig::Binding> the_rig,
       const Options& the_options);

  // The steps of a frame, in order; the second is StepTogether (batch.h). input_steps.cpp:
  STYLED_REALTIME void Bind(std::int64_t time_ns, const rig::RigPose& in, Output& out) noexcept;
  // stylist.cpp:
  STYLED_REALTIME bool HasSoundSteps() noexcept;
  STYLED_REALTIME void ChangeStyle(const body::Pose& input) noexcept;
  STYLED_REALTIME void Apply(Output& out) const noexcept;
  // output_steps.cpp:
  STYLED_REALTIME void Unbind(Output& out) noexcept;
  STYLED_REALTIME void HoldFeet(Output& out) noexcept;
  STYLED_REALTIME void GuardOutput(Output& out) noexcept;
  STYLED_REALTIME void Finish(Output& out) noexcept;

  // Parts of the steps.
  STYLED_REALTIME void CheckTiming(std::int64_t time_ns, Output& out) noexcept;
  STYLED_REALTIME void Restart() noexcept;
  STYLED_REALTIME void RestartAfterGap() noexcept;
  STYLED_REALTIME void UpdateTravel(Output& out) noexcept;
  STYLED_REALTIME void RemoveNeutral(const body::Pose& input) noexcept;
  STYLED_REALTIME float Shown(body::Part part) const noexcept;
  STYLED_REALTIME bool Bypassed() const noexcept;
  STYLED_REALTIME void FallBackToInput(Output& out) noexcept;
  // Null if the performer's neutral is not removed.
  STYLED_REALTIME const neutral::Reference* Reference() const noexcept {
    const auto& reference = predictor.network()->model().reference;
    return options.neutral && reference ? &*reference : nullptr;
  }
  // Null if the performer's gait is not followed.
  STYLED_REALTIME const neutral::Reference* Gaits() const noexcept {
    const auto& reference = predictor.network()->model().reference;
    return reference && reference->gaits ? &*reference : nullptr;
  }
  STYLED_REALTIME BatchEntry EntryOf(const Output& out) noexcept;

  std::shared_ptr<const rig::Binding> binding;
  Options options;
  Settings settings;

  InputGuard input_guard;
  neutral::Neutral neutral;
  body::Pose seen;  // the input as the network sees it: with the reference's carriage
  Mixer mixer;
  Predictor predictor;
  ChangeFilter filter;
  Domain domain;
  LimbGate gate;
  PostureKeeper posture;
  Stride stride;
  // Vertical shifts: of the canonical humanoid, and of the source skeleton in its units.
  CriticallyDamped shift_m, rig_shift;
  feet::Feet feet, rig_feet;
  CriticallyDamped feet_style;  // the style's weight, delayed like the style itself
  // The humanoid's offsets as translations.
  std::array<body::Vec3, body::kJointCount> offsets_in, offsets_out;

  std::int64_t last_ns = 0;
  double dt_s = 0;        // time between the frame before and this one
  double last_gap_s = 0;  // dt_s of the frame before if it exceeded gap_reset_s, else 0
  bool started = false, fresh_session = true;
  bool rests = false;    // see Stylist::Rest
  bool measured = true;  // see Stylist::SetMeasured
  // The prediction or output that was not sound, until the next step.
  Failure failure = Failure::kNone;
  bool failed() const { return failure != Failure::kNone; }
};

}  // namespace styled::stylist

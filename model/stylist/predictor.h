#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <memory>

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/net/stylizer.h"
#include "model/stylist/interleaver.h"
#include "model/stylist/low_pass.h"
#include "model/stylist/mixer.h"

namespace styled::stylist {

// Step 2 of the stylist for one performer: which recurrent states are due, the pose at each one's
// tick, and the style delta that their predictions ask for. The network itself is called by
// StepTogether (batch.h). Construction allocates; nothing else does. One thread at a time. Pinned
// by tests/unit/stylist/stylist_test.cpp.
class Predictor {
 public:
  explicit Predictor(std::shared_ptr<const net::Stylizer> network);

  // All states and ticks start anew.
  STYLED_REALTIME void Restart() noexcept;
  // The states alone.
  STYLED_REALTIME void RestartStates() noexcept;
  // The next frame has no frame before it.
  STYLED_REALTIME void ForgetInput() noexcept { has_last_input_ = false; }

  // Announces the frame at `time_ns`; false: restart, then once more (Interleaver::Begin).
  [[nodiscard]] STYLED_REALTIME bool Begin(std::int64_t time_ns) noexcept;
  // The frame is over; `input`: its canonical pose.
  STYLED_REALTIME void End(const body::Pose& input) noexcept;

  // One step of one recurrent state, on its way to the network and back.
  struct Step {
    int state;
    const body::Pose* pose;  // the input or `between`
    body::Pose between;      // the input at the state's own tick
    net::Prediction out;
  };
  // The next state whose tick is due at the frame of the canonical pose `input`; false when none
  // is.
  [[nodiscard]] STYLED_REALTIME bool Next(const body::Pose& input, Step& step) noexcept;
  // `step` as the network takes it, in the styles in force.
  STYLED_REALTIME net::StepJob JobOf(Step& step, const Mixer& mixer) const noexcept;
  // What the network made of it. `near`: which way round a turn beyond 90 degrees is counted.
  STYLED_REALTIME void Accept(const Step& step, const Mixer& mixer,
                              const StyleDelta& near) noexcept;

  // What the interleaved states ask for, averaged.
  STYLED_REALTIME StyleDelta MeanDelta() const noexcept;
  // The paper's output instead, as far as that is asked for: unfiltered, from the newest step
  // alone.
  STYLED_REALTIME void BlendAbsolute(const body::Pose& input, const Mixer& mixer,
                                     StyleDelta& delta) const noexcept;

  // Brings what the next frame reads into the caches.
  void Prefetch() const noexcept;

  const net::Stylizer* network() const { return network_.get(); }
  bool any() const { return stepped_.any(); }  // a state has stepped since the restart
  bool unsound() const { return unsound_; }    // a prediction of this frame is no pose
  int steps() const { return steps_; }         // of the network, for this frame
  double frame_period_s() const { return interleaver_.frame_period_s(); }
  // Reconstruction error: rms joint angle between reconstruction and input, toes apart; of the
  // newest step.
  float reconstruction_rad() const { return reconstruction_rad_; }

 private:
  std::shared_ptr<const net::Stylizer> network_;
  Interleaver interleaver_;
  std::array<std::unique_ptr<net::Stream>, tuning::kMaxInterleaved> streams_;
  std::array<StyleDelta, tuning::kMaxInterleaved> deltas_;  // each state's newest
  std::bitset<tuning::kMaxInterleaved> stepped_;
  std::array<body::Quat, body::kJointCount> last_styled_;  // of the newest step
  float last_heading_rad_ = 0;
  body::Pose last_input_;
  bool has_last_input_ = false, unsound_ = false;
  int steps_ = 0;
  float reconstruction_rad_ = 0;
};

}  // namespace styled::stylist

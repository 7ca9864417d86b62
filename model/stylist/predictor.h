#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <memory>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/net/stylizer.h"
#include "model/stylist/interleaver.h"
#include "model/stylist/limb_gate.h"
#include "model/stylist/low_pass.h"
#include "model/stylist/mixer.h"

namespace styled::stylist {

// Step 2 of the stylist for one performer: finds the recurrent states that are due, returns the
// pose at each one's tick, and turns their predictions into style deltas. StepTogether (batch.h)
// calls the network itself. Construction allocates; nothing else does. One thread at a time. Pinned
// by tests/unit/stylist/stylist_test.cpp.
class Predictor {
 public:
  explicit Predictor(std::shared_ptr<const net::Stylizer> network);

  // Continues with `network`, which must share streams with the former one.
  void Adopt(std::shared_ptr<const net::Stylizer> network) noexcept;

  // Restarts all states and ticks.
  STYLED_REALTIME void Restart() noexcept;
  // Restarts the states only.
  STYLED_REALTIME void RestartStates() noexcept;
  // The next frame is treated as the first: no input before it.
  STYLED_REALTIME void ForgetInput() noexcept { has_last_input_ = false; }

  // Announces the frame at `time_ns`. If false, call Restart and then Begin again
  // (Interleaver::Begin).
  [[nodiscard]] STYLED_REALTIME bool Begin(std::int64_t time_ns) noexcept;
  // Skips the frame's ticks without a step; the states are then as after a restart.
  STYLED_REALTIME void Skip() noexcept;
  // Ends the frame; `input`: its canonical pose.
  STYLED_REALTIME void End(const body::Pose& input) noexcept;

  // One step of one recurrent state.
  struct Step {
    int state;
    const body::Pose* pose;  // the input, or `between`
    body::Pose between;      // the input interpolated at the state's tick
    net::Prediction out;
  };
  // The next state whose tick is due in the frame of the canonical pose `input`; false if none is.
  [[nodiscard]] STYLED_REALTIME bool Next(const body::Pose& input, Step& step) noexcept;
  // The network's job for `step`, in the styles in effect. `step` must outlive the job.
  STYLED_REALTIME net::StepJob JobOf(Step& step, const Mixer& mixer) const noexcept;
  // Applies the prediction in `step`. `near` decides which way round a rotation beyond 90 degrees
  // is counted (body::LogNear).
  STYLED_REALTIME void Accept(const Step& step, const Mixer& mixer,
                              const StyleDelta& near) noexcept;

  // Writes the mean of the interleaved states' newest style deltas; 0 if none has stepped.
  STYLED_REALTIME void MeanDelta(StyleDelta& mean) const noexcept;
  // Replaces `delta` by the paper's absolute output, in the share mixer.absolute(): unfiltered,
  // from the newest step only. Not its rise: the hips keep the performer's height and the change.
  STYLED_REALTIME void BlendAbsolute(const body::Pose& input, const Mixer& mixer,
                                     StyleDelta& delta) const noexcept;

  // Brings the streams that the next frame reads into the caches.
  void Prefetch() const noexcept;

  // See model/base/checkpoint.h. States that have not stepped are as Restart leaves them.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;

  const net::Stylizer* network() const { return network_.get(); }
  bool any() const { return stepped_.any(); }  // a state has stepped since the last restart
  bool unsound() const { return unsound_; }    // a prediction of this frame was not sound
  int steps() const { return steps_; }         // network steps of this frame
  // The mean age of the interleaved states' newest predictions, s.
  float delay_s() const noexcept;
  double frame_period_s() const { return interleaver_.frame_period_s(); }
  // Reconstruction error of the newest step: rms joint angle between reconstruction and input,
  // without toes.
  float reconstruction_rad() const { return reconstruction_rad_; }
  // The same by limb, m.
  const PerLimb& limb_errors_m() const { return limb_errors_m_; }

 private:
  std::shared_ptr<const net::Stylizer> network_;
  Interleaver interleaver_;
  std::array<std::unique_ptr<net::Stream>, tuning::kMaxInterleaved> streams_;
  std::array<StyleDelta, tuning::kMaxInterleaved> deltas_;  // the newest of each state
  std::bitset<tuning::kMaxInterleaved> stepped_;
  std::array<body::Quat, body::kJointCount> last_styled_;  // the newest step's
  float last_heading_rad_ = 0;
  body::Pose last_input_;
  bool has_last_input_ = false, unsound_ = false;
  int steps_ = 0;
  float reconstruction_rad_ = 0;
  PerLimb limb_errors_m_{};
};

}  // namespace styled::stylist

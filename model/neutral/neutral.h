#pragma once

#include <array>
#include <cstdint>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/gait/tracker.h"
#include "model/gait/velocity.h"
#include "model/neutral/carriage.h"
#include "model/neutral/own_gait.h"
#include "model/neutral/tuning.h"

namespace styled::neutral {

// The evidence that one pose gives about a carriage. A pose is ordinary if the body is upright, the
// legs are straight and both upper arms hang; while standing, the forearms must hang, too, and the
// feet must not be far apart.
struct Ordinary {
  float heading_rad = 0;              // body::Heading_rad
  float moving = 0, running = 0;      // 0 stands, 1 walks or runs; 0 walks, 1 runs
  float body = 0;                     // 0 .. 1
  float left_arm = 0, right_arm = 0;  // 0 .. 1, at most `body`

  STYLED_REALTIME float Of(int joint) const noexcept;  // of the three, that of the joint's part
};
// Evaluates a pose, canonical and finite, by its shape and by the hips' smoothed speed over the
// floor. Pure.
STYLED_REALTIME Ordinary JudgeOrdinary(const body::WorldPose& world, float speed_mps,
                                       const Reference& reference) noexcept;

// The learned neutral of a performer, independent of the network: to be kept over a restart.
struct Known {
  Carriage own;             // their carriage, with the reference's own where nothing was learned
  float body_s = 0;         // seconds of ordinary standing and moving that it was learned from,
  float arms_s = 0;         // and of hanging arms: 0 .. tuning::kRemembered_s
  bool calibrated = false;  // set by a calibration; it no longer changes
  // Their gaits, about `own`, and the seconds that they were learned from; 0: nothing is known.
  gait::Series walking = gait::Series::Zero(), running = gait::Series::Zero();
  float walking_s = 0, running_s = 0;

  friend bool operator==(const Known&, const Known&) = default;
};

// The same performer with left and right exchanged (body::Mirror). Pure.
Known Mirrored(const Known& known);

// The performer's neutral: the difference between the carriage of this performer on this rig and
// that of the performers whom a network knows. It is learned while they stand, walk and run, and is
// removed from the poses that the network sees. It need not be added again: the change of style is
// applied to the performer's own pose.
//
// For joint j with local rotation q_j and the reference's mean M_j (standing, walking or running,
// by speed), the turn C_j is the running mean of M_j q_j^-1, so the network sees C_j q_j; for the
// hips, in the frame of the heading. Frames are weighted by how ordinary they are, so that an act
// is not mistaken for a carriage. No joint's turn exceeds a bound of its class (tuning.h).
//
// If the reference has gaits, the phase of the performer's gait is followed, and their own gaits
// are learned, too (OwnGait), for a family that changes gaits by their phase.
//
// Value type of fixed size, no allocation; one thread at a time. Time is the sum of `dt_s`.
// Mathematics: model/README.md, 1. Pinned by tests/unit/neutral/neutral_test.cpp.
class Neutral {
 public:
  // Processes one frame, `dt_s` after the one before (0: the first): canonical, finite. `learns`:
  // false for a performer who is not in neutral (an input style); such frames are not learned from.
  STYLED_REALTIME void Follow(const body::Pose& input, float dt_s, bool learns,
                              const Reference& reference) noexcept;

  // Writes `input`, the last processed pose, with the carriage of the reference's performer. `out`
  // may be `input`. The hips' place is unchanged.
  STYLED_REALTIME void RemoveCarriage(const body::Pose& input, body::Pose& out) const noexcept;

  // How well the neutral is known, 0 .. 1: the weight of the performer's frames in the mean, for
  // the body without the arms.
  float learned() const;
  // As in Known.
  float body_s() const { return seconds_[kBody]; }
  float arms_s() const { return seconds_[kArms]; }
  bool calibrated() const { return calibrated_; }
  // Seconds until a calibration ends; 0: there is none.
  float calibrates_s() const { return calibrates_s_; }
  // The turns that are in effect; identity where nothing was learned.
  const Carriage& turns() const { return used_; }

  // Only if the reference has gaits. The phase of the performer's gait in the last frame.
  const gait::Phase& phase() const { return tracker_.phase(); }
  float running() const { return running_; }  // 0 walks, 1 runs
  // The performer's own gaits, about the means of the reference's.
  const OwnGait& walk() const { return walk_; }
  const OwnGait& run() const { return run_; }

  // Starts learning again for `seconds`, from the performer's current motion. After that it no
  // longer changes, if enough of the motion was ordinary (tuning::kEnough_s); otherwise learning
  // continues as without a calibration.
  STYLED_REALTIME void Calibrate(float seconds) noexcept;
  // Clears the learned or calibrated neutral; it fades out, and is learned again.
  STYLED_REALTIME void Forget() noexcept;

  // The following frames are those of the same performer with left and right exchanged.
  STYLED_REALTIME void Mirror() noexcept;

  // The learned neutral, and its use for another network or by another stylist: at once, without a
  // fade.
  STYLED_REALTIME Known Tell(const Reference& reference) const noexcept;
  STYLED_REALTIME void Know(const Known& known, const Reference& reference) noexcept;
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;

 private:
  enum Class : std::uint8_t { kBody, kArms };
  void FollowGait(const body::Pose& input, float learned, float dt_s,
                  const Reference& reference) noexcept;
  void SolveGaits(const Reference& reference) noexcept;
  void Learn(const body::Pose& input, const Ordinary& ordinary, float dt_s,
             const Reference& reference) noexcept;

  Carriage learned_, used_;
  std::array<float, 2> seconds_{};  // by Class
  bool calibrated_ = false;
  float calibrates_s_ = 0;
  float heading_rad_ = 0;  // of the pose last followed
  gait::Velocity velocity_;
  gait::Tracker tracker_;
  OwnGait walk_, run_;
  float running_ = 0;
  // Since the last sample of a gait, and since the curves were last found; whether they no longer
  // are those of all samples.
  float sample_s_ = 0, solved_s_ = tuning::kSolved_s;
  bool stale_ = true;
};

}  // namespace styled::neutral

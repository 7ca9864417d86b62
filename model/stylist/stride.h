#pragma once

#include "model/base/checkpoint.h"
#include "model/base/critically_damped.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/feet/travel.h"
#include "model/net/styles.h"
#include "model/stylist/mixer.h"

namespace styled::stylist {

// A style's effect on a gait, as natural logarithms: of the factor of the path over the floor, and
// of the factor of the cadence, which is 0 unless the caller warps time (Options::own_cadence).
struct GaitChange {
  float log_way = 0, log_cadence = 0;

  friend GaitChange operator*(float share, const GaitChange& change) {
    return {share * change.log_way, share * change.log_cadence};
  }
};

// The performer's path over the floor, scaled by the style's effect on speed (Root::kStride). The
// styled hips move by the factor times the performer's own step in every frame, so a straight line
// stays straight, a circle stays a circle, and a turn keeps its angle. The offset, moved_m(), is an
// integral and is kept, so no change of style or setting causes a jump. Spaces: canonical metres,
// +Y up; all vectors are horizontal. Fixed size, no allocation; one thread at a time. Mathematics:
// model/README.md, 4. Pinned by tests/unit/stylist/stride_test.cpp.
class Stride {
 public:
  // One frame, `dt_s` after the one before (0: the first). `hips_m`: the performer's own hips.
  // `change` returns the GaitChange for the performer's smoothed speed (m/s); `settle_s` is added
  // to the time constant with which it is followed. A step over a hole of `hole_s` or more, or one
  // that no performer makes, is not scaled; neither is a place that is not finite.
  template <typename Change>
  STYLED_REALTIME void Follow(const body::Vec3& hips_m, double dt_s, double hole_s, float settle_s,
                              const Change& change) noexcept {
    const Step step = Measure(hips_m, dt_s, hole_s);
    if (step != Step::kNone) Scale(change(speed_mps()), static_cast<float>(dt_s), settle_s);
  }

  // The styled hips minus the performer's, and the factor in this frame, for the feet.
  const body::Vec3& moved_m() const { return travel_.moved_m; }
  const feet::Travel& travel() const { return travel_; }
  // The factor in this frame; exactly 1 if no style scales anything.
  float factor() const { return factor_; }
  // The factor of the cadence in this frame; exactly 1 if no style changes it. It passes through
  // the same filter as the path's factor, so that their product, the factor of the speed in warped
  // time, always equals the factor that Root::kStride alone applies to the speed.
  float cadence() const { return cadence_; }
  // The performer's speed over the floor, smoothed.
  float speed_mps() const { return velocity_mps_.norm(); }

  // The performer is in another place: styled and own hips agree again.
  STYLED_REALTIME void Reset() noexcept { *this = Stride(); }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;

 private:
  enum class Step { kNone, kAccepted };
  Step Measure(const body::Vec3& hips_m, double dt_s, double hole_s) noexcept;
  void Scale(const GaitChange& change, float dt_s, float settle_s) noexcept;

  Eigen::Vector3d gained_m_ = Eigen::Vector3d::Zero();  // in double: a sum over hours
  body::Vec3 last_m_ = body::Vec3::Zero(), step_m_ = body::Vec3::Zero();
  body::Vec3 velocity_mps_ = body::Vec3::Zero();
  float seen_ = 0;  // 0 .. 1: the share of the velocity's average that has been filled
  bool placed_ = false;
  CriticallyDamped log_factor_, log_cadence_;
  float factor_ = 1, cadence_ = 1;
  feet::Travel travel_;
};

// The logarithm of the factor at a speed: each active style by its weight, minus that of the
// performer's own style. 0 for standing; at walking speed by the styles' walks, at running speed by
// their runs (net::StyleInfo), smooth between. Most of the difference between the speed and the
// usual one of the performer's own style is taken back, so that the result is near the styles' own
// speeds (tuning::kStrideOwnSpeed). Styles without measured speeds count as 0. Bounded by
// tuning::kLeastStride and kMostStride. Pure.
STYLED_REALTIME float LogStride(const net::Styles& styles, const Mixer& mixer,
                                float speed_mps) noexcept;

// The logarithm of the factor of the cadence at a speed, by the same gaits and weights, from the
// styles' cadences; for any Root. It is the ratio to neutral's cadence: a performer who takes more
// steps a minute than others keeps this difference. Styles without a measured cadence count as 0.
// All styles do if neutral has no speeds, which separate walks from runs. Bounded by
// tuning::kLeastCadence and kMostCadence. Pure.
STYLED_REALTIME float LogCadence(const net::Styles& styles, const Mixer& mixer,
                                 float speed_mps) noexcept;

// Both, for the stylist. Speed is the length of steps times their cadence. If the caller warps time
// to the style's cadence (`own_cadence`), LogStride's factor of the speed is shared: the path is
// scaled by the ratio of step lengths, LogStride - LogCadence, within the bounds of LogStride, for
// which the feet stage is designed. With Root::kFollow the path stays the performer's, and only
// time changes. Pure.
STYLED_REALTIME GaitChange ChangeOfGait(const net::Styles& styles, const Mixer& mixer,
                                        bool own_cadence, float speed_mps) noexcept;

}  // namespace styled::stylist

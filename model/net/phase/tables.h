#pragma once

#include "model/base/realtime.h"
#include "model/gait/lanes.h"
#include "model/net/phase/dynamics.h"
#include "model/net/phase/style.h"
#include "model/net/stylizer.h"

namespace styled::phase {

// A curve as the hot path reads it.
struct LaneCurve {
  explicit LaneCurve(const gait::Curve& curve = {});
  STYLED_REALTIME gait::TurnLanes At(const gait::Terms& terms) const noexcept;

  gait::TurnLanes mean;
  gait::LaneSeries series;
};

// A style as the hot path reads it.
struct Table {
  explicit Table(const Style& style);

  bool difference = false;
  bool has_walk = false, has_run = false;
  LaneCurve walk, run;
  // The style's rotations without a gait, and whether the neutral that it replaces there is the
  // performer's walk (its own gait's mean) or their standing.
  gait::TurnLanes rest;
  bool rest_of_gait = false;
  // Without a gait or a standing performer in the example, only trunk, neck, head and collars of
  // its mean are a posture; 0: the joint keeps what it does.
  gait::Lane rest_share;
  DynamicValues dynamics;
};

// The performer's own neutral in one step, at the phase at which the result is shown.
class Own {
 public:
  // Without a performer: the neutral of `reference`, in no gait.
  STYLED_REALTIME Own(const net::Performer* performer,
                      const neutral::Reference& reference) noexcept;

  const gait::Terms& terms() const { return terms_; }
  float confidence() const { return confidence_; }
  float running() const { return running_; }
  // The gaits at the phase, their means, and standing. Each is computed by the call: few styles
  // need all of them.
  STYLED_REALTIME gait::TurnLanes Walk() const noexcept;
  STYLED_REALTIME gait::TurnLanes Run() const noexcept;
  STYLED_REALTIME gait::TurnLanes WalkMean() const noexcept;
  STYLED_REALTIME gait::TurnLanes RunMean() const noexcept;
  STYLED_REALTIME gait::TurnLanes Standing() const noexcept;
  // The mean of the gait, walking or running, and the rms angles about it, rad.
  STYLED_REALTIME gait::TurnLanes Mean() const noexcept;
  STYLED_REALTIME gait::Lane Spread_rad() const noexcept;

 private:
  gait::Terms terms_;
  float confidence_ = 0, running_ = 0;
  const neutral::Reference& reference_;  // the performer's, if there is one
  const neutral::Neutral* neutral_ = nullptr;
};

// The rotation vectors, after the performer's own rotations, by which the style turns them.
STYLED_REALTIME gait::VectorLanes TurnOf(const Table& style, const Own& own) noexcept;

}  // namespace styled::phase

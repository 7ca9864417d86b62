#pragma once

#include <array>

#include "model/base/realtime.h"
#include "model/gait/curve.h"
#include "model/net/phase/dynamics.h"
#include "model/net/phase/style.h"
#include "model/net/stylizer.h"

namespace styled::phase {

// A style as the hot path reads it.
struct Table {
  explicit Table(const Style& style);

  bool difference = false;
  bool has_walk = false, has_run = false;
  gait::Curve walk, run;
  // The style's rotations without a gait, and whether the neutral that it replaces there is the
  // performer's walk (its own gait's mean) or their standing.
  gait::Rotations rest;
  bool rest_of_gait = false;
  // Without a gait or a standing performer in the example, only trunk, neck, head and collars of
  // its mean are a posture; 0: the joint keeps what it does.
  std::array<float, body::kJointCount> rest_share;
  DynamicValues dynamics;
};

// The performer's own neutral in one step, at the phase at which the result is shown.
struct Own {
  // Without a performer: the neutral of `reference`, in no gait.
  STYLED_REALTIME Own(const net::Performer* performer,
                      const neutral::Reference& reference) noexcept;

  gait::Terms terms;
  float confidence = 0, running = 0;
  gait::Rotations walk, run;                        // at the phase
  gait::Rotations walk_mean, run_mean, standing;    // means
  std::array<float, body::kJointCount> spread_rad;  // rms about the mean of the gait
};

// The rotation vectors, after the performer's own rotations, by which the style turns them.
STYLED_REALTIME gait::Vectors TurnOf(const Table& style, const Own& own) noexcept;

}  // namespace styled::phase

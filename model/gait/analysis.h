#pragma once

#include <optional>
#include <span>

#include "model/gait/curve.h"

namespace styled::gait {

// One gait as a clip shows it.
struct Gait {
  Curve curve;
  float rate_rad_s = 0;  // mean
  float speed_mps = 0;   // mean speed over the floor, canonical; 0: on the spot
  float seconds = 0;     // of the frames that show it
  float strides = 0;     // in these
  float explained = 0;   // 0 .. 1: the share of the movement about the mean that the curve has
};

// The standing, walking and running that a recorded clip shows. Rotations as in Curve.
struct Analysis {
  std::optional<Gait> walk, run;      // each if there are at least 1.5 strides of it
  std::optional<Rotations> standing;  // the mean while they stand
  float standing_s = 0;
  // The mean of the gaits, or of the whole clip without one: a posture.
  Rotations posture;
  float spread_rad = 0;  // of the joints' rotations about the clip's mean, rms
  float seconds = 0;     // of the clip

  bool has_gait() const { return walk || run; }
  bool is_pose() const;  // it does not move
};

// Analyses canonical poses at a constant rate, at least one, by the phase as it is live (Tracker),
// in two passes, so that the second knows the phase from the first frame on. Allocates; 10 s at 30
// Hz take less than 1 ms. Mathematics: model/gait/README.md. Pinned by
// tests/unit/gait/analysis_test.cpp.
Analysis Analyse(std::span<const body::Pose> poses, float rate_hz);

}  // namespace styled::gait

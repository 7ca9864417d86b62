#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "model/clip/clip.h"

namespace styled::offline {

// A clip's frames for a stylist. A live stream does not show the motion between two distant frames;
// a clip allows a smooth curve, so one slower than kSlowest_hz gets `steps` - 1 frames in between.
// `clip` must outlive it; a frame may be overwritten once it and those before it have been read.
// Allocates; one thread at a time. Pinned by tests/unit/library/clips_test.cpp.
struct Frames {
  static constexpr double kSlowest_hz = 30;  // the networks' own rate

  explicit Frames(const clip::Clip& the_clip)
      : clip(the_clip),
        steps(static_cast<std::size_t>(std::ceil(kSlowest_hz / clip.rate_hz - 1e-6))),
        rate_hz(clip.rate_hz * static_cast<double>(steps)),
        count((clip.frames.size() - 1) * steps + 1),
        between(steps > 1 ? clip::Resample(clip, rate_hz) : clip::Clip()) {}
  // Whether frame i is one of the clip's, i / steps.
  bool Given(std::size_t i) const { return i % steps == 0; }
  const rig::RigPose& At(std::size_t i) const {
    return Given(i) ? clip.frames[i / steps] : between.frames[i];
  }
  std::int64_t Time_ns(std::size_t i) const {
    return static_cast<std::int64_t>(static_cast<double>(i) / rate_hz * 1e9);
  }

  const clip::Clip& clip;
  std::size_t steps;
  double rate_hz;
  std::size_t count;
  clip::Clip between;
};

}  // namespace styled::offline

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/clip.h"
#include "model/clip/write.h"
#include "proto/recording/reader.h"

namespace styled::rec {

// Which of a performer's motions.
enum class What {
  kRig,        // styled, on the rig's own skeleton
  kCanonical,  // styled, on the canonical humanoid
  kSource,     // as it came from the rig
  kAvatar,     // styled, on the skeleton of an [[output]]
};

// A performer's motion as recorded: on one skeleton, at the frames' source times.
struct Take {
  std::string performer;
  rig::Skeleton skeleton;  // the rig's units and axes
  std::vector<rig::Quat> rest;
  float metres_per_unit = 1;
  bool unit_known = true;  // false: found by the hips' height above the toes
  rig::Quat canonical_from_source = rig::Quat::Identity();
  std::vector<double> times_s;  // growing, from 0
  std::vector<rig::RigPose> frames;
  std::uint64_t on_other_bodies =
      0;                       // frames left out: the body was changed; the most used one counts
  std::uint64_t unusable = 0;  // frames left out: their body is not in the recording, no numbers
  std::uint64_t restarts = 0;  // the source's clock began anew; it goes on here as time did
};

// Reads all of `reader`, twice. `kSource` comes from source/ or, where there is none, from our own
// datagrams among the arrivals. Errors name the file and what it does hold. Allocates.
// `output`: the name of the [[output]], for `kAvatar`.
Result<Take> ReadTake(recording::Reader& reader, const std::string& performer, What what,
                      const std::string& output = "");

// The take at a constant rate: that of its frames where `rate_hz` is 0 (the median step, rounded to
// the rate that is meant), with the frames as they are when they keep it, else moved to it by
// interpolation; another rate through clip::Resample. Errors: fewer than two frames, a rate out of
// 1 to 1000 Hz, more than ten million frames.
Result<clip::Clip> ToClip(const Take& take, double rate_hz);

// The take as `format` is written: at the frames' own times where `rate_hz` is 0 and the format
// keeps them, else at a constant rate, as ToClip makes it and with its errors.
Result<clip::Motion> ToMotion(const Take& take, double rate_hz, const clip::Format& format);

}  // namespace styled::rec

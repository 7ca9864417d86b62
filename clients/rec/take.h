#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/clip.h"
#include "model/clip/write.h"
#include "proto/recording/reader.h"

namespace styled::rec {

// Selects a motion of a performer.
enum class What {
  kRig,        // styled, on the rig's own skeleton
  kCanonical,  // styled, on the canonical humanoid
  kSource,     // as received from the rig
  kAvatar,     // styled, on the skeleton of an [[output]]
};

// A pause of a recording is exported as the motion between two poses, at the rate of the frames. A
// performer who returns after a day would otherwise fill the memory.
inline constexpr double kLongestPause_s = 10;

// A recorded motion of a performer: on one skeleton, at the source times of its frames.
struct Take {
  std::string performer;
  rig::Skeleton skeleton;  // the rig's units and axes
  std::vector<rig::Quat> rest;
  float metres_per_unit = 1;
  bool unit_known = true;  // false: estimated from the height of the hips above the toes
  rig::Quat canonical_from_source = rig::Quat::Identity();
  std::vector<double> times_s;  // increasing, starts at 0
  std::vector<rig::RigPose> frames;
  // Pauses that were longer than kLongestPause_s and are shortened to that, and the removed time.
  std::uint64_t pauses = 0;
  double left_out_s = 0;
  // Frames skipped because the body changed; the most frequent body is used.
  std::uint64_t on_other_bodies = 0;
  std::uint64_t unusable = 0;  // frames skipped: no body in the recording, or non-finite values
  std::uint64_t restarts = 0;
};

// Reads all of `reader`, twice. `kSource` is taken from source/ or, if that is missing, from native
// datagrams among the arrivals. `output`: the name of the [[output]], for `kAvatar`. Errors name
// the file and its actual content; more than 2 GiB of poses is an error, too. Allocates.
Result<Take> ReadTake(recording::Reader& reader, const std::string& performer, What what,
                      const std::string& output = "");

// Converts the take to a constant rate. `rate_hz` 0: the rate of its frames (the median step,
// rounded to the nominal rate, a usual one within 2 %); the frames stay unchanged if they keep that
// rate, else they are interpolated. Any other rate uses clip::Resample. Errors: fewer than two
// frames, a rate outside 1 to 1000 Hz, more than 16 times as many frames as the take has, and
// 100,000.
Result<clip::Clip> ToClip(const Take& take, double rate_hz);

// Converts the take for `format`: at the frames' own times if `rate_hz` is 0 and the format stores
// times; else at a constant rate, as ToClip does and with its errors.
Result<clip::Motion> ToMotion(const Take& take, double rate_hz, const clip::Format& format);

}  // namespace styled::rec

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/rig/binding.h"
#include "model/rig/skeleton.h"

namespace styled::clip {

// Recorded motion of one skeleton at a constant rate.
struct Clip {
  rig::Skeleton skeleton;
  double rate_hz = 30.0;
  std::vector<rig::RigPose> frames;
  // BVH bookkeeping so that a file is written back as it came: per joint its channels in file order
  // ('X','Y','Z' position, 'x','y','z' rotation), and its End Site offset where it has one.
  std::vector<std::string> channels;
  std::vector<std::vector<rig::Vec3>> end_sites;
};

// Reads a BVH file or text. Accepts any hierarchy, channel order and count, CRLF, tabs, End Sites,
// position channels on any joint, 1 to 1000 Hz. Errors: "FILE:LINE: found X, expected Y".
Result<Clip> ReadBvh(const std::filesystem::path& file);
Result<Clip> ParseBvh(std::string_view text, const std::string& name);

// Writes with the clip's channel order (default: root XYZ + zxy, others zxy), continuous Euler
// angles, %.6f. The format's own precision decides the round trip: < 1e-4 degrees.
Status WriteBvh(const Clip& clip, const std::filesystem::path& file);
std::string FormatBvh(const Clip& clip);

// The clip at another rate, through a C2 interpolant (natural cubic splines on positions and on
// sign-continuous quaternions, renormalized): slerp alone makes 30 Hz clips jerk at 120 Hz. Keeps
// the duration (last frame time <= the source's) and the original frames where the times coincide.
Clip Resample(const Clip& clip, double rate_hz);

// The canonical poses of a clip, and the same resampled in canonical space.
std::vector<body::Pose> ToCanonical(const Clip& clip, const rig::Binding& binding);
std::vector<body::Pose> ResamplePoses(const std::vector<body::Pose>& poses, double rate_hz,
                                      double new_rate_hz);

}  // namespace styled::clip

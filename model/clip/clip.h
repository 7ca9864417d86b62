#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"
#include "model/base/work_limit.h"
#include "model/rig/binding.h"
#include "model/rig/skeleton.h"

namespace styled::clip {

// Recorded motion of one skeleton at a constant rate.
struct Clip {
  rig::Skeleton skeleton;
  double rate_hz = 30.0;
  std::vector<rig::RigPose> frames;
  // The data by which a BVH file is written back unchanged: per joint its channels in file order
  // ('X','Y','Z' position, 'x','y','z' rotation) and the offsets of its End Sites. Empty:
  // FormatBvh's own channels.
  std::vector<std::string> channels;
  std::vector<std::vector<rig::Vec3>> end_sites;
  // The oddities that a reader accepted, for a warning: "239 rows where
  // Frames: says 240; decimal commas are read as points". Empty: nothing.
  std::string remark;
};

// A reader's limits for a client's file.
struct ReadLimits {
  // The length of motion that is read, from its begin; the rest is left out, with a remark.
  double longest_s = std::numeric_limits<double>::infinity();
  WorkLimit work;
};

// The longest example of a style; longer ones are cut there.
inline constexpr double kLongestExample_s = 60;

// The remark of a reader that has read the first seconds only.
std::string OnlyBegin(double seconds);

// The memory that a frame of a skeleton takes, in bytes.
constexpr std::size_t FrameBytes(std::size_t joints) {
  constexpr std::size_t kHeap = 16;  // of each of the two lists
  return sizeof(rig::RigPose) + 2 * kHeap + joints * (sizeof(rig::Vec3) + sizeof(rig::Quat));
}

// Reads a BVH file or text. Accepts any hierarchy, channel order and count, CRLF, CR or LF, UTF-8
// or UTF-16, NUL and Ctrl-Z at the end, tabs, End Sites of any name, position channels on any
// joint, 1 to 1000 Hz (0.0333333 s is read as 30 Hz). Position channels replace the OFFSET, also at
// the root: positions are absolute, not added to it; an axis without a channel keeps the OFFSET.
// Angles are degrees, applied in channel order (intrinsic); the resulting rotations are continuous
// in sign over time.
//
// The oddities that Blender's importer or many exporters tolerate are read, too, with a remark:
// more or fewer rows than Frames: says; rows of several lines, if the first row is one; values that
// are no numbers ("nan"): the frame before stands for the row; decimal commas; several ROOTs: the
// skeleton with most joints; OFFSETs that are all zero below the root where every joint has its
// positions in channels: those of the first frame.
//
// Refuses, besides syntax errors: no channels, a channel twice in a joint, numbers beyond 1e9, rows
// that do not match CHANNELS, no row, more than rig::kMaxSourceJoints joints, a joint's name of
// more than 256 bytes, and a text that takes longer than limits.work. The frames take at most 6
// times the text's bytes and 2 MiB: rows of joints that have hardly a channel are refused. Time in
// proportion to the text. Never throws on content. Errors: "FILE:LINE: found X, expected Y"; for
// limits.work, without the line. Any thread. Pinned by tests/unit/clip/bvh_test.cpp,
// hostile_clips_test.cpp, and by Blender's importer in tests/witness/blender.
Result<Clip> ReadBvh(const std::filesystem::path& file, const ReadLimits& limits = {});
Result<Clip> ParseBvh(std::string_view text, const std::string& name,
                      const ReadLimits& limits = {});

// Writes with the clip's channel order (default: root XYZ + zxy, others zxy), continuous Euler
// angles, %.6f. The precision of the text limits the round trip: < 1e-4 degrees. Rotations about
// axes for which a joint has no channel are lost. Joints are written depth first. Errors: no joints
// or frames, a rate outside 1 to 1000 Hz, a file that cannot be written.
Status WriteBvh(const Clip& clip, const std::filesystem::path& file);
std::string FormatBvh(const Clip& clip);

// Resamples the clip with a C2 interpolant: natural cubic splines on positions and on
// sign-continuous quaternions, renormalized. (With slerp alone, 30 Hz clips jerk at 120 Hz.) Keeps
// the duration (last frame time <= the source's), the original frames at coinciding times, and
// constant translations exactly. `rate_hz` > 0. Allocates; any thread. Pinned by
// tests/unit/clip/resample_test.cpp.
Clip Resample(const Clip& clip, double rate_hz);

// The clip with its frames at other times: frame i is at times_s[i], s. Times begin with 0 and rise
// strictly; there is one per frame. The rate stays, and between frames the interpolant is that of
// Resample. The first and the last frame are kept: if the last is not on the rate's grid, all times
// are stretched by less than half a frame in total, so that it is. At least two frames remain of
// two. Allocates; any thread. Pinned by tests/unit/clip/retime_test.cpp.
Clip Retime(const Clip& clip, std::span<const double> times_s);

// The binding of a clip whose rest pose no dialect knows. It uses the first frame, of those every
// 0.1 s, that stands upright as rig::BindStanding defines it, arms anywhere. Correct only if that
// frame also looks ahead with its soles flat. Errors are those of the first frame.
Result<rig::Binding> BindStanding(const Clip& clip);

// The canonical poses of a clip, continuous in sign over time; and such poses at another rate, by
// the same interpolant. `binding` must be of the clip's skeleton; rates > 0, Hz.
std::vector<body::Pose> ToCanonical(const Clip& clip, const rig::Binding& binding);
std::vector<body::Pose> ResamplePoses(const std::vector<body::Pose>& poses, double rate_hz,
                                      double new_rate_hz);
// The same within a limit, whose errors name `file`. The clip's frames are freed as they are read,
// and the poses come in pieces, so that the memory is that of the larger of the two.
Result<std::deque<body::Pose>> ToCanonical(Clip&& clip, const rig::Binding& binding,
                                           const WorkLimit& work, const std::string& file);
Result<std::vector<body::Pose>> ResamplePoses(const std::deque<body::Pose>& poses, double rate_hz,
                                              double new_rate_hz, const WorkLimit& work,
                                              const std::string& file);

}  // namespace styled::clip

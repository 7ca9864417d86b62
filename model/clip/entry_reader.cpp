#include "model/clip/entry_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/body/heading.h"
#include "model/clip/clip.h"
#include "model/rig/dialects.h"

namespace styled::clip {
namespace {

// The performer's place and heading, as a transform on the floor.
struct OnFloor {
  float heading_rad;
  body::Vec3 hips_m;
};
OnFloor OnFloorOf(const body::Pose& pose) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  return {body::Heading_rad(world), pose.hips_position_m};
}

// The dialect of a clip that is bound by the first frame that stands upright.
constexpr std::string_view kStanding = "standing";

// The height of the floor, from the feet and toes at their lowest compared with a standing
// figure's, m. The share kOnTheFloor of the frames' lowest values counts, so that no single wrong
// frame decides; it is far less than the share of a jump in which a foot stands.
constexpr double kOnTheFloor = 0.02;
float FloorUnderFeet_m(const std::vector<body::Pose>& poses) {
  body::WorldPose standing;
  body::ForwardKinematics(body::Pose(), standing);
  std::vector<float> lowest_m;
  for (const body::Pose& pose : poses) {
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    float lowest = std::numeric_limits<float>::max();
    for (const int joint : {body::kLeftFoot, body::kRightFoot, body::kLeftToes, body::kRightToes}) {
      lowest = std::min(lowest, world.positions_m[joint].y() - standing.positions_m[joint].y());
    }
    lowest_m.push_back(lowest);
  }
  const auto place = static_cast<long>(kOnTheFloor * static_cast<double>(lowest_m.size()));
  std::nth_element(lowest_m.begin(), lowest_m.begin() + place, lowest_m.end());
  return lowest_m[place];
}

}  // namespace

std::vector<body::Pose> RepeatLoop(const std::vector<body::Pose>& loop, int frames) {
  std::vector<body::Pose> out = loop;
  if (loop.size() < 2) return out;
  const OnFloor first = OnFloorOf(loop.front());
  while (static_cast<int>(out.size()) < frames) {
    const OnFloor last = OnFloorOf(out.back());
    const body::Quat turn = body::Yaw(last.heading_rad - first.heading_rad);
    for (std::size_t i = 1; i < loop.size(); ++i) {
      body::Pose pose = loop[i];
      const float height_m = pose.hips_position_m.y();
      pose.hips_position_m = last.hips_m + turn * (pose.hips_position_m - first.hips_m);
      pose.hips_position_m.y() = height_m;
      pose.rotations[body::kHips] = turn * pose.rotations[body::kHips];
      out.push_back(pose);
    }
  }
  return out;
}

Result<const rig::Binding*> EntryReader::Bind(const Clip& clip, const std::string& dialect) {
  const bool standing = dialect == kStanding;
  if (!binding_ || standing || dialect_ != dialect || binding_->skeleton() != clip.skeleton) {
    Result<rig::Binding> bound =
        standing ? BindStanding(clip) : rig::BindDialect(clip.skeleton, dialect);
    if (!bound.ok()) return bound.status();
    binding_.emplace(std::move(bound.value()));
    dialect_ = dialect;
  }
  return &*binding_;
}

// Without the part before the motion, resampled, put on the floor, a loop repeated, then cut to its
// part in time.
Result<std::vector<body::Pose>> EntryReader::Read(const ManifestEntry& entry, double rate_hz) {
  Result<Clip> source = ReadBvh(entry.file);
  if (!source.ok()) return source.status();
  const Result<const rig::Binding*> binding = Bind(source.value(), entry.rig);
  if (!binding.ok()) {
    return Status::Error(entry.file.string() + ": " + binding.status().message());
  }
  auto& frames = source.value().frames;
  const auto skipped = static_cast<std::size_t>(std::lround(entry.skip_s * source.value().rate_hz));
  if (skipped >= frames.size()) {
    return Status::Error(entry.file.string() + ": skip_s leaves nothing of the clip");
  }
  frames.erase(frames.begin(), frames.begin() + static_cast<long>(skipped));
  std::vector<body::Pose> poses = ToCanonical(source.value(), *binding.value());
  if (std::abs(source.value().rate_hz / rate_hz - 1.0) > 1e-3) {
    poses = ResamplePoses(poses, source.value().rate_hz, rate_hz);
  }
  if (entry.floor_at_feet) {
    const float floor_m = FloorUnderFeet_m(poses);
    for (body::Pose& pose : poses) pose.hips_position_m.y() -= floor_m;
  }
  if (entry.repeat_s > 0) {
    poses = RepeatLoop(poses, static_cast<int>(std::ceil(entry.repeat_s * rate_hz)));
  }
  const auto frame_at = [&poses](double share) {
    return static_cast<long>(std::lround(share * static_cast<double>(poses.size())));
  };
  return std::vector<body::Pose>{poses.begin() + frame_at(entry.from),
                                 poses.begin() + frame_at(entry.to)};
}

}  // namespace styled::clip

#include "model/train/dataset.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <limits>
#include <optional>
#include <random>
#include <string_view>
#include <unordered_map>

#include "model/body/heading.h"
#include "model/clip/clip.h"
#include "model/rig/dialects.h"
#include "model/train/persons.h"

namespace styled::train {
namespace {

// Lower limits of the deviations, so that a feature that hardly varies in the clips is not
// standardized to a large number on another rig. Higher: small motion is represented less.
constexpr float kRotationFloor = 0.02F;
constexpr float kPositionFloor_m = 0.01F;
constexpr float kVelocityFloor_mps = 0.05F;
constexpr float kHeightFloor_m = 0.01F;

float DeviationFloor(int feature) {
  if (feature < erd::kPositionBegin) return kRotationFloor;
  if (feature < erd::kVelocityBegin) return kPositionFloor_m;
  if (feature < erd::kHipsHeightIndex) return kVelocityFloor_mps;
  return kHeightFloor_m;
}

int IndexOf(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
}

// One pass over a clip: the heading filter's states, and which frames are still.
void RunFilters(const erd::FeatureParameters& parameters, double still_speed_mps,
                TrainingClip& clip) {
  erd::FeatureState state;
  erd::Features features;
  int still = 0;
  for (const body::Pose& pose : clip.poses) {
    const bool first = !state.started;
    erd::ComputeFeatures(pose, parameters, state, features);
    clip.heading_cos.push_back(state.heading_cos);
    clip.heading_sin.push_back(state.heading_sin);
    if (still_speed_mps <= 0) continue;
    const auto velocities = Eigen::Map<const Eigen::Matrix<float, 3, body::kJointCount>>(
        &features[erd::kVelocityBegin]);
    if (!first && velocities.colwise().norm().maxCoeff() < static_cast<float>(still_speed_mps)) {
      ++still;
    }
    clip.still_count.push_back(still);
  }
}

// The performer's place and heading, as a transform on the floor.
struct Place {
  float heading_rad;
  body::Vec3 hips_m;
};
Place PlaceOf(const body::Pose& pose) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  return {body::Heading_rad(world), pose.hips_position_m};
}

}  // namespace

int TrainingClip::ContentOf(int start, int length) const {
  if (still_count.empty()) return content;
  const int still = still_count[start + length - 1] - (start > 0 ? still_count[start - 1] : 0);
  return 2 * still > length ? still_content : content;
}

std::vector<body::Pose> RepeatLoop(const std::vector<body::Pose>& loop, int frames) {
  std::vector<body::Pose> out = loop;
  if (loop.size() < 2) return out;
  const Place first = PlaceOf(loop.front());
  while (static_cast<int>(out.size()) < frames) {
    const Place last = PlaceOf(out.back());
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

Miscalibration DrawMiscalibration(std::uint64_t seed) {
  constexpr float kRotation_rad = 15.0F * 0.017453293F;  // 15 degrees, of a bad calibration
  constexpr float kFloor_m = 0.1F;
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform;
  Miscalibration out;
  out.rotations[body::kHips] = body::Quat::Identity();
  const float size_rad = kRotation_rad * uniform(random);  // of the joint that is worst
  for (int joint = 1; joint < body::kJointCount; ++joint) {
    const float x = normal(random);
    const float y = normal(random);
    const float z = normal(random);
    out.rotations[joint] =
        body::Exp(body::Vec3(x, y, z).normalized() * (size_rad * uniform(random)));
  }
  out.floor_m = kFloor_m * (2.0F * uniform(random) - 1.0F);
  return out;
}

namespace {

// A frame of a clip as a window shows it.
body::Pose PoseAt(const TrainingClip& clip, int frame, bool mirrored, const Miscalibration* wrong) {
  body::Pose pose = clip.poses[frame];
  if (mirrored) body::Mirror(pose, pose);
  if (wrong == nullptr) return pose;
  for (int joint = 1; joint < body::kJointCount; ++joint) {
    pose.rotations[joint] = pose.rotations[joint] * wrong->rotations[joint];
  }
  pose.hips_position_m.y() += wrong->floor_m;
  return pose;
}

// The data besides the pose on which a frame's features depend.
struct Past {
  erd::FeatureState state;
  float heading_rad = 0.0F;
  body::Vec3 hips_m = body::Vec3::Zero();
};

// The past of the frame after `frame`.
Past PastAt(const TrainingClip& clip, int frame, bool mirrored, const Miscalibration* wrong) {
  const body::Pose before = PoseAt(clip, frame, mirrored, wrong);
  body::WorldPose world;
  body::ForwardKinematics(before, world);
  Past past;
  past.state.started = true;
  past.state.positions_m = world.positions_m;
  past.state.heading_cos = clip.heading_cos[frame];
  past.state.heading_sin = clip.heading_sin[frame] * (mirrored ? -1.0F : 1.0F);
  if (wrong != nullptr) {  // shoulders with a wrong rotation turn the heading, too
    body::WorldPose right_world;
    body::ForwardKinematics(PoseAt(clip, frame, mirrored, nullptr), right_world);
    const Eigen::Rotation2Df turn(body::Heading_rad(world) - body::Heading_rad(right_world));
    const Eigen::Vector2f heading =
        turn * Eigen::Vector2f(past.state.heading_cos, past.state.heading_sin);
    past.state.heading_cos = heading.x();
    past.state.heading_sin = heading.y();
  }
  past.heading_rad = std::atan2(past.state.heading_sin, past.state.heading_cos);
  past.hips_m = before.hips_position_m;
  return past;
}

}  // namespace

void FillWindow(const TrainingClip& clip, int start, int length, bool mirrored, bool session_start,
                const erd::FeatureParameters& parameters, const WindowView& out,
                const Miscalibration* wrong) {
  Past past;
  if (start > 0 && !session_start) past = PastAt(clip, start - 1, mirrored, wrong);
  erd::Features features;
  for (int t = 0; t < length; ++t) {
    const body::Pose pose = PoseAt(clip, start + t, mirrored, wrong);
    const bool first = !past.state.started;
    const float heading_rad = erd::ComputeFeatures(pose, parameters, past.state, features);
    std::copy(features.begin(), features.end(), out.features + t * out.feature_stride);
    if (out.yaw_change_rad != nullptr) {
      out.yaw_change_rad[t * out.yaw_stride] = first ? 0.0F : heading_rad - past.heading_rad;
    }
    if (out.hips_step_m != nullptr) {
      const body::Vec3 step =
          first ? body::Vec3(body::Vec3::Zero())
                : body::Vec3(body::Yaw(-heading_rad) * (pose.hips_position_m - past.hips_m));
      Eigen::Map<body::Vec3>(out.hips_step_m + t * out.step_stride) = step;
    }
    past.heading_rad = heading_rad;
    past.hips_m = pose.hips_position_m;
  }
}

namespace {

// Binds skeletons to the canonical humanoid; keeps the last one, since most sets have only one.
class Binder {
 public:
  static constexpr std::string_view kStanding = "standing";

  Result<const rig::Binding*> Bind(const clip::Clip& clip, const std::string& dialect) {
    const bool standing = dialect == kStanding;
    if (!binding_ || standing || dialect_ != dialect || binding_->skeleton() != clip.skeleton) {
      Result<rig::Binding> bound =
          standing ? clip::BindStanding(clip) : rig::BindDialect(clip.skeleton, dialect);
      if (!bound.ok()) return bound.status();
      binding_.emplace(std::move(bound.value()));
      dialect_ = dialect;
    }
    return &*binding_;
  }

 private:
  std::optional<rig::Binding> binding_;
  std::string dialect_;
};

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

// The poses of an entry at `rate_hz`: without the part before the motion, resampled, put on the
// floor, a loop repeated, then cut to its part in time.
Result<std::vector<body::Pose>> ReadPoses(const clip::ManifestEntry& entry, double rate_hz,
                                          Binder& binder) {
  Result<clip::Clip> source = clip::ReadBvh(entry.file);
  if (!source.ok()) return source.status();
  const Result<const rig::Binding*> binding = binder.Bind(source.value(), entry.rig);
  if (!binding.ok()) {
    return Status::Error(entry.file.string() + ": " + binding.status().message());
  }
  auto& frames = source.value().frames;
  const auto skipped = static_cast<std::size_t>(std::lround(entry.skip_s * source.value().rate_hz));
  if (skipped >= frames.size()) {
    return Status::Error(entry.file.string() + ": skip_s leaves nothing of the clip");
  }
  frames.erase(frames.begin(), frames.begin() + static_cast<long>(skipped));
  std::vector<body::Pose> poses = clip::ToCanonical(source.value(), *binding.value());
  if (std::abs(source.value().rate_hz / rate_hz - 1.0) > 1e-3) {
    poses = clip::ResamplePoses(poses, source.value().rate_hz, rate_hz);
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

}  // namespace

Result<std::vector<TrainingClip>> LoadClips(const clip::Manifest& manifest,
                                            const std::string& split,
                                            const erd::FeatureParameters& parameters,
                                            int min_frames) {
  std::unordered_map<std::string, int> styles;
  for (std::size_t i = 0; i < manifest.styles.size(); ++i) {
    styles[manifest.styles[i].name] = static_cast<int>(i);
  }
  std::vector<TrainingClip> clips;
  std::unordered_map<std::string, int> sources;
  Binder binder;
  for (const clip::ManifestEntry& entry : manifest.entries) {
    if (entry.split != split) continue;
    Result<std::vector<body::Pose>> poses = ReadPoses(entry, parameters.rate_hz, binder);
    if (!poses.ok()) return poses.status();
    TrainingClip clip;
    clip.file = entry.file.string();
    const int next_source = static_cast<int>(sources.size());
    clip.source = sources.try_emplace(entry.file.parent_path().string(), next_source).first->second;
    clip.style = styles.at(entry.style);
    clip.content = IndexOf(manifest.contents, entry.content);
    clip.poses = std::move(poses.value());
    if (static_cast<int>(clip.poses.size()) < min_frames) continue;
    const bool still = entry.still && !manifest.still_content.empty();
    if (still) clip.still_content = IndexOf(manifest.contents, manifest.still_content);
    clip.person = entry.person;
    clips.push_back(std::move(clip));
  }
  if (clips.empty()) {
    return Status::Error("manifest " + manifest.name + ": no clip of split \"" + split + "\" has " +
                         std::to_string(min_frames) + " frames");
  }
  const Status shown = RemovePersons(parameters.rate_hz, clips);
  if (!shown.ok()) return Status::Error("manifest " + manifest.name + ": " + shown.message());
  for (TrainingClip& clip : clips) {
    RunFilters(parameters, clip.still_content < 0 ? 0 : manifest.still_speed_mps, clip);
  }
  return clips;
}

Result<TrainingData> LoadTrainingData(const std::filesystem::path& manifest,
                                      const std::filesystem::path& data,
                                      const erd::FeatureParameters& parameters, int min_frames) {
  const auto begin = std::chrono::steady_clock::now();
  Result<clip::Manifest> read = clip::LoadManifest(manifest, data);
  if (!read.ok()) return read.status();
  Result<std::vector<TrainingClip>> train =
      LoadClips(read.value(), "train", parameters, min_frames);
  if (!train.ok()) return train.status();
  Result<std::vector<TrainingClip>> validation =
      LoadClips(read.value(), "validation", parameters, min_frames);
  if (!validation.ok()) return validation.status();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  std::cout << train.value().size() << " training clips, " << validation.value().size()
            << " validation clips, " << seconds.count() << " s" << std::endl;
  return TrainingData{std::move(read.value()), std::move(train.value()),
                      std::move(validation.value())};
}

void SetHemisphere(const erd::Features& mean, erd::FeatureParameters& parameters) {
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    parameters.hemisphere[joint].coeffs() =
        Eigen::Map<const Eigen::Vector4f>(&mean[4 * joint]).normalized();
  }
}

FeatureStatistics ComputeStatistics(const std::vector<TrainingClip>& clips,
                                    erd::FeatureParameters parameters) {
  FeatureStatistics statistics;
  // First on the hemisphere of identity, then on that of the first pass's mean.
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(erd::kFeatureCount);
    Eigen::ArrayXd square = sum;
    double count = 0;
    std::vector<float> window;
    for (const TrainingClip& clip : clips) {
      const int length = static_cast<int>(clip.poses.size());
      window.resize(static_cast<std::size_t>(length) * erd::kFeatureCount);
      for (const bool mirrored : {false, true}) {
        FillWindow(clip, 0, length, mirrored, false, parameters, {.features = window.data()});
        for (int t = 1; t < length; ++t) {  // the first frame's v = 0 is not a velocity
          const Eigen::ArrayXd x =
              Eigen::Map<const Eigen::ArrayXf>(&window[t * erd::kFeatureCount], erd::kFeatureCount)
                  .cast<double>();
          sum += x;
          square += x.square();
          count += 1;
        }
      }
    }
    const Eigen::ArrayXd mean = sum / count;
    const Eigen::ArrayXd deviation = (square / count - mean.square()).max(0).sqrt();
    for (int i = 0; i < erd::kFeatureCount; ++i) {
      statistics.mean[i] = static_cast<float>(mean[i]);
      statistics.deviation[i] = std::max(static_cast<float>(deviation[i]), DeviationFloor(i));
    }
    SetHemisphere(statistics.mean, parameters);
  }
  return statistics;
}

Status CheckDataFolder(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    return Status::Error("--data " + folder.string() + ": no such folder");
  }
  bool unpacked = false;
  std::string archives;
  for (const auto& item : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = item.path().filename().string();
    if (name.ends_with(".tar.xz")) archives += " " + name;
    if (item.is_directory() && name.find("-") != std::string::npos) unpacked = true;
  }
  if (!unpacked && !archives.empty()) {
    return Status::Error(
        "--data " + folder.string() + " holds only archives (" + archives.substr(1) +
        "). Unpack them, for example: mkdir -p data && for a in " + folder.string() +
        "/*.tar.xz; do tar -xJf \"$a\" -C data; done; then pass --data data");
  }
  return Status::Ok();
}

}  // namespace styled::train

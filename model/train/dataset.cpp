#include "model/train/dataset.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <random>
#include <unordered_map>

#include "model/body/heading.h"
#include "model/clip/entry_reader.h"
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

}  // namespace

int TrainingClip::ContentOf(int start, int length) const {
  if (still_count.empty()) return content;
  const int still = still_count[start + length - 1] - (start > 0 ? still_count[start - 1] : 0);
  return 2 * still > length ? still_content : content;
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
  clip::EntryReader reader;
  for (const clip::ManifestEntry& entry : manifest.entries) {
    if (entry.split != split) continue;
    Result<std::vector<body::Pose>> poses = reader.Read(entry, parameters.rate_hz);
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

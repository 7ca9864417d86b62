#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/net/erd/features.h"

namespace styled::train {

// One labelled clip as canonical poses at the network's rate.
struct TrainingClip {
  std::string file;
  int source = 0;      // clips of one folder share it
  int style = 0;       // index into Manifest::styles
  int content = 0;     // index into Manifest::contents
  std::string person;  // ManifestEntry::person
  std::vector<body::Pose> poses;
  // The heading filter's state after each frame, from the clip's first frame on.
  std::vector<float> heading_cos, heading_sin;
  // The number of still frames up to and including each (Manifest::still_speed_mps); empty if the
  // manifest has no [still].
  std::vector<int> still_count;
  int still_content = -1;

  // The content of frames [start, start + length): the clip's, or that of standing if most of them
  // are still.
  int ContentOf(int start, int length) const;
};

// Mean and deviation of every feature over a set of clips and their mirror images. The mean of each
// quaternion also defines its hemisphere.
struct FeatureStatistics {
  erd::Features mean{}, deviation{};
};

// A performer whose rig is not well calibrated: every joint but the hips has a constant rotation in
// addition to its own, and the floor is too high or too low.
struct Miscalibration {
  std::array<body::Quat, body::kJointCount> rotations;
  float floor_m = 0.0F;
};
// Up to 15 degrees about any axis and up to 10 cm, deterministic by seed.
Miscalibration DrawMiscalibration(std::uint64_t seed);

// Where FillWindow writes, `length` frames each. Frame t of features starts at
// features + t * feature_stride (floats), and so on; strides let a batch be time-major.
struct WindowView {
  float* features = nullptr;
  long feature_stride = erd::kFeatureCount;
  float* yaw_change_rad = nullptr;  // heading now minus heading one frame ago; 0 in a first frame
  long yaw_stride = 1;
  float* hips_step_m = nullptr;  // hips now minus one frame ago, in the heading frame of now
  long step_stride = 3;
};

// Writes frames [start, start + length) of a clip as the network sees them, through
// erd::ComputeFeatures. With `session_start` (or start = 0) the first frame has v = 0 and an
// unfiltered heading, as in a new session; otherwise the window continues the clip's own past. With
// `wrong`, as shown by a rig with this miscalibration.
void FillWindow(const TrainingClip& clip, int start, int length, bool mirrored, bool session_start,
                const erd::FeatureParameters& parameters, const WindowView& out,
                const Miscalibration* wrong = nullptr);

// Reads every clip of `split` with at least `min_frames` frames at `rate_hz`, with persons removed
// (persons.h). Errors name the file or the person.
Result<std::vector<TrainingClip>> LoadClips(const clip::Manifest& manifest,
                                            const std::string& split,
                                            const erd::FeatureParameters& parameters,
                                            int min_frames);

// A run's clips: the splits "train" and "validation".
struct TrainingData {
  clip::Manifest manifest;
  std::vector<TrainingClip> train, validation;
};
// Reads the manifest and both splits as LoadClips does, and prints how many clips there are. Errors
// name the file.
Result<TrainingData> LoadTrainingData(const std::filesystem::path& manifest,
                                      const std::filesystem::path& data,
                                      const erd::FeatureParameters& parameters, int min_frames);

// Mean and deviation, deviations at least 0.02 (r), 0.01 m (p), 0.05 m/s (v), 0.01 m (height).
FeatureStatistics ComputeStatistics(const std::vector<TrainingClip>& clips,
                                    erd::FeatureParameters parameters);

// The hemisphere that statistics (or weights) define.
void SetHemisphere(const erd::Features& mean, erd::FeatureParameters& parameters);

// An error that says how to unpack the data if `folder` contains only archives of the missing
// files.
Status CheckDataFolder(const std::filesystem::path& folder);

}  // namespace styled::train

#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "model/clip/clip.h"
#include "sim/player/motion.h"

namespace styled::player {

// The BVH files that `paths` name, in their order; a folder stands for the *.bvh in it, by name.
// Errors name the path and what was expected.
Result<std::vector<std::filesystem::path>> FindClips(
    const std::vector<std::filesystem::path>& paths);

struct ClipMotionOptions {
  double rate_hz = 120;          // clips are resampled to it (C2)
  std::string dialect = "auto";  // sent in the body; the daemon binds
  float metres_per_unit = 0;     // sent in the body; 0 = unknown
  bool loop = false;             // begin again with the first file after the last
  std::size_t first = 0;         // the file to begin with
};

// Recorded motion on the file's own skeleton. Several files are played one after the other, each a
// new body. A single looped file stays one body: every pass goes on from where the last one
// ended (horizontal place and heading, y up) and leads from its last pose to its first one within
// 0.3 s, so that no frame of a loop jumps. Translations of other joints than the root are not sent.
class ClipMotion final : public Motion {
 public:
  // Reads and resamples the first file. Files not empty. Errors: those of clip::ReadBvh.
  static Result<std::unique_ptr<ClipMotion>> Make(std::vector<std::filesystem::path> files,
                                                  ClipMotionOptions options);

  const RigBody& body() const override { return body_; }
  Step Next(rig::RigPose& pose) override;
  Status error() const override { return error_; }

 private:
  ClipMotion() = default;
  Status Load(std::size_t file);
  void JoinPasses(const rig::RigPose& last);

  std::vector<std::filesystem::path> files_;
  ClipMotionOptions options_;
  RigBody body_;
  clip::Clip clip_;
  std::size_t file_ = 0, frame_ = 0, files_played_ = 0;
  // Since the last seam of a loop: the rigid move that continues the path, and the last pose's
  // difference to the first one, which fades out.
  rig::Quat turn_ = rig::Quat::Identity();
  rig::Vec3 shift_ = rig::Vec3::Zero();
  std::vector<rig::Vec3> seam_;  // rotation vectors per joint; empty before the first seam
  float seam_height_ = 0;
  Status error_ = Status::Ok();
};

}  // namespace styled::player

#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "model/clip/clip.h"
#include "model/rig/dialects.h"
#include "sim/player/motion.h"

namespace styled::player {

// Lists the BVH files of `paths`, in their order; a folder stands for its *.bvh files, sorted by
// name. Errors name the path and what was expected.
Result<std::vector<std::filesystem::path>> FindClips(
    const std::vector<std::filesystem::path>& paths);

struct ClipMotionOptions {
  double rate_hz = 120;          // clips are resampled to this rate
  std::string dialect = "auto";  // sent in the body; the daemon uses it to bind the skeleton
  float metres_per_unit = 0;     // sent in the body; 0 = unknown
  bool loop = false;             // after the last file, continue with the first
  std::size_t first = 0;         // index of the file to start with
  // Joints by hand, where names and tree leave a doubt: then all that are found are sent under the
  // humanoid's names.
  rig::JointNames joints;
};

// Plays recorded motion on the file's own skeleton. Several files are played one after the other,
// each with a new body. A single looped file keeps its body: each pass continues at the horizontal
// position and heading where the previous one ended (y up), and blends from its last pose to the
// first one within 0.3 s, so that no frame jumps. Only the root's translation is sent.
class ClipMotion final : public Motion {
 public:
  // Reads and resamples the first file. `files` must not be empty. Errors: those of clip::ReadBvh,
  // of joints by hand that rig::MapJoints refuses, and a clip that takes more than 512 MiB at the
  // rate.
  static Result<std::unique_ptr<ClipMotion>> Make(std::vector<std::filesystem::path> files,
                                                  ClipMotionOptions options);

  const RigBody& body() const override { return body_; }
  Step Next(rig::RigPose& pose) override;
  Status error() const override { return error_; }

 private:
  ClipMotion() = default;
  Status Load(std::size_t file);
  Status CheckSize(const clip::Clip& clip) const;
  Status NameJoints(clip::Clip& clip) const;
  void FindTPose(const std::string& name, clip::Clip& clip) const;
  void JoinPasses(const rig::RigPose& last);

  std::vector<std::filesystem::path> files_;
  ClipMotionOptions options_;
  RigBody body_;
  clip::Clip clip_;
  std::size_t file_ = 0, frame_ = 0, files_played_ = 0;
  // Since the last seam of a loop: the rigid transform that continues the path, and the difference
  // between the last pose and the first one, which fades out.
  rig::Quat turn_ = rig::Quat::Identity();
  rig::Vec3 shift_ = rig::Vec3::Zero();
  std::vector<rig::Vec3> seam_;  // rotation vectors per joint; empty before the first seam
  float seam_height_ = 0;
  Status error_ = Status::Ok();
};

}  // namespace styled::player

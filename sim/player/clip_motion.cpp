#include "sim/player/clip_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <system_error>
#include <utility>

#include "model/base/text.h"
#include "model/clip/bind_clip.h"
#include "model/rig/dialects.h"
#include "model/rig/find_humanoid.h"
#include "model/rig/motion_up.h"

namespace styled::player {
namespace {

namespace fs = std::filesystem;

constexpr double kSeam_s = 0.3;

bool IsBvh(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".bvh";
}

// The rotation's twist about +Y.
rig::Quat TurnOf(const rig::Quat& q) {
  const float norm = std::hypot(q.w(), q.y());
  if (norm < 1e-6F) return rig::Quat::Identity();
  return {q.w() / norm, 0, q.y() / norm, 0};
}

}  // namespace

Result<std::vector<fs::path>> FindClips(const std::vector<fs::path>& paths) {
  std::vector<fs::path> files;
  for (const fs::path& path : paths) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      if (!fs::exists(path, error)) {
        return Status::Error(path.string() +
                             ": not found, expected a BVH file or a folder of them");
      }
      files.push_back(path);
      continue;
    }
    const std::size_t before = files.size();
    for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
      if (entry.is_regular_file(error) && IsBvh(entry.path())) files.push_back(entry.path());
    }
    if (files.size() == before) {
      return Status::Error(path.string() + ": no *.bvh in it, expected at least one");
    }
    std::sort(files.begin() + static_cast<std::ptrdiff_t>(before), files.end());
  }
  return files;
}

Result<std::unique_ptr<ClipMotion>> ClipMotion::Make(std::vector<fs::path> files,
                                                     ClipMotionOptions options) {
  std::unique_ptr<ClipMotion> motion(new ClipMotion);
  motion->files_ = std::move(files);
  motion->options_ = std::move(options);
  const std::size_t first = motion->options_.first % motion->files_.size();
  if (Status status = motion->Load(first); !status.ok()) return status;
  return motion;
}

Status ClipMotion::Load(std::size_t file) {
  Result<clip::Clip> read = clip::ReadBvh(files_[file]);
  if (!read.ok()) return read.status();
  if (read.value().frames.empty()) {
    return Status::Error(files_[file].string() + ": no frames, expected at least one");
  }
  if (!read.value().remark.empty()) {
    std::fprintf(stderr, "%s: warning: %s\n", files_[file].c_str(), read.value().remark.c_str());
  }
  if (Status status = NameJoints(read.value()); !status.ok()) {
    return Status::Error(files_[file].string() + ": " + status.message());
  }
  if (Status status = CheckSize(read.value()); !status.ok()) {
    return Status::Error(files_[file].string() + ": " + status.message());
  }
  FindTPose(files_[file].string(), read.value());
  clip_ = clip::Resample(read.value(), options_.rate_hz);
  file_ = file;
  frame_ = 0;
  seam_.clear();
  turn_ = rig::Quat::Identity();
  shift_ = rig::Vec3::Zero();
  body_ = {clip_.skeleton, {}, options_.metres_per_unit, options_.dialect};
  return Status::Ok();
}

// A clip at 1 Hz becomes 120 times as large: 1 MB of text took 676 MB.
Status ClipMotion::CheckSize(const clip::Clip& clip) const {
  constexpr double kMost_MiB = 512;  // 110 minutes of a body of 21 joints at 120 Hz
  const double frames = static_cast<double>(clip.frames.size()) * options_.rate_hz / clip.rate_hz;
  const double size_MiB =
      frames * static_cast<double>(clip::FrameBytes(clip.skeleton.names.size())) / (1 << 20);
  if (size_MiB <= kMost_MiB) return Status::Ok();
  return Status::Error("found " + NumberText(frames / options_.rate_hz, 0) + " s of " +
                       std::to_string(clip.skeleton.joint_count()) + " joints, " +
                       NumberText(size_MiB, 0) + " MiB at " + NumberText(options_.rate_hz) +
                       " Hz, expected at most " + NumberText(kMost_MiB) +
                       " MiB; a lower --rate or a shorter clip");
}

Status ClipMotion::NameJoints(clip::Clip& clip) const {
  if (options_.joints.empty()) return Status::Ok();
  std::vector<std::string>& names = clip.skeleton.names;
  const auto map = rig::FindHumanoid(clip.skeleton, options_.joints, clip.frames);
  if (!map.ok()) return map.status();
  // All of them, because one given by hand may have been what decided about others.
  for (std::size_t c = 0; c < map.value().joint.size(); ++c) {
    const int joint = map.value().joint[c];
    if (joint < 0) continue;
    const std::string canonical(body::kHumanoid[c].name);
    std::string& own = names[static_cast<std::size_t>(joint)];
    const auto taken = std::find(names.begin(), names.end(), canonical);
    if (taken != names.end() && &*taken != &own) *taken += "_";
    own = canonical;
  }
  return Status::Ok();
}

// Live, a zero pose is a T-pose, and its up axis the motion's. Others are found as `stylize` finds
// them.
void ClipMotion::FindTPose(const std::string& name, clip::Clip& clip) const {
  const auto warn = [&name](const std::string& what) {
    std::fprintf(stderr, "%s: warning: %s\n", name.c_str(), what.c_str());
  };
  const auto live = rig::BindDialect(clip.skeleton, options_.dialect);
  const auto bound = clip::BindClip(clip, {.dialect = options_.dialect});
  if (bound.ok()) {
    const auto& [binding, dialect, rest, map, remark] = bound.value();
    if (!remark.empty()) warn(remark);
    if (live.ok() && rig::UpOf(binding).dot(rig::UpOf(live.value())) > 0.9F) return;
    clip::Clip straight = clip::WithTPose(clip, binding);
    if (rig::BindDialect(straight.skeleton, options_.dialect).ok()) {
      if (!live.ok()) warn("its zero pose is not a T-pose; sent with that of its " + rest);
      clip = std::move(straight);
      return;
    }
  }
  if (!live.ok()) {
    warn("a daemon without joints for this source refuses it: " + live.status().message());
  }
}

Motion::Step ClipMotion::Next(rig::RigPose& pose) {
  if (frame_ == clip_.frames.size()) {
    ++files_played_;
    if (files_played_ >= files_.size() && !options_.loop) return Step::kEnd;
    if (files_.size() > 1) {
      error_ = Load((file_ + 1) % files_.size());
      return error_.ok() ? Step::kNewBody : Step::kError;
    }
    JoinPasses(pose);
  }
  pose = clip_.frames[frame_];
  rig::Vec3& place = pose.translations[0];
  place = turn_ * place + shift_;
  pose.rotations[0] = turn_ * pose.rotations[0];
  const double share = static_cast<double>(frame_) / (kSeam_s * options_.rate_hz);
  if (!seam_.empty() && share < 1) {
    // 1 - (6 s^5 - 15 s^4 + 10 s^3) fades with zero velocity and acceleration at both ends.
    const double faded = 1 - share * share * share * (10 + share * (6 * share - 15));
    const auto weight = static_cast<float>(faded);
    for (std::size_t j = 0; j < seam_.size(); ++j) {
      pose.rotations[j] = (pose.rotations[j] * body::Exp(weight * seam_[j])).normalized();
    }
    place.y() += weight * seam_height_;
  }
  ++frame_;
  return Step::kPose;
}

// `last` is the last pose sent. The next pass starts one frame later, so that this pose is not
// repeated.
void ClipMotion::JoinPasses(const rig::RigPose& last) {
  frame_ = std::min<std::size_t>(1, clip_.frames.size() - 1);
  const rig::RigPose& first = clip_.frames[0];
  turn_ = TurnOf(last.rotations[0] * first.rotations[0].conjugate());
  shift_ = last.translations[0] - turn_ * first.translations[0];
  seam_height_ = shift_.y();
  shift_.y() = 0;
  seam_.resize(first.rotations.size());
  for (std::size_t j = 0; j < seam_.size(); ++j) {
    const rig::Quat from = j == 0 ? turn_ * first.rotations[0] : first.rotations[j];
    seam_[j] = body::Log(from.conjugate() * last.rotations[j]);
  }
}

}  // namespace styled::player

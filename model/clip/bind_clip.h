#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "model/base/status.h"
#include "model/clip/clip.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"
#include "model/rig/find_humanoid.h"

namespace styled::clip {

// The pose of a clip from which its skeleton's T-pose is derived.
struct RestPose {
  enum class Kind {
    kAuto,      // the dialect's; without a dialect, the straighter of the two below
    kZero,      // the file's zero pose: upright, arms anywhere
    kStanding,  // each limb from the frame in which it is straightest
    kTime,      // the frame nearest to time_s
  };
  Kind kind = Kind::kAuto;
  double time_s = 0;
};
// "auto", "zero", "standing" or a time in seconds from the clip's begin.
Result<RestPose> ParseRestPose(const std::string& text);

struct BindOptions {
  std::string dialect = "auto";
  RestPose rest;
  rig::JointNames joints;  // named by hand
  // The motion's up axis in the file, of unit length; empty: found from zero pose and frames.
  std::optional<rig::Vec3> up;
};
// "auto" is empty; "x", "y", "z", "-x", "-y", "-z".
Result<std::optional<rig::Vec3>> ParseUp(const std::string& text);

struct BoundClip {
  rig::Binding binding;
  std::string dialect;  // as rig::BindDialect names it; "standing" where no dialect has such names
  std::string rest;  // "zero pose", "straightest frames" or "frame at 1.2 s"; "": the dialect's own
  rig::HumanoidMap map;
  // What a user should know: the map's remark, a motion whose up axis is not the zero pose's, a
  // bone that points elsewhere than on the humanoid (rig::WrongBone). Sentences; "" if nothing.
  std::string remark;
};

// Binds a clip of any skeleton and rest pose. Joints are found by rig::FindHumanoid, sides also
// from the frames. With kAuto and dialect "auto" rig::BindMapped decides if it can, so that known
// dialects are bound as live. Otherwise the T-pose is found from an upright pose with its arms
// anywhere (rig::BindStanding). One frame every 0.1 s is considered: a leg is taken from the frame
// in which it is straightest, a foot where it lies flattest, an arm where it hangs or points
// sideways, so that a walk is sufficient. A motion that stands along another axis than the zero
// pose is bound by it (rig::UpOfMotion). Errors: a joint that is not found or in doubt (the
// skeleton's names are listed), a time beyond the clip, no upright pose; none names the file.
// Allocates; any thread. Pinned by tests/unit/clip/bind_clip_test.cpp.
Result<BoundClip> BindClip(const Clip& clip, const BindOptions& options = {});

// The same motion of the same joints, with the binding's T-pose as the skeleton's zero pose.
Clip WithTPose(Clip clip, const rig::Binding& binding);

}  // namespace styled::clip

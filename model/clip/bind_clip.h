#pragma once

#include <string>
#include <string_view>

#include "model/base/status.h"
#include "model/clip/clip.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"

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

struct BoundClip {
  rig::Binding binding;
  std::string dialect;  // as rig::BindDialect names it; "standing" where no dialect has such names
  std::string rest;  // "zero pose", "straightest frames" or "frame at 1.2 s"; "": the dialect's own
};

// Binds a clip whose rest pose need not be a T-pose. With kAuto and dialect "auto" rig::BindDialect
// decides if it can, so that known dialects are bound as live. Otherwise the T-pose is found from
// an upright pose with its arms anywhere (rig::BindStanding). One frame every 0.1 s is considered:
// a leg is taken from the frame in which it is straightest, a foot where it lies flattest, an arm
// where it hangs or points sideways, so that a walk is sufficient. `given`: joints named by hand.
// Errors: a joint that no name maps to (the skeleton's names are listed), a time beyond the clip,
// no upright pose; none names the file. Allocates; any thread. Pinned by
// tests/unit/clip/bind_clip_test.cpp.
Result<BoundClip> BindClip(const Clip& clip, std::string_view dialect = "auto",
                           const RestPose& rest = {}, const rig::JointNames& given = {});

// The same motion of the same joints, with the binding's T-pose as the skeleton's zero pose.
Clip WithTPose(Clip clip, const rig::Binding& binding);

}  // namespace styled::clip

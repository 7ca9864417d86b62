#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/base/status.h"
#include "model/rig/binding.h"

namespace styled::rig {

// Maps joint names to the canonical humanoid by the naming conventions of the field (VRM/Unity,
// Mixamo, HIK/LaFAN1, CMU, Xsens, Motive, Rokoko, Axis, Bandai-Namco, Biped, Unreal, SMPL, ...; the
// tables are in joint_names.cpp). Prefixes up to the last ':' and separators are dropped, case is
// ignored, sides are read from Left/Right, L/R, _L/_R. Entry c is the source joint for canonical
// joint c, -1 if no name fits. Allocates; any thread. The same holds for all functions here.
std::array<int, body::kJointCount> MapJointNames(const Skeleton& skeleton);

// Joints named in the configuration, where conventions do not help: pairs of the canonical name
// (leftUpperArm) and the source's name; "" if the source has none.
using JointNames = std::vector<std::pair<std::string, std::string>>;
// Joints named on a command line, each CANONICAL=NAME; errors begin with the option.
Result<JointNames> ParseJoints(const std::string& option, const std::vector<std::string>& texts);
// The map of FindHumanoid (rig/find_humanoid.h): by the tree and names, joints `given` by hand
// fixed. Errors: a name that is not a canonical joint's, a joint that the skeleton lacks, a source
// joint given for two canonical ones, a tree that can be read in two ways.
Result<std::array<int, body::kJointCount>> MapJoints(const Skeleton& skeleton,
                                                     const JointNames& given);

// Makes the binding for `skeleton` under the named dialect, or, with "auto", under the dialect
// recognized by joint names. Dialects: "bandai-namco" (rest rotations are constants, found by
// swinging a standing frame); "cmu" (its zero pose, legs spread by 20 degrees, is swung); "rokoko"
// (constants, unless its zero pose is a T-pose already); "canonical", "vrm" and others whose zero
// pose is a T-pose with identity rotations. Rest poses are never guessed from a clip here
// (clip::BindClip does that).
//
// The resulting rest pose must be a T-pose: arms sideways, legs down, head up, each within 25
// degrees, and toes in front. Up, left and forward become the source axes nearest to it. Errors
// name the joints that could not be mapped and the known dialects.
//
// `used`, if given, is set to the dialect in use: `dialect`, or what "auto" found, where
// "canonical" stands for all with identity rotations that DialectOfNames does not know. Pinned by
// tests/unit/rig/dialects_test.cpp.
Result<Binding> BindDialect(const Skeleton& skeleton, std::string_view dialect = "auto",
                            std::string* used = nullptr, const JointNames& given = {});

// The same for joints that are mapped already (FindHumanoid).
Result<Binding> BindMapped(const Skeleton& skeleton, std::string_view dialect, std::string* used,
                           const std::array<int, body::kJointCount>& map);

// Whether BindDialect accepts it; "auto" counts as a dialect.
bool IsDialect(std::string_view name);
// The dialect that is the only one with these joint names ("poser", "character-creator", "cmu",
// ...); "" if the names are ambiguous.
std::string_view DialectOfNames(const Skeleton& skeleton);

}  // namespace styled::rig

#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/base/status.h"
#include "model/rig/binding.h"

namespace styled::rig {

// Maps joint names to the canonical humanoid by the naming habits of the field (VRM/Unity, Mixamo,
// HIK/LaFAN1, CMU, Xsens, Motive, Rokoko, Axis, Bandai-Namco, ...): prefixes up to the last ':' and
// separators dropped, case folded, sides from Left/Right, L/R, _L/_R. -1 where nothing fits. The rows
// are in joint_names.cpp, Biped, Unreal and SMPL among them. Allocates; any thread, as BindDialect.
std::array<int, body::kJointCount> MapJointNames(const Skeleton& skeleton);

// Joints named by hand, where habits do not help: canonical name (leftUpperArm) and the source's;
// "" = the source has none.
using JointNames = std::vector<std::pair<std::string, std::string>>;
// MapJointNames, but for those given. Errors: a name that is no canonical joint's, that the
// skeleton lacks, or that is given twice.
Result<std::array<int, body::kJointCount>> MapJoints(const Skeleton& skeleton,
                                                     const JointNames& given);

// The binding for `skeleton` under the named dialect, or, for "auto", the dialect recognized by its
// joint names and offsets. Knows "bandai-namco" (rest rotations are constants found by swinging a
// standing frame), "cmu" (its zero pose, legs spread by 20 degrees, is swung), "canonical", "vrm"
// and the other identity-rest T-pose dialects; "rokoko" has constants, unless its zero pose is a
// T-pose already. Rest poses are never guessed from a clip. The rest pose that results must be a
// T-pose: arms sideways, legs down, head up within 25 degrees, toes in front; up, left and forward
// are the source axes nearest to it. Pinned by tests/unit/rig/dialects_test.cpp.
// `used`, where given, is set to the dialect in use: `dialect`, or what "auto" found; "canonical"
// stands for all whose rest rotations are identity.
// Errors name the joints that could not be mapped and the dialects known.
Result<Binding> BindDialect(const Skeleton& skeleton, std::string_view dialect = "auto",
                            std::string* used = nullptr, const JointNames& given = {});

}  // namespace styled::rig

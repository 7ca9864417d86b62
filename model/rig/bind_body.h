#pragma once

#include <memory>
#include <string>

#include "model/base/status.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"
#include "model/rig/find_humanoid.h"
#include "model/rig/skeleton.h"

namespace styled::rig {

// A body as a rig or a program describes it, checked and bound: by its own T-pose rests, otherwise
// by a dialect. Allocates; any thread. Pinned by
// tests/unit/daemon/perform/performer/conventions_test.cpp.
struct BoundBody {
  std::shared_ptr<const Binding> binding;
  // "given" if the body came with its rests; "standing" if its zero pose is upright with its arms
  // down; else as BindDialect names it.
  std::string dialect;
  // In the rest pose the toes lie behind the ankles: left and right are exchanged, or the axes are
  // mirrored. The body is bound nevertheless; a calibration corrects it.
  bool toes_backwards = false;
  std::string remark;  // HumanoidMap's
};

// Parents and offsets have an entry per joint, rests as many or none. Errors name the joint, and
// what was expected and found.
Status CheckBody(const RigBody& body);

// FindHumanoid, by the body's own T-pose where it has one.
Result<HumanoidMap> MapBody(const RigBody& body, const JointNames& given = {});

// `given`: the source's joint names set by hand. Errors: CheckBody's, FindHumanoid's,
// BindDialect's.
Result<BoundBody> BindBody(const RigBody& body, const JointNames& given = {});

// BoundBody::toes_backwards of a binding.
bool ToesPointBackwards(const BindingSpec& spec);

}  // namespace styled::rig

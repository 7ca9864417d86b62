#pragma once

#include <memory>
#include <optional>
#include <string>

#include "daemon/looks/profile.h"
#include "model/base/status.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"
#include "proto/styled/v1/body.pb.h"

namespace styled::pipeline {

// A rig's body, checked and bound. The binding comes from a calibration of this skeleton if there
// is one, otherwise from the body's own T-pose rests, otherwise from a dialect.
struct BoundBody {
  std::shared_ptr<const rig::Binding> binding;
  // "calibrated"; "given" if the rig sent its rests; "standing" if its zero pose is upright with
  // its arms down.
  std::string dialect;
  // The binding is that of the mirrored skeleton; poses must be mirrored, too.
  bool left_handed = false;
  // In the rest pose the toes lie behind the ankles: left and right are exchanged, or the axes are
  // mirrored. The body is bound nevertheless; a calibration corrects it.
  bool toes_backwards = false;
  std::string remark;  // rig::HumanoidMap's
};

// Errors state what in the body was expected and found. Both functions allocate; pipeline thread,
// outside the hot section.
Result<rig::Skeleton> ReadSkeleton(const v1::Body& body);
// `given`: the source's joint names set by hand.
Result<BoundBody> BindBody(const v1::Body& body, const std::optional<KeptRest>& calibrated,
                           const rig::JointNames& given = {});

}  // namespace styled::pipeline

#pragma once

#include <memory>
#include <optional>
#include <string>

#include "daemon/pipeline/profile.h"
#include "model/base/status.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"
#include "proto/styled/v1/body.pb.h"

namespace styled::pipeline {

// A rig's body, checked and bound: by a calibration of this skeleton where there is one, by its own
// T-pose rests where it sends them, else by dialect.
struct BoundBody {
  std::shared_ptr<const rig::Binding> binding;
  std::string dialect;       // "calibrated"; "given" where the rig sent its rests
  bool left_handed = false;  // binding is of the skeleton mirrored; poses are to be, too
  // In the rest pose the toes lie behind the ankles: left and right are exchanged, or the axes are
  // mirrored. Bound all the same; a calibration mends it.
  bool toes_backwards = false;
};

// Errors say what in the body was expected and found. Allocate; pipeline thread, outside the hot
// section.
Result<rig::Skeleton> ReadSkeleton(const v1::Body& body);
// `given`: the source's joints by hand.
Result<BoundBody> BindBody(const v1::Body& body, const std::optional<KeptRest>& calibrated,
                           const rig::JointNames& given = {});

}  // namespace styled::pipeline

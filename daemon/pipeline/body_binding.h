#pragma once

#include <memory>
#include <string>

#include "model/base/status.h"
#include "model/rig/binding.h"
#include "proto/styled/v1/body.pb.h"

namespace styled::pipeline {

// A rig's body, checked and bound: by its own T-pose rests where it sends them, else by dialect.
struct BoundBody {
  std::shared_ptr<const rig::Binding> binding;
  std::string dialect;  // "given" where the rig sent its rests
};

// Errors say what in the body was expected and found. Allocates; pipeline thread, outside the hot
// section.
Result<BoundBody> BindBody(const v1::Body& body);

}  // namespace styled::pipeline

#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "model/base/status.h"
#include "model/clip/avatar.h"
#include "proto/styled/v1/body.pb.h"

namespace styled::pipeline {

// One [[output]] with its avatar. Immutable and shared by performers.
struct RetargetOutput {
  std::string name;
  std::vector<std::string> performers;  // ids; empty = all
  clip::AvatarSkeleton skeleton;
  v1::Body body;  // without a performer's name; in the axes and units of the avatar's file

  bool IsFor(std::string_view performer) const;
};

// Errors name the place in the config and the file, and say what was expected. Start-up and reload
// only; allocates.
Result<std::shared_ptr<const RetargetOutput>> ReadRetargetOutput(const config::Output& output);

}  // namespace styled::pipeline

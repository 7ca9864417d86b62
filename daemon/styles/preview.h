#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "daemon/looks/runtime_config.h"
#include "model/base/status.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Small moving figures of styles (v1::PreviewReply): two strides of the built-in performer's walk
// in a style. They loop: the first frames are blended with those after the last. Each is computed
// once, in some 30 ms, and kept until the style or the weights change. Files thread; allocates.
// Pinned by tests/e2e/style_library_test.cpp.
class Previews {
 public:
  // Answers for a style by its name or alias. CODE_UNKNOWN_STYLE: there is no such style.
  Status Make(const RuntimeConfig& config, const std::string& style, v1::PreviewReply& reply);

 private:
  struct Kept {
    std::uint32_t weights_crc = 0;
    std::shared_ptr<const MadeStyle> style;  // null: styles of the weights
    v1::PreviewReply preview;
  };
  std::map<std::string, Kept> kept_;  // by style name
};

}  // namespace styled::pipeline

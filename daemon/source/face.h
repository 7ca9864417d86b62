#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "model/base/realtime.h"

namespace styled::source {

// What a rig sends beside the pose: expressions (name and weight), and messages to be passed on
// unread. Views; a translator keeps one and refills it.
struct Face {
  struct Expression {
    std::string_view name;  // UTF-8
    float value = 0;
  };
  std::vector<Expression> expressions;
  std::vector<std::span<const std::byte>> thru;
};

// The face as fields 18 and 19 of v1::SourceFrame, the bytes that protobuf would write. Returns
// their number, or 0 where `to` is too small for all of them. Pure.
// Pinned against protobuf by tests/unit/daemon/performer_stream_test.cpp.
STYLED_REALTIME std::size_t EncodeFace(const Face& face, std::span<std::byte> to) noexcept;

// Whether protobuf's readers accept it as a string: no surrogates, no overlong forms.
STYLED_REALTIME bool IsUtf8(std::string_view text) noexcept;

}  // namespace styled::source

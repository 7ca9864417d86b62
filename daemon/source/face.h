#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "model/base/realtime.h"

namespace styled::source {

// Data that a rig sends in addition to the pose: expressions (name and weight), and messages that
// are passed on unread. Holds views only; a translator keeps one object and refills it.
struct Face {
  struct Expression {
    std::string_view name;  // UTF-8
    float value = 0;
  };
  std::vector<Expression> expressions;
  std::vector<std::span<const std::byte>> thru;
};

// Encodes the face as fields 18 and 19 of v1::SourceFrame, byte for byte as protobuf would. Returns
// the number of bytes, or 0 if `to` is too small for all of them. Pure. Pinned against protobuf by
// tests/unit/daemon/source/performer_stream_test.cpp.
STYLED_REALTIME std::size_t EncodeFace(const Face& face, std::span<std::byte> to) noexcept;

// The part of an encoded face that holds the messages that are passed on: they follow the
// expressions (frame.proto). Empty if the bytes are not such fields.
STYLED_REALTIME std::span<const std::byte> PassedOn(std::span<const std::byte> face) noexcept;
// Writes an encoded face with its values multiplied by `by`. Expressions that close an eye ("blink"
// in their names, in any case: eyeBlinkLeft, Blink_L) are `closed` at least. Returns the number of
// bytes; 0 if `to` is too small, or the bytes are not such fields.
STYLED_REALTIME std::size_t RestFace(std::span<const std::byte> face, float by, float closed,
                                     std::span<std::byte> to) noexcept;
// Writes an encoded face to `to`, which must not overlap it, with left and right exchanged in the
// names of its expressions: Left and Right in any case as words of their own (eyeBlinkLeft,
// leftEye, mouth_right), L and R between separators (Blink_L, L-brow). Words that only contain them
// (bright, Upright) stay, and so do messages that are passed on, and everything after bytes that
// are not such fields. Returns the number of bytes, or 0 if `to` is too small for all of them: a
// Right is a byte longer than a Left. Pinned by tests/unit/daemon/source/face_test.cpp.
STYLED_REALTIME std::size_t MirrorFace(std::span<const std::byte> face,
                                       std::span<std::byte> to) noexcept;
// Multiplies the values of an encoded face's expressions; stops at bytes that are not such fields.
STYLED_REALTIME void ScaleFace(std::span<std::byte> face, float by) noexcept;

}  // namespace styled::source

#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "model/base/realtime.h"
#include "model/rig/skeleton.h"
#include "proto/styled/props.h"

namespace styled::source {

// A rigid object that the rig tracks: its pose in the world, in the units and axes of the body's
// root position. A view only.
struct Prop {
  std::string_view name;  // UTF-8
  rig::Vec3 position = rig::Vec3::Zero();
  rig::Quat rotation = rig::Quat::Identity();
};

// The props of a frame: checked by ReadProps, or gathered by a translator.
struct PropList {
  std::array<Prop, kMaxProps> props;
  std::size_t count = 0;
  std::size_t left_out = 0;

  std::span<const Prop> all() const noexcept { return std::span(props).first(count); }
  STYLED_REALTIME void Add(const Prop& prop) noexcept {
    if (count == kMaxProps) {
      ++left_out;
      return;
    }
    props[count++] = prop;
  }
};

// Encodes the props as field 20 of v1::SourceFrame, byte for byte as protobuf would, as many as fit
// into `to`; returns the number of bytes. A name is cut after the first byte that makes it too
// long, so that ReadProps counts it. Pure. Pinned against protobuf by
// tests/unit/daemon/perform/performer/props_test.cpp.
STYLED_REALTIME std::size_t EncodeProps(std::span<const Prop> props,
                                        std::span<std::byte> to) noexcept;

// Reads encoded props; their names point into `bytes`. The following are left out and counted: a
// prop without a name; a name that is too long, not UTF-8 or that of an earlier prop; a position or
// rotation that is not three or four packed, finite numbers; coordinates beyond a billion units; a
// rotation of zero length; props beyond kMaxProps. Bytes that are not such a field end the reading
// and count as one prop. A rotation whose length is not 1 is normalized, like that of a joint.
// Pure; any bytes.
STYLED_REALTIME void ReadProps(std::span<const std::byte> bytes, PropList& list) noexcept;

}  // namespace styled::source

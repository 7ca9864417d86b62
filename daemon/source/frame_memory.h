#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "daemon/source/source_frame.h"
#include "model/base/realtime.h"
#include "model/rig/binding.h"
#include "proto/styled/face.h"
#include "proto/styled/props.h"

namespace styled::source {

// Copies a SourceFrame, so that it outlives the call that delivered it. Pipeline thread.
class FrameMemory {
 public:
  // Reserves `bytes` for name, pose, face and props, or for a body. Allocates.
  explicit FrameMemory(std::size_t bytes) { bytes_.reserve(bytes); }

  // Returns a copy of the frame whose views point into this object; valid until the next Keep.
  // Allocates only for a frame that is larger than the reserved room and all earlier frames.
  STYLED_REALTIME SourceFrame Keep(const SourceFrame& frame) noexcept {
    SourceFrame kept = frame;
    const auto name = std::as_bytes(std::span(frame.performer));
    // Copy all bytes before taking views: the vector moves when it grows.
    bytes_.assign(name.begin(), name.end());
    for (const auto part :
         {frame.root_position, frame.rotations, frame.face, frame.props, frame.body_bytes}) {
      bytes_.insert(bytes_.end(), part.begin(), part.end());
    }
    kept.performer = {reinterpret_cast<const char*>(bytes_.data()), name.size()};
    std::size_t begin = name.size();
    for (auto* const view :
         {&kept.root_position, &kept.rotations, &kept.face, &kept.props, &kept.body_bytes}) {
      *view = std::span<const std::byte>(bytes_).subspan(begin, view->size());
      begin += view->size();
    }
    return kept;
  }

 private:
  std::vector<std::byte> bytes_;
};

// The largest frame of a translator: a name, 256 joints, the largest face and all props.
inline constexpr std::size_t kMostFrameBytes =
    32 + sizeof(rig::Vec3) + rig::kMaxSourceJoints * sizeof(rig::Quat) + kMaxFace + kMaxPropBytes;

}  // namespace styled::source

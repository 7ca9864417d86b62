#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "daemon/source/face.h"
#include "daemon/source/outbox.h"
#include "model/base/realtime.h"
#include "proto/arkit/shapes.h"

namespace styled::source {

// Turns the faces of a source that is merged into a performer (config::Source::merge_into) into
// SourceFrames that have a face and no pose. Made when a sender is first seen; pipeline thread.
// Nothing but the constructor allocates. Pinned by tests/unit/livelinkface/translator_test.cpp.
class FaceStream {
 public:
  FaceStream();

  // Subsequent frames belong to a new session.
  STYLED_REALTIME void Restart() noexcept;
  // `number`: the frame's number, increasing within a session; an older one is not merged. A face
  // of more than kMaxFace bytes is not sent.
  STYLED_REALTIME void Send(const Face& face, std::uint64_t number, std::uint64_t source_time_ns,
                            Outbox& out) noexcept;

 private:
  std::uint64_t session_;
  std::vector<std::byte> bytes_;
};

// The face of ARKit's 52 weights, clamped to 0 .. 1: under their own names, or as VRM's presets. A
// weight that is not a number keeps its last value. Allocates only in the constructor.
class ShapeFace {
 public:
  explicit ShapeFace(bool as_presets);
  STYLED_REALTIME const Face& Of(std::span<const float, arkit::kShapes> shapes) noexcept;

 private:
  bool as_presets_;
  std::array<float, arkit::kShapes> last_{};
  Face face_;
};

}  // namespace styled::source

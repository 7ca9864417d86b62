#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/perform/merge/finger_layer.h"
#include "daemon/perform/merge/merged_part.h"
#include "daemon/source/source_frame.h"
#include "model/base/realtime.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::pipeline {

// The newest face of a source that is merged into a performer: as it came for kHold_ns, then all
// expressions fade to 0 within kFade_ns and stay there for kZero_ns, so that no avatar keeps half a
// smile. After that there is no face. Nothing but the constructor allocates.
class FaceLayer : public MergedPart {
 public:
  static constexpr std::int64_t kZero_ns = 1'000'000'000;

  FaceLayer();
  // Takes a frame's face over; kAccepted, or what it is refused as. `now_ns`: monotonic.
  STYLED_REALTIME runtime::Counter Accept(const source::SourceFrame& frame,
                                          std::int64_t now_ns) noexcept;
  // What is shown instead of `own`: the layer's expressions and what `own` passes on unread; valid
  // until the next call. `own` itself where the layer has no face.
  STYLED_REALTIME std::span<const std::byte> Over(std::span<const std::byte> own,
                                                  std::int64_t now_ns) noexcept;

 private:
  std::vector<std::byte> face_, shown_;
};

// What one source gives to the performer that it is merged into: one of the parts, or both.
struct Layer {
  std::string source, into;
  std::optional<FaceLayer> face;
  std::optional<FingerLayer> fingers;

  // Takes over what the frame has of the parts; kAccepted, or what it is refused as. A frame that
  // has nothing of them is ignored.
  STYLED_REALTIME runtime::Counter Accept(const source::SourceFrame& frame,
                                          std::int64_t now_ns) noexcept;
};

// The layers of all sources. Where two sources give the same part of one performer, the first that
// has it counts, finger by finger. Pipeline thread. Pinned by tests/unit/daemon/layers_test.cpp.
class Layers {
 public:
  // Makes the layers of the sources with merge_into.
  void Set(const std::vector<config::Source>& sources);

  // The layer that a source's frames belong to; null: they are performers'.
  STYLED_REALTIME Layer* Of(int source) noexcept {
    const auto at = static_cast<std::size_t>(source);
    return at < layers_.size() ? layers_[at].get() : nullptr;
  }
  // `own`, or what the layers of this performer show instead.
  STYLED_REALTIME std::span<const std::byte> FaceOf(std::string_view performer,
                                                    std::span<const std::byte> own,
                                                    std::int64_t now_ns) noexcept;
  // The fingers of this performer, in the order of the configuration. Valid as long as this object.
  std::vector<FingerLayer*> FingersOf(std::string_view performer);
  // The performer that a source is merged into; "": none, the source has performers of its own.
  std::string Into(std::size_t source) const {
    return source < layers_.size() && layers_[source] ? layers_[source]->into : "";
  }
  // Fills `layers` of the row.
  void Describe(std::int64_t now_ns, v1::PerformerStats& row) const;
  std::size_t size() const { return layers_.size(); }

 private:
  std::vector<std::unique_ptr<Layer>> layers_;  // by source; null: it has performers of its own
};

}  // namespace styled::pipeline

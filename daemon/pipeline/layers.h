#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/source/source_frame.h"
#include "model/base/realtime.h"

namespace styled::pipeline {

// The newest face of a source that is merged into a performer: as it came for kHold_ns, then all
// expressions fade to 0 within kFade_ns and stay there for kZero_ns, so that no avatar keeps half a
// smile. After that there is no face. Nothing but the constructor allocates.
class FaceLayer {
 public:
  // A phone sends 60 frames a second and pauses when its camera loses the face for a moment.
  static constexpr std::int64_t kHold_ns = 500'000'000;
  static constexpr std::int64_t kFade_ns = 500'000'000;
  static constexpr std::int64_t kZero_ns = 1'000'000'000;

  FaceLayer();
  // Returns false for a frame that is not newer than the last of its session. `now_ns`: monotonic.
  STYLED_REALTIME bool Take(const source::SourceFrame& frame, std::int64_t now_ns) noexcept;
  // What is shown instead of `own`: the layer's expressions and what `own` passes on unread; valid
  // until the next call. `own` itself where the layer has no face.
  STYLED_REALTIME std::span<const std::byte> Over(std::span<const std::byte> own,
                                                  std::int64_t now_ns) noexcept;
  // Whether it came, 1, or fell silent, -1, since the last call; 0: neither.
  STYLED_REALTIME int Change(std::int64_t now_ns) noexcept;

 private:
  bool any_ = false, told_ = false;
  std::uint64_t session_ = 0, sequence_ = 0;
  std::int64_t taken_ns_ = 0;
  std::vector<std::byte> face_, shown_;
};

// The layers of all sources. Pipeline thread. Pinned by tests/unit/daemon/layers_test.cpp.
class Layers {
 public:
  // Of each source the performer's id that it is merged into; "": it has performers of its own.
  void Set(std::vector<std::string> merge_into);

  // The layer that a source's frames belong to; null: they are performers'.
  STYLED_REALTIME FaceLayer* Of(int source) noexcept {
    const auto at = static_cast<std::size_t>(source);
    return at < layers_.size() ? layers_[at].get() : nullptr;
  }
  // `own`, or what the layers of this performer show instead; the first source with a face counts.
  STYLED_REALTIME std::span<const std::byte> FaceOf(std::string_view performer,
                                                    std::span<const std::byte> own,
                                                    std::int64_t now_ns) noexcept;
  const std::string& Into(std::size_t source) const { return into_[source]; }
  std::size_t size() const { return layers_.size(); }

 private:
  std::vector<std::string> into_;
  std::vector<std::unique_ptr<FaceLayer>> layers_;
};

}  // namespace styled::pipeline

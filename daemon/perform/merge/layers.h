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

// The newest face of a source that is merged into a performer. It stays for kHold_ns, then all
// expressions fade to 0 within kFade_ns and stay 0 for kZero_ns, so that no avatar keeps half a
// smile. After that there is no face. Only the constructor allocates.
class FaceLayer : public MergedPart {
 public:
  static constexpr std::int64_t kZero_ns = 1'000'000'000;

  FaceLayer();
  // Accepts a frame's face. Returns kAccepted, or the counter of its refusal. `now_ns`: monotonic.
  STYLED_REALTIME runtime::Counter Accept(const source::SourceFrame& frame,
                                          std::int64_t now_ns) noexcept;
  // The face to publish instead of `own`: the layer's expressions and the other fields of `own`,
  // unread. Valid until the next call. Returns `own` itself if the layer has no face.
  STYLED_REALTIME std::span<const std::byte> Over(std::span<const std::byte> own,
                                                  std::int64_t now_ns) noexcept;

 private:
  std::vector<std::byte> face_, shown_;
};

// The data that one source merges into a performer: a face, fingers, or both.
struct Layer {
  std::string source;
  // The performer's id; "": none yet, because the layer belongs to the only performer (`follows`),
  // and two were here.
  std::string into;
  bool follows = false;
  std::optional<FaceLayer> face;
  std::optional<FingerLayer> fingers;

  // Whether a part of it arrives.
  bool Live(std::int64_t now_ns) const noexcept {
    return (face && face->Live(now_ns)) || (fingers && fingers->Live(now_ns));
  }
  // Accepts the frame's face and fingers. Returns kAccepted, or the counter of its refusal. Ignores
  // a frame that has neither.
  STYLED_REALTIME runtime::Counter Accept(const source::SourceFrame& frame,
                                          std::int64_t now_ns) noexcept;
};

// The layers of all sources. If two sources have the same part of one performer, the first one that
// has data counts, for each finger separately. Pipeline thread. Pinned by
// tests/unit/daemon/perform/merge/layers_test.cpp.
class Layers {
 public:
  // Makes the layers of the sources with merge_into.
  void Set(const std::vector<config::Source>& sources);

  // The layer of a source; null: the source has performers of its own.
  STYLED_REALTIME Layer* Of(int source) noexcept {
    const auto at = static_cast<std::size_t>(source);
    return at < layers_.size() ? layers_[at].get() : nullptr;
  }
  // The face to publish for this performer: `own`, or the one that its layers show instead.
  // `alone`: there is no other performer. Layers that follow the only performer become theirs, and
  // stay so until another one is alone.
  STYLED_REALTIME std::span<const std::byte> FaceOf(std::string_view performer, bool alone,
                                                    std::span<const std::byte> own,
                                                    std::int64_t now_ns) noexcept;
  // The fingers merged into this performer, in the order of the configuration. Valid as long as
  // this object.
  std::vector<FingerLayer*> FingersOf(std::string_view performer);
  // The performer that a source is merged into; "": none, the source has performers of its own.
  std::string Into(std::size_t source) const {
    if (source >= layers_.size() || !layers_[source]) return "";
    const Layer& layer = *layers_[source];
    return layer.follows && layer.into.empty() ? std::string(config::kOnlyPerformer) : layer.into;
  }
  // Whether data of a source that is merged arrive.
  bool Arrives(std::size_t source, std::int64_t now_ns) const noexcept {
    return source < layers_.size() && layers_[source] && layers_[source]->Live(now_ns);
  }
  // Why the data of a source reach no performer now: "its data are for stage.anna, who is not here;
  // here is stage.ben". "": they reach one, or none arrive. `here`: the performers.
  // Allocates: call it where Arrives.
  std::string Stray(std::size_t source, std::span<const std::string_view> here,
                    std::int64_t now_ns) const;
  // Fills `layers` of the row.
  void Describe(std::int64_t now_ns, v1::PerformerStats& row) const;
  std::size_t size() const { return layers_.size(); }

 private:
  std::vector<std::unique_ptr<Layer>> layers_;  // by source; null: it has performers of its own
};

}  // namespace styled::pipeline

#include "daemon/source/face_stream.h"

#include <algorithm>
#include <cmath>

#include "model/base/random_id.h"
#include "proto/styled/face.h"

namespace styled::source {

FaceStream::FaceStream() : session_(RandomId() | 1U), bytes_(kMaxFace) {}

void FaceStream::Restart() noexcept { session_ += 2; }

void FaceStream::Send(const Face& face, std::uint64_t number, std::uint64_t source_time_ns,
                      Outbox& out) noexcept {
  SourceFrame frame;
  frame.session = session_;
  frame.sequence = number;
  frame.source_time_ns = source_time_ns;
  frame.face = std::span<const std::byte>(bytes_).first(EncodeFace(face, bytes_));
  if (!frame.face.empty()) out.Put(frame);
}

ShapeFace::ShapeFace(bool as_presets) : as_presets_(as_presets) {
  face_.expressions.resize(as_presets ? arkit::kPresets.size() : arkit::kShapes);
  for (std::size_t i = 0; i < face_.expressions.size(); ++i) {
    face_.expressions[i].name = as_presets ? arkit::kPresets[i] : arkit::kNames[i];
  }
}

const Face& ShapeFace::Of(std::span<const float, arkit::kShapes> shapes) noexcept {
  for (std::size_t i = 0; i < arkit::kShapes; ++i) {
    if (std::isfinite(shapes[i])) last_[i] = std::clamp(shapes[i], 0.0F, 1.0F);
  }
  std::array<float, arkit::kPresets.size()> presets;
  if (as_presets_) arkit::ToPresets(last_, presets);
  const std::span<const float> values =
      as_presets_ ? std::span<const float>(presets) : std::span<const float>(last_);
  for (std::size_t i = 0; i < values.size(); ++i) face_.expressions[i].value = values[i];
  return face_;
}

}  // namespace styled::source

#include "daemon/pipeline/layers.h"

#include <algorithm>
#include <utility>

#include "daemon/source/face.h"
#include "proto/styled/face.h"

namespace styled::pipeline {

FaceLayer::FaceLayer() {
  face_.reserve(kMaxFace);
  shown_.reserve(kMaxFace);
}

bool FaceLayer::Take(const source::SourceFrame& frame, std::int64_t now_ns) noexcept {
  if (any_ && frame.session == session_ && frame.sequence <= sequence_) return false;
  if (frame.face.size() > kMaxFace) return false;
  any_ = true;
  session_ = frame.session;
  sequence_ = frame.sequence;
  taken_ns_ = now_ns;
  face_.assign(frame.face.begin(), frame.face.end());
  return true;
}

std::span<const std::byte> FaceLayer::Over(std::span<const std::byte> own,
                                           std::int64_t now_ns) noexcept {
  const std::int64_t age_ns = now_ns - taken_ns_;
  if (!any_ || age_ns > kHold_ns + kFade_ns + kZero_ns) return own;
  const auto passed_on = source::PassedOn(own);
  if (face_.size() + passed_on.size() > kMaxFace) return own;
  shown_.assign(face_.begin(), face_.end());
  const auto faded = static_cast<float>(age_ns - kHold_ns) / static_cast<float>(kFade_ns);
  if (faded > 0) source::ScaleFace(shown_, std::max(1 - faded, 0.0F));
  shown_.insert(shown_.end(), passed_on.begin(), passed_on.end());
  return shown_;
}

int FaceLayer::Change(std::int64_t now_ns) noexcept {
  const bool shown = any_ && now_ns - taken_ns_ <= kHold_ns + kFade_ns;
  return std::exchange(told_, shown) == shown ? 0 : shown ? 1 : -1;
}

void Layers::Set(std::vector<std::string> merge_into) {
  into_ = std::move(merge_into);
  layers_.clear();
  for (const std::string& performer : into_) {
    layers_.push_back(performer.empty() ? nullptr : std::make_unique<FaceLayer>());
  }
}

std::span<const std::byte> Layers::FaceOf(std::string_view performer,
                                          std::span<const std::byte> own,
                                          std::int64_t now_ns) noexcept {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    if (!layers_[i] || into_[i] != performer) continue;
    const auto face = layers_[i]->Over(own, now_ns);
    if (face.data() != own.data()) return face;
  }
  return own;
}

}  // namespace styled::pipeline

#include "daemon/perform/merge/layers.h"

#include <algorithm>
#include <utility>

#include "daemon/source/face.h"
#include "proto/styled/face.h"

namespace styled::pipeline {

using runtime::Counter;

namespace {
constexpr std::size_t kLongestId = 65;  // SOURCE.NAME of config::IsPerformerId
}

FaceLayer::FaceLayer() {
  face_.reserve(kMaxFace);
  shown_.reserve(kMaxFace);
}

Counter FaceLayer::Accept(const source::SourceFrame& frame, std::int64_t now_ns) noexcept {
  if (frame.face.size() > kMaxFace) return Counter::kSourceMalformed;
  const Counter why = Admit(frame, now_ns);
  if (why != kAccepted) return why;
  MarkAccepted(now_ns);
  face_.assign(frame.face.begin(), frame.face.end());
  return kAccepted;
}

std::span<const std::byte> FaceLayer::Over(std::span<const std::byte> own,
                                           std::int64_t now_ns) noexcept {
  const std::int64_t age_ns = now_ns - accepted_ns();
  if (!any() || age_ns > kHold_ns + kFade_ns + kZero_ns) return own;
  const auto passed_on = source::PassedOn(own);
  if (face_.size() + passed_on.size() > kMaxFace) return own;
  shown_.assign(face_.begin(), face_.end());
  const auto faded = static_cast<float>(age_ns - kHold_ns) / static_cast<float>(kFade_ns);
  if (faded > 0) source::ScaleFace(shown_, std::max(1 - faded, 0.0F));
  shown_.insert(shown_.end(), passed_on.begin(), passed_on.end());
  return shown_;
}

// Face and fingers may arrive in separate frames, each with its own numbers (source/rigs/vmc.h).
Counter Layer::Accept(const source::SourceFrame& frame, std::int64_t now_ns) noexcept {
  Counter why = MergedPart::kAccepted;
  if (face && !frame.face.empty()) why = face->Accept(frame, now_ns);
  if (fingers && !frame.rotations.empty()) {
    const Counter fingers_why = fingers->Accept(frame, now_ns);
    if (why == MergedPart::kAccepted) why = fingers_why;
  }
  return why;
}

void Layers::Set(const std::vector<config::Source>& sources) {
  layers_.clear();
  for (const config::Source& source : sources) {
    auto& layer = layers_.emplace_back();
    if (source.merge_into.empty()) continue;
    layer = std::make_unique<Layer>();
    layer->source = source.name;
    layer->follows = source.merge_into == config::kOnlyPerformer;
    layer->into.reserve(kLongestId);
    if (!layer->follows) layer->into = source.merge_into;
    if (source.Merges("face")) layer->face.emplace();
    rig::TailSet fingers;
    if (source.Merges("leftFingers")) fingers |= rig::FingersOf(body::kLeftHand);
    if (source.Merges("rightFingers")) fingers |= rig::FingersOf(body::kRightHand);
    if (fingers.any()) layer->fingers.emplace(fingers, source.joints, source.smoothing);
  }
}

std::span<const std::byte> Layers::FaceOf(std::string_view performer, bool alone,
                                          std::span<const std::byte> own,
                                          std::int64_t now_ns) noexcept {
  for (const auto& layer : layers_) {
    if (!layer || !layer->face) continue;
    if (alone && layer->follows && performer.size() <= kLongestId) layer->into.assign(performer);
    if (layer->into != performer) continue;
    const auto face = layer->face->Over(own, now_ns);
    if (face.data() != own.data()) return face;
  }
  return own;
}

std::vector<FingerLayer*> Layers::FingersOf(std::string_view performer) {
  std::vector<FingerLayer*> fingers;
  for (const auto& layer : layers_) {
    if (layer && layer->fingers && layer->into == performer) fingers.push_back(&*layer->fingers);
  }
  return fingers;
}

std::string Layers::Stray(std::size_t source, std::span<const std::string_view> here,
                          std::int64_t now_ns) const {
  if (!Arrives(source, now_ns)) return "";
  const Layer* const layer = layers_[source].get();
  if (std::ranges::find(here, layer->into) != here.end()) return "";
  if (layer->follows && here.size() == 1) return "";  // with their next frame
  constexpr std::size_t kShown = 3;
  std::string list = here.empty()       ? "no performer is here"
                     : here.size() == 1 ? "here is "
                                        : "here are ";
  for (std::size_t i = 0; i < std::min(here.size(), kShown); ++i) {
    list.append(i == 0 ? "" : ", ").append(here[i]);
  }
  if (here.size() > kShown) list += " and " + std::to_string(here.size() - kShown) + " more";
  if (!layer->follows) return "its data are for " + layer->into + ", who is not here; " + list;
  return here.empty() ? list : list + ": merge_into must name the one who gets its data";
}

void Layers::Describe(std::int64_t now_ns, v1::PerformerStats& row) const {
  for (const auto& layer : layers_) {
    if (!layer || layer->into != row.performer()) continue;
    const auto add = [&](const char* part, bool live) {
      v1::LayerStats& stats = *row.add_layers();
      stats.set_source(layer->source);
      stats.set_part(part);
      stats.set_live(live);
    };
    if (layer->face) add("face", layer->face->Live(now_ns));
    if (layer->fingers) add("fingers", layer->fingers->Live(now_ns));
  }
}

}  // namespace styled::pipeline

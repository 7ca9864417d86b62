#include "daemon/perform/performer/outputs.h"

#include <algorithm>

#include "daemon/publish/body_message.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::pipeline {

Outputs::Outputs(const std::string& id, std::uint64_t epoch, publish::Subscriptions& subscriptions,
                 runtime::Counters& counters)
    : id_(id), epoch_(epoch), subscriptions_(subscriptions), counters_(counters) {
  topics_[kRig].name = "styled/" + id + "/rig/";
  topics_[kCanonical].name = "styled/" + id + "/canonical/";
  topics_[kSource].name = "source/" + id + "/";
  topics_[kBody].name = "body/" + id + "/";
  for (auto& topic : topics_) subscriptions_.Register(topic);
}

Outputs::~Outputs() {
  for (auto& topic : topics_) subscriptions_.Unregister(topic);
}

void Outputs::Bind(const BoundBody& body, const v1::Body& given, const RuntimeConfig& config) {
  const v1::Body rig =
      publish::RigBody(id_, *body.binding, body.left_handed, given.metres_per_unit(), body.dialect);
  tail_ = rig::Tail::Make(
      *body.binding, rig::FindTail(body.binding->skeleton(), body.binding->spec().source_joint));
  canonical_.assign(body::kJointCount + tail_.size(), rig::Quat::Identity());
  const v1::Body canonical = publish::CanonicalBody(id_, tail_);
  rig_bytes_ = rig.SerializeAsString();
  canonical_bytes_ = canonical.SerializeAsString();
  ready_ = {};
  for (EncodedProps& encoded : props_) encoded.Clear();
  const int joints = body.binding->skeleton().joint_count();
  const auto& styles = config.network->model().styles;
  messages_[kRig].emplace(id_, epoch_, rig, joints, styles);
  messages_[kCanonical].emplace(id_, epoch_, canonical, joints, styles);
  messages_[kSource].emplace(id_, epoch_, rig, joints, styles);
  streams_.clear();
  for (const auto& output : config.outputs) {
    if (!output->IsFor(id_)) continue;
    streams_.push_back(
        std::make_unique<RetargetStream>(output, body, id_, epoch_, config, subscriptions_));
  }
  network_ = config.network;  // the messages no longer refer to the last network's styles
}

void Outputs::Adopt(const RuntimeConfig& config) {
  const net::Styles& styles = config.network->model().styles;
  for (auto& message : messages_) {
    if (message) message->UseStyles(styles);
  }
  for (const auto& stream : streams_) stream->UseStyles(styles);
  network_ = config.network;
}

bool Outputs::Retarget(std::int64_t elapsed_ns, const stylist::Output& out,
                       const CarriedProps& props) noexcept {
  bool failed = false;
  for (EncodedProps& encoded : props_) encoded.Clear();
  if (!props.empty()) {
    if (Wanted(kRig)) props.OnRig(out, props_[kRig]);
    if (Wanted(kCanonical)) props.OnCanonical(out, props_[kCanonical]);
    if (Wanted(kSource)) props.OnSource(out, props_[kSource]);
  }
  std::copy(out.canonical.rotations.begin(), out.canonical.rotations.end(), canonical_.begin());
  tail_.Read(out.rig.rotations, std::span(canonical_).subspan(body::kJointCount));
  for (const auto& stream : streams_) {
    stream->Process(elapsed_ns, out, props);
    failed = failed || stream->failed();
  }
  return failed;
}

void Outputs::Serialize(const decide::FrameInTransit& frame, const Styling& styling,
                        std::span<const std::byte> face) noexcept {
  const stylist::Output& out = styling.out();
  const auto fill = [&](publish::FrameMessage& message, std::uint32_t frame_flags) {
    message.SetHeader(frame, frame_flags);
    message.SetStyles({out.in_force.data(), static_cast<std::size_t>(out.in_force_count)});
    for (std::size_t j = 0; out.held.any() && j < styling.in().rotations.size(); ++j) {
      if (out.held.test(j)) message.AddHeld(static_cast<int>(j));
    }
  };
  ready_ = {};
  for (std::size_t i = 0; i < ready_.size(); ++i) {
    if (!Wanted(i)) continue;
    publish::FrameMessage& message = *messages_[i];
    // Without held joints, the output equals the source bit for bit.
    const std::uint32_t own = i == kSource && !out.held.any() ? v1::FLAG_BYPASS : 0;
    fill(message, frame.flags | own);
    if (i == kRig) message.SetPose(styling.rig_root(), out.rig.rotations);
    if (i == kSource) message.SetPose(out.source.translations.front(), out.source.rotations);
    if (i == kCanonical) message.SetPose(out.canonical.hips_position_m, canonical_);
    ready_[i] = message.Serialize(face, props_[i].bytes());
  }
  for (const auto& stream : streams_) {
    const std::uint32_t own = stream->failed() ? v1::FLAG_FAILED : 0;
    stream->Serialize(face, [&](publish::FrameMessage& message) {
      fill(message, (frame.flags & ~std::uint32_t{v1::FLAG_BYPASS}) | own);
    });
  }
}

void Outputs::Send(publish::Publisher& publisher, std::span<publish::Bundle> bundles,
                   std::int64_t now_ns, bool repeats) {
  for (std::size_t i = 0; i < ready_.size(); ++i) {
    if (!ready_[i].empty() && topics_[i].wanted != 0) publisher.Send(topics_[i].name, ready_[i]);
    bundles[i].Add(ready_[i], publisher);
  }
  ready_ = {};
  for (const auto& stream : streams_) {
    if (!stream->ready().empty()) publisher.Send(stream->topic.name, stream->ready());
    stream->MarkSent();
  }
  last_send_ns_ = now_ns;
  published_ += repeats ? 0 : 1;
}

bool Outputs::Asked() const {
  const auto asked = [](const publish::Topic& topic) { return topic.asked; };
  return std::any_of(topics_.begin(), topics_.end(), asked) ||
         std::any_of(streams_.begin(), streams_.end(),
                     [&](const auto& stream) { return asked(stream->topic); });
}

void Outputs::SendBodies(publish::Publisher& publisher) {
  for (auto& topic : topics_) topic.asked = false;
  for (const auto& stream : streams_) stream->topic.asked = false;
  if (rig_bytes_.empty() || topics_[kBody].wanted == 0) return;
  const auto send = [&](const std::string& bytes) {
    publisher.Send(topics_[kBody].name, std::as_bytes(std::span(bytes)));
    counters_.Add(runtime::Counter::kPublishBodies);
  };
  send(rig_bytes_);
  send(canonical_bytes_);
  for (const auto& stream : streams_) send(stream->body_bytes());
}

}  // namespace styled::pipeline

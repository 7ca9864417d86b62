#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/pipeline/body_binding.h"
#include "daemon/pipeline/runtime_config.h"
#include "daemon/publish/frame_message.h"
#include "daemon/publish/subscriptions.h"
#include "model/base/realtime.h"
#include "model/stylist/avatar.h"

namespace styled::pipeline {

// One performer's motion on the skeleton of one RetargetOutput, and its topic. Pipeline thread;
// construction allocates.
class RetargetStream {
 public:
  // `subscriptions` outlives it; the topic is registered while it lives.
  RetargetStream(std::shared_ptr<const RetargetOutput> output, const BoundBody& body,
                 const std::string& id, std::uint64_t epoch, const RuntimeConfig& config,
                 publish::Subscriptions& subscriptions);
  ~RetargetStream();
  RetargetStream(const RetargetStream&) = delete;
  RetargetStream& operator=(const RetargetStream&) = delete;

  // Retargets a frame; computed only while somebody subscribes, and the frame after a pause is a
  // first one. `elapsed_ns` as the session's.
  STYLED_REALTIME void Process(std::int64_t elapsed_ns, const stylist::Output& out) noexcept;
  // The frame is the performer's own motion: the styled pose was invalid.
  bool failed() const { return failed_; }

  // Serializes the last frame, where there is one and somebody subscribes. `fill` writes header,
  // flags and styles into the message.
  template <typename Fill>
  STYLED_REALTIME void Serialize(std::span<const std::byte> face, Fill fill) noexcept {
    ready_ = {};
    if (topic.wanted == 0 || !has_frame_) return;
    fill(message_);
    message_.SetPose(root_, rotations_);
    ready_ = message_.Serialize(face);
  }
  // Serialized and not sent yet; empty: nothing.
  std::span<const std::byte> ready() const { return ready_; }
  STYLED_REALTIME void MarkSent() noexcept { ready_ = {}; }
  const std::string& body_bytes() const { return body_bytes_; }  // the v1.Body message

  publish::Topic topic;

 private:
  std::shared_ptr<const RetargetOutput> output_;
  stylist::Avatar avatar_;
  bool has_frame_ = false;  // root_ and rotations_ hold one
  bool failed_ = false;
  rig::Vec3 root_ = rig::Vec3::Zero();
  std::vector<rig::Quat> rotations_;
  publish::FrameMessage message_;
  publish::Subscriptions& subscriptions_;
  std::string body_bytes_;
  std::span<const std::byte> ready_;
};

}  // namespace styled::pipeline

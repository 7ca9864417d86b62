#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/looks/runtime_config.h"
#include "daemon/perform/performer/body_binding.h"
#include "daemon/perform/performer/carried_props.h"
#include "daemon/publish/frame_message.h"
#include "daemon/publish/subscriptions.h"
#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/stylist/avatar.h"

namespace styled::pipeline {

// One performer's motion on the skeleton of one RetargetOutput, and its topic. Pipeline thread;
// construction allocates.
class RetargetStream {
 public:
  // `subscriptions` must outlive it; the topic is registered during its lifetime.
  RetargetStream(std::shared_ptr<const RetargetOutput> output, const BoundBody& body,
                 const std::string& id, std::uint64_t epoch, const RuntimeConfig& config,
                 publish::Subscriptions& subscriptions);
  ~RetargetStream();
  RetargetStream(const RetargetStream&) = delete;
  RetargetStream& operator=(const RetargetStream&) = delete;

  // As FrameMessage::UseStyles.
  void UseStyles(const net::Styles& styles) noexcept { message_.UseStyles(styles); }

  // Retargets a frame and its props, but only while a client subscribes; the first frame after a
  // pause starts anew. `elapsed_ns` is the session's.
  STYLED_REALTIME void Process(std::int64_t elapsed_ns, const stylist::Output& out,
                               const CarriedProps& props) noexcept;
  // See model/base/checkpoint.h. The last frame is not in it.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(has_frame_, avatar_); }
  // The styled pose was invalid, so the frame is the performer's own motion.
  bool failed() const { return failed_; }

  // Serializes the last frame if there is one and a client subscribes. `fill` writes header, flags
  // and styles into the message.
  template <typename Fill>
  STYLED_REALTIME void Serialize(std::span<const std::byte> face, Fill fill) noexcept {
    ready_ = {};
    if (topic.wanted == 0 || !has_frame_) return;
    fill(message_);
    message_.SetPose(root_, rotations_);
    ready_ = message_.Serialize(face, props_.bytes());
  }
  // The serialized frame that is not sent yet, or empty.
  std::span<const std::byte> ready() const { return ready_; }
  STYLED_REALTIME void MarkSent() noexcept { ready_ = {}; }
  const std::string& body_bytes() const { return body_bytes_; }  // the v1.Body message

  publish::Topic topic;

 private:
  STYLED_REALTIME void PlaceProps(const rig::Vec3& root, const CarriedProps& props) noexcept;

  std::shared_ptr<const RetargetOutput> output_;
  stylist::Avatar avatar_;
  bool has_frame_ = false;  // root_ and rotations_ hold one
  bool failed_ = false;
  rig::Vec3 root_ = rig::Vec3::Zero();
  std::vector<rig::Quat> rotations_;
  rig::Wrists wrists_;
  EncodedProps props_;
  publish::FrameMessage message_;
  publish::Subscriptions& subscriptions_;
  std::string body_bytes_;
  std::span<const std::byte> ready_;
};

}  // namespace styled::pipeline

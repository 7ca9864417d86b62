#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "daemon/looks/runtime_config.h"
#include "daemon/perform/performer/body_binding.h"
#include "daemon/perform/performer/carried_props.h"
#include "daemon/perform/performer/retarget_stream.h"
#include "daemon/perform/performer/styling.h"
#include "daemon/publish/bundle.h"
#include "daemon/publish/frame_message.h"
#include "daemon/publish/publisher.h"
#include "daemon/publish/subscriptions.h"
#include "daemon/runtime/counters.h"
#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/rig/tail.h"
#include "proto/styled/v1/body.pb.h"

namespace styled::pipeline {

// The published output of one performer: a topic each for the rig's skeleton, the canonical
// humanoid (with the rig's fingers, eyes and jaw behind it), the source and the bodies, and one for
// each RetargetOutput; and its part of the bundles. A topic is serialized only while a client
// subscribes to it or to its bundle. Pipeline thread; Bind and SendBodies allocate.
class Outputs {
 public:
  // `id`: the performer's; `subscriptions` and `counters` must outlive it.
  Outputs(const std::string& id, std::uint64_t epoch, publish::Subscriptions& subscriptions,
          runtime::Counters& counters);
  ~Outputs();
  Outputs(const Outputs&) = delete;
  Outputs& operator=(const Outputs&) = delete;

  // Makes messages and retarget streams for a body (`given`: the rig's message) and a
  // configuration. Drops what was serialized for the last body.
  void Bind(const BoundBody& body, const v1::Body& given, const RuntimeConfig& config);

  // Takes over a configuration whose network shares streams with the last one's; the motion goes
  // on.
  void Adopt(const RuntimeConfig& config);

  // Retargets a styled frame, reads its fingers, eyes and jaw, and places its props; call it while
  // `out` is in the binding's axes. Returns true if a retarget output fell back to the performer's
  // own motion.
  STYLED_REALTIME bool Retarget(std::int64_t elapsed_ns, const stylist::Output& out,
                                const CarriedProps& props) noexcept;
  // Serializes a frame for the subscribed topics. `face`: as received, at most kMaxFace bytes.
  STYLED_REALTIME void Serialize(const decide::FrameInTransit& frame, const Styling& styling,
                                 std::span<const std::byte> face) noexcept;
  // Sends what Serialize prepared, and adds it to the bundles. `repeats`: it is the last pose
  // again, which does not count as published.
  void Send(publish::Publisher& publisher, std::span<publish::Bundle> bundles, std::int64_t now_ns,
            bool repeats);
  std::int64_t last_send_ns() const { return last_send_ns_; }

  // The retargeting of all streams; see model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    for (const auto& stream : streams_) stream->Carry(c);
  }

  // Whether a new subscriber waits for the bodies; SendBodies serves all of them.
  bool Asked() const;
  void SendBodies(publish::Publisher& publisher);

  // Call once a second; returns the poses published since the last call.
  std::uint64_t Sample() noexcept { return published_ - std::exchange(sampled_, published_); }
  std::uint64_t published() const { return published_; }

 private:
  enum TopicIndex : std::uint8_t { kRig, kCanonical, kSource, kBody, kTopicCount };
  static constexpr std::size_t kFrameTopics = 3;
  static_assert(kRig == int{publish::Subscriptions::kRigBundle} &&
                kCanonical == int{publish::Subscriptions::kCanonicalBundle} &&
                kSource == int{publish::Subscriptions::kSourceBundle});
  // Whether somebody reads it.
  bool Wanted(std::size_t topic) const noexcept {
    return topics_[topic].wanted != 0 || subscriptions_.bundle(topic).wanted != 0;
  }

  std::string id_;
  std::uint64_t epoch_;
  publish::Subscriptions& subscriptions_;
  runtime::Counters& counters_;
  std::array<publish::Topic, kTopicCount> topics_;
  // These depend on the bound body; empty before.
  std::shared_ptr<const net::Stylizer> network_;  // the messages refer to its style names
  std::string rig_bytes_, canonical_bytes_;       // v1.Body messages
  rig::Tail tail_;
  std::vector<rig::Quat>
      canonical_;  // the last frame's rotations, the tail's behind the humanoid's
  std::array<EncodedProps, kFrameTopics> props_;  // the last frame's
  std::array<std::optional<publish::FrameMessage>, kFrameTopics> messages_;
  std::vector<std::unique_ptr<RetargetStream>> streams_;
  std::array<std::span<const std::byte>, kFrameTopics> ready_;  // empty: not subscribed
  std::int64_t last_send_ns_ = 0;
  std::uint64_t published_ = 0, sampled_ = 0;
};

}  // namespace styled::pipeline

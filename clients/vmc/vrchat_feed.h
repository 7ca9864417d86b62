#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "model/base/status.h"
#include "model/body/pose.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::stylevmc {

// The trackers that VRChat gets, by SlimeVR's numbers: bit 1 hip, 2 and 3 feet, 4 and 5 knees, 6
// chest, 7 and 8 elbows. Parses "hip,feet,knees,chest,elbows", or "all". Errors name the word.
Result<std::uint32_t> ParseTrackerSet(const std::string& list);

// Converts frames on the canonical humanoid to VRChat's OSC trackers: positions of the hips, the
// feet, the knees, the chest and the elbows, and rotations of hips, feet, thighs, chest and upper
// arms, in Unity's axes. The head's position is sent with each frame; its heading only with the
// first one, and with the first one after a new session, a pause of more than a second, or another
// performer (Bind), because VRChat rotates its space by it.
//
// One thread. Pinned by tests/unit/vmc_out/vrchat_feed_test.cpp.
class VrChatFeed {
 public:
  struct Options {
    std::uint32_t trackers = 0;  // ParseTrackerSet
    // Of the person in VRChat, metres; 0: positions are sent unscaled.
    double user_height_m = 0;
  };
  // The height of the canonical humanoid: its head's joint, and a head above it.
  static constexpr double kCanonicalHeight_m = 1.71;
  static constexpr std::size_t kMaxSize = 1400;  // below an Ethernet frame's 1472

  explicit VrChatFeed(const Options& options) : options_(options) {}

  // `body` must be of OUTPUT_CANONICAL and have passed client::Validate. Refuses a body that does
  // not begin with the joints of the canonical humanoid; the previous one then stays bound.
  Status Bind(const v1::Body& body);

  // The datagram of the frame, one bundle, which must fit the bound body. Valid until the next
  // call.
  std::span<const std::byte> Pack(const v1::Frame& frame, std::int64_t now_ns);

 private:
  Options options_;
  std::array<body::Vec3, body::kJointCount> offsets_{};
  bool turn_ = true;  // the head's heading is to be sent
  std::int64_t last_ns_ = 0;
  std::array<std::byte, kMaxSize> buffer_{};
};

}  // namespace styled::stylevmc

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "daemon/runtime/counters.h"
#include "daemon/source/source_frame.h"
#include "proto/styled/timecode.h"
#include "proto/styled/v1/fate.pb.h"

namespace styled::decide {

// What is done with a frame or body, and why. A leader's standby gets it and does the same.
struct Decision {
  // Why a frame is refused or passed over, by the counter that counts it.
  static constexpr auto kNoReason = runtime::Counter::kCount;

  v1::Fate fate = v1::FATE_REFUSED;
  runtime::Counter reason = kNoReason;
  v1::Restart restart = v1::RESTART_NONE;
  bool late = false;             // published behind schedule: FLAG_LATE
  bool relieved = false;         // without style, because the machine cannot keep up
  bool postponed = false;        // a body that a later batch handles, or a frame behind it
  std::uint64_t sequence = 0;    // Frame.sequence, if it is styled
  std::uint64_t lost = 0;        // sequence numbers skipped before it
  std::int64_t lateness_ns = 0;  // behind the performer's schedule (runtime::Schedule)
};

inline constexpr std::size_t kLimbs = 5;

// A frame or body on its way from the rig to the subscribers: what came and when, what was decided,
// and what came out. The pipeline has one for each frame of a batch, from its reading until the
// batch is logged. Monotonic times are on runtime::Clock::Now_ns(). Pipeline thread.
struct FrameInTransit {
  // As the rig sent it. Null where the performer's last pose is sent again.
  const source::SourceFrame* given = nullptr;
  Decision decision;

  // Filled from `given`, which does not outlive the batch.
  std::uint64_t source_sequence = 0, source_time_ns = 0;
  bool has_timecode = false;
  Timecode timecode;
  std::span<const std::byte> face{};  // what is passed on beside the pose, merged faces included

  std::int64_t elapsed_ns = 0;  // source time in the session
  std::int64_t arrival_ns = 0;  // of its datagram
  std::int64_t receive_ns = 0;  // when its batch was read
  std::int64_t wall_ns = 0;     // arrival_ns, since 1970
  std::int64_t publish_ns = 0;  // when it was styled
  std::int64_t sent_ns = 0;     // when its last topic was sent; 0: not sent

  std::uint32_t flags = 0;     // v1::Flag, of the rig's topic
  std::uint32_t contacts = 0;  // as stylist::Output::contacts
  v1::Failure failure = v1::FAILURE_NONE;
  int held_joints = 0, first_held_joint = 0;  // of the rig's joints, how many, and which first
  // As in stylist::Output, by stylist::Limb.
  std::array<float, kLimbs> limb_weights{}, limb_errors_m{};
  // Of the styled pose on the canonical body, with a standby only: its CRC-32C, and the bytes of
  // its log::RoundedPose, little-endian (a view; empty: there is no pose).
  std::uint32_t styled_crc = 0;
  std::span<const std::byte> rounded_pose{};
};

}  // namespace styled::decide

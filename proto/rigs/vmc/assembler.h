#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "proto/rigs/vmc/bones.h"
#include "proto/rigs/vmc/vmc.h"

namespace styled::vmc {

// The messages of a sender for one instant. Space as in vmc.h.
struct Frame {
  struct Expression {
    static constexpr std::size_t kMaxName = 64;
    std::array<char, kMaxName> text;
    std::size_t size = 0;
    float value = 0;
    std::uint32_t datagram = 0;  // used by the assembler
    std::string_view name() const noexcept { return {text.data(), size}; }
  };
  struct Passed {
    static constexpr std::size_t kMaxSize = 512;
    std::array<std::byte, kMaxSize> text;
    std::size_t size = 0;
    std::span<const std::byte> bytes() const noexcept { return std::span(text).first(size); }
  };
  static constexpr std::size_t kMaxBlends = 256, kMaxThrus = 8;

  BoneSet bones = 0;    // that arrived
  BoneSet missing = 0;  // that arrived earlier in this session, but not now: to be held
  BoneSet stale = 0;    // those of `missing` that were absent for more than 0.5 s
  std::array<Transform, kBoneCount> transforms;  // valid for `bones`
  bool has_root = false;
  Transform root;
  bool has_time = false;         // else only `received_ns` is known
  float time_s = 0;              // the sender's clock
  std::int64_t received_ns = 0;  // arrival of the frame's first message
  bool restarted = false;        // the sender's clock went back: this frame begins a new session
  bool has_available = false;
  Available available;
  std::size_t blend_count = 0, thru_count = 0;
  std::array<Expression, kMaxBlends> blends;  // each name once
  bool blends_applied = false;                // Blend/Apply arrived
  std::array<Passed, kMaxThrus> thrus;        // whole messages, in their order
};

// Assembles one sender's messages into frames. The protocol does not mark the end of a frame, and
// senders differ: T comes first or last, and a frame fills one datagram, several, or one per
// message. The rules:
//  - A second T of another value begins the next frame.
//  - A bone, root or expression that the frame already has begins the next one if it comes from a
//    later datagram. Exceptions: in the same datagram it is a correction, and the last one counts;
//    in a datagram with the frame's own T it belongs to the frame; unchanged it is a copy, once the
//    sender's habit is known.
//  - A silence of half a period ends the frame, because senders send a frame in one burst. This
//    rule also restores the order after a lost datagram or a start in the middle of a frame.
//  - A frame ends at once when all bones of the previous frame have arrived, and the message that
//    ended that one.
// The first three rules are those of FrameAssembler in usd-vrm-plugins (Apache-2.0).
//
// A T that is not after the last frame's is refused. If it is lower by more than 1 s, or comes more
// than 250 ms after the last frame, the sender has restarted. A clock that stands still, is
// negative, or exceeds 36 hours (where a float no longer resolves single frames) is ignored: the
// frame has no time.
//
//   if (assembler.Begin(datagram, now_ns) == osc::Result::kOk) {
//     while (assembler.Next()) Use(assembler.frame());
//   }
//   if (assembler.Flush(now_ns)) Use(assembler.frame());   // when deadline_ns() has passed
//
// No allocation; one thread; 50 kB. Pinned by tests/unit/vmc/assembler_test.cpp.
class Assembler {
 public:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  // Numbers of refused and skipped items since construction.
  struct Counts {
    std::uint64_t refused = 0;     // known messages with missing or wrong arguments, unknown bones
    std::uint64_t ignored = 0;     // other messages
    std::uint64_t duplicate = 0;   // frames, datagrams and messages that were repeated
    std::uint64_t late = 0;        // frames and datagrams older than the last frame
    std::uint64_t left_out = 0;    // expressions and Thrus beyond the maximum
    std::uint64_t incomplete = 0;  // frames that lacked a bone of the frame before
  };

  // Starts a datagram that arrived at `now_ns` (monotonic). Any result but kOk leaves the assembler
  // unchanged. The bytes must stay valid until Next() returned false.
  STYLED_REALTIME osc::Result Begin(std::span<const std::byte> datagram,
                                    std::int64_t now_ns) noexcept;
  // Returns true if frame() is a new frame. T or OK alone make no frame.
  STYLED_REALTIME bool Next() noexcept;
  // Ends a frame that has waited long enough; returns as Next() does.
  STYLED_REALTIME bool Flush(std::int64_t now_ns) noexcept;
  // When Flush() ends the open frame; kNever if none is open.
  std::int64_t deadline_ns() const noexcept;

  // Valid until the next call of Begin(), Next() or Flush().
  const Frame& frame() const noexcept { return frames_[1 - open_index_]; }
  const Counts& counts() const noexcept { return counts_; }

 private:
  using Key = std::uint64_t;  // identifies a message's subject; 0: none

  Frame& open() noexcept { return frames_[open_index_]; }
  const Frame& open() const noexcept { return frames_[open_index_]; }
  bool IsOld(float time_s) noexcept;
  void PassOver() noexcept;
  bool Decode(const osc::Message& bytes) noexcept;
  bool BeginsNext() const noexcept;
  bool IsLateEnd() const noexcept;
  std::size_t Find(const Blend& blend) const noexcept;
  Key MessageKey() const noexcept;
  void Add() noexcept;
  void AddBlend(const Blend& blend) noexcept;
  void AddThru(const Thru& thru) noexcept;
  bool Close(bool learn) noexcept;
  bool AcceptTime() noexcept;
  void AcceptBones() noexcept;
  void LearnEnd() noexcept;
  void LearnPeriod() noexcept;
  void Clear() noexcept;
  bool IsComplete() const noexcept;
  std::int64_t Silence_ns() const noexcept;

  std::array<Frame, 2> frames_;  // the open one and the last one
  std::size_t open_index_ = 0;
  Counts counts_;
  // The current datagram.
  osc::Reader reader_;
  Message message_;
  int bone_ = -1;         // of message_, if it is a Bone
  bool waiting_ = false;  // message_ begins the next frame and is not added yet
  bool at_end_ = true;
  bool flush_first_ = false;    // it came after a silence: the open frame ends before it
  bool of_open_frame_ = false;  // it carries the open frame's T
  bool passing_over_ = false;   // datagrams without a T of their own belong to an old frame
  std::uint32_t datagram_ = 0;
  std::int64_t now_ns_ = 0;
  // The open frame.
  bool empty_ = true, has_mark_ = false, end_seen_ = false;
  float mark_s_ = 0;  // its T, whether usable as a time or not
  Key last_key_ = 0;
  std::uint32_t root_datagram_ = 0;
  std::array<std::uint32_t, kBoneCount> bone_datagram_{};
  // The session.
  bool vrm1_ = false;
  Key end_key_ = 0;        // the message that ends a frame
  Key candidate_key_ = 0;  // the message that ended the last frame, if not by end_key_
  BoneSet expected_ = 0;   // the bones of the last frame
  BoneSet seen_ = 0;
  std::array<std::int64_t, kBoneCount> seen_ns_{};
  bool any_time_ = false, clock_stands_ = false;
  float last_time_s_ = 0;           // of the last frame that had a time
  std::int64_t last_timed_ns_ = 0;  // arrival of that frame
  std::int64_t last_frame_ns_ = 0;  // the last frame's arrival
  bool last_had_time_ = false;
  std::int64_t period_ns_ = 16'000'000;
};

}  // namespace styled::vmc

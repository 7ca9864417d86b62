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

// All that a sender said of one instant. Space as in vmc.h.
struct Frame {
  struct Expression {
    static constexpr std::size_t kMaxName = 64;
    std::array<char, kMaxName> text;
    std::size_t size = 0;
    float value = 0;
    std::uint32_t datagram = 0;  // the assembler's own
    std::string_view name() const noexcept { return {text.data(), size}; }
  };
  struct Passed {
    static constexpr std::size_t kMaxSize = 512;
    std::array<std::byte, kMaxSize> text;
    std::size_t size = 0;
    std::span<const std::byte> bytes() const noexcept { return std::span(text).first(size); }
  };
  static constexpr std::size_t kMaxBlends = 256, kMaxThrus = 8;

  BoneSet bones = 0;                             // that came
  BoneSet missing = 0;                           // that came before in this session: to be held
  BoneSet stale = 0;                             // ... and have been missing for more than 0.5 s
  std::array<Transform, kBoneCount> transforms;  // of `bones`
  bool has_root = false;
  Transform root;
  bool has_time = false;         // else only `received_ns` tells
  float time_s = 0;              // the sender's clock
  std::int64_t received_ns = 0;  // arrival of its first message
  bool restarted = false;        // the sender's clock went back: a new session begins with it
  bool has_available = false;
  Available available;
  std::size_t blend_count = 0, thru_count = 0;
  std::array<Expression, kMaxBlends> blends;  // each name once
  bool blends_applied = false;                // Blend/Apply came
  std::array<Passed, kMaxThrus> thrus;        // whole messages, in their order
};

// Puts the messages of one sender together to frames: the protocol says nowhere where one ends.
// Senders of both habits, T first and T last, in one datagram, in several or in one per message:
//  - a second T of another value begins the next frame;
//  - so does a bone, root or expression that the frame has already, from a later datagram (in the
//    same one it is a correction: the last counts; with the frame's own T it belongs to it, and
//    unchanged it is a copy, once the sender's habit is known);
//  - so does a silence of half a period: senders send a frame in one burst. That also puts right
//    what a lost datagram, or a start in the middle of a frame, put out of step;
//  - and a frame ends at once where the bones of the previous one are there, and the message that
//    was the sender's last then.
// The first three rules: usd-vrm-plugins' FrameAssembler (Apache-2.0) found them. T not after the
// last frame's: refused; lower by more than 1 s, or 250 ms after the last frame: the sender began
// anew. A clock that stands, is negative, or of more than 36 hours (a float no longer tells frames
// apart) is no clock: the frame has no time.
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

  // What was refused or passed over, since the assembler was made.
  struct Counts {
    std::uint64_t refused = 0;    // messages of ours with missing or wrong arguments, unknown bones
    std::uint64_t ignored = 0;    // other messages
    std::uint64_t duplicate = 0;  // frames, datagrams and messages that came before
    std::uint64_t late = 0;       // frames and datagrams older than the last frame
    std::uint64_t left_out = 0;   // expressions and Thrus that found no room
    std::uint64_t incomplete = 0;  // frames that lacked a bone of the one before
  };

  // A datagram that arrived at `now_ns` (monotonic). Where it is not kOk nothing has happened. The
  // bytes are looked at until Next() has said false.
  STYLED_REALTIME osc::Result Begin(std::span<const std::byte> datagram,
                                    std::int64_t now_ns) noexcept;
  // True: frame() is one more frame. Frames of T or OK alone are none.
  STYLED_REALTIME bool Next() noexcept;
  // Ends a frame that has waited long enough; as Next().
  STYLED_REALTIME bool Flush(std::int64_t now_ns) noexcept;
  std::int64_t deadline_ns() const noexcept;

  // Valid until the next call of anything above.
  const Frame& frame() const noexcept { return frames_[1 - open_index_]; }
  const Counts& counts() const noexcept { return counts_; }

 private:
  using Key = std::uint64_t;  // what a message is about; 0: nothing

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
  bool TakeTime() noexcept;
  void TakeBones() noexcept;
  void LearnEnd() noexcept;
  void LearnPeriod() noexcept;
  void Clear() noexcept;
  bool IsComplete() const noexcept;
  std::int64_t Silence_ns() const noexcept;

  std::array<Frame, 2> frames_;  // the open one and the last one
  std::size_t open_index_ = 0;
  Counts counts_;
  // The datagram at hand.
  osc::Reader reader_;
  Message message_;
  int bone_ = -1;         // of message_, where it is a Bone
  bool waiting_ = false;  // message_ begins the next frame and is not added yet
  bool at_end_ = true;
  bool flush_first_ = false;    // it came after a silence
  bool of_open_frame_ = false;  // it carries the open frame's T
  bool passing_over_ = false;   // what has no T of its own belongs to an old one
  std::uint32_t datagram_ = 0;
  std::int64_t now_ns_ = 0;
  // The open frame.
  bool empty_ = true, has_mark_ = false, end_seen_ = false;
  float mark_s_ = 0;  // its T, of use as a time or not
  Key last_key_ = 0;
  std::uint32_t root_datagram_ = 0;
  std::array<std::uint32_t, kBoneCount> bone_datagram_{};
  // The session.
  bool vrm1_ = false;
  Key end_key_ = 0;        // the message that ends a frame
  Key candidate_key_ = 0;  // ... that ended the last one for which it was not that
  BoneSet expected_ = 0;   // of the last frame
  BoneSet seen_ = 0;
  std::array<std::int64_t, kBoneCount> seen_ns_{};
  bool any_time_ = false, clock_stands_ = false;
  float last_time_s_ = 0;           // of the last frame that had one
  std::int64_t last_timed_ns_ = 0;  // when that arrived
  std::int64_t last_frame_ns_ = 0;  // the last frame's arrival
  bool last_had_time_ = false;
  std::int64_t period_ns_ = 16'000'000;
};

}  // namespace styled::vmc

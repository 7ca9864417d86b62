#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "daemon/decide/frame_in_transit.h"
#include "model/base/realtime.h"
#include "proto/styled/v1/fate.pb.h"

namespace styled::log {

// Fills a FrameFate with all that the frame tells of itself, but for `performer`, `period_ms`,
// `held_joint` and `text`. Allocates where the message has no room yet.
void FillFate(const decide::FrameInTransit& frame, v1::FrameFate& fate);

// What became of the last frames of one performer, for who asks why (v1::Explain). 64 kB, allocated
// at construction; one per performer, pipeline thread. Pinned by
// tests/unit/daemon/log/frame_history_test.cpp.
class FrameHistory {
 public:
  // 8.5 s at 120 Hz, as long as a sender's numbers may jump (decide::Session::kFarAhead).
  static constexpr std::size_t kKept = 1024;

  FrameHistory();
  STYLED_REALTIME void Add(const decide::FrameInTransit& frame) noexcept;
  // The last message of the frame published as `sequence` has left later than Add was told.
  STYLED_REALTIME void NoteSent(std::uint64_t sequence, std::int64_t latency_ns) noexcept;

  std::size_t size() const { return size_; }
  // Number `i`, 0 the oldest. As FillFate.
  void Fill(std::size_t i, v1::FrameFate& fate) const;
  // Index into the joints of the performer's body; of number `i`.
  int FirstHeldJoint(std::size_t i) const { return At(i).first_held; }
  std::uint64_t SequenceOf(std::size_t i) const { return At(i).sequence; }
  std::int64_t ArrivalOf(std::size_t i) const { return At(i).arrival_ns; }

 private:
  // One cache line.
  struct Row {
    std::int64_t arrival_ns = 0;
    std::uint64_t source_sequence = 0, sequence = 0;
    std::int32_t lateness_us = 0, latency_us = 0;
    std::uint16_t flags = 0;
    std::uint16_t lost = 0;
    std::array<std::uint16_t, decide::kLimbs> limb_errors_mm{};
    std::array<std::uint8_t, decide::kLimbs> limb_percents{};
    std::uint8_t reason = 0;  // runtime::Counter
    std::uint8_t fate = 0, restart = 0, failure = 0;
    std::uint8_t held = 0, first_held = 0;
    bool is_body = false, relieved = false, is_styled = false;
  };
  static_assert(sizeof(Row) <= 64);

  const Row& At(std::size_t i) const { return rows_[(next_ + kKept - size_ + i) % kKept]; }

  std::unique_ptr<std::array<Row, kKept>> storage_;
  std::array<Row, kKept>& rows_;
  std::size_t next_ = 0, size_ = 0;
};

}  // namespace styled::log

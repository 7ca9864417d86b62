#include "daemon/log/frame_history.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "daemon/runtime/counters.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::log {
namespace {

using decide::Decision;
using decide::FrameInTransit;
using runtime::Counter;

static_assert(static_cast<int>(Counter::kCount) <= std::numeric_limits<std::uint8_t>::max());

// Limits `value` to the range of T; NaN gives the smallest value.
template <typename T>
T Saturated(double value) noexcept {
  constexpr auto kMost = static_cast<double>(std::numeric_limits<T>::max());
  if (!(value > static_cast<double>(std::numeric_limits<T>::min()))) {
    return std::numeric_limits<T>::min();
  }
  return value >= kMost ? std::numeric_limits<T>::max() : static_cast<T>(std::lround(value));
}

std::int32_t Micros(std::int64_t ns) noexcept {
  return Saturated<std::int32_t>(static_cast<double>(ns) * 1e-3);
}

bool IsStyled(const FrameInTransit& frame) noexcept {
  return frame.decision.fate == v1::FATE_STYLED &&
         (frame.flags & (v1::FLAG_BYPASS | v1::FLAG_FAILED | v1::FLAG_STALE)) == 0;
}

std::int64_t Latency_ns(const FrameInTransit& frame) noexcept {
  return frame.sent_ns == 0 ? 0 : frame.sent_ns - frame.arrival_ns;
}

void FillReason(Counter reason, v1::FrameFate& fate) {
  fate.clear_reason();
  if (reason == Decision::kNoReason) return;
  const std::string_view name = runtime::Name(reason);
  fate.set_reason(name.data(), name.size());
}

void FillLimbs(bool styled, std::span<const float> weights, std::span<const float> errors_m,
               v1::FrameFate& fate) {
  fate.clear_limb_weights();
  fate.clear_limb_errors_m();
  if (!styled) return;
  for (const float weight : weights) fate.add_limb_weights(weight);
  for (const float error_m : errors_m) fate.add_limb_errors_m(error_m);
}

}  // namespace

void FillFate(const FrameInTransit& frame, v1::FrameFate& fate) {
  const Decision& decision = frame.decision;
  fate.set_arrival_ns(frame.arrival_ns);
  fate.set_is_body(frame.given != nullptr && frame.given->is_body);
  fate.set_source_sequence(frame.source_sequence);
  fate.set_sequence(decision.fate == v1::FATE_STYLED ? decision.sequence : 0);
  fate.set_fate(decision.fate);
  FillReason(decision.reason, fate);
  fate.set_restart(decision.restart);
  fate.set_lost(Saturated<std::uint16_t>(static_cast<double>(decision.lost)));
  fate.set_lateness_ms(static_cast<float>(Micros(decision.lateness_ns)) * 1e-3F);
  fate.set_latency_ms(static_cast<float>(Micros(Latency_ns(frame))) * 1e-3F);
  fate.set_flags(frame.flags);
  fate.set_relieved(decision.relieved);
  fate.set_failure(frame.failure);
  fate.set_held_joints(static_cast<std::uint32_t>(frame.held_joints));
  FillLimbs(IsStyled(frame), frame.limb_weights, frame.limb_errors_m, fate);
}

FrameHistory::FrameHistory()
    : storage_(std::make_unique<std::array<Row, kKept>>()), rows_(*storage_) {}

void FrameHistory::Add(const FrameInTransit& frame) noexcept {
  const Decision& decision = frame.decision;
  Row& row = rows_[next_];
  row = Row();
  row.arrival_ns = frame.arrival_ns;
  row.source_sequence = frame.source_sequence;
  row.sequence = decision.fate == v1::FATE_STYLED ? decision.sequence : 0;
  row.lateness_us = Micros(decision.lateness_ns);
  row.latency_us = Micros(Latency_ns(frame));
  row.flags = static_cast<std::uint16_t>(frame.flags);
  row.lost = Saturated<std::uint16_t>(static_cast<double>(decision.lost));
  for (std::size_t limb = 0; limb < decide::kLimbs; ++limb) {
    row.limb_percents[limb] = Saturated<std::uint8_t>(100.0 * frame.limb_weights[limb]);
    row.limb_errors_mm[limb] = Saturated<std::uint16_t>(1000.0 * frame.limb_errors_m[limb]);
  }
  row.reason = static_cast<std::uint8_t>(decision.reason);
  row.fate = static_cast<std::uint8_t>(decision.fate);
  row.restart = static_cast<std::uint8_t>(decision.restart);
  row.failure = static_cast<std::uint8_t>(frame.failure);
  row.held = Saturated<std::uint8_t>(frame.held_joints);
  row.first_held = Saturated<std::uint8_t>(frame.first_held_joint);
  row.is_body = frame.given != nullptr && frame.given->is_body;
  row.relieved = decision.relieved;
  row.is_styled = IsStyled(frame);
  next_ = (next_ + 1) % kKept;
  size_ = std::min(size_ + 1, kKept);
}

void FrameHistory::NoteSent(std::uint64_t sequence, std::int64_t latency_ns) noexcept {
  // A batch has at most this many frames.
  constexpr std::size_t kNear = 64;
  for (std::size_t back = 1; back <= std::min(size_, kNear); ++back) {
    Row& row = rows_[(next_ + kKept - back) % kKept];
    if (row.sequence != sequence) continue;
    row.latency_us = Micros(latency_ns);
    return;
  }
}

void FrameHistory::Fill(std::size_t i, v1::FrameFate& fate) const {
  const Row& row = At(i);
  fate.set_arrival_ns(row.arrival_ns);
  fate.set_is_body(row.is_body);
  fate.set_source_sequence(row.source_sequence);
  fate.set_sequence(row.sequence);
  fate.set_fate(static_cast<v1::Fate>(row.fate));
  FillReason(static_cast<Counter>(row.reason), fate);
  fate.set_restart(static_cast<v1::Restart>(row.restart));
  fate.set_lost(row.lost);
  fate.set_lateness_ms(static_cast<float>(row.lateness_us) * 1e-3F);
  fate.set_latency_ms(static_cast<float>(row.latency_us) * 1e-3F);
  fate.set_flags(row.flags);
  fate.set_relieved(row.relieved);
  fate.set_failure(static_cast<v1::Failure>(row.failure));
  fate.set_held_joints(row.held);
  std::array<float, decide::kLimbs> weights{}, errors_m{};
  for (std::size_t limb = 0; limb < decide::kLimbs; ++limb) {
    weights[limb] = static_cast<float>(row.limb_percents[limb]) * 0.01F;
    errors_m[limb] = static_cast<float>(row.limb_errors_mm[limb]) * 0.001F;
  }
  FillLimbs(row.is_styled, weights, errors_m, fate);
}

}  // namespace styled::log

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/wakeup.h"
#include "proto/recording/byte_ring.h"

namespace styled::source::usb {

// Passes finished transfers, with their time of arrival, and lines for the log from the USB thread
// to the pipeline, in order, through a bounded ring. Neither side waits. An entry that finds the
// ring full is dropped; lost data is counted (usb.ring_full). Allocates only at construction.
// Pinned by tests/unit/usb/reports_test.cpp.
class Reports {
 public:
  // The largest transfer.
  static constexpr std::size_t kMaxSize = 16384;
  // Ten seconds of a receiver's reports, or sixty full bulk transfers.
  static constexpr std::size_t kCapacity = 1U << 20U;

  struct Report {
    bool is_note = false;  // a line for the log, else a transfer
    std::uint32_t device =
        0;  // number of its opening: a device that was plugged in again has another one
    std::int64_t arrival_ns = 0;       // monotonic
    std::span<const std::byte> bytes;  // at most kMaxSize; valid until the next Pop
  };

  // `capacity` in bytes, a power of two.
  Reports(runtime::Clock& clock, runtime::Counters& counters, std::size_t capacity = kCapacity);

  // USB thread. `bytes` beyond kMaxSize are cut off. Both functions wake the pipeline.
  void PushData(std::uint32_t device, std::span<const std::byte> bytes) noexcept;
  void PushNote(std::string_view text) noexcept;

  // Pipeline thread. Pops the oldest entry; returns false and leaves `report` untouched if there is
  // none.
  bool Pop(Report& report) noexcept;
  // A descriptor that is readable when there may be something to pop; call Clear() before popping.
  int fd() const { return wakeup_.fd(); }
  void Clear() noexcept { wakeup_.Clear(); }

 private:
  bool Push(bool is_note, std::uint32_t device, std::span<const std::byte> bytes) noexcept;

  runtime::Clock& clock_;
  runtime::Counters& counters_;
  runtime::Wakeup wakeup_;
  recording::ByteRing ring_;
  std::vector<std::byte> popped_;  // never grows beyond what was reserved
};

}  // namespace styled::source::usb

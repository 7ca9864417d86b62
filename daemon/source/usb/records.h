#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "daemon/runtime/counters.h"
#include "daemon/source/native_decoder.h"
#include "daemon/source/transport.h"
#include "daemon/source/usb/reports.h"
#include "proto/rigs/native/stream_reader.h"

namespace styled::source::usb {

// Cuts what vendor devices send into our own records, which may begin and end anywhere in their
// transfers. Where a record makes no sense, the rest of its transfer is dropped and the next one is
// taken to begin with a record. Pipeline thread. Pinned by tests/unit/usb/records_test.cpp.
class Records {
 public:
  Records(int source, runtime::Counters& counters)
      : counters_(counters), decoder_(source, counters) {}

  // Hands what the records that the transfer completes say to `receiver`. Allocates for a device
  // that was not heard before only; of more than 16 the longest silent is forgotten, with what it
  // began.
  void Take(const Reports::Report& report, Receiver& receiver);
  std::uint64_t received() const { return received_; }

 private:
  static constexpr std::size_t kMaxDevices = 16;
  struct Stream {
    std::uint32_t device = 0;
    std::int64_t heard_ns = 0;
    std::vector<std::byte> buffer = std::vector<std::byte>(2 * native::kMaxDatagramSize);
    native::StreamReader reader{buffer};
  };

  Stream& StreamOf(std::uint32_t device);

  runtime::Counters& counters_;
  NativeDecoder decoder_;
  std::uint64_t received_ = 0;
  std::vector<std::unique_ptr<Stream>> streams_;
  std::array<std::span<const std::byte>, kBatch> records_;
};

}  // namespace styled::source::usb

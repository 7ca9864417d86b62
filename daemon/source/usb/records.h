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

// Cuts the data of vendor devices into native records, which may begin and end anywhere in their
// transfers. After an invalid record the rest of its transfer is dropped, and the next transfer is
// expected to begin with a record. Pipeline thread. Pinned by tests/unit/usb/records_test.cpp.
class Records {
 public:
  Records(int source, runtime::Counters& counters)
      : counters_(counters), decoder_(source, counters) {}

  // Decodes the records that the transfer completes, and passes their frames to `receiver`.
  // Allocates only for a new device. Beyond 16 devices, the one that was silent for longest is
  // removed, with its incomplete record.
  void Decode(const Reports::Report& report, Receiver& receiver);
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
  std::array<std::int64_t, kBatch> arrivals_ns_{};
};

}  // namespace styled::source::usb

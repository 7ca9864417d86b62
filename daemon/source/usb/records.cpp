#include "daemon/source/usb/records.h"

#include <algorithm>

namespace styled::source::usb {

using native::StreamReader;
using runtime::Counter;

Records::Stream& Records::StreamOf(std::uint32_t device) {
  for (const auto& stream : streams_) {
    if (stream->device == device) return *stream;
  }
  if (streams_.size() < kMaxDevices) {
    streams_.push_back(std::make_unique<Stream>());
    streams_.back()->device = device;
    return *streams_.back();
  }
  Stream& oldest =
      **std::ranges::min_element(streams_, {}, [](const auto& stream) { return stream->heard_ns; });
  oldest.device = device;
  oldest.reader = StreamReader(oldest.buffer);
  return oldest;
}

void Records::Decode(const Reports::Report& report, Receiver& receiver) {
  Stream& stream = StreamOf(report.device);
  stream.heard_ns = report.arrival_ns;
  StreamReader& reader = stream.reader;
  // The transfer always fits: the pending bytes are less than a datagram.
  std::ranges::copy(report.bytes, reader.Space().begin());
  reader.Received(report.bytes.size());
  while (true) {
    std::size_t count = 0;
    auto result = StreamReader::Result::kRecord;
    while (count < kBatch) {
      result = reader.Next(records_[count]);
      if (result != StreamReader::Result::kRecord) break;
      ++count;
    }
    received_ += count + (result == StreamReader::Result::kBroken ? 1 : 0);
    if (count > 0) {
      std::fill_n(arrivals_ns_.begin(), count, report.arrival_ns);
      decoder_.HandOn({records_.data(), count}, {}, receiver, std::span(arrivals_ns_).first(count));
    }
    if (result == StreamReader::Result::kNeedMore) return;
    if (result == StreamReader::Result::kBroken) {
      counters_.Add(runtime::CounterOf(reader.Broken()));
      counters_.Add(Counter::kUsbBadReports);
      reader = StreamReader(stream.buffer);
      return;
    }
  }
}

}  // namespace styled::source::usb

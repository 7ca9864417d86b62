// Fuzzes styled::native: the datagram decoder with the input unchanged and with a corrected
// checksum (to reach the code behind the check), and the stream reader with the input in pieces.
// Seeds: the unit test's case table (tests/unit/native/decode_cases.h).
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "model/base/crc32c.h"
#include "proto/rigs/native/datagram.h"
#include "proto/rigs/native/header.h"
#include "proto/rigs/native/stream_reader.h"

namespace {

using styled::native::Datagram;
using styled::native::DecodeResult;
using styled::native::StreamReader;
namespace header = styled::native::header;

void Require(bool condition) {
  if (!condition) std::abort();
}

// A decoded datagram must encode to the same bytes.
void CheckDatagram(std::span<const std::byte> bytes) {
  Datagram datagram;
  if (Decode(bytes, datagram) != DecodeResult::kOk) return;
  std::vector<std::byte> again(bytes.size());
  Require(Encode(datagram, again) == bytes.size());
  Require(std::ranges::equal(again, bytes));
}

void CheckResealed(std::span<const std::byte> bytes) {
  if (bytes.size() < styled::native::kHeaderSize) return;
  std::vector<std::byte> sealed(bytes.begin(), bytes.end());
  header::Write<std::uint32_t>(
      sealed, header::kLength,
      static_cast<std::uint32_t>(sealed.size() - styled::native::kHeaderSize));
  header::Write<std::uint32_t>(sealed, header::kCrc, 0);
  header::Write<std::uint32_t>(sealed, header::kCrc, styled::Crc32c(sealed));
  CheckDatagram(sealed);
}

void CheckStream(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  static std::vector<std::byte> buffer(styled::native::kMaxDatagramSize);
  StreamReader reader(buffer);
  const std::size_t piece = 1 + std::to_integer<std::size_t>(bytes.front()) * 16;
  std::size_t handed_out = 0;
  for (std::size_t at = 0; at < bytes.size();) {
    const auto space = reader.Space();
    Require(!space.empty());
    const std::size_t size = std::min({piece, bytes.size() - at, space.size()});
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), size, space.begin());
    reader.Received(size);
    at += size;
    std::span<const std::byte> record;
    StreamReader::Result result = reader.Next(record);
    for (; result == StreamReader::Result::kRecord; result = reader.Next(record)) {
      Require(std::ranges::equal(record, bytes.subspan(handed_out, record.size())));
      handed_out += record.size();
      CheckDatagram(record);
    }
    if (result == StreamReader::Result::kBroken) return;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  CheckDatagram(bytes);
  CheckResealed(bytes);
  CheckStream(bytes);
  return 0;
}

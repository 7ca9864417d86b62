// Fuzzes styled::mocopi: a decoded datagram is written by the encoder in the grammar's order, reads
// back the same, and encodes to the same bytes again. Seeds: tests/unit/mocopi/decode_cases.h.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "proto/rigs/mocopi/mocopi.h"

namespace {

using styled::mocopi::Datagram;
using styled::mocopi::DecodeResult;

using Buffer = std::array<std::byte, styled::mocopi::kSkeletonSize>;

void Require(bool condition) {
  if (!condition) std::abort();
}

std::size_t Write(const Datagram& datagram, Buffer& out) {
  return datagram.kind == Datagram::Kind::kSkeleton
             ? Encode(datagram.sender, datagram.skeleton, out)
             : Encode(datagram.sender, datagram.frame, out);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Datagram datagram;
  if (Decode(std::as_bytes(std::span(data, size)), datagram) != DecodeResult::kOk) return 0;
  Buffer written;
  const std::size_t written_size = Write(datagram, written);
  Require(written_size > 0);
  Datagram again;
  Require(Decode(std::span(written).first(written_size), again) == DecodeResult::kOk);
  Require(again.kind == datagram.kind && again.sender == datagram.sender);
  Buffer twice;
  Require(Write(again, twice) == written_size);
  Require(std::equal(twice.begin(), twice.begin() + static_cast<std::ptrdiff_t>(written_size),
                     written.begin()));
  return 0;
}

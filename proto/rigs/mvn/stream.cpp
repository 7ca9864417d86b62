#include "proto/rigs/mvn/stream.h"

#include "proto/rigs/mvn/mvn.h"

namespace styled::mvn {

Cut CutRecord(std::span<const std::byte> received, std::size_t& size) noexcept {
  if (received.size() < kHeaderSize) return Cut::kNeedMore;
  Header header;
  if (DecodeHeader(received, header) != DecodeResult::kOk) return Cut::kBroken;
  std::size_t payload = header.payload_size;
  if (payload == 0 && header.type == Type::kEuler) payload = header.items * std::size_t{28};
  if (payload == 0 && header.type == Type::kQuaternion) payload = header.items * std::size_t{32};
  if (kHeaderSize + payload > kMaxDatagramSize) return Cut::kBroken;
  if (received.size() < kHeaderSize + payload) return Cut::kNeedMore;
  size = kHeaderSize + payload;
  return Cut::kRecord;
}

}  // namespace styled::mvn

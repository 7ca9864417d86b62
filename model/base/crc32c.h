#pragma once

#include <boost/crc.hpp>
#include <cstddef>
#include <cstdint>
#include <span>

namespace styled {

// CRC-32C (Castagnoli) of RFC 3720 B.4: of datagrams and recordings, bodies, weights and
// checkpoints. For parts that follow each other: process_bytes of each, then checksum(). Pinned by
// tests/unit/native/datagram_test.cpp.
using Crc32cSum = boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true>;
inline std::uint32_t Crc32c(std::span<const std::byte> bytes) noexcept {
  Crc32cSum sum;
  sum.process_bytes(bytes.data(), bytes.size());
  return sum.checksum();
}

}  // namespace styled

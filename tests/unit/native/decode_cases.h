#pragma once

#include <cstddef>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/crc32c.h"
#include "proto/rigs/native/datagram.h"
#include "proto/rigs/native/header.h"

// Every way to get a datagram wrong, one by one, and some right ones. Shared by the unit test and,
// as seeds, by the fuzzer.
namespace styled::native::testing {

using Bytes = std::vector<std::byte>;

struct DecodeCase {
  std::string name;
  Bytes bytes;
  DecodeResult expected;
};

inline Bytes ToBytes(std::string_view text) {
  Bytes bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

inline Bytes MakeDatagram(Kind kind, std::uint64_t session, std::uint64_t sequence,
                          const Bytes& payload) {
  Bytes bytes(kHeaderSize + payload.size());
  bytes.resize(Encode({kind, session, sequence, payload}, bytes));
  return bytes;
}

// Writes the checksum that belongs to the (damaged) header, so that a later rule is reached.
inline void Reseal(Bytes& bytes) {
  header::Write<std::uint32_t>(bytes, header::kCrc, 0);
  header::Write<std::uint32_t>(bytes, header::kCrc, Crc32c(bytes));
}

inline std::vector<DecodeCase> DecodeCases() {
  const Bytes payload = ToBytes("\x0A\x04room\x10\x07");
  const Bytes good = MakeDatagram(Kind::kSourceFrame, 0x1122334455667788ULL, 7, payload);
  std::vector<DecodeCase> cases;
  const auto add = [&](std::string name, DecodeResult expected,
                       const std::function<void(Bytes&)>& damage, bool reseal = false) {
    Bytes bytes = good;
    damage(bytes);
    if (reseal) Reseal(bytes);
    cases.push_back({std::move(name), std::move(bytes), expected});
  };
  using R = DecodeResult;
  add("frame", R::kOk, [](Bytes&) {});
  cases.push_back({"body", MakeDatagram(Kind::kBody, 1, 0, payload), R::kOk});
  cases.push_back({"empty payload", MakeDatagram(Kind::kBody, 1, 0, {}), R::kOk});
  cases.push_back(
      {"largest payload", MakeDatagram(Kind::kBody, ~0ULL, ~0ULL, Bytes(kMaxPayloadSize)), R::kOk});
  add("nothing", R::kTooShort, [](Bytes& b) { b.clear(); });
  add("one byte", R::kTooShort, [](Bytes& b) { b.resize(1); });
  add("one byte less than a header", R::kTooShort, [](Bytes& b) { b.resize(kHeaderSize - 1); });
  add("more than UDP carries", R::kTooLong, [](Bytes& b) { b.resize(kMaxDatagramSize + 1); });
  add("a length of 4 GiB", R::kTooLong,
      [](Bytes& b) { header::Write<std::uint32_t>(b, header::kLength, ~0U); });
  add("a length one more than UDP carries", R::kTooLong,
      [](Bytes& b) { header::Write<std::uint32_t>(b, header::kLength, kMaxPayloadSize + 1); });
  for (std::size_t i = 0; i < 4; ++i) {
    add("magic, byte " + std::to_string(i), R::kBadMagic,
        [i](Bytes& b) { b[header::kMagic + i] ^= std::byte{0x20}; });
  }
  add("version 0", R::kBadVersion, [](Bytes& b) { b[header::kVersion] = std::byte{0}; });
  add(
      "version 2", R::kBadVersion, [](Bytes& b) { b[header::kVersion] = std::byte{2}; }, true);
  add("truncated by one byte", R::kLengthMismatch, [](Bytes& b) { b.pop_back(); });
  add("header alone", R::kLengthMismatch, [](Bytes& b) { b.resize(kHeaderSize); });
  add("one byte too many", R::kLengthMismatch, [](Bytes& b) { b.push_back(std::byte{0}); });
  add("length in network order", R::kTooLong, [&](Bytes& b) {
    header::Write<std::uint32_t>(b, header::kLength,
                                 static_cast<std::uint32_t>(payload.size()) << 24);
  });
  add("payload, last bit", R::kBadChecksum, [](Bytes& b) { b.back() ^= std::byte{1}; });
  add("payload, first bit", R::kBadChecksum, [](Bytes& b) { b[kHeaderSize] ^= std::byte{0x80}; });
  add("session damaged", R::kBadChecksum, [](Bytes& b) { b[header::kSession] ^= std::byte{4}; });
  add("sequence damaged", R::kBadChecksum, [](Bytes& b) { b[header::kSequence] ^= std::byte{4}; });
  add("kind damaged", R::kBadChecksum, [](Bytes& b) { b[header::kKind] = std::byte{1}; });
  add("reserved damaged", R::kBadChecksum, [](Bytes& b) { b[header::kReserved] = std::byte{1}; });
  add("checksum damaged", R::kBadChecksum, [](Bytes& b) { b[header::kCrc] ^= std::byte{1}; });
  add("checksum not taken with its own field 0", R::kBadChecksum,
      [](Bytes& b) { header::Write<std::uint32_t>(b, header::kCrc, Crc32c(b)); });
  add(
      "reserved, low byte", R::kBadReserved, [](Bytes& b) { b[header::kReserved] = std::byte{1}; },
      true);
  add(
      "reserved, high byte", R::kBadReserved,
      [](Bytes& b) { b[header::kReserved + 1] = std::byte{0x80}; }, true);
  add(
      "kind 0", R::kBadKind, [](Bytes& b) { b[header::kKind] = std::byte{0}; }, true);
  add(
      "kind 3", R::kBadKind, [](Bytes& b) { b[header::kKind] = std::byte{3}; }, true);
  add(
      "kind 255", R::kBadKind, [](Bytes& b) { b[header::kKind] = std::byte{255}; }, true);
  add(
      "session 0", R::kNoSession,
      [](Bytes& b) { header::Write<std::uint64_t>(b, header::kSession, 0); }, true);
  return cases;
}

}  // namespace styled::native::testing

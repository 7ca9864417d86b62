// Fuzzes styled::slimevr: the input as a receiver's report, as a tracker's datagram and as a
// server's reply. A decoded packet has unit rotations and is unchanged by encoding and decoding.
// Seeds: the unit tests' case tables (tests/unit/slimevr/decode_cases.h).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "proto/rigs/slimevr/hid.h"
#include "proto/rigs/slimevr/udp.h"

namespace {

using namespace styled::slimevr;

void Require(bool condition) {
  if (!condition) std::abort();
}

void CheckOrientation(const Orientation& orientation) {
  float norm = 0;
  for (const float part : orientation.rotation) norm += part * part;
  Require(std::abs(norm - 1) < 1e-4F);
}

void CheckReport(std::span<const std::byte> bytes) {
  Report report, again;
  if (DecodeReport(bytes, report) != ReportResult::kOk) return;
  Require((report.count + report.unknown) * kRecordSize == bytes.size());
  for (std::size_t i = 0; i < report.count; ++i) {
    if (const auto* orientation = OrientationOf(report.records[i])) CheckOrientation(*orientation);
    std::array<std::byte, kRecordSize> once, twice;
    EncodeRecord(report.records[i], once);
    Require(DecodeReport(once, again) == ReportResult::kOk);
    Require(again.count == 1 && again.records[0].tracker == report.records[i].tracker);
    Require(again.records[0].body.index() == report.records[i].body.index());
    // The second round trip loses nothing to rounding, except packed rotations of more than half a
    // turn.
    if (OrientationOf(again.records[0]) != nullptr) continue;
    EncodeRecord(again.records[0], twice);
    Require(once == twice);
  }
}

void CheckDatagram(std::span<const std::byte> bytes) {
  static Datagram datagram, again;
  if (Decode(bytes, datagram) != UdpResult::kOk) return;
  static std::array<std::byte, 1 << 17> once, twice;
  for (std::size_t i = 0; i < datagram.count; ++i) {
    const Packet& packet = datagram.packets[i];
    if (const auto* p = std::get_if<Rotation>(&packet)) CheckOrientation(p->orientation);
    if (const auto* p = std::get_if<LegacyRotation>(&packet)) CheckOrientation(p->orientation);
    const std::size_t size = Encode(datagram.number, packet, once);
    Require(size != 0);
    Require(Decode(std::span(once).first(size), again) == UdpResult::kOk);
    Require(again.count == 1 && again.number == datagram.number);
    Require(again.packets[0].index() == packet.index());
    if (std::holds_alternative<Rotation>(packet) ||
        std::holds_alternative<LegacyRotation>(packet) ||
        std::holds_alternative<RotationAndAcceleration>(packet)) {
      continue;  // normalized again: the last bit may differ
    }
    Require(Encode(again.number, again.packets[0], twice) == size);
    Require(
        std::equal(once.begin(), once.begin() + static_cast<std::ptrdiff_t>(size), twice.begin()));
  }
}

void CheckAnswer(std::span<const std::byte> bytes) {
  Answer answer, again;
  if (DecodeAnswer(bytes, answer) != UdpResult::kOk) return;
  std::array<std::byte, kMaxAnswerSize> out;
  const std::size_t size = EncodeAnswer(answer, out);
  Require(size != 0);
  Require(DecodeAnswer(std::span(out).first(size), again) == UdpResult::kOk);
  Require(again.index() == answer.index());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  CheckReport(bytes);
  CheckDatagram(bytes);
  CheckAnswer(bytes);
  return 0;
}

// Fuzzes styled::qtm. The input is a stream, cut into packets; what remains after the first broken
// header is decoded as one payload of each kind, whatever its header says. A decoded frame, or
// parameters, must encode to what decodes to the same. Seeds: the unit test's case tables.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "proto/rigs/qtm/frame.h"
#include "proto/rigs/qtm/parameters.h"

namespace {

using namespace styled::qtm;
using Bytes = std::span<const std::byte>;

void Require(bool condition) {
  if (!condition) std::abort();
}

template <typename T>
bool Same(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;  // NaNs too
}

void CheckFrame(Bytes payload) {
  static Frame frame, again;
  static std::vector<std::byte> buffer(kMaxPacketSize);
  if (DecodeFrame(payload, frame) != DecodeResult::kOk) return;
  const std::size_t size = EncodeFrame(frame, buffer);
  Require(size > 0 && size <= payload.size() + kHeaderSize);
  Packet packet;
  Require(DecodePacket(Bytes(buffer).first(size), packet) == DecodeResult::kOk);
  Require(DecodeFrame(packet.payload, again) == DecodeResult::kOk);
  Require(again.timestamp_us == frame.timestamp_us && again.number == frame.number &&
          again.has_skeletons == frame.has_skeletons && again.has_timecode == frame.has_timecode &&
          again.skeleton_count == frame.skeleton_count);
  Require(!frame.has_timecode || Same(again.timecode, frame.timecode));
  for (std::size_t k = 0; k < frame.skeleton_count; ++k) {
    const SkeletonPose &a = frame.skeletons[k], &b = again.skeletons[k];
    Require(a.segment_count == b.segment_count);
    for (std::size_t s = 0; s < a.segment_count; ++s) {
      Require(Same(a.segments[s], b.segments[s]));
    }
  }
}

void CheckParameters(std::string_view xml) {
  const auto read = ReadParameters(xml);
  if (!read.ok()) return Require(!read.status().message().empty());
  if (!read.value().skeletons) return;
  for (const SkeletonDescription& skeleton : *read.value().skeletons) {
    Require(skeleton.segments.size() <= kMaxSegments);
    for (std::size_t s = 0; s < skeleton.segments.size(); ++s) {
      const SegmentDescription& segment = skeleton.segments[s];
      Require(segment.parent < static_cast<int>(s));
      for (const double value : segment.position_mm) Require(std::isfinite(value));
    }
  }
}

void CheckPayload(PacketType type, Bytes payload) {
  switch (type) {
    case PacketType::kData:
      return CheckFrame(payload);
    case PacketType::kXml:
      return CheckParameters(TextOf(payload));
    default:
      Require(TextOf(payload).size() <= payload.size());
      Require(ToString(TextOf(payload)).size() <= 200);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes stream = std::as_bytes(std::span(data, size));
  std::size_t packet_size = 0;
  styled::rigs::Cut cut{};
  while ((cut = CutPacket(stream, packet_size)) == styled::rigs::Cut::kRecord) {
    Packet packet;
    Require(packet_size <= stream.size());
    Require(DecodePacket(stream.first(packet_size), packet) == DecodeResult::kOk);
    CheckPayload(packet.type, packet.payload);
    stream = stream.subspan(packet_size);
  }
  if (stream.size() < kHeaderSize) return 0;
  if (cut == styled::rigs::Cut::kBroken) Require(!WhyBroken(stream).empty());
  for (const PacketType type : {PacketType::kData, PacketType::kXml, PacketType::kCommand}) {
    CheckPayload(type, stream.subspan(kHeaderSize));
  }
  return 0;
}

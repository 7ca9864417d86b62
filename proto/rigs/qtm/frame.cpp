#include "proto/rigs/qtm/frame.h"

#include "proto/rigs/qtm/cursor.h"

namespace styled::qtm {
namespace {

constexpr std::size_t kSegmentSize = 32;
// 30 years, in microseconds: no measurement is as long, and nanoseconds fit into 64 bits.
constexpr std::int64_t kMaxTime_us = 30LL * 365 * 24 * 3600 * 1'000'000;

void GetSkeletons(Reader& reader, Frame& frame) noexcept {
  frame.has_skeletons = true;
  for (std::size_t n = reader.GetCount(4); n > 0 && reader.ok(); --n) {
    const std::size_t segments = reader.GetCount(kSegmentSize);
    if (frame.skeleton_count == kMaxSkeletons) {
      ++frame.skeletons_left_out;
      reader.Consume(segments * kSegmentSize);
      continue;
    }
    SkeletonPose& skeleton = frame.skeletons[frame.skeleton_count++];
    skeleton.segment_count = segments;
    if (segments > kMaxSegments) {
      ++frame.skeletons_left_out;
      skeleton.segment_count = 0;
      reader.Consume(segments * kSegmentSize);
      continue;
    }
    for (std::size_t s = 0; s < segments; ++s) {
      Segment& segment = skeleton.segments[s];
      segment.id = reader.Get<std::uint32_t>();
      segment.position_mm = reader.Get<std::array<float, 3>>();
      segment.rotation = reader.Get<std::array<float, 4>>();
    }
  }
}

void GetTimecode(Reader& reader, Frame& frame) noexcept {
  const std::size_t count = reader.GetCount(12);
  if (count == 0) return;
  frame.has_timecode = true;
  frame.timecode.kind = reader.Get<Timecode::Kind>();
  frame.timecode.high = reader.Get<std::uint32_t>();
  frame.timecode.low = reader.Get<std::uint32_t>();
}

}  // namespace

DecodeResult DecodeFrame(std::span<const std::byte> payload, Frame& frame) noexcept {
  frame.has_skeletons = frame.has_timecode = frame.has_markers = false;
  frame.skeleton_count = frame.skeletons_left_out = 0;
  Reader reader(payload);
  frame.timestamp_us = reader.Get<std::int64_t>();
  frame.number = reader.Get<std::uint32_t>();
  for (std::size_t n = reader.GetCount(kHeaderSize); n > 0 && reader.ok(); --n) {
    const auto size = reader.Get<std::uint32_t>();
    const auto type = reader.Get<Component>();
    Reader body(reader.Consume(size < kHeaderSize ? kMaxPacketSize : size - kHeaderSize));
    if (!reader.ok()) break;
    if (type == Component::kSkeletons && !frame.has_skeletons) GetSkeletons(body, frame);
    if (type == Component::kTimecode && !frame.has_timecode) GetTimecode(body, frame);
    if (!body.ok()) reader.Fail(body.result());
  }
  if (!reader.ok()) return reader.result();
  if (frame.timestamp_us < 0 || frame.timestamp_us >= kMaxTime_us) return DecodeResult::kBadTime;
  return DecodeResult::kOk;
}

std::size_t EncodeFrame(const Frame& frame, std::span<std::byte> out) noexcept {
  Writer writer(PacketType::kData, out);
  writer.Put(frame.timestamp_us);
  writer.Put(frame.number);
  writer.Put(static_cast<std::uint32_t>(frame.has_markers) +
             static_cast<std::uint32_t>(frame.has_timecode) +
             static_cast<std::uint32_t>(frame.has_skeletons));
  const auto begin = [&](Component type) { return writer.Begin(static_cast<std::uint32_t>(type)); };
  if (frame.has_markers) {
    const std::size_t at = begin(Component::kMarkers);
    writer.Put(static_cast<std::uint32_t>(frame.markers.count));
    writer.Put<std::uint32_t>(0);  // two rates, per mille: frames dropped, and out of sync
    for (std::size_t m = 0; m < frame.markers.count; ++m) writer.Put(frame.markers.positions_mm[m]);
    writer.End(at);
  }
  if (frame.has_timecode) {
    const std::size_t at = begin(Component::kTimecode);
    writer.Put<std::uint32_t>(1);
    writer.Put(frame.timecode.kind);
    writer.Put(frame.timecode.high);
    writer.Put(frame.timecode.low);
    writer.End(at);
  }
  if (frame.has_skeletons) {
    const std::size_t at = begin(Component::kSkeletons);
    writer.Put(static_cast<std::uint32_t>(frame.skeleton_count));
    for (std::size_t k = 0; k < frame.skeleton_count; ++k) {
      const SkeletonPose& skeleton = frame.skeletons[k];
      writer.Put(static_cast<std::uint32_t>(skeleton.segment_count));
      for (std::size_t s = 0; s < skeleton.segment_count; ++s) {
        writer.Put(skeleton.segments[s].id);
        writer.Put(skeleton.segments[s].position_mm);
        writer.Put(skeleton.segments[s].rotation);
      }
    }
    writer.End(at);
  }
  return writer.Finish();
}

}  // namespace styled::qtm

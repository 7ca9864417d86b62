#include "daemon/source/native_decoder.h"

#include <algorithm>

#include "daemon/config/config.h"
#include "daemon/runtime/realtime.h"
#include "daemon/source/face.h"
#include "daemon/source/wire.h"
#include "model/base/crc32c.h"
#include "model/base/text.h"
#include "proto/rigs/native/datagram.h"
#include "proto/styled/face.h"
#include "proto/styled/props.h"

namespace styled::source {
namespace {

std::string_view AsText(std::span<const std::byte> bytes) noexcept {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool ReadTimecode(std::span<const std::byte> bytes, Timecode& timecode) noexcept {
  WireReader reader(bytes);
  while (!reader.AtEnd()) {
    std::uint32_t field = 0;
    std::uint32_t wire = 0;
    std::uint64_t number = 0;
    if (!reader.Tag(field, wire)) return false;
    if (field == 5 && wire == kFixed32) {
      if (!reader.Fixed(timecode.rate)) return false;
    } else if (wire == kVarint) {
      if (!reader.Varint(number)) return false;
      if (field == 1) timecode.hours = static_cast<std::uint32_t>(number);
      if (field == 2) timecode.minutes = static_cast<std::uint32_t>(number);
      if (field == 3) timecode.seconds = static_cast<std::uint32_t>(number);
      if (field == 4) timecode.frames = static_cast<std::uint32_t>(number);
      if (field == 6) timecode.drop_frame = number != 0;
    } else if (!reader.Skip(wire)) {
      return false;
    }
  }
  return true;
}

// Expressions are passed on to subscribers unparsed, so they must be valid for protobuf's readers.
bool IsExpression(std::span<const std::byte> bytes) noexcept {
  WireReader reader(bytes);
  while (!reader.AtEnd()) {
    std::uint32_t field = 0, wire = 0;
    std::span<const std::byte> name;
    float value = 0;
    if (!reader.Tag(field, wire)) return false;
    if (field == 1 && wire == kBytes) {
      if (!reader.Bytes(name) || !IsUtf8(AsText(name))) return false;
    } else if (field == 2 && wire == kFixed32) {
      if (!reader.Fixed(value)) return false;
    } else if (!reader.Skip(wire)) {
      return false;
    }
  }
  return true;
}

constexpr std::uint32_t kExpressions = 18, kThru = 19, kPropsField = 20;

// Extends `run` by a field's bytes, or restarts it at `begin` if it does not end there.
void Extend(const std::byte* begin, const std::byte* end, std::span<const std::byte>& run) {
  const bool goes_on = !run.empty() && run.data() + run.size() == begin;
  const std::byte* const from = goes_on ? run.data() : begin;
  run = {from, end};
}

// Reads one field of a SourceFrame, whose tag has been read.
bool ReadField(WireReader& reader, std::uint32_t field, std::uint32_t wire,
               SourceFrame& frame) noexcept {
  std::span<const std::byte> bytes;
  if (wire == kBytes) {
    if (!reader.Bytes(bytes)) return false;
    switch (field) {
      case 1:
        frame.performer = AsText(bytes);
        return true;
      case 3:
        frame.has_timecode = true;
        return ReadTimecode(bytes, frame.timecode);
      case 4:
        frame.root_position = bytes;
        return bytes.size() % sizeof(float) == 0;
      case 5:
        frame.rotations = bytes;
        return bytes.size() % sizeof(float) == 0;
      case kExpressions:
        return IsExpression(bytes);
      default:
        // Fields 2 and 6 are scalars and must not be length-delimited.
        return field != 2 && field != 6;
    }
  }
  if (field == 2 && wire == kVarint) return reader.Varint(frame.source_time_ns);
  if (field == 6 && wire == kFixed32) return reader.Fixed(frame.body_crc);
  return field > 6 && reader.Skip(wire);
}

}  // namespace

FrameResult ReadSourceFrame(std::span<const std::byte> payload, SourceFrame& frame) noexcept {
  frame = SourceFrame();
  WireReader reader(payload);
  while (!reader.AtEnd()) {
    std::uint32_t field = 0;
    std::uint32_t wire = 0;
    const std::byte* const begin = reader.at();
    if (!reader.Tag(field, wire) || !ReadField(reader, field, wire, frame)) {
      return FrameResult::kMalformed;
    }
    if (wire == kBytes && (field == kExpressions || field == kThru)) {
      Extend(begin, reader.at(), frame.face);
    }
    if (wire == kBytes && field == kPropsField) Extend(begin, reader.at(), frame.props);
  }
  if (frame.face.size() > kMaxFace) frame.face = {};
  frame.props = frame.props.first(std::min(frame.props.size(), kMaxPropBytes));
  return config::IsName(frame.performer) ? FrameResult::kOk : FrameResult::kBadName;
}

std::string_view ReadPerformer(std::span<const std::byte> payload) noexcept {
  WireReader reader(payload);
  while (!reader.AtEnd()) {
    std::uint32_t field = 0;
    std::uint32_t wire = 0;
    std::span<const std::byte> bytes;
    if (!reader.Tag(field, wire)) return {};
    if (field == 1)
      return wire == kBytes && reader.Bytes(bytes) ? AsText(bytes) : std::string_view();
    if (!reader.Skip(wire)) return {};
  }
  return {};
}

namespace {

// Returns kCount for a good frame, otherwise the counter of the refusal.
runtime::Counter Decode(std::span<const std::byte> bytes, SourceFrame& frame) noexcept {
  using runtime::Counter;
  native::Datagram datagram;
  const auto result = native::Decode(bytes, datagram);
  if (result != native::DecodeResult::kOk) return runtime::CounterOf(result);
  if (datagram.kind == native::Kind::kBody) {
    frame = SourceFrame();
    frame.is_body = true;
    frame.performer = ReadPerformer(datagram.payload);
    if (!config::IsName(frame.performer)) return Counter::kSourceBadName;
    frame.body_crc = Crc32c(datagram.payload);
    frame.body_bytes = datagram.payload;
  } else {
    const FrameResult read = ReadSourceFrame(datagram.payload, frame);
    if (read == FrameResult::kBadName) return Counter::kSourceBadName;
    if (read != FrameResult::kOk) return Counter::kSourceMalformed;
  }
  frame.session = datagram.session;
  frame.sequence = datagram.sequence;
  return Counter::kCount;
}

}  // namespace

NativeDecoder::NativeDecoder(int source, runtime::Counters& counters)
    : source_(source), counters_(counters) {}

std::size_t NativeDecoder::DecodeAll(std::span<const std::span<const std::byte>> datagrams,
                                     std::span<const Machine> senders,
                                     std::span<const std::int64_t> arrivals_ns) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < datagrams.size(); ++i) {
    const runtime::Counter refused = Decode(datagrams[i], frames_[count]);
    if (refused != runtime::Counter::kCount) {
      counters_.AddOf(source_, refused);
      continue;
    }
    frames_[count].arrival_ns = i < arrivals_ns.size() ? arrivals_ns[i] : 0;
    frames_[count++].machine = i < senders.size() ? senders[i] : Machine{};
  }
  counters_.Add(runtime::Counter::kSourceReceived, datagrams.size() - count);
  return count;
}

void NativeDecoder::HandOn(std::span<const std::span<const std::byte>> datagrams,
                           std::span<const Machine> senders, Receiver& receiver,
                           std::span<const std::int64_t> arrivals_ns) {
  runtime::HotSection hot;
  const std::size_t count = DecodeAll(datagrams, senders, arrivals_ns);
  hot.Leave();  // the pipeline enters a section of its own
  if (count == 0) return;
  receiver.OnFrames(source_, std::span(frames_).first(count), datagrams.size() == kBatch);
}

void NativeDecoder::HandOn(std::span<const std::span<const std::byte>> records,
                           std::span<const Machine> senders, Receiver& receiver,
                           const ReadTogether& read) {
  runtime::HotSection hot;
  const std::size_t count = DecodeAll(records, senders, {});
  Spread(std::span(frames_).first(count), read);
  hot.Leave();
  if (count == 0) return;
  receiver.OnFrames(source_, std::span(frames_).first(count), records.size() == kBatch);
}

void NativeDecoder::Spread(std::span<SourceFrame> frames, const ReadTogether& read) noexcept {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    SourceFrame& frame = frames[i];
    frame.arrival_ns = read.last_ns;
    if (frame.is_body) continue;
    const SourceFrame* last = &frame;
    for (const SourceFrame& later : frames.subspan(i + 1)) {
      if (!later.is_body && later.performer == frame.performer) last = &later;
    }
    // Clocks of rigs may go back, and may have any value.
    if (last->source_time_ns <= frame.source_time_ns) continue;
    const std::uint64_t before_ns = last->source_time_ns - frame.source_time_ns;
    const auto most_ns =
        static_cast<std::uint64_t>(std::max<std::int64_t>(0, read.last_ns - read.not_before_ns));
    frame.arrival_ns -= static_cast<std::int64_t>(std::min(before_ns, most_ns));
  }
}

}  // namespace styled::source

#include "proto/rigs/mvn/mvn.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "proto/rigs/big_endian.h"
#include "proto/rigs/result_name.h"

namespace styled::mvn {
namespace {

constexpr std::size_t kEulerItem = 28, kQuaternionItem = 32;

using Reader = rigs::BigEndianReader;
using Writer = rigs::BigEndianWriter;

template <std::size_t N>
std::array<float, N> Floats(Reader& reader) noexcept {
  std::array<float, N> values;
  for (float& value : values) value = reader.Float();
  return values;
}

// Reads a signed length and that many bytes; false where they are not there.
bool ReadText(Reader& reader, std::string_view& text) noexcept {
  const auto size = reader.Number<std::int32_t>();
  if (!reader.ok() || size < 0) return false;
  text = reader.Text(static_cast<std::size_t>(size));
  return reader.ok();
}

std::array<float, 4> FromEuler(const std::array<float, 3>& degrees) noexcept {
  constexpr double kHalfRadians = 3.14159265358979323846 / 360.0;
  const double x = degrees[0] * kHalfRadians, y = degrees[1] * kHalfRadians,
               z = degrees[2] * kHalfRadians;
  const double cx = std::cos(x), sx = std::sin(x), cy = std::cos(y), sy = std::sin(y),
               cz = std::cos(z), sz = std::sin(z);
  return {static_cast<float>(sx * cy * cz - cx * sy * sz),
          static_cast<float>(cx * sy * cz + sx * cy * sz),
          static_cast<float>(cx * cy * sz - sx * sy * cz),
          static_cast<float>(cx * cy * cz + sx * sy * sz)};
}

// The angles of R = Rz Ry Rx, with y from -90 to 90 degrees. x is taken from Rz^-1 R, so that x and
// z together stay correct at y = +-90 degrees, where neither is unique.
std::array<float, 3> ToEuler(const std::array<float, 4>& xyzw) noexcept {
  constexpr double kDegrees = 180.0 / 3.14159265358979323846;
  const double x = xyzw[0], y = xyzw[1], z = xyzw[2], w = xyzw[3];
  const double r00 = 1 - 2 * (y * y + z * z), r10 = 2 * (x * y + w * z), r20 = 2 * (x * z - w * y);
  const double r01 = 2 * (x * y - w * z), r11 = 1 - 2 * (x * x + z * z);
  const double r02 = 2 * (x * z + w * y), r12 = 2 * (y * z - w * x);
  const double about_z = std::atan2(r10, r00), s = std::sin(about_z), c = std::cos(about_z);
  const double about_y = std::atan2(-r20, std::hypot(r00, r10));
  const double about_x = std::atan2(s * r02 - c * r12, c * r11 - s * r01);
  return {static_cast<float>(kDegrees * about_x), static_cast<float>(kDegrees * about_y),
          static_cast<float>(kDegrees * about_z)};
}

DecodeResult Begin(std::span<const std::byte> bytes, Type type, Reader& reader) noexcept {
  Header header;
  const DecodeResult result = DecodeHeader(bytes, header);
  if (result != DecodeResult::kOk) return result;
  if (header.type != type) return DecodeResult::kNotThisType;
  reader = Reader(bytes.subspan(kHeaderSize));
  return DecodeResult::kOk;
}

Writer BeginWriting(const Header& header, std::span<std::byte> out) noexcept {
  Writer writer(out);
  const auto number = static_cast<unsigned>(header.type);
  writer.Text("MXTP");
  writer.U8('0' + number / 10);
  writer.U8('0' + number % 10);
  writer.U32(header.sample);
  writer.U8((header.datagram & 0x7FU) | (header.last ? 0x80U : 0U));
  writer.U8(header.items);
  writer.U32(header.time_ms);
  writer.U8(header.character);
  writer.U8(header.body_segments);
  writer.U8(header.props);
  writer.U8(header.finger_segments);
  writer.U32(0);  // reserved, and the payload's size, which Finish writes
  return writer;
}

std::size_t Finish(const Writer& writer, std::span<std::byte> out) noexcept {
  if (writer.size() == 0) return 0;
  const std::size_t payload = writer.size() - kHeaderSize;
  if (payload > 0xFFFF) return 0;
  out[kHeaderSize - 2] = static_cast<std::byte>(payload >> 8U);
  out[kHeaderSize - 1] = static_cast<std::byte>(payload & 0xFFU);
  return writer.size();
}

}  // namespace

std::string_view Name(DecodeResult result) noexcept {
  return rigs::ResultName(
      result, {"ok", "too short", "not an MXTP datagram", "longer than its items", "too many items",
               "bad text", "of another type"});
}

DecodeResult DecodeHeader(std::span<const std::byte> bytes, Header& out) noexcept {
  if (bytes.size() < kHeaderSize) return DecodeResult::kTooShort;
  const auto digit = [&bytes](std::size_t i) { return std::to_integer<unsigned>(bytes[i]) - '0'; };
  if (std::memcmp(bytes.data(), "MXTP", 4) != 0 || digit(4) > 9 || digit(5) > 9) {
    return DecodeResult::kBadMagic;
  }
  out.type = static_cast<Type>(10 * digit(4) + digit(5));
  Reader reader(bytes.subspan(6));
  out.sample = reader.U32();
  const std::uint32_t datagram = reader.U8();
  out.datagram = static_cast<std::uint8_t>(datagram & 0x7FU);
  out.last = (datagram & 0x80U) != 0;
  out.items = reader.U8();
  out.time_ms = reader.U32();
  out.character = reader.U8();
  out.body_segments = reader.U8();
  out.props = reader.U8();
  out.finger_segments = reader.U8();
  (void)reader.Bytes(2);
  out.payload_size = reader.Number<std::uint16_t>();
  return DecodeResult::kOk;
}

DecodeResult DecodePose(std::span<const std::byte> bytes, Header& header, Pose& out) noexcept {
  const DecodeResult result = DecodeHeader(bytes, header);
  if (result != DecodeResult::kOk) return result;
  const bool euler = header.type == Type::kEuler;
  if (!euler && header.type != Type::kQuaternion) return DecodeResult::kNotThisType;
  if (header.items > kMaxSegments) return DecodeResult::kTooManyItems;
  const std::size_t payload = header.items * (euler ? kEulerItem : kQuaternionItem);
  if (bytes.size() < kHeaderSize + payload) return DecodeResult::kTooShort;
  if (bytes.size() > kHeaderSize + payload) return DecodeResult::kLengthMismatch;
  Reader reader(bytes.subspan(kHeaderSize));
  out.count = header.items;
  for (std::size_t i = 0; i < header.items; ++i) {
    Segment& segment = out.segments[i];
    segment.id = reader.U32();
    segment.position = Floats<3>(reader);
    if (euler) {
      segment.rotation = FromEuler(Floats<3>(reader));
    } else {
      const auto wxyz = Floats<4>(reader);
      segment.rotation = {wxyz[1], wxyz[2], wxyz[3], wxyz[0]};
    }
  }
  return DecodeResult::kOk;
}

DecodeResult DecodeScale(std::span<const std::byte> bytes, Scale& out) noexcept {
  Reader reader;
  const DecodeResult result = Begin(bytes, Type::kScale, reader);
  if (result != DecodeResult::kOk) return result;
  const std::uint32_t count = reader.U32();
  if (!reader.ok()) return DecodeResult::kTooShort;
  if (count > kMaxSegments) return DecodeResult::kTooManyItems;
  out.count = static_cast<int>(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!ReadText(reader, out.segments[i].name)) return DecodeResult::kBadText;
    out.segments[i].position_m = Floats<3>(reader);
    if (!reader.ok()) return DecodeResult::kTooShort;
  }
  // The points that follow are markers on the body, which a pose does not need.
  return DecodeResult::kOk;
}

DecodeResult DecodeName(std::span<const std::byte> bytes, std::string_view& name) noexcept {
  Reader reader;
  const DecodeResult result = Begin(bytes, Type::kMeta, reader);
  if (result != DecodeResult::kOk) return result;
  std::string_view lines;
  if (!ReadText(reader, lines)) return DecodeResult::kBadText;
  name = {};
  while (!lines.empty()) {
    const std::string_view line = lines.substr(0, lines.find('\n'));
    lines.remove_prefix(std::min(line.size() + 1, lines.size()));
    if (!line.starts_with("name:")) continue;
    name = line.substr(5);
    if (name.ends_with('\r')) name.remove_suffix(1);
  }
  return DecodeResult::kOk;
}

DecodeResult DecodeTimecode(std::span<const std::byte> bytes, Timecode& out) noexcept {
  Reader reader;
  const DecodeResult result = Begin(bytes, Type::kTimecode, reader);
  if (result != DecodeResult::kOk) return result;
  constexpr std::size_t kText = 12;                    // HH:MM:SS.mmm
  if (reader.left() == kText + 4) (void)reader.U32();  // some senders put a length first
  if (reader.left() != kText) return DecodeResult::kBadText;
  const auto* text = reader.Text(kText).data();
  const auto number = [text](std::size_t at, std::size_t digits, std::uint32_t& value) {
    value = 0;
    for (std::size_t i = at; i < at + digits; ++i) {
      if (text[i] < '0' || text[i] > '9') return false;
      value = 10 * value + static_cast<std::uint32_t>(text[i] - '0');
    }
    return true;
  };
  const bool good = number(0, 2, out.hours) && text[2] == ':' && number(3, 2, out.minutes) &&
                    text[5] == ':' && number(6, 2, out.seconds) && text[8] == '.' &&
                    number(9, 3, out.milliseconds);
  return good ? DecodeResult::kOk : DecodeResult::kBadText;
}

std::size_t EncodePose(Header header, std::span<const Segment> segments,
                       std::span<std::byte> out) noexcept {
  if (segments.size() > kMaxSegments) return 0;
  const bool euler = header.type == Type::kEuler;
  if (!euler) header.type = Type::kQuaternion;
  header.items = static_cast<std::uint8_t>(segments.size());
  Writer writer = BeginWriting(header, out);
  for (const Segment& segment : segments) {
    writer.U32(segment.id);
    writer.Floats(segment.position);
    if (euler) {
      writer.Floats(ToEuler(segment.rotation));
      continue;
    }
    writer.Float(segment.rotation[3]);
    for (std::size_t i = 0; i < 3; ++i) writer.Float(segment.rotation[i]);
  }
  return Finish(writer, out);
}

std::size_t EncodeScale(Header header, std::span<const Scale::Row> segments,
                        std::span<std::byte> out) noexcept {
  header.type = Type::kScale;
  header.items = 0;
  Writer writer = BeginWriting(header, out);
  writer.U32(static_cast<std::uint32_t>(segments.size()));
  for (const auto& row : segments) {
    writer.U32(static_cast<std::uint32_t>(row.name.size()));
    writer.Text(row.name);
    writer.Floats(row.position_m);
  }
  writer.U32(0);  // points
  return Finish(writer, out);
}

std::size_t EncodeName(Header header, std::string_view name, std::span<std::byte> out) noexcept {
  header.type = Type::kMeta;
  header.items = 1;
  Writer writer = BeginWriting(header, out);
  writer.U32(static_cast<std::uint32_t>(name.size() + 6));
  writer.Text("name:");
  writer.Text(name);
  writer.Text("\n");
  return Finish(writer, out);
}

std::size_t EncodeTimecode(Header header, const Timecode& timecode,
                           std::span<std::byte> out) noexcept {
  header.type = Type::kTimecode;
  header.items = 1;
  Writer writer = BeginWriting(header, out);
  const auto number = [&writer](std::uint32_t value, std::uint32_t unit) {
    for (; unit > 0; unit /= 10) writer.U8('0' + value / unit % 10);
  };
  number(timecode.hours, 10);
  writer.Text(":");
  number(timecode.minutes, 10);
  writer.Text(":");
  number(timecode.seconds, 10);
  writer.Text(".");
  number(timecode.milliseconds, 100);
  return Finish(writer, out);
}

}  // namespace styled::mvn

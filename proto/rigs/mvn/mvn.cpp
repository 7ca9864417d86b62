#include "proto/rigs/mvn/mvn.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace styled::mvn {
namespace {

constexpr std::size_t kEulerItem = 28, kQuaternionItem = 32;

// Reads big-endian numbers from the front of `bytes`. A missing one reads as 0 and sets `bad`.
struct Reader {
  std::span<const std::byte> bytes;
  bool bad = false;

  std::uint32_t Unsigned(std::size_t size) noexcept {
    if (bytes.size() < size) {
      bad = true;
      bytes = {};
      return 0;
    }
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value = (value << 8U) | std::to_integer<unsigned>(bytes[i]);
    bytes = bytes.subspan(size);
    return value;
  }
  float Float() noexcept { return std::bit_cast<float>(Unsigned(4)); }
  template <std::size_t N>
  std::array<float, N> Floats() noexcept {
    std::array<float, N> values;
    for (float& value : values) value = Float();
    return values;
  }
  // Reads a signed length and that many bytes.
  std::string_view Text() noexcept {
    const auto size = static_cast<std::int32_t>(Unsigned(4));
    if (bad || size < 0 || static_cast<std::size_t>(size) > bytes.size()) {
      bad = true;
      return {};
    }
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()),
                                static_cast<std::size_t>(size));
    bytes = bytes.subspan(text.size());
    return text;
  }
};

// Writes big-endian numbers. One that does not fit sets `full`.
struct Writer {
  std::span<std::byte> bytes;
  std::size_t size = 0;
  bool full = false;

  void Unsigned(std::uint32_t value, std::size_t count) noexcept {
    if (bytes.size() - size < count) {
      full = true;
      return;
    }
    for (std::size_t i = 0; i < count; ++i) {
      bytes[size + i] = static_cast<std::byte>((value >> (8 * (count - 1 - i))) & 0xFFU);
    }
    size += count;
  }
  void Float(float value) noexcept { Unsigned(std::bit_cast<std::uint32_t>(value), 4); }
  void Raw(std::string_view text) noexcept {
    for (const char c : text) Unsigned(static_cast<unsigned char>(c), 1);
  }
  void Text(std::string_view text) noexcept {
    Unsigned(static_cast<std::uint32_t>(text.size()), 4);
    Raw(text);
  }
};

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
  reader.bytes = bytes.subspan(kHeaderSize);
  return DecodeResult::kOk;
}

Writer BeginWriting(const Header& header, std::span<std::byte> out) noexcept {
  Writer writer{out};
  const auto number = static_cast<unsigned>(header.type);
  writer.Raw("MXTP");
  writer.Unsigned('0' + number / 10, 1);
  writer.Unsigned('0' + number % 10, 1);
  writer.Unsigned(header.sample, 4);
  writer.Unsigned((header.datagram & 0x7FU) | (header.last ? 0x80U : 0U), 1);
  writer.Unsigned(header.items, 1);
  writer.Unsigned(header.time_ms, 4);
  writer.Unsigned(header.character, 1);
  writer.Unsigned(header.body_segments, 1);
  writer.Unsigned(header.props, 1);
  writer.Unsigned(header.finger_segments, 1);
  writer.Unsigned(0, 4);  // reserved, and the payload's size, which Finish writes
  return writer;
}

std::size_t Finish(Writer& writer) noexcept {
  if (writer.full) return 0;
  const std::size_t payload = writer.size - kHeaderSize;
  if (payload > 0xFFFF) return 0;
  writer.bytes[kHeaderSize - 2] = static_cast<std::byte>(payload >> 8U);
  writer.bytes[kHeaderSize - 1] = static_cast<std::byte>(payload & 0xFFU);
  return writer.size;
}

}  // namespace

std::string_view Name(DecodeResult result) noexcept {
  constexpr std::array<std::string_view, 7> kNames{"ok",
                                                   "too short",
                                                   "not an MXTP datagram",
                                                   "longer than its items",
                                                   "too many items",
                                                   "bad text",
                                                   "of another type"};
  return kNames[static_cast<std::size_t>(result)];
}

DecodeResult DecodeHeader(std::span<const std::byte> bytes, Header& out) noexcept {
  if (bytes.size() < kHeaderSize) return DecodeResult::kTooShort;
  const auto digit = [&bytes](std::size_t i) { return std::to_integer<unsigned>(bytes[i]) - '0'; };
  if (std::memcmp(bytes.data(), "MXTP", 4) != 0 || digit(4) > 9 || digit(5) > 9) {
    return DecodeResult::kBadMagic;
  }
  out.type = static_cast<Type>(10 * digit(4) + digit(5));
  Reader reader{bytes.subspan(6)};
  out.sample = reader.Unsigned(4);
  const std::uint32_t datagram = reader.Unsigned(1);
  out.datagram = static_cast<std::uint8_t>(datagram & 0x7FU);
  out.last = (datagram & 0x80U) != 0;
  out.items = static_cast<std::uint8_t>(reader.Unsigned(1));
  out.time_ms = reader.Unsigned(4);
  out.character = static_cast<std::uint8_t>(reader.Unsigned(1));
  out.body_segments = static_cast<std::uint8_t>(reader.Unsigned(1));
  out.props = static_cast<std::uint8_t>(reader.Unsigned(1));
  out.finger_segments = static_cast<std::uint8_t>(reader.Unsigned(1));
  (void)reader.Unsigned(2);
  out.payload_size = static_cast<std::uint16_t>(reader.Unsigned(2));
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
  Reader reader{bytes.subspan(kHeaderSize)};
  out.count = header.items;
  for (std::size_t i = 0; i < header.items; ++i) {
    Segment& segment = out.segments[i];
    segment.id = reader.Unsigned(4);
    segment.position = reader.Floats<3>();
    if (euler) {
      segment.rotation = FromEuler(reader.Floats<3>());
    } else {
      const auto wxyz = reader.Floats<4>();
      segment.rotation = {wxyz[1], wxyz[2], wxyz[3], wxyz[0]};
    }
  }
  return DecodeResult::kOk;
}

DecodeResult DecodeScale(std::span<const std::byte> bytes, Scale& out) noexcept {
  Reader reader;
  const DecodeResult result = Begin(bytes, Type::kScale, reader);
  if (result != DecodeResult::kOk) return result;
  const std::uint32_t count = reader.Unsigned(4);
  if (reader.bad) return DecodeResult::kTooShort;
  if (count > kMaxSegments) return DecodeResult::kTooManyItems;
  out.count = static_cast<int>(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    out.segments[i].name = reader.Text();
    if (reader.bad) return DecodeResult::kBadText;
    out.segments[i].position_m = reader.Floats<3>();
    if (reader.bad) return DecodeResult::kTooShort;
  }
  // The points that follow are markers on the body, which a pose does not need.
  return DecodeResult::kOk;
}

DecodeResult DecodeName(std::span<const std::byte> bytes, std::string_view& name) noexcept {
  Reader reader;
  const DecodeResult result = Begin(bytes, Type::kMeta, reader);
  if (result != DecodeResult::kOk) return result;
  std::string_view lines = reader.Text();
  if (reader.bad) return DecodeResult::kBadText;
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
  constexpr std::size_t kText = 12;  // HH:MM:SS.mmm
  if (reader.bytes.size() == kText + 4)
    (void)reader.Unsigned(4);  // some senders put a length first
  if (reader.bytes.size() != kText) return DecodeResult::kBadText;
  const auto* text = reinterpret_cast<const char*>(reader.bytes.data());
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
    writer.Unsigned(segment.id, 4);
    for (const float value : segment.position) writer.Float(value);
    if (euler) {
      for (const float degrees : ToEuler(segment.rotation)) writer.Float(degrees);
      continue;
    }
    writer.Float(segment.rotation[3]);
    for (std::size_t i = 0; i < 3; ++i) writer.Float(segment.rotation[i]);
  }
  return Finish(writer);
}

std::size_t EncodeScale(Header header, std::span<const Scale::Row> segments,
                        std::span<std::byte> out) noexcept {
  header.type = Type::kScale;
  header.items = 0;
  Writer writer = BeginWriting(header, out);
  writer.Unsigned(static_cast<std::uint32_t>(segments.size()), 4);
  for (const auto& row : segments) {
    writer.Text(row.name);
    for (const float value : row.position_m) writer.Float(value);
  }
  writer.Unsigned(0, 4);  // points
  return Finish(writer);
}

std::size_t EncodeName(Header header, std::string_view name, std::span<std::byte> out) noexcept {
  header.type = Type::kMeta;
  header.items = 1;
  Writer writer = BeginWriting(header, out);
  writer.Unsigned(static_cast<std::uint32_t>(name.size() + 6), 4);
  writer.Raw("name:");
  writer.Raw(name);
  writer.Raw("\n");
  return Finish(writer);
}

std::size_t EncodeTimecode(Header header, const Timecode& timecode,
                           std::span<std::byte> out) noexcept {
  header.type = Type::kTimecode;
  header.items = 1;
  Writer writer = BeginWriting(header, out);
  const auto number = [&writer](std::uint32_t value, std::uint32_t unit) {
    for (; unit > 0; unit /= 10) writer.Unsigned('0' + value / unit % 10, 1);
  };
  number(timecode.hours, 10);
  writer.Raw(":");
  number(timecode.minutes, 10);
  writer.Raw(":");
  number(timecode.seconds, 10);
  writer.Raw(".");
  number(timecode.milliseconds, 100);
  return Finish(writer);
}

}  // namespace styled::mvn

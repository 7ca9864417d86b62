#include "daemon/source/native_decoder.h"

#include <bit>
#include <cstring>

#include "daemon/config/config.h"

static_assert(std::endian::native == std::endian::little, "floats are copied as they lie");

namespace styled::source {
namespace {

// Protobuf's wire types.
enum Wire : std::uint32_t { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };

// A cursor over protobuf's encoding. Every method returns false at the first malformed byte.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}
  bool AtEnd() const noexcept { return bytes_.empty(); }
  const std::byte* at() const noexcept { return bytes_.data(); }

  bool Varint(std::uint64_t& value) noexcept {
    value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      if (bytes_.empty()) return false;
      const auto byte = std::to_integer<std::uint64_t>(bytes_.front());
      bytes_ = bytes_.subspan(1);
      value |= (byte & 0x7FU) << shift;
      if (byte < 0x80U) return true;
    }
    return false;
  }

  bool Tag(std::uint32_t& field, std::uint32_t& wire) noexcept {
    std::uint64_t tag = 0;
    if (!Varint(tag) || tag > 0xFFFFFFFFU) return false;
    field = static_cast<std::uint32_t>(tag >> 3U);
    wire = static_cast<std::uint32_t>(tag & 7U);
    return field != 0;
  }

  bool Bytes(std::span<const std::byte>& value) noexcept {
    std::uint64_t length = 0;
    if (!Varint(length) || length > bytes_.size()) return false;
    value = bytes_.first(static_cast<std::size_t>(length));
    bytes_ = bytes_.subspan(static_cast<std::size_t>(length));
    return true;
  }

  template <typename T>
  bool Fixed(T& value) noexcept {
    if (bytes_.size() < sizeof value) return false;
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
    return true;
  }

  bool Skip(std::uint32_t wire) noexcept {
    std::uint64_t number = 0;
    std::uint32_t word = 0;
    std::span<const std::byte> bytes;
    switch (wire) {
      case kVarint:
        return Varint(number);
      case kFixed64:
        return Fixed(number);
      case kBytes:
        return Bytes(bytes);
      case kFixed32:
        return Fixed(word);
      default:
        return false;  // groups: retired from proto3
    }
  }

 private:
  std::span<const std::byte> bytes_;
};

std::string_view AsText(std::span<const std::byte> bytes) noexcept {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool ReadTimecode(std::span<const std::byte> bytes, Timecode& timecode) noexcept {
  Reader reader(bytes);
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

// As protobuf checks a string; no surrogates, nothing longer than it need be.
bool IsUtf8(std::span<const std::byte> text) noexcept {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = std::to_integer<std::uint32_t>(text[i]);
    const std::size_t more = lead < 0x80 ? 0 : lead < 0xE0 ? 1 : lead < 0xF0 ? 2 : 3;
    if ((lead >= 0x80 && lead < 0xC2) || lead > 0xF4 || text.size() - i <= more) return false;
    std::uint32_t code = more == 0 ? lead : lead & (0x3FU >> more);
    for (std::size_t k = 1; k <= more; ++k) {
      const auto next = std::to_integer<std::uint32_t>(text[i + k]);
      if ((next & 0xC0U) != 0x80U) return false;
      code = code << 6U | (next & 0x3FU);
    }
    if ((more == 2 && (code < 0x800 || (code >= 0xD800 && code < 0xE000))) ||
        (more == 3 && (code < 0x10000 || code > 0x10FFFF))) {
      return false;
    }
    i += more + 1;
  }
  return true;
}

// What goes on to subscribers unread has to be what they can read.
bool IsExpression(std::span<const std::byte> bytes) noexcept {
  Reader reader(bytes);
  while (!reader.AtEnd()) {
    std::uint32_t field = 0, wire = 0;
    std::span<const std::byte> name;
    float value = 0;
    if (!reader.Tag(field, wire)) return false;
    if (field == 1 && wire == kBytes) {
      if (!reader.Bytes(name) || !IsUtf8(name)) return false;
    } else if (field == 2 && wire == kFixed32) {
      if (!reader.Fixed(value)) return false;
    } else if (!reader.Skip(wire)) {
      return false;
    }
  }
  return true;
}

constexpr std::uint32_t kExpressions = 18, kThru = 19;

// Takes a field of the run that begins at `begin`, or goes on there.
void Extend(const std::byte* begin, const std::byte* end, std::span<const std::byte>& run) {
  const bool goes_on = !run.empty() && run.data() + run.size() == begin;
  const std::byte* const from = goes_on ? run.data() : begin;
  run = {from, end};
}

// One field of a SourceFrame; its tag has been read.
bool ReadField(Reader& reader, std::uint32_t field, std::uint32_t wire,
               SourceFrameView& view) noexcept {
  std::span<const std::byte> bytes;
  if (wire == kBytes) {
    if (!reader.Bytes(bytes)) return false;
    switch (field) {
      case 1:
        view.performer = AsText(bytes);
        return true;
      case 3:
        view.has_timecode = true;
        return ReadTimecode(bytes, view.timecode);
      case 4:
        view.root_position = bytes;
        return bytes.size() % sizeof(float) == 0;
      case 5:
        view.rotations = bytes;
        return bytes.size() % sizeof(float) == 0;
      case kExpressions:
        return IsExpression(bytes);
      default:
        return field != 2 && field != 6;
    }
  }
  if (field == 2 && wire == kVarint) return reader.Varint(view.source_time_ns);
  if (field == 6 && wire == kFixed32) return reader.Fixed(view.body_crc);
  return field > 6 && reader.Skip(wire);
}

}  // namespace

FrameResult ReadSourceFrame(std::span<const std::byte> payload, SourceFrameView& view) noexcept {
  view = SourceFrameView();
  Reader reader(payload);
  while (!reader.AtEnd()) {
    std::uint32_t field = 0;
    std::uint32_t wire = 0;
    const std::byte* const begin = reader.at();
    if (!reader.Tag(field, wire) || !ReadField(reader, field, wire, view)) {
      return FrameResult::kMalformed;
    }
    if (wire == kBytes && (field == kExpressions || field == kThru)) {
      Extend(begin, reader.at(), view.face);
    }
  }
  if (view.face.size() > kMaxFace) view.face = {};
  return config::IsName(view.performer) ? FrameResult::kOk : FrameResult::kBadName;
}

std::string_view ReadPerformer(std::span<const std::byte> payload) noexcept {
  Reader reader(payload);
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

bool IsUtf8(std::string_view text) noexcept { return IsUtf8(std::as_bytes(std::span(text))); }

bool CopyPose(const SourceFrameView& view, int joint_count, rig::RigPose& pose) noexcept {
  const auto joints = static_cast<std::size_t>(joint_count);
  static_assert(sizeof(rig::Vec3) == 3 * sizeof(float));
  static_assert(sizeof(rig::Quat) == 4 * sizeof(float));  // coefficients x,y,z,w
  if (view.root_position.size() != sizeof(rig::Vec3)) return false;
  if (view.rotations.size() != joints * sizeof(rig::Quat)) return false;
  std::memcpy(pose.translations.front().data(), view.root_position.data(), sizeof(rig::Vec3));
  std::memcpy(pose.rotations.front().coeffs().data(), view.rotations.data(), view.rotations.size());
  return true;
}

}  // namespace styled::source

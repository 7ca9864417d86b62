#include "daemon/source/props.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "daemon/source/wire.h"
#include "model/base/text.h"

namespace styled::source {
namespace {

constexpr std::uint32_t kProps = 20, kPropName = 1, kPropPosition = 2, kPropRotation = 3;
constexpr std::uint32_t Tag(std::uint32_t field) { return field << 3U | kBytes; }

// As for joints (model/stylist/tuning.h): a coordinate beyond this is an error, whatever its unit;
// a rotation of a smaller squared length has no direction; within this distance of 1 a length
// counts as 1.
constexpr float kLargest = 1e9F, kLeastSquare = 1e-6F, kUnitTolerance = 5e-4F;

constexpr std::size_t kPositionBytes = 3 * sizeof(float), kRotationBytes = 4 * sizeof(float);
static_assert(sizeof(rig::Vec3) == kPositionBytes && sizeof(rig::Quat) == kRotationBytes);

void WriteProp(const Prop& prop, WireWriter& out) noexcept {
  const std::string_view name = prop.name.substr(0, kMaxPropName + 1);
  const std::size_t named = name.empty() ? 0 : 1 + VarintSize(name.size()) + name.size();
  out.Varint(Tag(kProps));
  out.Varint(named + 2 + kPositionBytes + 2 + kRotationBytes);
  if (!name.empty()) {
    out.Varint(Tag(kPropName));
    out.Varint(name.size());
    out.Bytes(std::as_bytes(std::span(name)));
  }
  out.Varint(Tag(kPropPosition));
  out.Varint(kPositionBytes);
  out.Bytes(std::as_bytes(std::span(prop.position.data(), 3)));
  out.Varint(Tag(kPropRotation));
  out.Varint(kRotationBytes);
  out.Bytes(std::as_bytes(std::span(prop.rotation.coeffs().data(), 4)));
}

// Reads one message. Returns false if the bytes are not a message, or lack a number.
bool ReadProp(std::span<const std::byte> bytes, Prop& prop) noexcept {
  WireReader reader(bytes);
  bool has_position = false, has_rotation = false;
  while (!reader.AtEnd()) {
    std::uint32_t field = 0, wire = 0;
    std::span<const std::byte> value;
    if (!reader.Tag(field, wire)) return false;
    if (wire != kBytes || field > kPropRotation) {
      if (!reader.Skip(wire)) return false;
      continue;
    }
    if (!reader.Bytes(value)) return false;
    if (field == kPropName) {
      prop.name = {reinterpret_cast<const char*>(value.data()), value.size()};
    } else if (field == kPropPosition) {
      has_position = value.size() == kPositionBytes;
      if (has_position) std::memcpy(prop.position.data(), value.data(), kPositionBytes);
    } else {
      has_rotation = value.size() == kRotationBytes;
      if (has_rotation) std::memcpy(prop.rotation.coeffs().data(), value.data(), kRotationBytes);
    }
  }
  return has_position && has_rotation;
}

bool IsSound(Prop& prop) noexcept {
  if (prop.name.empty() || prop.name.size() > kMaxPropName || !IsUtf8(prop.name)) return false;
  if (!prop.position.allFinite() || prop.position.cwiseAbs().maxCoeff() >= kLargest) return false;
  const float square = prop.rotation.squaredNorm();
  if (!std::isfinite(square) || square <= kLeastSquare) return false;
  if (std::abs(square - 1) >= kUnitTolerance) prop.rotation.normalize();
  return true;
}

}  // namespace

std::size_t EncodeProps(std::span<const Prop> props, std::span<std::byte> to) noexcept {
  WireWriter out(to);
  std::size_t whole = 0;
  for (const Prop& prop : props) {
    WriteProp(prop, out);
    if (!out.fits()) break;
    whole = out.size();
  }
  return whole;
}

void ReadProps(std::span<const std::byte> bytes, PropList& list) noexcept {
  list.count = list.left_out = 0;
  WireReader reader(bytes);
  while (!reader.AtEnd()) {
    std::uint32_t field = 0, wire = 0;
    std::span<const std::byte> content;
    if (!reader.Tag(field, wire) || field != kProps || wire != kBytes || !reader.Bytes(content)) {
      ++list.left_out;
      return;
    }
    Prop prop;
    const auto known = list.all();
    const bool good = ReadProp(content, prop) && IsSound(prop) &&
                      std::none_of(known.begin(), known.end(),
                                   [&prop](const Prop& other) { return other.name == prop.name; });
    if (good) {
      list.Add(prop);
    } else {
      ++list.left_out;
    }
  }
}

}  // namespace styled::source

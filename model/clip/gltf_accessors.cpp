#include "model/clip/gltf_accessors.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "model/base/text.h"
#include "model/clip/gltf_meshopt.h"
#include "model/clip/gltf_nodes.h"

namespace styled::clip::gltf {
namespace {

using nlohmann::json;

constexpr float kMaxValue = 1e6F;  // of a translation, m
// For packed views: a minute of 55 joints at 60 Hz, packed to a third, has room.
constexpr std::size_t kUnpackedAllowance = std::size_t{3} << 20;
constexpr const char* kNotInside = "expected its data within the file";

Status CheckTimes(const std::vector<float>& times_s) {
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const bool rises = i == 0 ? times_s[0] >= 0 : times_s[i] > times_s[i - 1];
    if (!rises) return Status::Error("found times that do not rise");
  }
  if (!(static_cast<double>(times_s.back()) <= kLatest_s)) {
    return Status::Error("found a key at " + NumberText(times_s.back(), 2) +
                         " s, expected at most " + NumberText(kLatest_s));
  }
  return Status::Ok();
}

std::size_t SizeOf(int component) {
  switch (component) {
    case 5120:  // byte
    case 5121:  // unsigned byte
      return 1;
    case 5122:  // short
    case 5123:  // unsigned short
      return 2;
    case 5126:  // float
      return 4;
    default:
      return 0;
  }
}

template <typename T>
T Load(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

// glTF 2.0, 3.11: f = max(c / 127, -1) and so on.
float ValueAt(const char* at, int component) {
  switch (component) {
    case 5120:
      return std::max(static_cast<float>(Load<std::int8_t>(at)) / 127, -1.0F);
    case 5121:
      return static_cast<float>(Load<std::uint8_t>(at)) / 255;
    case 5122:
      return std::max(static_cast<float>(Load<std::int16_t>(at)) / 32767, -1.0F);
    case 5123:
      return static_cast<float>(Load<std::uint16_t>(at)) / 65535;
    default:
      return Load<float>(at);
  }
}

std::size_t NumberOf(const json& object, const char* key, std::size_t otherwise) {
  const auto value = IndexOf(object, key);
  return value ? static_cast<std::size_t>(*value) : otherwise;
}

}  // namespace

Result<Accessors::Values> Accessors::Read(int index, const std::string& type) {
  Values& kept = kept_[{index, type}];
  if (kept != nullptr) return kept;
  auto values = ReadNew(index, type);
  if (!values.ok()) return values.status();
  if (type == "SCALAR") {
    if (const Status status = CheckTimes(values.value()); !status.ok()) return status;
  }
  kept = std::make_shared<const std::vector<float>>(std::move(values.value()));
  return kept;
}

Result<std::vector<float>> Accessors::ReadNew(int index, const std::string& type) {
  const json& accessor = At("accessors", index);
  const auto refuse = [index](const std::string& what) {
    return Status::Error("accessor " + std::to_string(index) + ": " + what);
  };
  if (!accessor.is_object()) return refuse("there is none");
  if (!Member(accessor, "sparse").is_null()) {
    return refuse("found a sparse one, expected a dense one");
  }
  const json& found = Member(accessor, "type");
  if (!found.is_string() || found.get_ref<const std::string&>() != type) {
    return refuse("expected type " + type);
  }
  const auto component = IndexOf(accessor, "componentType"), count = IndexOf(accessor, "count");
  const std::size_t size = component ? SizeOf(*component) : 0;
  const bool normalized = Member(accessor, "normalized") == true;
  if (size == 0 || (size < 4 && !normalized)) {
    return refuse("expected floats, or normalized integers of 8 or 16 bits");
  }
  if (!count || *count == 0) return refuse("expected a count of 1 or more");
  const std::size_t width = type == "SCALAR" ? 1 : type == "VEC3" ? 3 : 4;
  const auto view = View(accessor, width * size, static_cast<std::size_t>(*count));
  if (!view.ok()) return refuse(view.status().message());
  const std::size_t all = width * static_cast<std::size_t>(*count);
  if (all > left_ / sizeof(float)) {
    return refuse("found more values in its channels than the file can hold");
  }
  left_ -= sizeof(float) * all;
  std::vector<float> values;
  values.reserve(all);
  for (std::size_t row = 0; row < static_cast<std::size_t>(*count); ++row) {
    for (std::size_t i = 0; i < width; ++i) {
      const char* const at = view.value().begin + row * view.value().stride + i * size;
      values.push_back(ValueAt(at, *component));
      if (std::isfinite(values.back()) && std::abs(values.back()) < kMaxValue) continue;
      return refuse("found " + NumberText(values.back()) + ", expected finite numbers below " +
                    NumberText(kMaxValue));
    }
  }
  return values;
}

const json& Accessors::At(const char* list, int index) const {
  static const json kNull;
  const json& entries = Member(file_, list);
  if (!entries.is_array() || static_cast<std::size_t>(index) >= entries.size()) return kNull;
  return entries[static_cast<std::size_t>(index)];
}

// The bytes of a packed buffer view, unpacked once.
Result<std::string_view> Accessors::Unpacked(int number, const json& packed, std::size_t size) {
  if (unpacked_.empty()) left_ += kUnpackedAllowance;
  const auto [kept, fresh] = unpacked_.try_emplace(number);
  if (fresh) {
    auto bytes = UnpackView(packed, data_, size, left_);
    if (!bytes.ok()) return bytes.status();
    left_ -= size;
    kept->second = std::move(bytes.value());
  }
  return std::string_view(kept->second);
}

// The bytes of a buffer view.
Result<std::string_view> Accessors::Bytes(int number, const json& view) {
  const std::size_t size = NumberOf(view, "byteLength", 0);
  const json& packed = Member(Member(view, "extensions"), kMeshopt);
  if (packed.is_object()) return Unpacked(number, packed, size);
  const int buffer = IndexOf(view, "buffer").value_or(0);
  if (buffer != 0 || Member(At("buffers", buffer), "uri").is_string()) {
    return Status::Error(
        "found its data in another file, or in the text; expected it in this "
        "file's binary chunk");
  }
  const std::size_t begin = NumberOf(view, "byteOffset", 0);
  if (begin + size > data_.size()) return Status::Error(kNotInside);
  return data_.substr(begin, size);
}

// The position of an accessor's rows; `size` bytes each.
Result<Accessors::Rows> Accessors::View(const json& accessor, std::size_t size, std::size_t count) {
  const auto number = IndexOf(accessor, "bufferView");
  const json& view = number ? At("bufferViews", *number) : At("bufferViews", 1 << 30);
  if (!view.is_object()) return Status::Error("expected a bufferView");
  const auto bytes = Bytes(*number, view);
  if (!bytes.ok()) return bytes.status();
  const std::size_t begin = NumberOf(accessor, "byteOffset", 0);
  const std::size_t stride = NumberOf(view, "byteStride", size);
  // All below 2^31, so that nothing overflows but the product, which count is checked for.
  const bool inside = stride >= size && begin + size <= bytes.value().size() &&
                      count - 1 <= (bytes.value().size() - begin - size) / stride;
  if (!inside) return Status::Error(kNotInside);
  return Rows{bytes.value().data() + begin, stride};
}

}  // namespace styled::clip::gltf

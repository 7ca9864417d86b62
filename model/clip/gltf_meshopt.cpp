#include "model/clip/gltf_meshopt.h"

#include <meshoptimizer.h>

#include "model/clip/gltf_nodes.h"

namespace styled::clip::gltf {
namespace {

using nlohmann::json;

constexpr std::size_t kMostStride = 256;

// Turns the unpacked rows into those that the accessors describe, in place.
struct Filter {
  const char* name;
  void (*run)(void* rows, std::size_t count, std::size_t stride);
  bool (*accepts)(std::size_t stride);
};
constexpr Filter kFilters[] = {
    {"NONE", nullptr, [](std::size_t) { return true; }},
    {"OCTAHEDRAL", meshopt_decodeFilterOct,
     [](std::size_t stride) { return stride == 4 || stride == 8; }},
    {"QUATERNION", meshopt_decodeFilterQuat, [](std::size_t stride) { return stride == 8; }},
    {"EXPONENTIAL", meshopt_decodeFilterExp, [](std::size_t) { return true; }},
};

// The text of an object's key; `otherwise` if there is none.
std::string TextOf(const json& object, const char* key, const char* otherwise) {
  constexpr std::size_t kMostText = 32;
  const json& text = Member(object, key);
  return text.is_string() ? Shown(text.get_ref<const std::string&>().substr(0, kMostText))
                          : otherwise;
}

}  // namespace

Result<std::string> UnpackView(const json& packed, std::string_view data, std::size_t size,
                               std::size_t most) {
  const auto refuse = [](const std::string& what) {
    return Status::Error(std::string(kMeshopt) + ": " + what);
  };
  const auto number = [&packed](const char* key) {
    return static_cast<std::size_t>(IndexOf(packed, key).value_or(0));
  };
  const std::size_t begin = number("byteOffset"), length = number("byteLength"),
                    stride = number("byteStride"), count = number("count");
  if (const std::string mode = TextOf(packed, "mode", ""); mode != "ATTRIBUTES") {
    return refuse("found mode \"" + mode + "\", expected ATTRIBUTES of an animation's data");
  }
  const std::string name = TextOf(packed, "filter", "NONE");
  const Filter* filter = nullptr;
  for (const Filter& known : kFilters) {
    if (known.name == name) filter = &known;
  }
  if (filter == nullptr) {
    return refuse("found filter \"" + name +
                  "\", expected NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL");
  }
  if (stride == 0 || stride % 4 != 0 || stride > kMostStride || !filter->accepts(stride)) {
    return refuse("found a byteStride of " + std::to_string(stride) +
                  ", expected a multiple of 4 up to " + std::to_string(kMostStride) +
                  " that suits filter " + name);
  }
  // Below 2^31 * 2^8.
  if (count == 0 || count * stride != size) {
    return refuse("found " + std::to_string(count) + " rows of " + std::to_string(stride) +
                  " bytes, expected the view's " + std::to_string(size) + " bytes");
  }
  if (IndexOf(packed, "buffer") != 0 || begin + length > data.size()) {
    return refuse("expected its data within the file's binary chunk");
  }
  if (size > most) {
    return refuse("found " + std::to_string(size) + " bytes packed into " + std::to_string(length) +
                  ", expected an animation's");
  }
  std::string rows(size, '\0');
  const auto* const bytes = reinterpret_cast<const unsigned char*>(data.data() + begin);
  if (meshopt_decodeVertexBuffer(rows.data(), count, stride, bytes, length) != 0) {
    return refuse("found " + std::to_string(length) +
                  " bytes that cannot be unpacked, expected those of " + std::to_string(count) +
                  " rows in version 0 of the format");
  }
  if (filter->run != nullptr) filter->run(rows.data(), count, stride);
  return rows;
}

}  // namespace styled::clip::gltf

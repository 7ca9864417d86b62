#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <iterator>
#include <utility>

#include "model/clip/gltf_meshopt.h"
#include "model/clip/gltf_nodes.h"

namespace styled::clip::gltf {
namespace {

using nlohmann::json;

constexpr const char* kOnlyTwo =
    ", expected glTF 2.0: export it again, or convert it (Blender reads and writes glTF)";
// The number of JSON values that are kept. An avatar of 2000 nodes has 40 000.
constexpr std::size_t kMaxValues = 1 << 20;

// The memory of kept values in bytes: on the heap, including the allocator's overhead.
namespace bytes_of {
constexpr std::size_t kMember = 112;  // a map's node with a short key and its value
constexpr std::size_t kEntry = 32;    // a value in a list that grows
constexpr std::size_t kObject = 64, kList = 48, kString = 48;
// Of each value of a list or an object beyond kFew: a list that grows is in memory twice, and
// json's destructor moves the values into another list that grows.
constexpr std::size_t kFew = 16, kOfMany = 48;
// A node is also an entry of Model, Nodes and the tables in which bones are searched.
constexpr std::size_t kNode = 320;
}  // namespace bytes_of

enum class Of { kAvatar, kMotion };

constexpr std::size_t kMaxDepth = 64;  // far more than any avatar's

// Builds only the used parts of a JSON text, in one pass: meshes, accessors, materials and
// animations are most of a file. The library's own filter, json::parse with a callback, is too
// slow: it searches the whole list again after every object in it.
class Wanted final : public json::json_sax_t {
 public:
  // `most`: bytes of memory; `all`: those of the file, for the message.
  Wanted(json& root, Of of, std::size_t most, std::size_t all)
      : root_(root), with_motion_(of == Of::kMotion), left_(most), all_(all) {}

  // Which limit was exceeded, as an error message; empty if none.
  const std::string& refused() const { return refused_; }

  bool null() override { return Add(nullptr); }
  bool boolean(bool value) override { return Add(value); }
  bool number_integer(number_integer_t value) override { return Add(value); }
  bool number_unsigned(number_unsigned_t value) override { return Add(value); }
  bool number_float(number_float_t value, const string_t&) override { return Add(value); }
  bool string(string_t& value) override {
    value.shrink_to_fit();
    return Spend(bytes_of::kString + value.size()) && Add(std::move(value));
  }
  bool binary(binary_t&) override { return false; }  // never in JSON text
  bool start_object(std::size_t) override {
    const bool node = of_nodes_ && open_.size() == 2;
    return Spend(bytes_of::kObject + (node ? bytes_of::kNode : 0)) && Open(json::value_t::object);
  }
  bool start_array(std::size_t) override {
    return Spend(bytes_of::kList) && Open(json::value_t::array);
  }
  bool end_object() override { return Close(); }
  bool end_array() override { return Close(); }
  bool key(string_t& name) override {
    if (skipped_ > 0) return true;
    skip_next_ = !IsWanted(name);
    if (skip_next_) return true;
    if (!Spend(bytes_of::kMember + name.size() + OfMany(*open_.back()))) return false;
    member_ = &(*open_.back())[std::move(name)];
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override {
    return false;
  }

 private:
  template <std::size_t size>
  static bool IsOneOf(const std::string& name, const std::array<std::string_view, size>& names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  }

  // Whether the value of this key of the innermost open object is used.
  bool IsWanted(const std::string& name) {
    constexpr std::array<std::string_view, 6> kTop{"asset", "buffers", "images",
                                                   "nodes", "skins",   "extensions"};
    constexpr std::array<std::string_view, 9> kOfEntries{"uri",      "name",   "children",
                                                         "joints",   "matrix", "translation",
                                                         "rotation", "scale",  "version"};
    constexpr std::array<std::string_view, 3> kVrm{"VRMC_vrm", "VRM", "VRMC_vrm_animation"};
    constexpr std::array<std::string_view, 4> kTopOfMotion{"accessors", "bufferViews", "animations",
                                                           "extensionsRequired"};
    constexpr std::array<std::string_view, 17> kOfMotion{
        "bufferView", "byteOffset", "componentType", "normalized", "count",    "type",
        "sparse",     "buffer",     "byteLength",    "byteStride", "channels", "samplers",
        "sampler",    "target",     "node",          "path",       "input"};
    constexpr std::array<std::string_view, 2> kOfSamplers{"output", "interpolation"};
    constexpr std::array<std::string_view, 4> kOfViews{"extensions", kMeshopt, "mode", "filter"};
    if (open_.size() == 1) {
      of_extensions_ = name == "extensions";
      of_nodes_ = name == "nodes";
      of_views_ = name == "bufferViews";
      return IsOneOf(name, kTop) || (with_motion_ && IsOneOf(name, kTopOfMotion));
    }
    if (!of_extensions_) {
      return IsOneOf(name, kOfEntries) ||
             (with_motion_ && (IsOneOf(name, kOfMotion) || IsOneOf(name, kOfSamplers) ||
                               (of_views_ && IsOneOf(name, kOfViews))));
    }
    if (open_.size() == 2) return IsOneOf(name, kVrm);
    return open_.size() > 3 || name == "humanoid";
  }

  // The place of a value that begins now; null if the value is skipped, or is one too many.
  json* Place() {
    if (skipped_ > 0) return nullptr;
    if (std::exchange(skip_next_, false)) return nullptr;
    if (++values_ > kMaxValues) {
      refused_ = "found more than " + std::to_string(kMaxValues) +
                 " values in its nodes, skins, buffers, images and humanoid, expected an avatar's";
      return nullptr;
    }
    if (open_.empty()) return &root_;
    if (open_.back()->is_object()) return member_;
    if (!Spend(bytes_of::kEntry + OfMany(*open_.back()))) return nullptr;
    open_.back()->push_back(nullptr);
    return &open_.back()->back();
  }

  // The additional memory of one more value in it.
  static std::size_t OfMany(const json& container) {
    return container.size() < bytes_of::kFew ? 0 : bytes_of::kOfMany;
  }
  // Whether there is room for this many bytes of a stored value.
  bool Spend(std::size_t bytes) {
    if (skipped_ > 0 || skip_next_) return true;
    if (bytes <= left_) {
      left_ -= bytes;
      return true;
    }
    refused_ = (with_motion_ ? "found more nodes and channels than a file of "
                             : "found more nodes, skins, buffers and images than a file of ") +
               std::to_string(all_) +
               (with_motion_ ? " bytes has with a motion, expected a humanoid's"
                             : " bytes has, expected an avatar's");
    return false;
  }

  template <typename T>
  bool Add(T&& value) {
    if (json* const place = Place()) *place = std::forward<T>(value);
    return refused_.empty();
  }
  bool Open(json::value_t kind) {
    if (open_.size() + skipped_ >= kMaxDepth) return false;
    json* const place = Place();
    if (place == nullptr) {
      ++skipped_;
      return refused_.empty();
    }
    *place = kind;
    open_.push_back(place);
    return true;
  }
  bool Close() {
    if (skipped_ > 0) {
      --skipped_;
    } else {
      open_.pop_back();
    }
    return true;
  }

  json& root_;
  bool with_motion_;
  std::vector<json*> open_;     // the kept values that are still open, outermost first
  json* member_ = nullptr;      // the value of the last key
  std::size_t skipped_ = 0;     // depth within a value that is skipped
  bool skip_next_ = false;      // skip the last key's value
  bool of_extensions_ = false;  // the last key of the root was "extensions"
  bool of_nodes_ = false;       // or "nodes"
  bool of_views_ = false;       // or "bufferViews"
  std::size_t left_, all_;
  std::size_t values_ = 0;  // the number of kept values
  std::string refused_;
};

// Counts the keys of each object, and the values around each value.
class Shape final : public json::json_sax_t {
 public:
  // The reason of a refusal; empty if there is none.
  const std::string& refused() const { return refused_; }

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return false; }  // never in JSON text
  bool start_object(std::size_t) override { return Open(); }
  bool start_array(std::size_t) override { return Open(); }
  bool end_object() override { return Close(); }
  bool end_array() override { return Close(); }
  bool key(string_t&) override {
    if (++keys_.back() <= kMaxKeys) return true;
    refused_ = "found a JSON object of more than " + std::to_string(kMaxKeys) + " keys";
    return false;
  }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override {
    return false;
  }

 private:
  static constexpr std::size_t kMaxKeys = 1024;

  bool Open() {
    keys_.push_back(0);
    if (keys_.size() <= kMaxDepth) return true;
    refused_ = "found JSON that is nested more than " + std::to_string(kMaxDepth) + " deep";
    return false;
  }
  bool Close() {
    keys_.pop_back();
    return true;
  }

  std::vector<std::size_t> keys_;  // per open object or list
  std::string refused_;
};

Status CheckVersion(const json& file) {
  const json& version = Member(Member(file, "asset"), "version");
  if (!version.is_string()) {
    return Broken("it has no asset.version");
  }
  const auto& text = version.get_ref<const std::string&>();
  if (text.starts_with("2.")) return Status::Ok();
  return WrongVersion(Shown(text.substr(0, 16)));
}

// Bytes of memory that the kept values may take per byte of the file, in addition to an allowance.
constexpr std::size_t kMemoryPerByte = 6;

// Whether a number has so many digits that the parser's copies of it would be most of the memory.
bool HasLongNumber(std::string_view text) {
  constexpr std::ptrdiff_t kMost = 4096;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  // The runs of digits that a step of this length cannot miss.
  for (std::size_t at = kMost; at < text.size(); at += kMost) {
    if (!digit(text[at])) continue;
    const auto* const here = text.data() + at;
    const auto* const end = std::find_if_not(here, text.data() + text.size(), digit);
    const auto begin = std::find_if_not(std::make_reverse_iterator(here),
                                        std::make_reverse_iterator(text.data()), digit);
    if (end - begin.base() > kMost) return true;
  }
  return false;
}

Result<json> Parse(std::string_view text, Of of, std::size_t bytes, std::size_t allowance) {
  json file;
  Wanted wanted(file, of, kMemoryPerByte * bytes + allowance, bytes);
  if (HasLongNumber(text)) return Broken("found a number of more than 4096 digits");
  const char* const begin = text.data();
  if (!json::sax_parse(begin, begin + text.size(), &wanted) || !file.is_object()) {
    return wanted.refused().empty() ? Broken("found JSON that cannot be read")
                                    : Status::Error(wanted.refused());
  }
  const Status status = CheckVersion(file);
  return status.ok() ? Result<json>(std::move(file)) : Result<json>(status);
}

}  // namespace

// Text from a file, made printable for an error message.
std::string Shown(std::string_view text) {
  std::string shown(text);
  std::replace_if(
      shown.begin(), shown.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
  return shown;
}

Status Broken(const std::string& found) {
  return Status::Error("is not glTF 2.0: " + found + ", expected an avatar's .vrm, .glb or .gltf");
}

Status WrongVersion(const std::string& version) {
  return Status::Error("is glTF " + version + kOnlyTwo);
}

std::uint32_t Word(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  static_assert(std::endian::native == std::endian::little);
  return value;
}

Result<Chunks> SplitGlb(std::string_view bytes) {
  if (bytes.size() < kHeader + kChunk) return Status::Error("it ends early");
  if (const auto version = Word(bytes, 4); version != 2) {
    return WrongVersion(std::to_string(version) + " in binary form");
  }
  if (Word(bytes, kHeader + 4) != kJsonChunk) return Status::Error("its first chunk is not JSON");
  const std::size_t text = Word(bytes, kHeader), begin = kHeader + kChunk;
  if (text > bytes.size() - begin) return Status::Error("it ends early");
  if (text > kMaxJson) return Status::Error(kTooMuchJson);
  Chunks chunks{bytes.substr(begin, text), {}};
  const std::string_view rest = bytes.substr(begin + text);
  if (rest.size() < kChunk || Word(rest, 4) != kBinaryChunk) return chunks;
  const std::size_t size = Word(rest, 0);
  if (size > rest.size() - kChunk) return Status::Error("it ends early");
  chunks.data = rest.substr(kChunk, size);
  return chunks;
}

Status CheckShape(std::string_view text) {
  Shape shape;
  (void)json::sax_parse(text.data(), text.data() + text.size(), &shape);
  return shape.refused().empty() ? Status::Ok() : Status::Error(shape.refused());
}

Result<json> ParseJson(std::string_view text, std::size_t bytes) {
  return Parse(text, Of::kAvatar, bytes, std::size_t{2} << 20);
}

Result<json> ParseMotionJson(std::string_view text, std::size_t bytes) {
  return Parse(text, Of::kMotion, bytes, std::size_t{4} << 20);
}

}  // namespace styled::clip::gltf

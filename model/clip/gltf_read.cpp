#include "model/clip/gltf_read.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/clip/read_file.h"

namespace styled::clip {
namespace {

using body::kHumanoid;
using body::kJointCount;
using rig::Quat;
using rig::Vec3;
using JointMap = std::array<int, kJointCount>;
using nlohmann::json;

constexpr const char* kExpected = ", expected an avatar's .vrm, .glb or .gltf";
constexpr const char* kOnlyTwo =
    ", expected glTF 2.0: export it anew, or convert it (Blender reads and writes glTF)";
constexpr float kEven = 0.01F;  // scales whose axes differ by less count as uniform

// Text from a file, made printable for an error message.
std::string Shown(std::string_view text) {
  std::string shown(text);
  std::replace_if(
      shown.begin(), shown.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
  return shown;
}

// Describes a file that does not begin like glTF; empty if it does.
std::string NotGltf(std::string_view read) {
  if (read.empty()) return "found an empty file";
  std::string_view text = read;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  if (text.starts_with('{')) return "";
  return "found a file that begins with \"" + Shown(read.substr(0, 16)) + "\"";
}

// The daemon reads avatars on the thread that feeds its watchdog (5 s), so a file may take one
// second at most. The JSON may contain images as text: that of a large avatar has 20 MB, and
// reading 64 MiB takes about a second.
constexpr std::size_t kMaxJson = std::size_t{64} << 20;
constexpr const char* kTooMuchJson = "found more than 64 MiB of JSON, expected less";
// The number of JSON values that are kept. An avatar of 2000 nodes has 40 000.
constexpr std::size_t kMaxValues = 1 << 20;
constexpr std::size_t kMaxNodes = 1 << 16;
// The number of buffers, and of images; an avatar has up to a hundred. Each costs a look at every
// folder on its path.
constexpr std::size_t kMaxUris = 4096;
constexpr std::ptrdiff_t kMaxParts = 16;   // folders on such a path
constexpr std::size_t kMaxUriSize = 1024;  // bytes of such a path

// The parts of a file that are used. A list is empty if the file has none, or if it is not a list
// of numbers.
struct Node {
  std::string name;
  std::vector<int> children;
  std::vector<double> translation, rotation, scale, matrix;
};
struct Model {
  std::vector<Node> nodes;
  std::vector<std::vector<int>> skins;  // their joints
  json vrm;                             // the humanoid of the VRM 1.0 or 0.x extension
};

struct Transform {
  Vec3 translation = Vec3::Zero();
  Quat rotation = Quat::Identity();
  float scale = 1;

  Transform operator*(const Transform& below) const {
    return {translation + scale * (rotation * below.translation),
            (rotation * below.rotation).normalized(), scale * below.scale};
  }
};

// The nodes of a file as a forest, with their transforms.
class Nodes {
 public:
  static Result<Nodes> Make(const Model& model) {
    Nodes nodes;
    const auto count = static_cast<int>(model.nodes.size());
    nodes.parents_.assign(model.nodes.size(), -1);
    for (int node = 0; node < count; ++node) {
      for (const int child : model.nodes[static_cast<std::size_t>(node)].children) {
        if (child < 0 || child >= count) return Refuse(node, "has a child that does not exist");
        int& parent = nodes.parents_[static_cast<std::size_t>(child)];
        if (parent >= 0) return Refuse(child, "hangs from two nodes");
        parent = node;
      }
    }
    if (const int node = nodes.PutInOrder(model); node >= 0) {
      return Refuse(node, "is its own ancestor");
    }
    for (int node = 0; node < count; ++node) {
      auto local = Local(model.nodes[static_cast<std::size_t>(node)]);
      if (!local.ok()) return Refuse(node, local.status().message());
      nodes.locals_.push_back(local.value());
    }
    return nodes;
  }

  int parent(int node) const { return parents_[static_cast<std::size_t>(node)]; }
  const Transform& local(int node) const { return locals_[static_cast<std::size_t>(node)]; }
  Transform World(int node) const {
    Transform world;
    for (; node >= 0; node = parent(node)) world = local(node) * world;
    return world;
  }
  // Per node: whether it is `above` or a descendant of it.
  std::vector<bool> Below(int above) const {
    std::vector<bool> below(parents_.size(), false);
    for (const int node : order_) {
      below[static_cast<std::size_t>(node)] =
          node == above || (parent(node) >= 0 && below[static_cast<std::size_t>(parent(node))]);
    }
    return below;
  }

 private:
  // Orders nodes with parents before children. Returns the first node that no root reaches (it is
  // on a cycle), -1 if there is none.
  int PutInOrder(const Model& model) {
    std::vector<bool> placed(parents_.size(), false);
    for (std::size_t node = 0; node < parents_.size(); ++node) {
      if (parents_[node] < 0) order_.push_back(static_cast<int>(node));
    }
    for (std::size_t next = 0; next < order_.size(); ++next) {
      const auto node = static_cast<std::size_t>(order_[next]);
      placed[node] = true;
      const auto& children = model.nodes[node].children;
      order_.insert(order_.end(), children.begin(), children.end());
    }
    const auto lost = std::find(placed.begin(), placed.end(), false);
    return lost == placed.end() ? -1 : static_cast<int>(lost - placed.begin());
  }
  static Status Refuse(int node, const std::string& what) {
    return Status::Error("node " + std::to_string(node) + " " + what +
                         ", expected a tree of bones");
  }
  static Result<Transform> Local(const Node& node) {
    Eigen::Affine3d affine = Eigen::Affine3d::Identity();
    const auto has = [](const std::vector<double>& values, std::size_t size) {
      return values.size() == size;
    };
    if (has(node.matrix, 16)) {
      affine.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
    } else {
      if (has(node.translation, 3)) {
        affine.translate(Eigen::Map<const Eigen::Vector3d>(node.translation.data()));
      }
      if (has(node.rotation, 4)) {
        affine.rotate(Eigen::Map<const Eigen::Quaterniond>(node.rotation.data()).normalized());
      }
      if (has(node.scale, 3)) {
        affine.scale(Eigen::Map<const Eigen::Vector3d>(node.scale.data()));
      }
    }
    // Only rotation and uniform scale can be bound: the columns must be equally long and not
    // mirrored.
    const Eigen::Matrix3d linear = affine.linear();
    const Eigen::Vector3d lengths = linear.colwise().norm();
    const double size = lengths.mean();
    if (!affine.matrix().allFinite() || !(size > 1e-9) || !(linear.determinant() > 0)) {
      return Status::Error("has a transform that is no turn and scale");
    }
    if ((lengths.array() - size).abs().maxCoeff() > kEven * size) {
      return Status::Error("is stretched unevenly");
    }
    Transform local;
    local.translation = affine.translation().cast<float>();
    local.rotation = Quat(Eigen::Matrix3f((linear / size).cast<float>())).normalized();
    local.scale = static_cast<float>(size);
    return local;
  }

  std::vector<int> parents_;
  std::vector<int> order_;
  std::vector<Transform> locals_;
};

// The value of an object's key; null if there is none.
const json& Member(const json& object, const char* key) {
  static const json kNull;
  if (!object.is_object()) return kNull;
  const auto found = object.find(key);
  return found == object.end() ? kNull : *found;
}

std::optional<int> ToIndex(const json& value) {
  if (!value.is_number_integer()) return std::nullopt;
  const auto number = value.get<std::int64_t>();
  if (number < 0 || number > std::numeric_limits<int>::max()) return std::nullopt;
  return static_cast<int>(number);
}

std::optional<int> IndexOf(const json& object, const char* key) {
  return ToIndex(Member(object, key));
}

// The indices in a list; other values are skipped.
std::vector<int> Indices(const json& list) {
  std::vector<int> indices;
  if (!list.is_array()) return indices;
  for (const json& entry : list) {
    if (const auto index = ToIndex(entry)) indices.push_back(*index);
  }
  return indices;
}

std::vector<double> Numbers(const json& list) {
  std::vector<double> numbers;
  if (!list.is_array() || list.size() > 16) return numbers;
  for (const json& entry : list) {
    if (!entry.is_number()) return {};
    numbers.push_back(entry.get<double>());
  }
  return numbers;
}

struct Humanoid {
  bool found = false;
  std::set<int> bones;  // all of VRM's bones, fingers included
  JointMap joint;       // node per canonical joint
};

// Reads VRM's table of bones: an object of objects in 1.0, a list in 0.x, with the same bone names.
Humanoid ReadVrm(const Model& model) {
  Humanoid humanoid;
  humanoid.joint.fill(-1);
  const auto add = [&](const std::string& bone, const json& value) {
    const auto node = IndexOf(value, "node");
    if (!node || *node >= static_cast<int>(model.nodes.size())) return;
    humanoid.found = true;
    humanoid.bones.insert(*node);
    for (std::size_t c = 0; c < kHumanoid.size(); ++c) {
      if (kHumanoid[c].name == bone) humanoid.joint[c] = *node;
    }
  };
  const json bones = Member(model.vrm, "humanBones");
  for (const auto& [key, entry] : bones.items()) {
    const json bone = Member(entry, "bone");
    if (bones.is_object()) add(key, entry);
    if (bones.is_array() && bone.is_string()) add(bone.get<std::string>(), entry);
  }
  return humanoid;
}

std::string NameOf(const Model& model, int node) {
  const std::string& name = model.nodes[static_cast<std::size_t>(node)].name;
  return name.empty() ? "node_" + std::to_string(node) : name;
}

// Maps the skins' joints by their names; every node if the file has no skin.
Result<Humanoid> ReadNames(const Model& model, const rig::JointNames& given) {
  Humanoid humanoid;
  for (const auto& skin : model.skins) {
    for (const int joint : skin) {
      if (joint < static_cast<int>(model.nodes.size())) humanoid.bones.insert(joint);
    }
  }
  if (humanoid.bones.empty()) {
    for (std::size_t node = 0; node < model.nodes.size(); ++node) {
      humanoid.bones.insert(static_cast<int>(node));
    }
  }
  const std::vector<int> nodes(humanoid.bones.begin(), humanoid.bones.end());
  rig::Skeleton named;
  for (const int node : nodes) named.names.push_back(NameOf(model, node));
  const auto map = rig::MapJoints(named, given);
  if (!map.ok()) return map.status();
  humanoid.joint = map.value();
  for (int& joint : humanoid.joint) {
    if (joint >= 0) joint = nodes[static_cast<std::size_t>(joint)];
  }
  humanoid.found = humanoid.joint[body::kHips] >= 0;
  return humanoid;
}

// The bones below the hips with all nodes between them, parents first, children in file order.
std::vector<int> Gather(const Model& model, const Nodes& nodes, int hips,
                        const std::set<int>& bones) {
  const std::vector<bool> below = nodes.Below(hips);
  std::set<int> wanted;
  for (const int bone : bones) {
    if (!below[static_cast<std::size_t>(bone)]) continue;
    // Add the node and its ancestors up to the hips, or to one that was added before.
    int node = bone;
    while (node != hips && wanted.insert(node).second) node = nodes.parent(node);
  }
  std::vector<int> order;
  std::vector<int> open{hips};
  while (!open.empty()) {
    const int node = open.back();
    open.pop_back();
    order.push_back(node);
    const auto& children = model.nodes[static_cast<std::size_t>(node)].children;
    for (auto child = children.rbegin(); child != children.rend(); ++child) {
      if (wanted.contains(*child)) open.push_back(*child);
    }
  }
  return order;
}

GltfSkeleton Build(const Model& model, const Nodes& nodes, const Humanoid& humanoid,
                   const std::vector<int>& order) {
  GltfSkeleton built;
  const int hips = order.front();
  const Transform above = nodes.parent(hips) < 0 ? Transform() : nodes.World(nodes.parent(hips));
  built.above_translation_m = above.translation;
  built.above_rotation = above.rotation;
  built.above_scale = above.scale;

  std::vector<int> index(model.nodes.size(), -1);
  std::vector<Transform> worlds;
  std::set<std::string> names;
  for (const int node : order) {
    const auto joint = static_cast<int>(worlds.size());
    index[static_cast<std::size_t>(node)] = joint;
    const int parent = joint == 0 ? -1 : index[static_cast<std::size_t>(nodes.parent(node))];
    const Transform over = joint == 0 ? above : worlds[static_cast<std::size_t>(parent)];
    worlds.push_back(over * nodes.local(node));
    std::string name = NameOf(model, node);
    if (!names.insert(name).second) {
      name.append("_").append(std::to_string(node));
      names.insert(name);
    }
    built.skeleton.names.push_back(std::move(name));
    built.skeleton.parents.push_back(parent);
    built.skeleton.offsets.emplace_back(
        joint == 0 ? worlds.back().translation : Vec3(over.scale * nodes.local(node).translation));
  }
  built.stance = rig::RigPose(built.skeleton);
  for (std::size_t joint = 0; joint < order.size(); ++joint) {
    built.stance.rotations[joint] =
        joint == 0 ? worlds[0].rotation : nodes.local(order[joint]).rotation;
  }
  for (std::size_t c = 0; c < kJointCount; ++c) {
    const int node = humanoid.joint[c];
    built.source_joint[c] = node < 0 ? -1 : index[static_cast<std::size_t>(node)];
  }
  return built;
}

Result<GltfSkeleton> Read(const Model& model, const rig::JointNames& given) {
  auto nodes = Nodes::Make(model);
  if (!nodes.ok()) return nodes.status();
  Humanoid humanoid = ReadVrm(model);
  const bool vrm = humanoid.found && given.empty();
  if (!vrm) {
    auto named = ReadNames(model, given);
    if (!named.ok()) return named.status();
    humanoid = named.value();
  }
  const int hips = humanoid.joint[body::kHips];
  if (hips < 0) {
    return Status::Error(vrm ? "found a VRM humanoid without hips"
                             : "found no bone named like hips, expected a humanoid");
  }
  auto order = Gather(model, nodes.value(), hips, humanoid.bones);
  // Too many bones: drop fingers and the like, keep the mapped ones.
  if (order.size() > rig::kMaxSourceJoints) {
    std::set<int> mapped(humanoid.joint.begin(), humanoid.joint.end());
    mapped.erase(-1);
    order = Gather(model, nodes.value(), hips, mapped);
  }
  if (order.size() > rig::kMaxSourceJoints) {
    return Status::Error("found " + std::to_string(order.size()) + " bones, expected at most " +
                         std::to_string(rig::kMaxSourceJoints));
  }
  GltfSkeleton built = Build(model, nodes.value(), humanoid, order);
  built.t_pose = vrm;
  return built;
}

// Decodes URI escapes: "../a%2Fb" becomes "../a/b". A "%" that begins no escape is kept.
std::string Unescaped(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned value = 0;
    const char* const digits = uri.data() + i + 1;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2) {
      text += static_cast<char>(value);
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

// Why the uri of a buffer or image of an avatar in `home` is refused; empty if it is accepted. The
// file is not opened here; the check protects the next program that opens it (a viewer, an
// exporter) and trusts an avatar that was accepted. A "data:" uri is no file.
std::string LeadsOut(const std::string& uri, const std::filesystem::path& home) {
  if (uri.starts_with("data:")) return "";
  if (uri.size() > kMaxUriSize) {
    return "has more than " + std::to_string(kMaxUriSize) + " characters";
  }
  std::string text = Unescaped(uri);
  std::replace(text.begin(), text.end(), '\\', '/');
  const std::filesystem::path path(text);
  if (text.find('\0') != std::string::npos || text.find(':') < text.find('/')) {
    return "is no file beside the avatar";
  }
  if (path.is_absolute()) return "is an absolute path";
  for (const auto& part : path) {
    if (part == "..") return "leads out of the avatar's folder";
  }
  if (std::distance(path.begin(), path.end()) > kMaxParts) {
    return "lies more than " + std::to_string(kMaxParts) + " folders deep";
  }
  std::error_code error;
  const auto real = std::filesystem::weakly_canonical(home / path, error);
  if (error) return "cannot be followed";
  const auto [end, unused] = std::mismatch(home.begin(), home.end(), real.begin(), real.end());
  if (end != home.end()) return "is a link that leads out of the avatar's folder";
  const auto kind = std::filesystem::status(real, error).type();
  if (kind != std::filesystem::file_type::regular &&
      kind != std::filesystem::file_type::not_found) {
    return "is no ordinary file";
  }
  return "";
}

Status CheckUris(const json& file, const std::filesystem::path& folder) {
  std::error_code error;
  const auto home = std::filesystem::weakly_canonical(folder, error);
  if (error) return Status::Error("the avatar's folder cannot be followed: " + error.message());
  for (const char* const list : {"buffers", "images"}) {
    const json& entries = Member(file, list);
    if (!entries.is_array()) continue;
    if (entries.size() > kMaxUris) {
      return Status::Error("found " + std::to_string(entries.size()) + " " + list +
                           ", expected at most " + std::to_string(kMaxUris));
    }
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const json& uri = Member(entries[i], "uri");
      if (!uri.is_string()) continue;
      const auto& text = uri.get_ref<const std::string&>();
      const std::string wrong = LeadsOut(text, home);
      if (wrong.empty()) continue;
      return Status::Error(std::string(list) + "[" + std::to_string(i) + "].uri \"" +
                           Shown(text.substr(0, 64)) + "\" " + wrong +
                           ", expected a file in the avatar's own folder");
    }
  }
  return Status::Ok();
}

Result<Model> ReadModel(const json& file) {
  Model model;
  const json& nodes = Member(file, "nodes");
  if (nodes.is_array() && nodes.size() > kMaxNodes) {
    return Status::Error("found " + std::to_string(nodes.size()) + " nodes, expected at most " +
                         std::to_string(kMaxNodes));
  }
  for (std::size_t i = 0; nodes.is_array() && i < nodes.size(); ++i) {
    const json& name = Member(nodes[i], "name");
    model.nodes.push_back(
        {name.is_string() ? name.get<std::string>() : "", Indices(Member(nodes[i], "children")),
         Numbers(Member(nodes[i], "translation")), Numbers(Member(nodes[i], "rotation")),
         Numbers(Member(nodes[i], "scale")), Numbers(Member(nodes[i], "matrix"))});
  }
  const json& skins = Member(file, "skins");
  for (std::size_t i = 0; skins.is_array() && i < skins.size(); ++i) {
    model.skins.push_back(Indices(Member(skins[i], "joints")));
  }
  const json& extensions = Member(file, "extensions");
  const json& one = Member(Member(extensions, "VRMC_vrm"), "humanoid");
  const json& zero = Member(Member(extensions, "VRM"), "humanoid");
  if (Member(one, "humanBones").is_object()) {
    model.vrm = one;
  } else if (Member(zero, "humanBones").is_array()) {
    model.vrm = zero;
  }
  return model;
}

std::uint32_t Word(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  static_assert(std::endian::native == std::endian::little);
  return value;
}

Status Broken(const std::string& found) {
  return Status::Error("is no glTF 2.0: " + found + kExpected);
}

// The JSON text of a .gltf file, or of a .glb or .vrm (glTF 2.0, 4.4: a header, then chunks), of
// which nothing else is read.
Result<std::string> ReadJsonText(const InputFile& file) {
  constexpr std::size_t kHeader = 12, kChunk = 8;
  constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
  const auto start = file.Read(0, 64);
  if (!start.ok()) return start.status();
  const std::string& head = start.value();
  if (!head.starts_with("glTF")) {
    if (const std::string found = NotGltf(head); !found.empty()) {
      return Broken(found);
    }
    if (file.size() > kMaxJson) return Status::Error(kTooMuchJson);
    return file.Read(0, kMaxJson);
  }
  if (head.size() < kHeader) return Broken("it ends early");
  if (const std::uint32_t version = Word(head, 4); version != 2) {
    return Status::Error("is glTF " + std::to_string(version) + " in binary form" + kOnlyTwo);
  }
  if (head.size() < kHeader + kChunk || Word(head, kHeader + 4) != kJsonChunk) {
    return Broken("its first chunk is no JSON");
  }
  const std::size_t length = Word(head, kHeader);
  if (length > kMaxJson) return Status::Error(kTooMuchJson);
  auto text = file.Read(kHeader + kChunk, length);
  if (text.ok() && text.value().size() < length) {
    return Broken("it ends early");
  }
  return text;
}

// Builds only the used parts of a JSON text, in one pass: meshes, accessors, materials and
// animations are most of a file. The library's own filter, json::parse with a callback, is too
// slow: it searches the whole list again after every object in it.
class Wanted final : public json::json_sax_t {
 public:
  explicit Wanted(json& root) : root_(root) {}

  // Which limit was exceeded, as an error message; empty if none.
  const std::string& refused() const { return refused_; }

  bool null() override { return Add(nullptr); }
  bool boolean(bool value) override { return Add(value); }
  bool number_integer(number_integer_t value) override { return Add(value); }
  bool number_unsigned(number_unsigned_t value) override { return Add(value); }
  bool number_float(number_float_t value, const string_t&) override { return Add(value); }
  bool string(string_t& value) override { return Add(std::move(value)); }
  bool binary(binary_t&) override { return false; }  // never in JSON text
  bool start_object(std::size_t) override { return Open(json::value_t::object); }
  bool start_array(std::size_t) override { return Open(json::value_t::array); }
  bool end_object() override { return Close(); }
  bool end_array() override { return Close(); }
  bool key(string_t& name) override {
    if (skipped_ > 0) return true;
    skip_next_ = !IsWanted(name);
    if (!skip_next_) member_ = &(*open_.back())[std::move(name)];
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override {
    return false;
  }

 private:
  static constexpr std::size_t kMaxDepth = 64;  // far more than any avatar's

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
    constexpr std::array<std::string_view, 2> kVrm{"VRMC_vrm", "VRM"};
    if (open_.size() == 1) {
      of_extensions_ = name == "extensions";
      return IsOneOf(name, kTop);
    }
    if (!of_extensions_) return IsOneOf(name, kOfEntries);
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
    open_.back()->push_back(nullptr);
    return &open_.back()->back();
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
  std::vector<json*> open_;     // the kept values that are still open, outermost first
  json* member_ = nullptr;      // the value of the last key
  std::size_t skipped_ = 0;     // depth within a value that is skipped
  bool skip_next_ = false;      // skip the last key's value
  bool of_extensions_ = false;  // the last key of the root was "extensions"
  std::size_t values_ = 0;      // the number of kept values
  std::string refused_;
};

// The used parts of the JSON. Refuses text that is not JSON, is nested too deep, or has too many
// values.
Result<json> ParseWanted(const std::string& text) {
  json file;
  Wanted wanted(file);
  if (json::sax_parse(text, &wanted) && file.is_object()) return file;
  if (!wanted.refused().empty()) return Status::Error(wanted.refused());
  return Broken("found JSON that cannot be read");
}

Status CheckVersion(const json& file) {
  const json& version = Member(Member(file, "asset"), "version");
  if (!version.is_string()) {
    return Broken("it says no asset.version");
  }
  const auto& text = version.get_ref<const std::string&>();
  if (text.starts_with("2.")) return Status::Ok();
  return Status::Error("is glTF " + Shown(text.substr(0, 16)) + kOnlyTwo);
}

Result<GltfSkeleton> ReadFile(const std::filesystem::path& file, const rig::JointNames& given) {
  const auto opened = InputFile::Open(file, kExpected);
  if (!opened.ok()) return opened.status();
  const auto refuse = [&file](const Status& status) {
    const std::string& text = status.message();
    const std::string name = file.string() + ": ";
    return text.starts_with(name) ? status : Status::Error(name + text);
  };
  const auto text = ReadJsonText(opened.value());
  if (!text.ok()) return refuse(text.status());
  const auto read = ParseWanted(text.value());
  if (!read.ok()) return refuse(read.status());
  const json& parsed = read.value();
  if (const Status status = CheckVersion(parsed); !status.ok()) return refuse(status);
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  if (const Status status = CheckUris(parsed, folder); !status.ok()) return refuse(status);
  const auto model = ReadModel(parsed);
  if (!model.ok()) return refuse(model.status());
  auto skeleton = Read(model.value(), given);
  if (!skeleton.ok()) return refuse(skeleton.status());
  return skeleton;
}

}  // namespace

Result<GltfSkeleton> ReadGltfSkeleton(const std::filesystem::path& file,
                                      const rig::JointNames& given) {
  return ReadFile(file, given);
}

}  // namespace styled::clip

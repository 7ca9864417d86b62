#include "model/clip/gltf_read.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>
#include <string>
#include <vector>

namespace styled::clip {
namespace {

using body::kHumanoid;
using body::kJointCount;
using rig::Quat;
using rig::Vec3;
using JointMap = std::array<int, kJointCount>;

constexpr const char* kExpected = ", expected an avatar's .vrm, .glb or .gltf";
constexpr float kEven = 0.01F;  // scales that differ by less along the axes are one

struct Transform {
  Vec3 translation = Vec3::Zero();
  Quat rotation = Quat::Identity();
  float scale = 1;

  Transform operator*(const Transform& below) const {
    return {translation + scale * (rotation * below.translation),
            (rotation * below.rotation).normalized(), scale * below.scale};
  }
};

// The nodes of a file as a forest.
class Nodes {
 public:
  static Result<Nodes> Make(const tinygltf::Model& model) {
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
    for (int node = 0; node < count; ++node) {
      int steps = 0;
      for (int up = node; up >= 0; up = nodes.parent(up)) {
        if (++steps > count) return Refuse(node, "is its own ancestor");
      }
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
  bool IsBelow(int node, int above) const {
    while (node >= 0 && node != above) node = parent(node);
    return node == above;
  }

 private:
  static Status Refuse(int node, const std::string& what) {
    return Status::Error("node " + std::to_string(node) + " " + what +
                         ", expected a tree of bones");
  }
  static Result<Transform> Local(const tinygltf::Node& node) {
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
  std::vector<Transform> locals_;
};

struct Humanoid {
  bool found = false;
  std::set<int> bones;  // all of VRM's, fingers too
  JointMap joint;       // nodes
};

// VRM's table of bones: an object of objects in 1.0, a list in 0.x. Bones have the same names.
Humanoid ReadVrm(const tinygltf::Model& model) {
  Humanoid humanoid;
  humanoid.joint.fill(-1);
  const auto add = [&](const std::string& bone, const tinygltf::Value& value) {
    if (!value.IsObject() || !value.Has("node") || !value.Get("node").IsNumber()) return;
    const int node = value.Get("node").GetNumberAsInt();
    if (node < 0 || node >= static_cast<int>(model.nodes.size())) return;
    humanoid.found = true;
    humanoid.bones.insert(node);
    for (std::size_t c = 0; c < kHumanoid.size(); ++c) {
      if (kHumanoid[c].name == bone) humanoid.joint[c] = node;
    }
  };
  const auto bones_of = [&model](const char* extension) -> tinygltf::Value {
    const auto found = model.extensions.find(extension);
    if (found == model.extensions.end() || !found->second.IsObject()) return {};
    const tinygltf::Value& body = found->second.Get("humanoid");
    return body.IsObject() ? body.Get("humanBones") : tinygltf::Value();
  };
  if (const auto bones = bones_of("VRMC_vrm"); bones.IsObject()) {
    for (const std::string& bone : bones.Keys()) add(bone, bones.Get(bone));
  } else if (const auto list = bones_of("VRM"); list.IsArray()) {
    for (std::size_t i = 0; i < list.ArrayLen(); ++i) {
      const tinygltf::Value& entry = list.Get(static_cast<int>(i));
      if (entry.IsObject() && entry.Get("bone").IsString()) {
        add(entry.Get("bone").Get<std::string>(), entry);
      }
    }
  }
  return humanoid;
}

std::string NameOf(const tinygltf::Model& model, int node) {
  const std::string& name = model.nodes[static_cast<std::size_t>(node)].name;
  return name.empty() ? "node_" + std::to_string(node) : name;
}

// Skins' joints (every node where there is no skin), mapped by their names.
Result<Humanoid> ReadNames(const tinygltf::Model& model, const rig::JointNames& given) {
  Humanoid humanoid;
  for (const auto& skin : model.skins) {
    for (const int joint : skin.joints) {
      if (joint >= 0 && joint < static_cast<int>(model.nodes.size())) humanoid.bones.insert(joint);
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

// The bones below the hips with all that lies between, parents first, children in file order.
std::vector<int> Gather(const tinygltf::Model& model, const Nodes& nodes, int hips,
                        const std::set<int>& bones) {
  std::set<int> wanted;
  for (const int bone : bones) {
    if (!nodes.IsBelow(bone, hips)) continue;
    for (int node = bone; node != hips; node = nodes.parent(node)) wanted.insert(node);
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

GltfSkeleton Build(const tinygltf::Model& model, const Nodes& nodes, const Humanoid& humanoid,
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

Result<GltfSkeleton> Read(const tinygltf::Model& model, const rig::JointNames& given) {
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

// Images may be large and are not wanted.
bool SkipImage(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*,
               int, void*) {
  return true;
}

// What a file is that does not begin as glTF does, in words; empty where it does.
std::string NotGltf(std::ifstream& in) {
  std::array<char, 64> start{};
  in.read(start.data(), start.size());
  const std::string_view read(start.data(), static_cast<std::size_t>(in.gcount()));
  if (read.empty()) return "found an empty file";
  if (read.starts_with("glTF")) return "";
  std::string_view text = read;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  if (text.starts_with('{')) return "";
  std::string shown(read.substr(0, 16));
  std::replace_if(
      shown.begin(), shown.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
  return "found a file that begins with \"" + shown + "\"";
}

}  // namespace

Result<GltfSkeleton> ReadGltfSkeleton(const std::filesystem::path& file,
                                      const rig::JointNames& given) {
  std::error_code error;
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file, error)) {
    return Status::Error(file.string() + ": " +
                         (in ? "is a folder" : std::string(std::strerror(errno))) + kExpected);
  }
  if (const std::string found = NotGltf(in); !found.empty()) {
    return Status::Error(file.string() + ": is no glTF 2.0: " + found + kExpected);
  }
  std::array<char, 4> magic{};
  in.clear();
  in.seekg(0);
  in.read(magic.data(), magic.size());
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(SkipImage, nullptr);
  tinygltf::Model model;
  std::string what, warnings;
  bool read = false;
  try {
    const bool binary = std::string_view(magic.data(), magic.size()) == "glTF";
    read = binary ? loader.LoadBinaryFromFile(&model, &what, &warnings, file.string())
                  : loader.LoadASCIIFromFile(&model, &what, &warnings, file.string());
  } catch (const std::exception&) {  // of a damaged file, by the library's JSON parser
    what = "found JSON that cannot be read";
  }
  if (!read) {
    // The JSON library's own words are no use to who reads this.
    if (what.find("json.exception") != std::string::npos) what = "found JSON that cannot be read";
    std::replace(what.begin(), what.end(), '\n', ' ');
    while (what.ends_with(' ') || what.ends_with('.')) what.pop_back();
    return Status::Error(file.string() + ": is no glTF 2.0: " + what + kExpected);
  }
  auto skeleton = Read(model, given);
  if (!skeleton.ok()) return Status::Error(file.string() + ": " + skeleton.status().message());
  return skeleton;
}

}  // namespace styled::clip

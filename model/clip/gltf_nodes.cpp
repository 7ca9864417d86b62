#include "model/clip/gltf_nodes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include "model/rig/find_humanoid.h"

namespace styled::clip::gltf {
namespace {

using body::kHumanoid;
using body::kJointCount;
using nlohmann::json;
using rig::Quat;
using rig::Vec3;

constexpr float kEven = 0.01F;   // scales whose axes differ by less count as uniform
constexpr double kLeast = 1e-9;  // scales below it, or above its inverse, count as 0 or infinite
constexpr std::size_t kMaxNodes = 1 << 16;
constexpr std::size_t kMaxName = 256;  // bytes of a node's name that are kept

constexpr const char* kExpectedScale =
    "the same positive scale along all axes on the way to the humanoid's bones";

Status RefuseNode(const Model& model, int node, const std::string& what,
                  const std::string& expected = "a tree of bones") {
  constexpr std::size_t kShownName = 64;
  const std::string& name = model.nodes[static_cast<std::size_t>(node)].name;
  return Status::Error("node " + std::to_string(node) +
                       (name.empty() ? "" : " \"" + Shown(name.substr(0, kShownName)) + "\"") +
                       " " + what + ", expected " + expected);
}

// A node's transform; of one with a flaw only its translation.
std::pair<Transform, Nodes::Flaw> LocalOf(const Node& node) {
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
  Transform local;
  const Vec3 translation = affine.translation().cast<float>();
  if (translation.allFinite()) local.translation = translation;
  // Only rotation and uniform scale can be bound: the columns must be equally long and not
  // mirrored.
  const Eigen::Matrix3d linear = affine.linear();
  const Eigen::Vector3d lengths = linear.colwise().norm();
  const double size = lengths.mean();
  if (!translation.allFinite() || !linear.allFinite() || !(size > kLeast && size < 1 / kLeast) ||
      !(linear.determinant() > 0)) {
    return {local, Nodes::Flaw::kNotRigid};
  }
  if ((lengths.array() - size).abs().maxCoeff() > kEven * size) {
    return {local, Nodes::Flaw::kUneven};
  }
  local.rotation = Quat(Eigen::Matrix3f((linear / size).cast<float>())).normalized();
  local.scale = static_cast<float>(size);
  return {local, Nodes::Flaw::kNone};
}

std::optional<int> ToIndex(const json& value) {
  if (!value.is_number_integer()) return std::nullopt;
  const auto number = value.get<std::int64_t>();
  if (number < 0 || number > std::numeric_limits<int>::max()) return std::nullopt;
  return static_cast<int>(number);
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
  std::set<int> bones;                // all of VRM's bones, fingers included
  JointMap joint;                     // node per canonical joint
  rig::TailMap tail = rig::NoTail();  // node per joint of the tail
};

// VRM 0.x counts the thumb's bones as Unity does, from the knuckle on.
std::string NameIn1(const std::string& bone) {
  for (const std::string thumb : {"leftThumb", "rightThumb"}) {
    if (bone == thumb + "Proximal") return thumb + "Metacarpal";
    if (bone == thumb + "Intermediate") return thumb + "Proximal";
  }
  return bone;
}

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
    for (std::size_t t = 0; t < rig::kTailNames.size(); ++t) {
      if (rig::kTailNames[t] == bone) humanoid.tail[t] = *node;
    }
  };
  const json& bones = Member(model.vrm, "humanBones");
  for (const auto& [key, entry] : bones.items()) {
    const json bone = Member(entry, "bone");
    if (bones.is_object()) add(key, entry);
    if (bones.is_array() && bone.is_string()) add(NameIn1(bone.get<std::string>()), entry);
  }
  return humanoid;
}

std::string NameOf(const Model& model, int node) {
  const std::string& name = model.nodes[static_cast<std::size_t>(node)].name;
  return name.empty() ? "node_" + std::to_string(node) : name;
}

// Bones with the nodes above them as one skeleton in the file's pose.
struct Tree {
  rig::Skeleton skeleton;
  rig::RigPose stance;
  std::vector<int> nodes;  // per joint; -1 for the root, which the file does not have
};
Tree TreeOf(const Model& model, const Nodes& nodes, const std::set<int>& bones) {
  std::vector<bool> wanted(model.nodes.size(), false);
  for (int bone : bones) {
    for (; bone >= 0 && !wanted[static_cast<std::size_t>(bone)]; bone = nodes.parent(bone)) {
      wanted[static_cast<std::size_t>(bone)] = true;
    }
  }
  Tree tree;
  struct Open {
    int node, parent;
    float scale;  // of all nodes above
  };
  std::vector<Open> open;
  const auto add = [&](int node, int parent, const std::string& name, const Vec3& offset) {
    tree.nodes.push_back(node);
    tree.skeleton.names.push_back(name);
    tree.skeleton.parents.push_back(parent);
    tree.skeleton.offsets.push_back(offset);
    return tree.skeleton.joint_count() - 1;
  };
  add(-1, -1, "", Vec3::Zero());
  for (std::size_t node = model.nodes.size(); node > 0; --node) {
    const int root = static_cast<int>(node) - 1;
    if (wanted[node - 1] && nodes.parent(root) < 0) open.push_back({root, 0, 1});
  }
  while (!open.empty()) {
    const auto [node, parent, scale] = open.back();
    open.pop_back();
    const Transform& local = nodes.local(node);
    const int joint = add(node, parent, NameOf(model, node), scale * local.translation);
    const auto& children = model.nodes[static_cast<std::size_t>(node)].children;
    for (auto child = children.rbegin(); child != children.rend(); ++child) {
      if (wanted[static_cast<std::size_t>(*child)]) {
        open.push_back({*child, joint, scale * local.scale});
      }
    }
  }
  tree.stance = rig::RigPose(tree.skeleton);
  for (std::size_t joint = 1; joint < tree.nodes.size(); ++joint) {
    tree.stance.rotations[joint] = nodes.local(tree.nodes[joint]).rotation;
  }
  return tree;
}

// Finds the humanoid among the skins' joints; among all nodes if the file has no skin.
Result<Humanoid> ReadNames(const Model& model, const Nodes& nodes, const rig::JointNames& given) {
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
  const Tree tree = TreeOf(model, nodes, humanoid.bones);
  const auto map = rig::FindHumanoid(tree.skeleton, given, std::span(&tree.stance, 1));
  if (!map.ok()) return map.status();
  humanoid.joint = map.value().joint;
  humanoid.tail = rig::FindTail(tree.skeleton, map.value().joint);
  const auto to_node = [&tree](int& joint) {
    if (joint >= 0) joint = tree.nodes[static_cast<std::size_t>(joint)];
  };
  std::for_each(humanoid.joint.begin(), humanoid.joint.end(), to_node);
  std::for_each(humanoid.tail.begin(), humanoid.tail.end(), to_node);
  humanoid.found = humanoid.joint[body::kHips] >= 0;
  return humanoid;
}

// Whether the nodes from the root to the hips and to the mapped bones below them can be bound.
Status CheckChains(const Model& model, const Nodes& nodes, const Humanoid& humanoid) {
  const int hips = humanoid.joint[body::kHips];
  const std::vector<bool> below = nodes.Below(hips);
  std::vector<bool> chain(below.size(), false);
  const auto add = [&](int node) {
    for (; node >= 0 && !chain[static_cast<std::size_t>(node)]; node = nodes.parent(node)) {
      chain[static_cast<std::size_t>(node)] = true;
    }
  };
  add(hips);
  const auto add_below = [&](int node) {
    if (node >= 0 && below[static_cast<std::size_t>(node)]) add(node);
  };
  std::for_each(humanoid.joint.begin(), humanoid.joint.end(), add_below);
  std::for_each(humanoid.tail.begin(), humanoid.tail.end(), add_below);
  for (int node = 0; node < static_cast<int>(chain.size()); ++node) {
    if (!chain[static_cast<std::size_t>(node)] || nodes.flaw(node) == Nodes::Flaw::kNone) continue;
    return RefuseNode(model, node,
                      nodes.flaw(node) == Nodes::Flaw::kUneven
                          ? "is stretched unevenly"
                          : "has a transform that is not a rotation and scale",
                      kExpectedScale);
  }
  return Status::Ok();
}

// The bones below the hips with all nodes between them, parents first, children in file order;
// without flawed nodes and what hangs from them.
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
      const bool flawed = nodes.flaw(*child) != Nodes::Flaw::kNone;
      if (!flawed && wanted.contains(*child)) open.push_back(*child);
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
  for (std::size_t t = 0; t < built.tail.size(); ++t) {
    const int node = humanoid.tail[t];
    built.tail[t] = node < 0 ? -1 : index[static_cast<std::size_t>(node)];
  }
  return built;
}

bool IsFinite(const GltfSkeleton& skeleton) {
  const auto& offsets = skeleton.skeleton.offsets;
  return skeleton.above_translation_m.allFinite() && std::isfinite(skeleton.above_scale) &&
         skeleton.above_scale > 0 &&
         std::all_of(offsets.begin(), offsets.end(), [](const Vec3& v) { return v.allFinite(); });
}

}  // namespace

Result<Nodes> Nodes::Make(const Model& model) {
  Nodes nodes;
  const auto count = static_cast<int>(model.nodes.size());
  nodes.parents_.assign(model.nodes.size(), -1);
  for (int node = 0; node < count; ++node) {
    for (const int child : model.nodes[static_cast<std::size_t>(node)].children) {
      if (child < 0 || child >= count)
        return RefuseNode(model, node, "has a child that does not exist");
      int& parent = nodes.parents_[static_cast<std::size_t>(child)];
      if (parent >= 0) return RefuseNode(model, child, "hangs from two nodes");
      parent = node;
    }
  }
  if (const int node = nodes.PutInOrder(model); node >= 0) {
    return RefuseNode(model, node, "is its own ancestor");
  }
  nodes.locals_.reserve(model.nodes.size());
  nodes.flaws_.reserve(model.nodes.size());
  for (const Node& node : model.nodes) {
    const auto [local, flaw] = LocalOf(node);
    nodes.locals_.push_back(local);
    nodes.flaws_.push_back(flaw);
  }
  return nodes;
}

Transform Nodes::World(int node) const {
  Transform world;
  for (; node >= 0; node = parent(node)) world = local(node) * world;
  return world;
}

std::vector<bool> Nodes::Below(int above) const {
  std::vector<bool> below(parents_.size(), false);
  for (const int node : order_) {
    below[static_cast<std::size_t>(node)] =
        node == above || (parent(node) >= 0 && below[static_cast<std::size_t>(parent(node))]);
  }
  return below;
}

// Orders nodes with parents before children. Returns the first node that no root reaches (it is
// on a cycle), -1 if there is none.
int Nodes::PutInOrder(const Model& model) {
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

// The value of an object's key; null if there is none.
const json& Member(const json& object, const char* key) {
  static const json kNull;
  if (!object.is_object()) return kNull;
  const auto found = object.find(key);
  return found == object.end() ? kNull : *found;
}

std::optional<int> IndexOf(const json& object, const char* key) {
  return ToIndex(Member(object, key));
}

Result<Bones> FindBones(const Model& model, const Nodes& nodes, const rig::JointNames& given) {
  Humanoid humanoid = ReadVrm(model);
  const bool vrm = humanoid.found && given.empty();
  if (!vrm) {
    auto named = ReadNames(model, nodes, given);
    if (!named.ok()) return named.status();
    humanoid = named.value();
  }
  const int hips = humanoid.joint[body::kHips];
  if (hips < 0) {
    return Status::Error(vrm ? "found a VRM humanoid without hips"
                             : "found no bone named like hips, expected a humanoid");
  }
  if (const Status status = CheckChains(model, nodes, humanoid); !status.ok()) return status;
  auto order = Gather(model, nodes, hips, humanoid.bones);
  // Too many bones: drop fingers and the like, keep the mapped ones.
  if (order.size() > rig::kMaxSourceJoints) {
    std::set<int> mapped(humanoid.joint.begin(), humanoid.joint.end());
    mapped.erase(-1);
    order = Gather(model, nodes, hips, mapped);
  }
  if (order.size() > rig::kMaxSourceJoints) {
    return Status::Error("found " + std::to_string(order.size()) + " bones, expected at most " +
                         std::to_string(rig::kMaxSourceJoints));
  }
  Bones bones{order, Build(model, nodes, humanoid, order)};
  if (!IsFinite(bones.skeleton)) {
    return Status::Error(
        "found nodes whose scales multiply to more than a number holds, expected " +
        std::string(kExpectedScale));
  }
  bones.skeleton.nodes = bones.nodes;
  bones.skeleton.t_pose = vrm;
  return bones;
}

Result<Model> ReadModel(json& file) {
  Model model;
  // Moved out of the file, so that they are not in memory twice.
  const auto take = [](json& object, const char* key) {
    json taken;
    if (object.is_object() && object.contains(key)) taken.swap(object[key]);
    return taken;
  };
  json nodes = take(file, "nodes");
  if (nodes.is_array() && nodes.size() > kMaxNodes) {
    return Status::Error("found " + std::to_string(nodes.size()) + " nodes, expected at most " +
                         std::to_string(kMaxNodes));
  }
  if (nodes.is_array()) model.nodes.reserve(nodes.size());
  for (std::size_t i = 0; nodes.is_array() && i < nodes.size(); ++i) {
    const json node = std::exchange(nodes[i], nullptr);
    const json& name = Member(node, "name");
    model.nodes.push_back(
        {name.is_string() ? name.get_ref<const std::string&>().substr(0, kMaxName) : "",
         Indices(Member(node, "children")), Numbers(Member(node, "translation")),
         Numbers(Member(node, "rotation")), Numbers(Member(node, "scale")),
         Numbers(Member(node, "matrix"))});
  }
  json skins = take(file, "skins");
  for (std::size_t i = 0; skins.is_array() && i < skins.size(); ++i) {
    const json skin = std::exchange(skins[i], nullptr);
    model.skins.push_back(Indices(Member(skin, "joints")));
  }
  json extensions = take(file, "extensions");
  const auto humanoid = [&](const char* extension) {
    json of = take(extensions, extension);
    return take(of, "humanoid");
  };
  json one = humanoid("VRMC_vrm"), moving = humanoid("VRMC_vrm_animation"), zero = humanoid("VRM");
  if (Member(one, "humanBones").is_object()) {
    model.vrm = std::move(one);
  } else if (Member(moving, "humanBones").is_object()) {
    model.vrm = std::move(moving);
  } else if (Member(zero, "humanBones").is_array()) {
    model.vrm = std::move(zero);
  }
  return model;
}

}  // namespace styled::clip::gltf

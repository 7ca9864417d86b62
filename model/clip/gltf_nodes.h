#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"
#include "model/clip/gltf_read.h"

// The part that the readers of glTF share: the used parts of the JSON, the nodes, the humanoid
// among them. Included only by gltf_*.cpp. Errors do not name the file. Allocates; any thread.
// Pinned by tests/unit/clip/gltf_read_test.cpp, gltf_clip_test.cpp.
namespace styled::clip::gltf {

using JointMap = std::array<int, body::kJointCount>;

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
  nlohmann::json vrm;  // the humanoid of the VRM 1.0, VRM 0.x or VRMC_vrm_animation extension
};

struct Transform {
  rig::Vec3 translation = rig::Vec3::Zero();
  rig::Quat rotation = rig::Quat::Identity();
  float scale = 1;

  Transform operator*(const Transform& below) const {
    return {translation + scale * (rotation * below.translation),
            (rotation * below.rotation).normalized(), scale * below.scale};
  }
};

// The nodes of a file as a forest, with their transforms. Time in proportion to the nodes.
class Nodes {
 public:
  // The reason why a node's transform is none that a bone can have.
  enum class Flaw : std::uint8_t {
    kNone,
    kUneven,    // stretched by different scales
    kNotRigid,  // of scale 0, mirrored, sheared, or not finite
  };

  static Result<Nodes> Make(const Model& model);

  int parent(int node) const { return parents_[static_cast<std::size_t>(node)]; }
  // Of a flawed node only the translation.
  const Transform& local(int node) const { return locals_[static_cast<std::size_t>(node)]; }
  Flaw flaw(int node) const { return flaws_[static_cast<std::size_t>(node)]; }
  Transform World(int node) const;
  // Per node: whether it is `above` or a descendant of it.
  std::vector<bool> Below(int above) const;

 private:
  int PutInOrder(const Model& model);

  std::vector<int> parents_;
  std::vector<int> order_;
  std::vector<Transform> locals_;
  std::vector<Flaw> flaws_;
};

// The nodes that make the skeleton of the file's humanoid, hips first, and the skeleton.
struct Bones {
  std::vector<int> nodes;  // per joint
  GltfSkeleton skeleton;
};
// Refuses a flawed node between the root and a bone of the humanoid, fingers and the like included.
// Other flawed nodes (a stretched hat, a hidden prop of scale 0), with what hangs from them, are
// left out of the skeleton.
Result<Bones> FindBones(const Model& model, const Nodes& nodes, const rig::JointNames& given);

// The value of an object's key; null if there is none.
const nlohmann::json& Member(const nlohmann::json& object, const char* key);
// A number of the list of an object's key; empty if it is not an index.
std::optional<int> IndexOf(const nlohmann::json& object, const char* key);

// The used parts of the JSON of a file of `bytes`. Refuses text that is not JSON, is nested too
// deep, has too many values, or another version than glTF 2. The kept values, together with the
// results of ReadModel and Nodes, take at most 6 times as much memory as the file, and 2 MiB.
Result<nlohmann::json> ParseJson(std::string_view text, std::size_t bytes);
// The same with accessors and animations; at most 6 times the file, and 4 MiB.
Result<nlohmann::json> ParseMotionJson(std::string_view text, std::size_t bytes);
// Refuses JSON that nlohmann::ordered_json cannot be trusted with: an object of more than 1024
// keys, which it reads in the square of their number, and values so deep that writing them, which
// is recursive, might exhaust the stack. Not whether the text is JSON.
Status CheckShape(std::string_view text);
// Moves nodes, skins and humanoid out of `file`.
Result<Model> ReadModel(nlohmann::json& file);

// The maximum length of a JSON text.
inline constexpr std::size_t kMaxJson = std::size_t{64} << 20;
inline constexpr const char* kTooMuchJson = "found more than 64 MiB of JSON, expected less";
// Binary files (glTF 2.0, 4.4): a header, then chunks, each with a header.
inline constexpr std::size_t kHeader = 12, kChunk = 8;
inline constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
std::uint32_t Word(std::string_view bytes, std::size_t at);

// Text from a file, made printable for an error message.
std::string Shown(std::string_view text);
Status Broken(const std::string& found);  // "is not glTF 2.0: " ...
Status WrongVersion(const std::string& version);
// The two chunks of a .glb file (glTF 2.0, 4.4): its text and its data. Errors do not name a file.
struct Chunks {
  std::string_view text, data;
};
Result<Chunks> SplitGlb(std::string_view bytes);

}  // namespace styled::clip::gltf

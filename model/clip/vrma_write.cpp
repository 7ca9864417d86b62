#include "model/clip/vrma_write.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "model/clip/glb_write.h"
#include "model/rig/find_humanoid.h"

namespace styled::clip {
namespace {

using VrmaJson = nlohmann::json;

Result<rig::Binding> FoundBinding(const Motion& motion) {
  auto map = rig::FindHumanoid(motion.skeleton, {}, motion.frames);
  if (!map.ok()) return map.status();
  rig::BindingSpec spec{motion.skeleton, map.value().joint, motion.rest,
                        motion.canonical_from_source};
  if (spec.rest_rotations.empty()) {
    spec.rest_rotations.assign(motion.skeleton.names.size(), rig::Quat::Identity());
  }
  return rig::Binding::Make(std::move(spec));
}

// The animation's numbers, one accessor after the other, and its channels.
class VrmaTracks {
 public:
  explicit VrmaTracks(std::size_t keys) : keys_(keys) {}
  // Adds an accessor of `keys` rows; returns its number.
  int Add(const std::vector<float>& values, const char* type, bool bounds = false) {
    const auto bytes = std::as_bytes(std::span(values));
    views.push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}});
    buffer.insert(buffer.end(), bytes.begin(), bytes.end());
    accessors.push_back({{"bufferView", views.size() - 1},
                         {"componentType", 5126},  // float
                         {"count", keys_},
                         {"type", type}});
    if (bounds) {
      accessors.back()["min"] = {values.front()};
      accessors.back()["max"] = {values.back()};
    }
    return static_cast<int>(accessors.size()) - 1;
  }
  void Channel(std::size_t node, const char* path, int input, int output) {
    channels.push_back(
        {{"sampler", samplers.size()}, {"target", {{"node", node}, {"path", path}}}});
    samplers.push_back({{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
  }

  std::vector<std::byte> buffer;
  VrmaJson views = VrmaJson::array(), accessors = VrmaJson::array(), channels = VrmaJson::array(),
           samplers = VrmaJson::array();

 private:
  std::size_t keys_;
};

// Joint j's node is 1 + j: the first node is the root.
VrmaTracks TracksOf(const std::vector<body::Pose>& poses, const KeyTimes& keys) {
  VrmaTracks tracks(keys.frames.size());
  const int times = tracks.Add(keys.seconds, "SCALAR", true);
  std::vector<float> values;
  for (const std::size_t frame : keys.frames) {
    for (const float value : poses[frame].hips_position_m) values.push_back(value);
  }
  tracks.Channel(1, "translation", times, tracks.Add(values, "VEC3"));
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    values.clear();
    for (const std::size_t frame : keys.frames) {  // continuous in sign
      const auto& q = poses[frame].rotations[joint].coeffs();
      values.insert(values.end(), q.data(), q.data() + 4);
    }
    tracks.Channel(1 + joint, "rotation", times, tracks.Add(values, "VEC4"));
  }
  return tracks;
}

}  // namespace

Result<std::vector<std::byte>> FormatVrma(const Motion& motion) {
  if (Status status = CheckMotion(motion); !status.ok()) return status;
  const auto found = motion.binding ? Result<rig::Binding>(*motion.binding) : FoundBinding(motion);
  if (!found.ok()) {
    return Status::Error("found no humanoid, of which a VRM animation is: " +
                         found.status().message());
  }
  VrmaTracks tracks = TracksOf(ToCanonical(motion, found.value()), TimesOf(motion));

  VrmaJson nodes = {{{"name", "root"}, {"children", {1}}}}, bones;
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    const body::JointRow& row = body::kHumanoid[joint];
    bones[row.name] = {{"node", nodes.size()}};
    if (row.parent >= 0) {
      nodes[static_cast<std::size_t>(row.parent) + 1]["children"].push_back(nodes.size());
    }
    nodes.push_back({{"name", row.name}, {"translation", {row.x_m, row.y_m, row.z_m}}});
  }
  const VrmaJson file{
      {"asset", {{"version", "2.0"}, {"generator", "styled"}}},
      {"extensionsUsed", {"VRMC_vrm_animation"}},
      {"scene", 0},
      {"scenes", {{{"name", motion.name}, {"nodes", {0}}}}},
      {"nodes", nodes},
      {"animations",
       {{{"name", motion.name}, {"channels", tracks.channels}, {"samplers", tracks.samplers}}}},
      {"buffers", {{{"byteLength", tracks.buffer.size()}}}},
      {"bufferViews", tracks.views},
      {"accessors", tracks.accessors},
      {"extensions",
       {{"VRMC_vrm_animation", {{"specVersion", "1.0"}, {"humanoid", {{"humanBones", bones}}}}}}}};
  // The name may not be valid UTF-8: invalid bytes are replaced.
  return JoinGlb(file.dump(-1, ' ', false, VrmaJson::error_handler_t::replace), tracks.buffer);
}

Status WriteVrma(const Motion& motion, const std::filesystem::path& file) {
  const auto bytes = FormatVrma(motion);
  if (!bytes.ok()) return Status::Error(file.string() + ": " + bytes.status().message());
  return WriteBytes(bytes.value(), file);
}

}  // namespace styled::clip

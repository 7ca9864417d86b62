#include "model/clip/avatar_write.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "model/clip/glb_write.h"
#include "model/clip/gltf_nodes.h"
#include "model/clip/read_file.h"

namespace styled::clip {
namespace {

using nlohmann::ordered_json;
using rig::Quat;
using rig::Vec3;

constexpr const char* kExpected = ", expected an avatar's .vrm or .glb";
constexpr int kFloat32 = 5126;

// A .glb in its two parts.
struct Glb {
  ordered_json document;
  std::string binary;
};

Result<Glb> ReadGlb(const std::filesystem::path& file) {
  const auto opened = InputFile::Open(file, kExpected);
  if (!opened.ok()) return opened.status();
  const auto read = opened.value().Read(0, opened.value().size());
  if (!read.ok()) return read.status();
  const std::string_view bytes = read.value();
  const auto refuse = [&file](const std::string& what) {
    return Status::Error(file.string() + ": " + what + kExpected + " with its data inside");
  };
  if (!bytes.starts_with("glTF")) return refuse("is not a glTF binary");
  const auto chunks = gltf::SplitGlb(bytes);
  if (!chunks.ok()) return refuse(chunks.status().message());
  if (const Status shape = gltf::CheckShape(chunks.value().text); !shape.ok()) {
    return refuse(shape.message());
  }
  Glb glb{ordered_json::parse(chunks.value().text, nullptr, false),
          std::string(chunks.value().data)};
  if (!glb.document.is_object()) return refuse("has no JSON object");
  for (const char* const list : {"buffers", "images"}) {
    const auto entries = glb.document.find(list);
    if (entries == glb.document.end() || !entries->is_array()) continue;
    for (const ordered_json& entry : *entries) {
      const auto uri = entry.is_object() ? entry.find("uri") : entry.end();
      if (!entry.is_object() || uri == entry.end()) continue;
      if (!uri->is_string() || !uri->get_ref<const std::string&>().starts_with("data:")) {
        return refuse(std::string("has ") + list + " in other files");
      }
    }
  }
  // The buffer of the binary chunk is the first, and has no uri.
  const auto buffers = glb.document.find("buffers");
  if (buffers != glb.document.end() && buffers->is_array() && !buffers->empty() &&
      (!buffers->front().is_object() || buffers->front().contains("uri"))) {
    return refuse("has its data as text, not in its binary part");
  }
  return glb;
}

template <typename T>
ordered_json Listed(const T& vector) {
  return std::vector<float>(vector.data(), vector.data() + vector.size());
}

class AvatarDocument {
 public:
  AvatarDocument(Glb glb, const AvatarSkeleton& avatar, const Motion& motion)
      : glb_(std::move(glb)), avatar_(avatar), motion_(motion) {}

  Result<std::vector<std::byte>> Make() {
    ordered_json& document = glb_.document;
    for (const char* const list : {"buffers", "bufferViews", "accessors", "animations"}) {
      if (!document.contains(list)) document[list] = ordered_json::array();
      if (!document[list].is_array()) return Broken(list);
    }
    if (document["buffers"].empty()) document["buffers"].push_back(ordered_json{{"byteLength", 0}});
    while (glb_.binary.size() % 4 != 0) glb_.binary += '\0';
    if (const Status nodes = PrepareNodes(); !nodes.ok()) return nodes;
    Animate();
    document["buffers"][0]["byteLength"] = glb_.binary.size();
    return JoinGlb(document.dump(-1, ' ', false, ordered_json::error_handler_t::replace),
                   std::as_bytes(std::span(glb_.binary)));
  }

 private:
  static Status Broken(const std::string& what) {
    return Status::Error("found broken " + what + kExpected);
  }

  Status PrepareNodes() {
    ordered_json& nodes = glb_.document["nodes"];
    for (std::size_t joint = 0; joint < avatar_.nodes.size(); ++joint) {
      const auto node = static_cast<std::size_t>(avatar_.nodes[joint]);
      if (!nodes.is_array() || node >= nodes.size() || !nodes[node].is_object()) {
        return Broken("nodes");
      }
      ordered_json& own = nodes[node];
      if (!own.contains("matrix")) continue;
      const ordered_json matrix = own["matrix"];
      if (!matrix.is_array() || matrix.size() != 16) return Broken("matrix");
      Eigen::Matrix4f values;
      for (int i = 0; i < 16; ++i) {
        if (!matrix[static_cast<std::size_t>(i)].is_number()) return Broken("matrix");
        values.data()[i] = matrix[static_cast<std::size_t>(i)].get<float>();
      }
      const float scale = values.topLeftCorner<3, 1>().norm();
      if (!(scale > 0)) return Broken("matrix");
      own.erase("matrix");
      own["translation"] = Listed(Vec3(values.topRightCorner<3, 1>()));
      const Quat turn(Eigen::Matrix3f(values.topLeftCorner<3, 3>() / scale));
      own["rotation"] = Listed(turn.normalized().coeffs());
      own["scale"] = {scale, scale, scale};
    }
    return Status::Ok();
  }

  // Appends an accessor of these numbers, `width` of them per element.
  std::size_t Add(const std::vector<float>& values, const char* type, std::size_t width) {
    ordered_json& views = glb_.document["bufferViews"];
    ordered_json& accessors = glb_.document["accessors"];
    const std::size_t size = values.size() * sizeof(float);
    views.push_back(
        ordered_json{{"buffer", 0}, {"byteOffset", glb_.binary.size()}, {"byteLength", size}});
    const std::size_t at = glb_.binary.size();
    glb_.binary.resize(at + size);
    std::memcpy(glb_.binary.data() + at, values.data(), size);
    ordered_json accessor{{"bufferView", views.size() - 1},
                          {"componentType", kFloat32},
                          {"count", values.size() / width},
                          {"type", type}};
    if (width == 1) {
      accessor["min"] = {values.front()};
      accessor["max"] = {values.back()};
    }
    accessors.push_back(std::move(accessor));
    return accessors.size() - 1;
  }

  void Animate() {
    std::vector<float> times_s;
    for (std::size_t i = 0; i < motion_.frames.size(); ++i) {
      times_s.push_back(static_cast<float>(static_cast<double>(i) / motion_.rate_hz));
    }
    const std::size_t input = Add(times_s, "SCALAR", 1);
    ordered_json channels = ordered_json::array(), samplers = ordered_json::array();
    const auto add = [&](std::size_t joint, const char* path, std::size_t output) {
      channels.push_back(
          ordered_json{{"sampler", samplers.size()},
                       {"target", {{"node", avatar_.nodes[joint]}, {"path", path}}}});
      samplers.push_back(
          ordered_json{{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
    };
    for (std::size_t joint = 0; joint < avatar_.nodes.size(); ++joint) {
      add(joint, "rotation", Add(Rotations(joint), "VEC4", 4));
    }
    std::vector<float> way;
    for (const rig::RigPose& frame : motion_.frames) {
      const Vec3 place = avatar_.RootInFile(frame.translations[0]);
      way.insert(way.end(), place.data(), place.data() + 3);
    }
    add(0, "translation", Add(way, "VEC3", 3));
    ordered_json& animations = glb_.document["animations"];
    animations.insert(animations.begin(), ordered_json{{"name", motion_.name},
                                                       {"channels", std::move(channels)},
                                                       {"samplers", std::move(samplers)}});
  }

  std::vector<float> Rotations(std::size_t joint) const {
    std::vector<float> values;
    Quat last = Quat::Identity();
    for (const rig::RigPose& frame : motion_.frames) {
      Quat q = frame.rotations[joint].normalized();
      if (joint == 0) q = avatar_.RootInFile(q);
      if (q.dot(last) < 0) q.coeffs() = -q.coeffs();  // the shorter way between two frames
      values.insert(values.end(), q.coeffs().data(), q.coeffs().data() + 4);
      last = q;
    }
    return values;
  }

  Glb glb_;
  const AvatarSkeleton& avatar_;
  const Motion& motion_;
};

}  // namespace

struct AvatarFile::Content {
  Glb glb;
};

Result<AvatarFile> AvatarFile::Read(const std::filesystem::path& avatar_file,
                                    const AvatarSkeleton& avatar) {
  if (avatar.nodes.empty()) return Status::Error(avatar_file.string() + ": has no meshes");
  auto glb = ReadGlb(avatar_file);
  if (!glb.ok()) return glb.status();
  AvatarFile read;
  read.name_ = avatar_file.string();
  read.content_ = std::make_shared<const Content>(Content{std::move(glb.value())});
  return read;
}

Status AvatarFile::Write(const AvatarSkeleton& avatar, const Motion& motion,
                         const std::filesystem::path& file) const {
  const auto joints = avatar.nodes.size();
  const bool fits =
      joints > 0 && !motion.frames.empty() && motion.rate_hz > 0 && std::isfinite(motion.rate_hz) &&
      motion.skeleton.names.size() == joints &&
      std::all_of(motion.frames.begin(), motion.frames.end(), [joints](const rig::RigPose& frame) {
        return frame.rotations.size() == joints && frame.translations.size() == joints;
      });
  if (!fits) return Status::Error(file.string() + ": found no motion of the avatar's skeleton");
  const auto bytes = AvatarDocument(content_->glb, avatar, motion).Make();
  if (!bytes.ok()) return Status::Error(name_ + ": " + bytes.status().message());
  return WriteBytes(bytes.value(), file);
}

}  // namespace styled::clip

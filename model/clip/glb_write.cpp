// WriteGlb and FormatGlb, after the glTF 2.0 specification (Khronos, 2021), 4.4 "GLB File Format".
#include "model/clip/glb_write.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>
#include <utility>

#include "model/base/text.h"

namespace styled::clip {
namespace {

using nlohmann::json;
using rig::Quat;
using rig::Vec3;

constexpr int kFloat = 5126, kUnsignedShort = 5123, kArrayBuffer = 34962;
constexpr std::uint64_t kMaxSize = 0xFFFF'FFFFU;

// Collects the binary chunk with the buffer views and accessors that describe it.
class Buffer {
 public:
  // Appends `count` elements of `type` ("SCALAR", "VEC3", ...) made of `values`; returns the
  // accessor's index. `bounds` adds min and max, which glTF requires of positions and of key times.
  template <typename T>
  int Add(std::span<const T> values, int count, const char* type, bool vertices = false,
          bool bounds = false) {
    const auto bytes = std::as_bytes(values);
    json view{{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}};
    // In glTF a buffer view of vertices names its target.
    if (vertices) view["target"] = kArrayBuffer;
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    while (bytes_.size() % 4 != 0) bytes_.push_back(std::byte{0});
    json accessor{{"bufferView", views.size()},
                  {"componentType", std::is_same_v<T, float> ? kFloat : kUnsignedShort},
                  {"count", count},
                  {"type", type}};
    if (bounds) AddBounds(values, values.size() / static_cast<std::size_t>(count), accessor);
    views.push_back(std::move(view));
    accessors.push_back(std::move(accessor));
    return static_cast<int>(accessors.size()) - 1;
  }

  const std::vector<std::byte>& bytes() const { return bytes_; }
  json views = json::array(), accessors = json::array();

 private:
  template <typename T>
  static void AddBounds(std::span<const T> values, std::size_t width, json& accessor) {
    std::vector<T> low(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(width));
    std::vector<T> high = low;
    for (std::size_t i = 0; i < values.size(); ++i) {
      low[i % width] = std::min(low[i % width], values[i]);
      high[i % width] = std::max(high[i % width], values[i]);
    }
    accessor["min"] = low;
    accessor["max"] = high;
  }

  std::vector<std::byte> bytes_;
};

template <typename T>
std::vector<float> Numbers(const T& vector) {
  return {vector.data(), vector.data() + vector.size()};
}
std::vector<float> Numbers(const Quat& q) { return {q.x(), q.y(), q.z(), q.w()}; }

// World transforms of the joints in the pose that the mesh is bound in; metres, source axes.
struct BindPose {
  std::vector<Vec3> positions_m;
  std::vector<Quat> rotations;
};

BindPose MakeBindPose(const Motion& motion) {
  BindPose bind;
  const auto& skeleton = motion.skeleton;
  for (std::size_t j = 0; j < skeleton.names.size(); ++j) {
    const Vec3 offset_m = skeleton.offsets[j] * motion.metres_per_unit;
    bind.rotations.push_back(motion.rest.empty() ? Quat::Identity() : motion.rest[j].normalized());
    if (j == 0) {
      bind.positions_m.push_back(offset_m);
    } else {
      const auto parent = static_cast<std::size_t>(skeleton.parents[j]);
      bind.positions_m.push_back(bind.positions_m[parent] + bind.rotations[parent] * offset_m);
    }
  }
  return bind;
}

// Bones drawn as double pyramids with flat normals, each bound to one joint.
class Mesh {
 public:
  Mesh(const Motion& motion, const BindPose& bind) {
    const auto& parents = motion.skeleton.parents;
    std::vector<bool> has_child(parents.size(), false);
    for (std::size_t j = 1; j < parents.size(); ++j) {
      const auto parent = static_cast<std::size_t>(parents[j]);
      has_child[parent] = true;
      Bone(parent, bind.positions_m[parent], bind.positions_m[j]);
    }
    for (std::size_t j = 0; j < parents.size(); ++j) {
      if (has_child[j]) continue;
      // Extend the end of a chain a little along its last bone.
      const Vec3 came =
          j == 0
              ? Vec3(0, 2 * kTip_m, 0)
              : Vec3(bind.positions_m[j] - bind.positions_m[static_cast<std::size_t>(parents[j])]);
      const float length_m = came.norm();
      if (length_m < kShortest_m) continue;
      const float tip_m = std::min(kTip_m, length_m / 2);
      Bone(j, bind.positions_m[j], bind.positions_m[j] + came * (tip_m / length_m));
    }
    if (positions.empty()) Bone(0, bind.positions_m[0], bind.positions_m[0] + Vec3(0, kTip_m, 0));
  }

  int vertices() const { return static_cast<int>(positions.size() / 3); }

  std::vector<float> positions, normals, weights;
  std::vector<std::uint16_t> joints;

 private:
  static constexpr float kShortest_m = 1e-4F, kTip_m = 0.06F;

  void Bone(std::size_t joint, const Vec3& head, const Vec3& tail) {
    const Vec3 along = tail - head;
    const float length_m = along.norm();
    if (length_m < kShortest_m) return;
    const Vec3 across = along.unitOrthogonal();
    const Vec3 other = along.cross(across) / length_m;
    const float width_m = std::clamp(0.1F * length_m, 0.002F, 0.04F);
    // The two pyramids share a square ring at a fifth of the bone.
    const Vec3 middle = head + 0.2F * along;
    std::array<Vec3, 4> ring;
    for (int k = 0; k < 4; ++k) {
      const float sign = k < 2 ? width_m : -width_m;
      ring[static_cast<std::size_t>(k)] = middle + sign * (k % 2 == 0 ? across : other);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      Triangle(joint, head, ring[(k + 1) % 4], ring[k]);
      Triangle(joint, tail, ring[k], ring[(k + 1) % 4]);
    }
  }

  // Adds a triangle whose corners are counter-clockwise seen from outside.
  void Triangle(std::size_t joint, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 normal = (b - a).cross(c - a).normalized();
    for (const Vec3& corner : {a, b, c}) {
      for (const float value : corner) positions.push_back(value);
      for (const float value : normal) normals.push_back(value);
      for (int k = 0; k < 4; ++k) {
        joints.push_back(k == 0 ? static_cast<std::uint16_t>(joint) : 0);
        weights.push_back(k == 0 ? 1.0F : 0.0F);
      }
    }
  }
};

class Document {
 public:
  explicit Document(const Motion& motion)
      : motion_(motion), bind_(MakeBindPose(motion)), times_(TimesOf(motion)) {}

  Result<std::vector<std::byte>> Make() {
    const auto values_per_frame =
        1 + 7 * static_cast<std::uint64_t>(motion_.skeleton.joint_count());
    if (times_.frames.size() * values_per_frame * sizeof(float) > kMaxSize / 2) {
      return Status::Error("found " + std::to_string(times_.frames.size()) +
                           " frames, expected as many as 2 GiB hold");
    }
    AddNodes();
    AddMesh();
    AddAnimation();
    return Join();
  }

 private:
  void AddNodes() {
    const auto& skeleton = motion_.skeleton;
    json nodes = json::array();
    for (std::size_t j = 0; j < skeleton.names.size(); ++j) {
      const Vec3 offset_m = skeleton.offsets[j] * motion_.metres_per_unit;
      Quat local = bind_.rotations[j];
      if (j > 0) {
        const auto parent = static_cast<std::size_t>(skeleton.parents[j]);
        local = bind_.rotations[parent].conjugate() * local;
        nodes[parent]["children"].push_back(j);
      }
      nodes.push_back({{"name", skeleton.names[j]},
                       {"translation", Numbers(offset_m)},
                       {"rotation", Numbers(local.normalized())}});
    }
    root_ = 0;
    if (!motion_.canonical_from_source.isApprox(Quat::Identity())) {
      root_ = static_cast<int>(nodes.size());
      nodes.push_back({{"name", "axes"},
                       {"rotation", Numbers(motion_.canonical_from_source.normalized())},
                       {"children", {0}}});
    }
    json_["nodes"] = std::move(nodes);
  }

  void AddMesh() {
    const Mesh mesh(motion_, bind_);
    const int count = mesh.vertices();
    using Shorts = std::span<const std::uint16_t>;
    using Floats = std::span<const float>;
    const json attributes{
        {"POSITION", buffer_.Add(Floats(mesh.positions), count, "VEC3", true, true)},
        {"NORMAL", buffer_.Add(Floats(mesh.normals), count, "VEC3", true)},
        {"JOINTS_0", buffer_.Add(Shorts(mesh.joints), count, "VEC4", true)},
        {"WEIGHTS_0", buffer_.Add(Floats(mesh.weights), count, "VEC4", true)}};
    json_["meshes"] = {
        {{"name", "bones"}, {"primitives", {{{"attributes", attributes}, {"material", 0}}}}}};
    json_["materials"] = {{{"name", "bone"},
                           {"pbrMetallicRoughness",
                            {{"baseColorFactor", {0.55, 0.6, 0.7, 1.0}},
                             {"metallicFactor", 0.0},
                             {"roughnessFactor", 0.8}}}}};
    std::vector<float> inverse;
    json joints = json::array();
    for (std::size_t j = 0; j < bind_.rotations.size(); ++j) {
      Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
      const Quat turn = bind_.rotations[j].conjugate();
      matrix.topLeftCorner<3, 3>() = turn.toRotationMatrix();
      matrix.topRightCorner<3, 1>() = -(turn * bind_.positions_m[j]);
      inverse.insert(inverse.end(), matrix.data(), matrix.data() + matrix.size());
      joints.push_back(j);
    }
    const int matrices = buffer_.Add(Floats(inverse), static_cast<int>(joints.size()), "MAT4");
    json_["skins"] = {{{"joints", joints}, {"skeleton", 0}, {"inverseBindMatrices", matrices}}};
    const auto node = json_["nodes"].size();
    json_["nodes"].push_back({{"name", "figure"}, {"mesh", 0}, {"skin", 0}});
    json_["scenes"] = {{{"nodes", {root_, node}}}};
    json_["scene"] = 0;
  }

  void AddAnimation() {
    const int input = buffer_.Add(std::span<const float>(times_.seconds),
                                  static_cast<int>(times_.seconds.size()), "SCALAR", false, true);
    json channels = json::array(), samplers = json::array();
    const auto add = [&](std::size_t joint, const char* path, std::span<const float> values,
                         const char* type) {
      const int output = buffer_.Add(values, static_cast<int>(times_.frames.size()), type);
      channels.push_back(
          {{"sampler", samplers.size()}, {"target", {{"node", joint}, {"path", path}}}});
      samplers.push_back({{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
    };
    for (std::size_t j = 0; j < motion_.skeleton.names.size(); ++j) {
      add(j, "rotation", Rotations(j), "VEC4");
      if (j == 0 || Moves(j)) add(j, "translation", Translations(j), "VEC3");
    }
    json_["animations"] = {
        {{"name", motion_.name}, {"channels", channels}, {"samplers", samplers}}};
  }

  std::vector<float> Rotations(std::size_t joint) const {
    std::vector<float> values;
    Quat last = Quat::Identity();
    for (const std::size_t frame : times_.frames) {
      Quat q = motion_.frames[frame].rotations[joint].normalized();
      if (q.dot(last) < 0) q.coeffs() = -q.coeffs();  // the shorter way between two frames
      values.insert(values.end(), q.coeffs().data(), q.coeffs().data() + 4);
      last = q;
    }
    return values;
  }

  std::vector<float> Translations(std::size_t joint) const {
    std::vector<float> values;
    for (const std::size_t frame : times_.frames) {
      for (const float value : motion_.frames[frame].translations[joint]) {
        values.push_back(value * motion_.metres_per_unit);
      }
    }
    return values;
  }

  bool Moves(std::size_t joint) const {
    return std::any_of(motion_.frames.begin(), motion_.frames.end(), [&](const auto& frame) {
      return frame.translations[joint] != motion_.skeleton.offsets[joint];
    });
  }

  Result<std::vector<std::byte>> Join() {
    json_["asset"] = {{"version", "2.0"}, {"generator", "styled"}};
    json_["buffers"] = {{{"byteLength", buffer_.bytes().size()}}};
    json_["bufferViews"] = std::move(buffer_.views);
    json_["accessors"] = std::move(buffer_.accessors);
    // Joint names may not be valid UTF-8: invalid bytes are replaced.
    std::string text = json_.dump(-1, ' ', false, json::error_handler_t::replace);
    return JoinGlb(std::move(text), buffer_.bytes());
  }

  const Motion& motion_;
  BindPose bind_;
  KeyTimes times_;
  Buffer buffer_;
  json json_;
  int root_ = 0;
};

}  // namespace

Status CheckMotion(const Motion& motion) {
  const auto& skeleton = motion.skeleton;
  const std::size_t joints = skeleton.names.size();
  if (joints == 0 || motion.frames.empty()) {
    return Status::Error("found a motion without joints or frames, expected both");
  }
  if (skeleton.parents.size() != joints || skeleton.offsets.size() != joints || joints > 65535 ||
      (!motion.rest.empty() && motion.rest.size() != joints) ||
      (!motion.times_s.empty() && motion.times_s.size() != motion.frames.size())) {
    return Status::Error(
        "found sizes that differ, expected one parent, offset and rest per joint "
        "and one time per frame");
  }
  if (motion.times_s.empty() && !(motion.rate_hz > 0 && std::isfinite(motion.rate_hz))) {
    return Status::Error("found a rate of " + NumberText(motion.rate_hz) +
                         " Hz, expected one above 0");
  }
  if (!(motion.metres_per_unit > 0) || !std::isfinite(motion.metres_per_unit)) {
    return Status::Error("found a unit of no length, expected metres per unit above 0");
  }
  for (std::size_t j = 0; j < joints; ++j) {
    const int parent = skeleton.parents[j];
    if (j == 0 ? parent != -1 : parent < 0 || parent >= static_cast<int>(j)) {
      return Status::Error("joint " + std::to_string(j) + ": found parent " +
                           std::to_string(parent) + ", expected an earlier joint");
    }
    if (!skeleton.offsets[j].allFinite()) {
      return Status::Error("joint " + std::to_string(j) + ": offset is not finite");
    }
  }
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    const auto& frame = motion.frames[i];
    const std::string name = "frame " + std::to_string(i);
    if (frame.rotations.size() != joints || frame.translations.size() != joints) {
      return Status::Error(name + ": found another number of joints than the skeleton's");
    }
    for (std::size_t j = 0; j < joints; ++j) {
      const float square = frame.rotations[j].squaredNorm();
      if (!frame.translations[j].allFinite() || !std::isfinite(square) || square < 1e-12F) {
        return Status::Error(name + ", joint " + std::to_string(j) + ": is not a pose");
      }
    }
    if (motion.times_s.empty()) continue;
    if (!std::isfinite(motion.times_s[i]) ||
        (i > 0 && motion.times_s[i] <= motion.times_s[i - 1])) {
      return Status::Error(name + ": found a time not after the last, expected times that grow");
    }
  }
  return Status::Ok();
}

KeyTimes TimesOf(const Motion& motion) {
  KeyTimes times;
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    const auto seconds =
        static_cast<float>(motion.times_s.empty() ? static_cast<double>(i) / motion.rate_hz
                                                  : motion.times_s[i] - motion.times_s.front());
    if (i > 0 && seconds <= times.seconds.back()) continue;
    times.frames.push_back(i);
    times.seconds.push_back(seconds);
  }
  return times;
}

Result<std::vector<std::byte>> FormatGlb(const Motion& motion) {
  const Status status = CheckMotion(motion);
  if (!status.ok()) return status;
  return Document(motion).Make();
}

Result<std::vector<std::byte>> JoinGlb(std::string text, std::span<const std::byte> binary) {
  while (text.size() % 4 != 0) text += ' ';
  const std::uint64_t size = 12 + 8 + text.size() + 8 + binary.size();
  if (size > kMaxSize) return Status::Error("found more than 4 GiB, expected less");
  std::vector<std::byte> glb;
  glb.reserve(size);
  const auto put = [&glb](std::uint64_t value) {
    for (int shift = 0; shift < 32; shift += 8) {
      glb.push_back(static_cast<std::byte>(value >> shift & 0xFFU));
    }
  };
  put(0x46546C67);  // "glTF"
  put(2);
  put(size);
  put(text.size());
  put(0x4E4F534A);  // "JSON"
  const auto bytes = std::as_bytes(std::span(text));
  glb.insert(glb.end(), bytes.begin(), bytes.end());
  put(binary.size());
  put(0x004E4942);  // "BIN"
  glb.insert(glb.end(), binary.begin(), binary.end());
  return glb;
}

Status WriteBytes(std::span<const std::byte> value, const std::filesystem::path& file) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "wb"),
                                                         &std::fclose);
  if (!stream) {
    return Status::Error(file.string() + ": cannot be opened for writing: " +
                         std::generic_category().message(errno));
  }
  const bool written = std::fwrite(value.data(), 1, value.size(), stream.get()) == value.size();
  if (std::fclose(stream.release()) != 0 || !written) {
    return Status::Error(file.string() + ": found no room for " + std::to_string(value.size()) +
                         " bytes, expected the whole motion to fit");
  }
  return Status::Ok();
}

Status WriteGlb(const Motion& motion, const std::filesystem::path& file) {
  const auto bytes = FormatGlb(motion);
  if (!bytes.ok()) return Status::Error(file.string() + ": " + bytes.status().message());
  return WriteBytes(bytes.value(), file);
}

}  // namespace styled::clip

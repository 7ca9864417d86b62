// Writes small animations of the humanoid as seeds of gltf_fuzz: glTF binary by names, with packed
// data, and VRM Animation by its table.
#include <meshoptimizer.h>

#include <cstring>
#include <span>
#include <string>

#include "model/body/humanoid.h"
#include "model/clip/glb_write.h"
#include "tests/fuzz/write_seeds.h"

namespace {

using namespace styled;

std::vector<std::byte> Glb(int frames) {
  clip::Motion motion;
  motion.rate_hz = 10;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    motion.skeleton.names.emplace_back(body::kHumanoid[static_cast<std::size_t>(joint)].name);
    motion.skeleton.parents.push_back(body::kHumanoid[static_cast<std::size_t>(joint)].parent);
    motion.skeleton.offsets.push_back(body::Offset(joint));
  }
  for (int frame = 0; frame < frames; ++frame) {
    rig::RigPose& pose = motion.frames.emplace_back(motion.skeleton);
    pose.rotations[3] =
        rig::Quat(Eigen::AngleAxisf(0.1F * static_cast<float>(frame), rig::Vec3::UnitX()));
  }
  auto bytes = clip::FormatGlb(motion);
  return bytes.ok() ? bytes.value() : std::vector<std::byte>();
}

// A .glb of this JSON and, if there is one, this binary chunk.
std::vector<std::byte> WithText(std::string text, const std::string& data = "") {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<std::byte> bytes(20 + text.size() + (data.empty() ? 0 : 8 + data.size()));
  const auto word = [&bytes](std::size_t at, std::size_t value) {
    const auto word = static_cast<std::uint32_t>(value);
    std::memcpy(bytes.data() + at, &word, 4);
  };
  std::memcpy(bytes.data(), "glTF", 4);
  word(4, 2);
  word(8, bytes.size());
  word(12, text.size());
  word(16, 0x4E4F534A);
  std::memcpy(bytes.data() + 20, text.data(), text.size());
  if (data.empty()) return bytes;
  word(20 + text.size(), data.size());
  word(24 + text.size(), 0x004E4942);
  std::memcpy(bytes.data() + 28 + text.size(), data.data(), data.size());
  return bytes;
}

// The hips turned, by rows of 8 bytes that EXT_meshopt_compression packs, with this filter.
std::vector<std::byte> Packed(const std::string& filter) {
  constexpr std::size_t kRows = 20, kStride = 8;
  const float times_s[kRows] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,
                                10, 11, 12, 13, 14, 15, 16, 17, 18, 19};
  float turns[4 * kRows];
  for (std::size_t i = 0; i < 4 * kRows; ++i) turns[i] = 0.5F;
  std::string rows(kRows * kStride, '\0'), data(sizeof times_s, '\0');
  meshopt_encodeFilterQuat(rows.data(), kRows, kStride, 16, turns);
  std::memcpy(data.data(), times_s, sizeof times_s);
  std::string packed(meshopt_encodeVertexBufferBound(kRows, kStride), '\0');
  packed.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(packed.data()),
                                           packed.size(), rows.data(), kRows, kStride));
  return WithText(
      R"({"asset":{"version":"2.0"},"nodes":[{"name":"hips"}],"animations":[{"channels":)"
      R"([{"sampler":0,"target":{"node":0,"path":"rotation"}}],"samplers":)"
      R"([{"input":0,"output":1}]}],"buffers":[{},{}],"accessors":[)"
      R"({"bufferView":0,"componentType":5126,"count":20,"type":"SCALAR"},)"
      R"({"bufferView":1,"componentType":5122,"normalized":true,"count":20,"type":"VEC4"}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":80},{"buffer":1,"byteLength":160,"extensions":)"
      R"({"EXT_meshopt_compression":{"buffer":0,"byteOffset":80,"byteStride":8,"count":20,)"
      R"("mode":"ATTRIBUTES","filter":")" +
          filter + R"(","byteLength":)" + std::to_string(packed.size()) + "}}}]}",
      data + packed);
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::WriteSeeds(
      argc, argv,
      {Glb(1), Glb(3), Packed("NONE"), Packed("QUATERNION"), Packed("OCTAHEDRAL"),
       Packed("EXPONENTIAL"),
       WithText(
           R"({"asset":{"version":"2.0"},"nodes":[{"name":"hips","children":[1]},)"
           R"({"name":"b","matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}],)"
           R"("extensions":{"VRMC_vrm_animation":{"humanoid":{"humanBones":)"
           R"({"hips":{"node":0},"head":{"node":1}}}}},"animations":[{"channels":)"
           R"([{"sampler":0,"target":{"node":0,"path":"rotation"}}],"samplers":)"
           R"([{"input":0,"output":1,"interpolation":"CUBICSPLINE"}]}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":1,"type":"SCALAR"}]})")});
}

// Writes small animations of the humanoid as seeds of gltf_fuzz: glTF binary by names, and VRM
// Animation by its table.
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

// `text` in place of the JSON of a .glb.
std::vector<std::byte> WithText(std::string text) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<std::byte> bytes(20 + text.size());
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
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::WriteSeeds(
      argc, argv,
      {Glb(1), Glb(3),
       WithText(
           R"({"asset":{"version":"2.0"},"nodes":[{"name":"hips","children":[1]},)"
           R"({"name":"b","matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}],)"
           R"("extensions":{"VRMC_vrm_animation":{"humanoid":{"humanBones":)"
           R"({"hips":{"node":0},"head":{"node":1}}}}},"animations":[{"channels":)"
           R"([{"sampler":0,"target":{"node":0,"path":"rotation"}}],"samplers":)"
           R"([{"input":0,"output":1,"interpolation":"CUBICSPLINE"}]}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":1,"type":"SCALAR"}]})")});
}

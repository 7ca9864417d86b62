// Reads clips as examples of styles are read, and says how far the joints are from expected.json:
// `gltf_read_back FOLDER FILE...`. Files that three.js and the web page have written are among
// them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "model/body/pose.h"
#include "model/clip/gltf_clip.h"

namespace {

using nlohmann::json;

constexpr float kMost_m = 0.01F;

std::string ReadAll(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// The largest distance of a joint, m; negative after an error.
float Worst(const std::filesystem::path& file, const json& expected) {
  const auto clip = styled::clip::ParseGltfClip(ReadAll(file), file.filename());
  if (!clip.ok()) return std::printf("%s\n", clip.status().message().c_str()), -1;
  const auto bound = styled::clip::BindGltf(clip.value());
  if (!bound.ok()) return std::printf("%s\n", bound.status().message().c_str()), -1;
  const auto poses = styled::clip::ToCanonical(clip.value().clip, bound.value());
  float worst = 0;
  for (std::size_t k = 0; k < expected["times"].size(); ++k) {
    const auto frame = static_cast<std::size_t>(
        std::lround(expected["times"][k].get<double>() * clip.value().clip.rate_hz));
    styled::body::WorldPose world;
    styled::body::ForwardKinematics(poses[std::min(frame, poses.size() - 1)], world);
    for (std::size_t joint = 0; joint < world.positions_m.size(); ++joint) {
      const json& place = expected["metres"][k][joint];
      const styled::body::Vec3 wanted(place[0], place[1], place[2]);
      worst = std::max(worst, (world.positions_m[joint] - wanted).norm());
    }
  }
  return worst;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const std::filesystem::path folder = argv[1];
  for (int i = 2; i < argc; ++i) {
    if (!std::filesystem::exists(folder / argv[i])) {
      std::printf("skipped, there is no %s\n", argv[i]);
      return 77;
    }
  }
  const json expected = json::parse(ReadAll(folder / "expected.json"));
  bool failed = false;
  for (int i = 2; i < argc; ++i) {
    const float worst = Worst(folder / argv[i], expected);
    const bool good = worst >= 0 && worst < kMost_m;
    std::printf("%s: %s: joints are within %g m\n", good ? "ok" : "FAILED", argv[i],
                static_cast<double>(worst));
    failed = failed || !good;
  }
  return failed ? 1 : 0;
}

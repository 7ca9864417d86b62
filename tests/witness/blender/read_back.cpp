// Prints how our reader reads each BVH file of a folder: `bvh_read_back FOLDER`. JSON: by file name
// either "error", or "hz", "remark" and "joints", by joint its place in each frame, in the file's
// unit and axes.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/clip/clip.h"
#include "model/rig/skeleton.h"

namespace {

using nlohmann::json;

json Read(const std::filesystem::path& file) {
  const auto read = styled::clip::ReadBvh(file);
  if (!read.ok()) return {{"error", read.status().message()}};
  const styled::clip::Clip& clip = read.value();
  json joints = json::object();
  std::vector<styled::rig::Vec3> places;
  std::vector<styled::rig::Quat> rotations;
  for (const styled::rig::RigPose& frame : clip.frames) {
    styled::rig::WorldTransforms(clip.skeleton, frame, places, rotations);
    for (std::size_t j = 0; j < places.size(); ++j) {
      joints[clip.skeleton.names[j]].push_back({places[j].x(), places[j].y(), places[j].z()});
    }
  }
  return {{"hz", clip.rate_hz}, {"remark", clip.remark}, {"joints", joints}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  json all = json::object();
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
    if (entry.path().extension() != ".bvh") continue;
    all[entry.path().stem().string()] = Read(entry.path());
  }
  std::printf("%s\n", all.dump(1, ' ', true, json::error_handler_t::replace).c_str());
  return 0;
}

#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "model/clip/clip.h"
#include "tests/unit/train/walker.h"

namespace styled::train {

// A folder with BVH clips of two styles and two contents, and their manifest; removed at the end.
class MadeUpSet {
 public:
  explicit MadeUpSet(const std::string& name)
      : root_(std::filesystem::temp_directory_path() / (name + std::to_string(::getpid()))) {
    for (const char* folder : {"set-train", "set-val"}) {
      std::filesystem::create_directories(root_ / folder);
    }
    int phase = 0;
    for (const std::string style : {"plain", "odd"}) {
      for (const std::string content : {"walk", "wave"}) {
        for (int take = 1; take <= 4; ++take) Write(style, content, take, ++phase);
      }
    }
    std::ofstream(manifest()) << R"(
name = "made-up"
licence = "none"
neutral = "neutral"
styles = [ { name = "neutral", labels = ["plain"], aliases = [] },
           { name = "odd", labels = ["odd"], aliases = ["strange"] } ]
contents = [ { name = "walk", labels = ["walk"] }, { name = "wave", labels = ["wave"] } ]
[[clips]]
pattern = "set-train/{content}_{style}_{take}.bvh"
rig = "canonical"
split = "train"
[[clips]]
pattern = "set-val/{content}_{style}_{take}.bvh"
rig = "canonical"
split = "validation"
)";
  }
  ~MadeUpSet() { std::filesystem::remove_all(root_); }
  MadeUpSet(const MadeUpSet&) = delete;
  MadeUpSet& operator=(const MadeUpSet&) = delete;

  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path manifest() const { return root_ / "manifest.toml"; }

 private:
  void Write(const std::string& style, const std::string& content, int take, int phase) {
    const TrainingClip walker = Walker(80, static_cast<float>(phase));
    clip::Clip clip;
    for (const body::JointRow& row : body::kHumanoid) {
      clip.skeleton.names.emplace_back(row.name);
      clip.skeleton.parents.push_back(row.parent);
      clip.skeleton.offsets.emplace_back(row.x_m, row.y_m, row.z_m);
    }
    for (body::Pose pose : walker.poses) {
      if (style == "odd") {  // stooped
        pose.rotations[body::kSpine] =
            pose.rotations[body::kSpine] * body::Exp(body::Vec3(0.6F, 0, 0));
      }
      rig::RigPose frame(clip.skeleton);
      frame.translations[0] = pose.hips_position_m;
      frame.rotations.assign(pose.rotations.begin(), pose.rotations.end());
      clip.frames.push_back(frame);
    }
    const std::string name = content + "_" + style + "_" + std::to_string(take) + ".bvh";
    ASSERT_TRUE(clip::WriteBvh(clip, root_ / (take < 4 ? "set-train" : "set-val") / name).ok());
  }

  std::filesystem::path root_;
};

}  // namespace styled::train

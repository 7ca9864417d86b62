// Every naming convention, wherever a skeleton comes from: clips, rigs, avatars.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/perform/performer/body_binding.h"
#include "model/clip/avatar.h"
#include "model/clip/bind_clip.h"
#include "model/clip/glb_write.h"
#include "model/clip/gltf_clip.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/rig/random_bodies.h"
#include "tests/unit/rig/rigs.h"

namespace styled::pipeline {
namespace {

using body::kJointCount;
using rig::Quat;
using rig::Vec3;

// A body in metres that moves, its joints named by a convention.
clip::Motion Moving(const rig::Convention& convention) {
  clip::Motion motion;
  motion.skeleton = rig::HumanoidSkeleton();
  for (int c = 0; c < kJointCount; ++c) {
    motion.skeleton.names[static_cast<std::size_t>(c)] = rig::NameBy(convention, c);
  }
  motion.rate_hz = 30;
  body::Random random(7);
  for (int i = 0; i < 30; ++i) {
    rig::RigPose frame(motion.skeleton);
    for (Quat& rotation : frame.rotations) rotation = random.Turn(0.3F);
    motion.frames.push_back(frame);
  }
  return motion;
}

// The worst angle of a joint of the bound frames from the control's, degrees.
float Worst_deg(const rig::Binding& binding, const std::vector<rig::RigPose>& frames,
                const std::vector<rig::RigPose>& control_frames) {
  const rig::Binding control = rig::Binding::Make(rig::HumanoidSpec()).value();
  float worst = 0;
  body::Pose pose, expected;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    binding.Bind(frames[i], pose);
    control.Bind(control_frames[i], expected);
    for (int c = 0; c < kJointCount; ++c) {
      worst = std::max(
          worst, static_cast<float>(body::Angle_rad(pose.rotations[c], expected.rotations[c])));
    }
  }
  return worst * 57.29578F;
}

std::string Cell(const Result<rig::Binding>& binding, const std::vector<rig::RigPose>& frames,
                 const std::vector<rig::RigPose>& control) {
  if (!binding.ok()) return "refused: " + binding.status().message();
  const float worst_deg = Worst_deg(binding.value(), frames, control);
  char text[32];
  std::snprintf(text, sizeof text, worst_deg < 1 ? "right" : "%.0f degrees off",
                static_cast<double>(worst_deg));
  return text;
}

Result<rig::Binding> Bound(const Result<clip::BoundClip>& bound) {
  if (!bound.ok()) return bound.status();
  return bound.value().binding;
}

Result<rig::Binding> Avatar(const std::string& file) {
  const auto avatar = clip::ReadAvatar(file, "auto", {});
  if (!avatar.ok()) return avatar.status();
  return *avatar.value().binding;
}

Result<rig::Binding> Live(const rig::Skeleton& skeleton) {
  v1::Body body;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    body.add_names(skeleton.names[at]);
    body.add_parents(skeleton.parents[at]);
    for (int axis = 0; axis < 3; ++axis) body.add_offsets(skeleton.offsets[at][axis]);
  }
  body.set_dialect("auto");
  const auto bound = BindBody(body, std::nullopt);
  if (!bound.ok()) return bound.status();
  return *bound.value().binding;
}

TEST(Conventions, BindRightWhereverTheyComeFrom) {
  const support::TemporaryFolder folder;
  std::ostringstream table;
  table << "| tool | hips, upper arm, thigh | clip, BVH | clip, glTF | live | avatar, glTF | "
           "avatar, BVH |\n|---|---|---|---|---|---|---|\n";
  for (const rig::Convention& convention : rig::Conventions()) {
    const clip::Motion motion = Moving(convention);
    const auto& control = motion.frames;
    const auto text = clip::ParseBvh(clip::FormatBvh(motion), "clip.bvh");
    ASSERT_TRUE(text.ok()) << text.status().message();
    const std::string glb = folder / "body.glb", bvh = folder / "body.bvh";
    ASSERT_TRUE(clip::WriteGlb(motion, glb).ok());
    ASSERT_TRUE(clip::WriteBvh(motion, bvh).ok());
    std::ifstream file(glb, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    const auto gltf = clip::ParseGltfClip(bytes, "clip.glb");

    const std::vector<std::string> cells = {
        Cell(Bound(clip::BindClip(text.value())), text.value().frames, control),
        gltf.ok() ? Cell(clip::BindGltf(gltf.value()), gltf.value().clip.frames, control)
                  : "refused: " + gltf.status().message(),
        Cell(Live(motion.skeleton), motion.frames, control),
        Cell(Avatar(glb), motion.frames, control),
        Cell(Avatar(bvh), motion.frames, control),
    };
    table << "| " << convention.tool << " | `" << rig::NameBy(convention, body::kHips) << "`, `"
          << rig::NameBy(convention, body::kLeftUpperArm) << "`, `"
          << rig::NameBy(convention, body::kLeftUpperLeg) << "` |";
    for (const std::string& cell : cells) {
      EXPECT_EQ(cell, "right") << convention.tool;
      table << " " << cell << " |";
    }
    table << "\n";
  }
  const std::string document = STYLED_CONVENTIONS;
  constexpr const char* kHead =
      "# Names of joints that are understood\n\n"
      "Written by `STYLED_WRITE=1 build/release/bin/styled_conventions_test`, from what it "
      "measured. *Right*: every joint of a\nmoving body is within a degree of the same body under "
      "VRM's names, without `--joints`. Other names are found by the\ntree alone where it leaves "
      "no "
      "choice, as in the last two rows; `stylize --explain CLIP` shows how.\n\n";
  if (std::getenv("STYLED_WRITE") != nullptr) std::ofstream(document) << kHead << table.str();
  std::ifstream written(document);
  const std::string found{std::istreambuf_iterator<char>(written),
                          std::istreambuf_iterator<char>()};
  EXPECT_EQ(found, kHead + table.str()) << "write it again: STYLED_WRITE=1";
}

}  // namespace
}  // namespace styled::pipeline

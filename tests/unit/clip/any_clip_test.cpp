// Clips of any format: found by their first bytes, bound by what each states.
#include "model/clip/any_clip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "model/clip/glb_write.h"
#include "model/synthetic/performer.h"
#include "tests/support/temporary_folder.h"

namespace styled::clip {
namespace {

using testing::HasSubstr;

constexpr double kAnyRate_hz = 30;

// A walk of the canonical humanoid, with blanks in its names.
Motion NamedWalk() {
  Motion motion;
  motion.rate_hz = kAnyRate_hz;
  for (const body::JointRow& row : body::kHumanoid) {
    motion.skeleton.names.push_back(std::string(row.name) + " of her");
    motion.skeleton.parents.push_back(row.parent);
    motion.skeleton.offsets.emplace_back(row.x_m, row.y_m, row.z_m);
  }
  synthetic::Performer performer{synthetic::Options{}};
  body::Pose pose;
  for (int i = 0; i < 40; ++i) {
    performer.Pose(i / kAnyRate_hz, pose);
    rig::RigPose frame(motion.skeleton);
    frame.translations[0] = pose.hips_position_m;
    frame.rotations.assign(pose.rotations.begin(), pose.rotations.end());
    motion.frames.push_back(std::move(frame));
  }
  return motion;
}

std::string GlbBytes(const Motion& motion) {
  const auto bytes = FormatGlb(motion).value();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string AnyRefusal(const std::string& bytes) {
  const auto clip = ParseAnyClip(bytes, "x");
  return clip.ok() ? "accepted" : clip.status().message();
}

TEST(AnyClip, RefusesOtherFormatsByName) {
  for (const auto& [bytes, found] : std::vector<std::pair<std::string, std::string>>{
           {"Kaydara FBX Binary  ", "x: found FBX, expected BVH, glTF binary (.glb) or VRMA"},
           {"{\"asset\":{}}", "x: found glTF as text, expected"},
           {"PK\x03\x04", "x: found a ZIP archive, expected"},
           {"glTF", "x: "},
           {"", "x:1: found the end, expected HIERARCHY"}}) {
    EXPECT_THAT(AnyRefusal(bytes), HasSubstr(found));
  }
}

// Its name says glTF: a complaint about BVH would mislead. A BVH of that name is read.
TEST(AnyClip, AFileThatIsNoGltfDespiteItsNameIsNotCalledABadBvh) {
  const support::TemporaryFolder folder;
  for (const char* name : {"walk.glb", "walk.vrma"}) {
    std::ofstream(folder / name) << "torn";
    EXPECT_THAT(ReadAnyClip(folder / name).status().message(),
                HasSubstr("that does not begin as glTF, expected BVH, glTF binary (.glb) or VRMA"));
    std::ofstream(folder / name)
        << "HIERARCHY\nROOT Hips\n{\nOFFSET 0 90 0\nCHANNELS 6 Xposition Yposition Zposition "
           "Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 10 0\n}\n}\n"
           "MOTION\nFrames: 1\nFrame Time: 0.033333\n0 90 0 0 0 0\n";
    const auto read = ReadAnyClip(folder / name);
    EXPECT_TRUE(read.ok()) << read.status().message();
  }
}

TEST(AnyClip, GltfStatesItsAxesAndHowItStands) {
  const auto clip = ParseAnyClip(GlbBytes(NamedWalk()), "walk.glb");
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  EXPECT_TRUE(clip.value().is_gltf);
  BindOptions options;
  options.rest.kind = RestPose::Kind::kStanding;
  EXPECT_THAT(BindAnyClip(clip.value(), options).status().message(), HasSubstr("expected auto"));
  options = {};
  options.up = rig::Vec3::UnitZ();
  EXPECT_THAT(BindAnyClip(clip.value(), options).status().message(), HasSubstr("expected auto"));
  EXPECT_EQ(BindAnyClip(clip.value()).value().dialect, "gltf");
}

// The same motion, whichever file it comes from, and also by way of BVH.
TEST(AnyClip, AMotionIsTheSameOfEachFormat) {
  const support::TemporaryFolder folder;
  const Motion walk = NamedWalk();
  ASSERT_TRUE(WriteGlb(walk, folder / "walk.glb").ok());
  const auto read = ReadAnyClip(folder / "walk.glb");
  ASSERT_TRUE(read.ok()) << read.status().message();
  const auto bound = BindAnyClip(read.value());
  ASSERT_TRUE(bound.ok()) << bound.status().message();

  const Clip bvh = AsBvh(read.value().clip, bound.value().binding);
  EXPECT_EQ(bvh.skeleton.names[1], "spine_of_her");
  EXPECT_EQ(bvh.skeleton.offsets[0], rig::Vec3::Zero());
  ASSERT_TRUE(WriteBvh(bvh, folder / "walk.bvh").ok());
  const auto again = ReadAnyClip(folder / "walk.bvh", {.longest_s = 1, .work = {}});
  ASSERT_TRUE(again.ok()) << again.status().message();
  EXPECT_FALSE(again.value().is_gltf);
  EXPECT_EQ(again.value().clip.frames.size(), 31U);
  EXPECT_EQ(again.value().clip.remark, "only its first 1 s are read");
  const auto rebound = BindAnyClip(again.value());
  ASSERT_TRUE(rebound.ok()) << rebound.status().message();

  const auto poses = ToCanonical(read.value().clip, bound.value().binding);
  const auto same = ToCanonical(again.value().clip, rebound.value().binding);
  ASSERT_EQ(poses.size(), walk.frames.size());
  for (std::size_t i = 0; i < same.size(); ++i) {
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      EXPECT_LT(poses[i].rotations[j].angularDistance(walk.frames[i].rotations[j]), 2e-3F);
      EXPECT_LT(same[i].rotations[j].angularDistance(walk.frames[i].rotations[j]), 2e-3F);
    }
    EXPECT_LT((poses[i].hips_position_m - walk.frames[i].translations[0]).norm(), 1e-3F);
    EXPECT_LT((same[i].hips_position_m - walk.frames[i].translations[0]).norm(), 1e-3F);
  }
}

}  // namespace
}  // namespace styled::clip

// The VRM animations that are written, read back by the reader of clips. Programs that are not ours
// read them in tests/witness/gltf.
#include "model/clip/vrma_write.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "model/clip/gltf_clip.h"
#include "model/synthetic/performer.h"

namespace styled::clip {
namespace {

using testing::HasSubstr;

constexpr int kVrmaFrames = 40;

// A walk of the humanoid in centimetres, Z up, below a joint that moves and turns.
struct Carried {
  Motion motion;
  std::vector<body::Pose> poses;
};
Carried CarriedWalk() {
  Carried carried;
  Motion& motion = carried.motion;
  motion.name = "walk \xFF";
  motion.rate_hz = 30;
  motion.metres_per_unit = 0.01F;
  const rig::Quat up = body::Quat::FromTwoVectors(body::Vec3::UnitZ(), body::Vec3::UnitY());
  motion.canonical_from_source = up;
  motion.skeleton = {{"root"}, {-1}, {rig::Vec3::Zero()}};
  for (const body::JointRow& row : body::kHumanoid) {
    motion.skeleton.names.emplace_back(row.name);
    motion.skeleton.parents.push_back(row.parent + 1);
    motion.skeleton.offsets.push_back(up.conjugate() * rig::Vec3(row.x_m, row.y_m, row.z_m) * 100);
  }
  synthetic::Performer performer{synthetic::Options{}};
  const rig::Quat turn(Eigen::AngleAxisf(0.5F, rig::Vec3::UnitZ()));
  for (int i = 0; i < kVrmaFrames; ++i) {
    body::Pose& pose = carried.poses.emplace_back();
    performer.Pose(i / motion.rate_hz, pose);
    rig::RigPose frame(motion.skeleton);
    frame.translations[0] = rig::Vec3(10, 20, 0);
    frame.rotations[0] = turn;
    const rig::Vec3 hips = up.conjugate() * pose.hips_position_m * 100;
    frame.translations[1] = turn.conjugate() * (hips - frame.translations[0]);
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      frame.rotations[j + 1] = up.conjugate() * pose.rotations[j] * up;
    }
    frame.rotations[1] = turn.conjugate() * frame.rotations[1];
    motion.frames.push_back(std::move(frame));
  }
  return carried;
}

std::string VrmaBytes(const Motion& motion) {
  const auto bytes = FormatVrma(motion);
  EXPECT_TRUE(bytes.ok()) << bytes.status().message();
  if (!bytes.ok()) return "";
  return {reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size()};
}

TEST(VrmaWrite, RefusesOneThatIsNoHumanoidAndWhatGlbRefuses) {
  Motion tail;
  tail.skeleton = {{"hips", "tail"}, {-1, 0}, {rig::Vec3::Zero(), rig::Vec3::UnitX()}};
  EXPECT_THAT(FormatVrma(tail).status().message(), HasSubstr("found a motion without joints or"));
  tail.frames.assign(3, rig::RigPose(tail.skeleton));
  EXPECT_THAT(FormatVrma(tail).status().message(),
              HasSubstr("found no humanoid, of which a VRM animation is: "));
  EXPECT_THAT(WriteVrma(tail, "/tmp/x.vrma").message(), HasSubstr("/tmp/x.vrma: found no"));
  tail.frames[1].rotations[1].coeffs().setZero();
  EXPECT_THAT(FormatVrma(tail).status().message(), HasSubstr("frame 1, joint 1: is not a pose"));
}

TEST(VrmaWrite, EveryJointIsWhereItWasWhateverCarriesTheHips) {
  const Carried carried = CarriedWalk();
  const auto read = ParseGltfClip(VrmaBytes(carried.motion), "walk.vrma");
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_TRUE(read.value().skeleton.t_pose) << "by VRM's table of bones";
  EXPECT_EQ(read.value().clip.remark, "");
  const auto bound = BindGltf(read.value());
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  const auto poses = ToCanonical(read.value().clip, bound.value());
  ASSERT_EQ(poses.size(), carried.poses.size());
  float next = 0;
  body::WorldPose found, expected;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    body::ForwardKinematics(poses[i], found);
    body::ForwardKinematics(carried.poses[i], expected);
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      EXPECT_LT((found.positions_m[j] - expected.positions_m[j]).norm(), 1e-3F) << i << " " << j;
    }
    body::ForwardKinematics(carried.poses[(i + 1) % poses.size()], expected);
    next = std::max(next, (found.positions_m[0] - expected.positions_m[0]).norm());
  }
  EXPECT_GT(next, 0.01F) << "a frame beside it would be as near";
}

TEST(VrmaWrite, TheHipsAloneAreMovedAndKeysAreAtTheFramesTimes) {
  Motion motion = CarriedWalk().motion;
  for (int i = 0; i < kVrmaFrames; ++i) motion.times_s.push_back(7 + 0.1 * i * i);
  const std::string bytes = VrmaBytes(motion);
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, 4);
  const auto file = nlohmann::json::parse(bytes.substr(20, size));
  int moved = 0;
  for (const auto& channel : file["animations"][0]["channels"]) {
    const bool moves = channel["target"]["path"] == "translation";
    moved += moves ? 1 : 0;
    if (!moves) continue;
    EXPECT_EQ(file["nodes"][channel["target"]["node"].get<int>()]["name"], "hips");
  }
  EXPECT_EQ(moved, 1);
  EXPECT_EQ(file["accessors"][0]["count"], kVrmaFrames);
  EXPECT_NEAR(file["accessors"][0]["max"][0].get<double>(), 0.1 * 39 * 39, 1e-3);
  EXPECT_EQ(file["extensions"]["VRMC_vrm_animation"]["humanoid"]["humanBones"].size(),
            body::kJointCount);
}

}  // namespace
}  // namespace styled::clip

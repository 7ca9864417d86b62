#include "clients/vmc/puppet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "model/rig/tail.h"
#include "proto/rigs/vmc/bones.h"
#include "tests/unit/body/random_pose.h"
#include "tests/unit/clients/fake_daemon.h"
#include "tests/unit/vmc/witness.h"

namespace styled::stylevmc {
namespace {

using body::Quat;
using body::Vec3;

v1::Body Canonical() { return client::HumanoidBody("rig.a", v1::OUTPUT_CANONICAL, 5); }

Vec3 Position(const vmc::Transform& t) { return {t.position[0], t.position[1], t.position[2]}; }
Quat Rotation(const vmc::Transform& t) {
  return {t.rotation[3], t.rotation[0], t.rotation[1], t.rotation[2]};
}

// As a Unity application composes them: each bone on the nearest ancestor that was sent.
std::map<int, vmc::Transform> InTheWorld(const vmc::Packed& packed) {
  vmc::BoneSet sent = 0;
  std::map<int, vmc::Transform> local, world;
  for (const vmc::Bone& bone : packed.bones) {
    const int index = vmc::FindBone(bone.name, false);
    EXPECT_EQ(vmc::kBones[static_cast<std::size_t>(index)].name, bone.name) << "exact spelling";
    sent |= vmc::Bit(index);
    local[index] = bone.transform;
  }
  for (const int bone : vmc::kParentsFirst) {
    if (!vmc::Has(sent, bone)) continue;
    const int parent = vmc::ParentAmong(sent, bone);
    const vmc::Transform& on = parent < 0 ? packed.root.transform : world[parent];
    const Vec3 p = Position(on) + Rotation(on) * Position(local[bone]);
    const Quat q = Rotation(on) * Rotation(local[bone]);
    world[bone] = {{p.x(), p.y(), p.z()}, {q.x(), q.y(), q.z(), q.w()}};
  }
  return world;
}

TEST(Puppet, StandsInUnityWhereTheMirroredHumanoidStands) {
  body::Random random(3);
  for (const Carrier carrier : {Carrier::kHips, Carrier::kRoot}) {
    Puppet puppet(carrier);
    ASSERT_TRUE(puppet.Bind(Canonical()).ok());
    for (int i = 0; i < 50; ++i) {
      const body::Pose pose = random.AnyPose();
      body::WorldPose expected;
      body::ForwardKinematics(pose, expected);
      const auto packed = puppet.Pose(client::HumanoidFrame(Canonical(), pose, 1), 0);
      const auto world = InTheWorld(packed);
      ASSERT_EQ(world.size(), 21U);
      for (int j = 0; j < body::kJointCount; ++j) {
        const auto row = static_cast<std::size_t>(j);
        const auto& got = world.at(vmc::FindBone(body::kHumanoid[row].name, false));
        Vec3 p = expected.positions_m[row];
        p.x() = -p.x();
        EXPECT_NEAR((Position(got) - p).norm(), 0, 2e-5F) << body::kHumanoid[row].name;
        // A mirrored rotation turns mirrored vectors as the old one turned them.
        for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
          const Vec3 mirrored_axis(-axis.x(), axis.y(), axis.z());
          Vec3 turned = expected.rotations[row] * axis;
          turned.x() = -turned.x();
          EXPECT_NEAR((Rotation(got) * mirrored_axis - turned).norm(), 0, 1e-5F);
        }
      }
    }
  }
}

// By hand: the left arm is at Unity's -X, and raised it points up.
TEST(Puppet, RaisesTheLeftArmOfAUnityAvatar) {
  body::Pose pose;
  pose.rotations[body::kLeftUpperArm] = Quat(Eigen::AngleAxisf(1.5707964F, Vec3::UnitZ()));
  Puppet puppet(Carrier::kHips);
  ASSERT_TRUE(puppet.Bind(Canonical()).ok());
  const auto packed = puppet.Pose(client::HumanoidFrame(Canonical(), pose, 1), 0);
  const auto world = InTheWorld(packed);
  const Vec3 shoulder = Position(world.at(vmc::kLeftUpperArm));
  const Vec3 elbow = Position(world.at(vmc::kLeftLowerArm));
  EXPECT_LT(shoulder.x(), 0);
  EXPECT_NEAR((elbow - shoulder - Vec3(0, 0.27F, 0)).norm(), 0, 1e-5F);
  EXPECT_EQ(packed.bones[body::kLeftUpperArm].name, "LeftUpperArm");
}

// The canonical body's fingers are VRM 1.0's, Unity names the thumb's otherwise; the second of
// three is missing, as from a glove of two joints.
TEST(Puppet, SendsFingersEyesAndJawThatTheBodyHasByUnitysNames) {
  v1::Body body = Canonical();
  std::vector<std::string> expected;
  for (int t = 0; t < rig::kTailCount; ++t) {
    if (t % rig::kFingerJoints == 2 && t < rig::kTailLeftEye) continue;
    body.add_names(std::string(rig::kTailNames[static_cast<std::size_t>(t)]));
    body.add_parents(rig::TailAnchor(t));
    for (int axis = 0; axis < 3; ++axis) body.add_offsets(0.01F * static_cast<float>(t + axis));
  }
  v1::Frame frame = client::HumanoidFrame(Canonical(), {}, 1);
  const Quat turn(Eigen::AngleAxisf(0.5F, Vec3(1, 2, 3).normalized()));
  for (int j = body::kJointCount; j < body.names_size(); ++j) {
    for (const float value : std::span(turn.coeffs().data(), 4)) frame.add_rotations(value);
  }
  Puppet puppet(Carrier::kHips);
  ASSERT_TRUE(puppet.Bind(body).ok());
  const auto packed = puppet.Pose(frame, 0);
  ASSERT_EQ(packed.bones.size(), 21U + 20 + 3);
  vmc::BoneSet sent = 0;
  for (const vmc::Bone& bone : packed.bones) {
    const int index = vmc::FindBone(bone.name, false);
    EXPECT_FALSE(vmc::Has(sent, index)) << bone.name << " twice";
    sent |= vmc::Bit(index);
  }
  EXPECT_EQ(packed.bones[21].name, "LeftThumbProximal");
  EXPECT_EQ(packed.bones[22].name, "LeftThumbIntermediate");
  EXPECT_EQ(packed.bones[23].name, "LeftIndexProximal");
  EXPECT_EQ(packed.bones[43].name, "Jaw");
  EXPECT_FALSE(vmc::Has(sent, vmc::FindBone("LeftThumbDistal", false)));
  EXPECT_FALSE(vmc::Has(sent, vmc::FindBone("UpperChest", false)));
  const auto& jaw = packed.bones[43].transform;
  EXPECT_NEAR((Position(jaw) - Vec3(-0.32F, 0.33F, 0.34F)).norm(), 0, 1e-6F);
  EXPECT_NEAR(Rotation(jaw).dot(Quat(turn.w(), turn.x(), -turn.y(), -turn.z())), 1, 1e-6F);
}

TEST(Puppet, CarriesByTheRootOverTheFloorOnly) {
  body::Pose pose;
  pose.hips_position_m = {1, 0.9F, 2};
  const auto frame = client::HumanoidFrame(Canonical(), pose, 1);
  Puppet hips(Carrier::kHips), root(Carrier::kRoot);
  ASSERT_TRUE(hips.Bind(Canonical()).ok());
  ASSERT_TRUE(root.Bind(Canonical()).ok());
  using testing::ElementsAre;
  EXPECT_EQ(hips.Pose(frame, 0).root.transform, vmc::Transform());
  EXPECT_THAT(hips.Pose(frame, 0).bones[0].transform.position, ElementsAre(-1, 0.9F, 2));
  EXPECT_THAT(root.Pose(frame, 0).root.transform.position, ElementsAre(-1, 0, 2));
  EXPECT_THAT(root.Pose(frame, 0).bones[0].transform.position, ElementsAre(0, 0.9F, 0));
}

TEST(Puppet, OnlyAStaleFrameReportsLostTracking) {
  Puppet puppet(Carrier::kHips);
  ASSERT_TRUE(puppet.Bind(Canonical()).ok());
  auto frame = client::HumanoidFrame(Canonical(), {}, 1);
  EXPECT_EQ(puppet.Pose(frame, 0).available.tracking, 1);
  frame.set_flags(v1::FLAG_STALE | v1::FLAG_CONCEALED);
  EXPECT_EQ(puppet.Pose(frame, 0).available.tracking, 0);
  EXPECT_EQ(puppet.Pose(frame, 0).available.loaded, 1);
}

// liblo reads the tracker's message: its serial and the mirrored pose.
TEST(Puppet, SendsPropsAsTrackersOfTheirNames) {
  v1::Frame frame = client::HumanoidFrame(Canonical(), {}, 1);
  const auto add = [&frame](const std::string& name) {
    v1::Prop& prop = *frame.add_props();
    prop.set_name(name);
    for (const float value : {1.0F, 2.0F, 3.0F}) prop.add_position(value);
    for (const float value : {0.5F, 0.1F, -0.7F, 0.5F}) prop.add_rotation(value);
  };
  for (int i = 0; i < 16; ++i) add("sword" + std::string(static_cast<std::size_t>(i), 'x'));
  Puppet puppet(Carrier::kHips);
  ASSERT_TRUE(puppet.Bind(Canonical()).ok());
  const auto packed = puppet.Pose(frame, 0);
  ASSERT_EQ(packed.devices.size(), 16U);
  EXPECT_EQ(packed.devices[0].kind, vmc::Device::Kind::kTracker);
  EXPECT_EQ(packed.devices[0].transform, (vmc::Transform{{-1, 2, 3}, {0.5F, -0.1F, 0.7F, 0.5F}}));
  vmc::Packer packer(packed);
  std::vector<std::byte> buffer(vmc::Packer::kMaxPacketSize);
  std::string all;
  while (const std::size_t size = packer.Next(buffer)) {
    all.append(reinterpret_cast<const char*>(buffer.data()), size);
  }
  std::size_t found = 0;
  const std::string address("/VMC/Ext/Tra/Pos\0\0\0\0,sfffffff\0\0\0sword", 37);
  for (std::size_t at = all.find(address); at != std::string::npos;
       at = all.find(address, at + 1)) {
    ++found;
  }
  EXPECT_EQ(found, 16U) << "all of them, in as many datagrams as they need";
}

TEST(Puppet, RefusesABodyThatVmcCannotNameAndKeepsTheOldOne) {
  Puppet puppet(Carrier::kHips);
  ASSERT_TRUE(puppet.Bind(Canonical()).ok());
  v1::Body tail = Canonical();
  tail.add_names("tail");
  tail.add_parents(0);
  for (int i = 0; i < 3; ++i) tail.add_offsets(0);
  EXPECT_THAT(puppet.Bind(tail).message(), testing::HasSubstr("joint 21 is 'tail'"));
  v1::Body headless = Canonical();
  headless.set_names(0, "spine");
  EXPECT_THAT(puppet.Bind(headless).message(), testing::HasSubstr("expected hips"));
  EXPECT_EQ(puppet.Pose(client::HumanoidFrame(Canonical(), {}, 1), 0).bones.size(), 21U);
}

// liblo and oscpack read what is sent: what each message carries, in its order.
TEST(Puppet, IsReadByOthers) {
  Puppet puppet(Carrier::kHips);
  ASSERT_TRUE(puppet.Bind(Canonical()).ok());
  body::Random random(4);
  const auto packed = puppet.Pose(client::HumanoidFrame(Canonical(), random.AnyPose(), 1), 12.5F);
  vmc::Packer packer(packed);
  std::vector<std::byte> buffer(vmc::Packer::kMaxPacketSize);
  std::vector<std::string> messages;
  int datagrams = 0;
  while (const std::size_t size = packer.Next(buffer)) {
    ++datagrams;
    const auto datagram = std::span<const std::byte>(buffer).first(size);
    const auto liblo = vmc::testing::ReadLiblo(datagram);
    ASSERT_TRUE(liblo.taken);
    EXPECT_EQ(vmc::testing::ReadOscpack(datagram).messages, liblo.messages);
    messages.insert(messages.end(), liblo.messages.begin(), liblo.messages.end());
  }
  EXPECT_EQ(datagrams, 3);
  ASSERT_EQ(messages.size(), 25U);
  EXPECT_THAT(messages[0], testing::StartsWith("/VMC/Ext/Root/Pos ,sfffffff root "));
  EXPECT_THAT(messages[1], testing::StartsWith("/VMC/Ext/Bone/Pos ,sfffffff Hips "));
  EXPECT_EQ(messages[22], "/VMC/Ext/Blend/Apply ,");
  EXPECT_EQ(messages[23], "/VMC/Ext/OK ,iiii 1 3 0 1");
  EXPECT_EQ(messages[24], "/VMC/Ext/T ,f 41480000");
}

}  // namespace
}  // namespace styled::stylevmc

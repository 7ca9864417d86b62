// Fingers, eyes, jaw and expressions from one VMC application to another, through daemon and
// stylevmc. Both applications are liblo, which knows nothing of this project.
#include <gtest/gtest.h>
#include <lo/lo.h>
#include <signal.h>

#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "model/body/pose.h"
#include "model/clip/glb_write.h"
#include "model/rig/tail.h"
#include "proto/rigs/vmc/bones.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/support/units.h"

namespace styled::support {
namespace {

using body::Quat;
using body::Vec3;

constexpr int kFrames = 240, kRate_hz = 120;

// The tail: what hands and head have.
bool IsTail(int bone) {
  return vmc::Has(vmc::kFingers, bone) || bone == vmc::kLeftEye || bone == vmc::kRightEye ||
         bone == vmc::kJaw;
}

// The rotation of a bone in frame `i`, Unity's axes: every finger bends in its own way.
Quat Turn(int bone, int i) {
  const float phase = 0.05F * static_cast<float>(i) + static_cast<float>(bone);
  if (IsTail(bone)) {
    const Vec3 axis(std::sin(static_cast<float>(bone)), 1, std::cos(static_cast<float>(bone)));
    return Quat(Eigen::AngleAxisf(0.7F * std::sin(phase), axis.normalized()));
  }
  if (bone == vmc::kLeftUpperArm || bone == vmc::kRightLowerArm) {
    return Quat(Eigen::AngleAxisf(0.5F * std::sin(0.05F * static_cast<float>(i)), Vec3::UnitZ()));
  }
  return Quat::Identity();
}

// The bones' places, Unity's axes: a body of usual size, a hand of five fingers.
Vec3 Offset(int bone) {
  for (int c = 0; c < body::kJointCount; ++c) {
    const auto& row = body::kHumanoid[static_cast<std::size_t>(c)];
    if (vmc::FindBone(row.name, false) == bone) return {-row.x_m, row.y_m, row.z_m};
  }
  if (!vmc::Has(vmc::kFingers, bone)) return {0, 0.05F, 0.08F};
  const bool left = bone < vmc::kRightThumbProximal;
  const int finger = (bone - (left ? vmc::kLeftThumbProximal : vmc::kRightThumbProximal)) / 3;
  return {left ? -0.03F : 0.03F, 0, 0.03F - 0.012F * static_cast<float>(finger)};
}

// The application that sends: each frame in one datagram, its number in the blend "Index".
class Sender {
 public:
  explicit Sender(const std::string& address)
      : to_(lo_address_new("127.0.0.1", address.substr(address.rfind(':') + 1).c_str())) {}
  ~Sender() { lo_address_free(to_); }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  void Send(int i) {
    const lo_bundle bundle = lo_bundle_new(LO_TT_IMMEDIATE);
    for (int bone = 0; bone < vmc::kBoneCount; ++bone) {
      if (bone == vmc::kUpperChest) continue;
      const Vec3 p = Offset(bone);
      const Quat q = Turn(bone, i);
      Add(bundle, "/VMC/Ext/Bone/Pos", "sfffffff",
          std::string(vmc::kBones[static_cast<std::size_t>(bone)].name).c_str(), p.x(), p.y(),
          p.z(), q.x(), q.y(), q.z(), q.w());
    }
    Add(bundle, "/VMC/Ext/Blend/Val", "sf", "Index", static_cast<float>(i));
    Add(bundle, "/VMC/Ext/Blend/Val", "sf", "Joy", 0.25F);
    Add(bundle, "/VMC/Ext/Blend/Apply", "");
    Add(bundle, "/VMC/Ext/OK", "i", 1);
    Add(bundle, "/VMC/Ext/T", "f", static_cast<float>(i) / kRate_hz);
    EXPECT_GT(lo_send_bundle(to_, bundle), 0);
    lo_bundle_free_recursive(bundle);
  }

 private:
  template <typename... Values>
  static void Add(lo_bundle bundle, const char* address, const char* types, Values... values) {
    lo_message message = lo_message_new();
    lo_message_add(message, types, values...);
    lo_bundle_add_message(bundle, address, message);
  }
  lo_address to_;
};

// The application that receives.
class Receiver {
 public:
  struct Frame {
    std::map<std::string, Quat> bones;
    std::map<std::string, float> blends;
  };

  Receiver() : server_(lo_server_new(nullptr, [](int, const char*, const char*) {})) {
    lo_server_enable_queue(server_, 0, 1);
    lo_server_add_method(server_, nullptr, nullptr, &Receiver::OnMessage, this);
  }
  ~Receiver() { lo_server_free(server_); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  std::string address() const { return "127.0.0.1:" + std::to_string(lo_server_get_port(server_)); }
  void Receive() {
    while (lo_server_recv_noblock(server_, 0) > 0) {
    }
  }
  std::vector<Frame> frames;  // each ended by T

 private:
  static int OnMessage(const char* path, const char* /*types*/, lo_arg** a, int count,
                       lo_message /*message*/, void* user) {
    auto& self = *static_cast<Receiver*>(user);
    const std::string address = path;
    if (address == "/VMC/Ext/Bone/Pos" && count == 8) {
      self.open_.bones[&a[0]->s] = Quat(a[7]->f, a[4]->f, a[5]->f, a[6]->f);
    }
    if (address == "/VMC/Ext/Blend/Val") self.open_.blends[&a[0]->s] = a[1]->f;
    if (address == "/VMC/Ext/T") self.frames.push_back(std::exchange(self.open_, {}));
    return 0;
  }

  lo_server server_;
  Frame open_;
};

struct Worst {
  float tail_deg = 0, arm_deg = 0;  // from what the application sent in that frame
  int compared = 0;
};

// Plays the fingers through a daemon and stylevmc, with a style of that strength.
Worst PlayThrough(float strength) {
  Daemon daemon({}, "[[source]]\nname = \"app\"\ntype = \"vmc\"\nlisten = \"127.0.0.1:0\"\n");
  Receiver receiver;
  TemporaryFolder folder;
  Child forwarder({STYLEVMC_BINARY, "--publish", daemon.publish, "--to", receiver.address(),
                   "--performer", "app.app"},
                  folder / "stderr.txt");
  Sender sender(daemon.listens.at(2));
  Worst worst;
  // Until the connection works; the pose then restarts.
  for (int i = 0; i < 2400 && receiver.frames.size() < 10; ++i) {
    sender.Send(i);
    receiver.Receive();
    Sleep(1.0 / kRate_hz);
  }
  EXPECT_GE(receiver.frames.size(), 10U) << daemon.Log();
  ControlClient control(daemon.control);
  EXPECT_EQ(control.SetStyle("app.app", "style1", strength, 0).code(), v1::CODE_OK);
  receiver.frames.clear();
  Paced(kFrames, kRate_hz, [&](int i) {
    sender.Send(10000 + i);
    receiver.Receive();
  });
  for (int i = 0; i < 50; ++i, Sleep(0.01)) receiver.Receive();
  for (const Receiver::Frame& frame : receiver.frames) {
    if (frame.blends.find("Index") == frame.blends.end()) continue;
    const int i = static_cast<int>(std::lround(frame.blends.at("Index")));
    // A style is there after its first steps; the old count's frames are not compared.
    if (i < 10000 + kFrames / 2) continue;
    EXPECT_EQ(frame.blends.at("Joy"), 0.25F);
    EXPECT_EQ(frame.bones.size(), 54U) << "all but UpperChest, which was not sent";
    for (const auto& [name, rotation] : frame.bones) {
      const int bone = vmc::FindBone(name, false);
      if (bone < 0) {
        ADD_FAILURE() << name;
        continue;
      }
      const float deg = kDegrees * rotation.angularDistance(Turn(bone, i));
      float& most = IsTail(bone) ? worst.tail_deg : worst.arm_deg;
      most = std::max(most, deg);
    }
    ++worst.compared;
  }
  forwarder.Signal(SIGTERM);
  EXPECT_EQ(forwarder.Wait(5).value_or(-1), 0);
  return worst;
}

TEST(VmcFingers, ComeOutAsTheyCameInWithoutAStyle) {
  const Worst worst = PlayThrough(0);
  EXPECT_GT(worst.compared, kFrames / 4);
  EXPECT_LT(worst.tail_deg, 0.5F);
  EXPECT_LT(worst.arm_deg, 0.5F);
  std::cout << worst.compared << " frames, fingers " << worst.tail_deg << ", body " << worst.arm_deg
            << " degrees at most\n";
}

// VMC's rotations are relative to the parent, so the hand's shape is the same on the styled wrist.
TEST(VmcFingers, KeepTheirPoseAgainstTheStyledWrist) {
  const Worst worst = PlayThrough(1);
  EXPECT_GT(worst.compared, kFrames / 4);
  EXPECT_LT(worst.tail_deg, 0.5F);
  EXPECT_GT(worst.arm_deg, 2.0F) << "the body is styled";
  std::cout << worst.compared << " frames, fingers " << worst.tail_deg << ", body " << worst.arm_deg
            << " degrees at most\n";
}

// An avatar half as tall again, in centimetres, with Mixamo's names: thumb, index and little finger
// of the left hand, an eye, and a ring finger of two joints on the right one.
clip::Motion MakeAvatar() {
  clip::Motion motion;
  motion.metres_per_unit = 0.01F;
  const auto add = [&motion](const std::string& name, int parent, const Vec3& offset_m) {
    motion.skeleton.names.push_back(name);
    motion.skeleton.parents.push_back(parent);
    motion.skeleton.offsets.push_back(150 * offset_m);
    return motion.skeleton.joint_count() - 1;
  };
  for (int c = 0; c < body::kJointCount; ++c) {
    const auto& row = body::kHumanoid[static_cast<std::size_t>(c)];
    add(std::string(row.name), row.parent, body::Offset(c));
  }
  for (const std::string finger : {"LeftHandThumb", "LeftHandIndex", "LeftHandPinky"}) {
    int parent = body::kLeftHand;
    for (const char* const number : {"1", "2", "3", "4"}) {
      parent = add(finger + number, parent, {0.03F, 0, 0.02F});
    }
  }
  add("LeftEye", body::kHead, {0.03F, 0.05F, 0.08F});
  const int ring = add("RightHandRing1", body::kRightHand, {-0.08F, 0, 0});
  add("RightHandRing2", ring, {-0.03F, 0, 0});
  motion.times_s = {0};
  motion.frames = {rig::RigPose(motion.skeleton)};
  return motion;
}

// The avatar's frames, through a style: its fingers are as sent, against its own wrist; the joints
// that the performer lacks rest.
TEST(VmcFingers, DriveThoseOfAnAvatarThatHasThem) {
  TemporaryFolder folder;
  const std::string file = folder / "avatar.glb";
  const clip::Motion avatar = MakeAvatar();
  ASSERT_TRUE(clip::WriteGlb(avatar, file).ok());
  Daemon daemon({},
                "[[source]]\nname = \"app\"\ntype = \"vmc\"\nlisten = \"127.0.0.1:0\"\n"
                "[[output]]\nname = \"hero\"\navatar = \"" +
                    file + "\"\n");
  const std::string topic = "styled/app.app/hero/";
  Subscriber subscriber(daemon.publish, {"body/", topic});
  Sender sender(daemon.listens.at(2));
  for (int i = 0; i < 2400 && subscriber.Frames(topic).size() < 10; ++i) {
    sender.Send(i);
    Sleep(1.0 / kRate_hz);
  }
  ControlClient control(daemon.control);
  ASSERT_EQ(control.SetStyle("app.app", "style1", 1, 0).code(), v1::CODE_OK);
  Paced(kFrames, kRate_hz, [&](int i) { sender.Send(10000 + i); });
  const auto bodies = subscriber.Bodies();
  const auto body = std::find_if(bodies.begin(), bodies.end(),
                                 [](const v1::Body& b) { return b.output() == v1::OUTPUT_AVATAR; });
  ASSERT_NE(body, bodies.end());
  ASSERT_EQ(body->names_size(), avatar.skeleton.joint_count());
  // By the avatar's joint: the bone that drives it, or -1.
  std::vector<int> bones(static_cast<std::size_t>(body->names_size()), -1);
  rig::Skeleton skeleton;  // the file's joints have another order
  skeleton.names.assign(body->names().begin(), body->names().end());
  const rig::TailMap map = rig::MapTailNames(skeleton);
  int mapped = 0;
  for (std::size_t t = 0; t < map.size(); ++t) {
    if (map[t] < 0) continue;
    bones[static_cast<std::size_t>(map[t])] = vmc::FindBone(rig::kTailNames[t], true);
    ++mapped;
  }
  ASSERT_EQ(mapped, 3 * 3 + 1 + 2);
  float fingers_deg = 0, others_deg = 0, body_deg = 0;
  int compared = 0;
  for (const v1::Frame& frame : subscriber.Frames(topic)) {
    if (frame.expressions_size() == 0 || frame.expressions(0).value() < 10000 + kFrames / 2)
      continue;
    ++compared;
    const int i = static_cast<int>(std::lround(frame.expressions(0).value()));
    for (int j = 0; j < body->names_size(); ++j) {
      const float* const q = frame.rotations().data() + 4 * j;
      const Quat got(q[3], q[0], -q[1], -q[2]);  // in Unity's axes
      int bone = bones[static_cast<std::size_t>(j)];
      const bool driven = bone >= 0;
      if (!driven) bone = vmc::FindBone(body->names(j), true);  // the humanoid's, or an end
      float& most = driven ? fingers_deg : bone >= 0 ? body_deg : others_deg;
      const Quat expected = bone < 0 ? Quat::Identity() : Turn(bone, i);
      most = std::max(most, kDegrees * got.angularDistance(expected));
    }
  }
  EXPECT_GT(compared, kFrames / 4);
  EXPECT_LT(fingers_deg, 0.5F);
  EXPECT_LT(others_deg, 0.1F) << "ends of fingers";
  EXPECT_GT(body_deg, 2.0F) << "the body is styled";
  std::cout << compared << " frames, fingers " << fingers_deg << ", body " << body_deg
            << " degrees at most\n";
}

}  // namespace
}  // namespace styled::support

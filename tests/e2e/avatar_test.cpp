#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>

#include "model/body/humanoid.h"
#include "model/clip/glb_write.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

using rig::Quat;
using rig::Vec3;

// Writes the canonical humanoid, one and a half times as tall, as an avatar file in centimetres.
void WriteAvatar(const std::string& file, float metres_per_unit, float taller) {
  clip::Motion motion;
  for (const auto& row : body::kHumanoid) {
    motion.skeleton.names.emplace_back(row.name);
    motion.skeleton.parents.push_back(row.parent);
    motion.skeleton.offsets.emplace_back(Vec3(row.x_m, row.y_m, row.z_m) * taller /
                                         metres_per_unit);
  }
  motion.metres_per_unit = metres_per_unit;
  motion.times_s = {0};
  motion.frames = {rig::RigPose(motion.skeleton)};
  const Status status = clip::WriteGlb(motion, file);
  ASSERT_TRUE(status.ok()) << status.message();
}

std::string Output(const std::string& name, const std::string& file, const std::string& more = "") {
  return "[[output]]\nname = \"" + name + "\"\navatar = \"" + file + "\"\n" + more;
}

void Walk(const Daemon& daemon, Rig& rig, int frames) {
  const UdpLink link(daemon.udp);
  link.Send(rig.Body());
  Paced(frames, 120, [&](int) { link.Send(rig.Frame()); });
}

TEST(AvatarTest, AnAvatarIsDrivenOnItsOwnSkeletonAndMayBeChangedWhileItRuns) {
  TemporaryFolder folder;
  const std::string tall = folder / "tall.glb";
  WriteAvatar(tall, 0.01F, 1.5F);
  Daemon daemon({}, Output("hero", tall) + Output("other", tall, "performers = [\"rig.berta\"]\n"));
  Rig rig("anna");
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.anna/"});
  ControlClient control(daemon.control);
  Walk(daemon, rig, 10);
  ASSERT_TRUE(subscriber.WaitForBody());
  ASSERT_EQ(control.SetStyle("rig.anna", "style1").code(), v1::CODE_OK);
  Walk(daemon, rig, 120);
  ASSERT_TRUE(subscriber.WaitForFrames(100, "styled/rig.anna/hero/"));
  EXPECT_TRUE(subscriber.Frames("styled/rig.anna/other/").empty());

  const auto bodies = subscriber.Bodies();
  const auto body = std::find_if(bodies.begin(), bodies.end(),
                                 [](const v1::Body& b) { return b.output() == v1::OUTPUT_AVATAR; });
  ASSERT_NE(body, bodies.end());
  EXPECT_EQ(body->output_name(), "hero");
  EXPECT_EQ(body->performer(), "rig.anna");
  EXPECT_EQ(body->names_size(), body::kJointCount);
  EXPECT_NEAR(body->offsets(1), 1.5F * body::kHumanoid[0].y_m, 1e-4F);
  // The same motion: the local rotations of a T-posed avatar are the canonical ones, except for its
  // legs.
  const auto canonical = subscriber.Frames("styled/rig.anna/canonical/");
  for (const auto& frame : subscriber.Frames("styled/rig.anna/hero/")) {
    ASSERT_EQ(frame.body_hash(), body->hash());
    ASSERT_EQ(frame.rotations_size(), 4 * body::kJointCount);
    const auto same = std::find_if(canonical.begin(), canonical.end(), [&](const v1::Frame& c) {
      return c.sequence() == frame.sequence();
    });
    if (same == canonical.end()) continue;
    for (int i = 0; i < 4 * body::kLeftUpperLeg; i += 4) {
      const auto at = [i](const v1::Frame& f) {
        return Quat(f.rotations(i + 3), f.rotations(i), f.rotations(i + 1), f.rotations(i + 2));
      };
      ASSERT_LT(at(frame).angularDistance(at(*same)), 5e-3) << i;
    }
    ASSERT_NEAR(frame.root_position(1), 1.5F * same->root_position(1), 0.12F);
  }

  // SIGHUP with another file under the same name; then with a broken one, which changes nothing.
  const std::string taller = folder / "taller.glb";
  WriteAvatar(taller, 1, 2);
  daemon.Configure(Output("hero", taller));
  kill(daemon.child->pid(), SIGHUP);
  EXPECT_EQ(control.CounterSoon("config.reloads", 1), 1U);
  Walk(daemon, rig, 30);
  ASSERT_TRUE(subscriber.WaitFor(
      [&] { return subscriber.Frames("styled/rig.anna/hero/").back().body_hash() != body->hash(); },
      10));
  std::ofstream(taller) << "glTF";
  kill(daemon.child->pid(), SIGHUP);
  EXPECT_EQ(control.CounterSoon("config.reloads_refused", 1), 1U);
  EXPECT_NE(daemon.Log().find("taller.glb: is not glTF 2.0"), std::string::npos) << daemon.Log();
}

// The tree tells joints without names, but neither names nor toes tell left from right here.
TEST(JointsTest, ARigInDoubtIsMappedByHand) {
  std::string joints;
  for (std::size_t c = 0; c < body::kHumanoid.size(); ++c) {
    joints += (joints.empty() ? "{" : ", ") + std::string(body::kHumanoid[c].name) + " = \"b" +
              std::to_string(c) + "\"";
  }
  for (const bool by_hand : {false, true}) {
    Daemon daemon(by_hand ? std::vector<std::string>{"source.0.joints=" + joints + "}"}
                          : std::vector<std::string>{});
    ControlClient control(daemon.control);
    Rig rig("anna");
    v1::Body body = rig.MakeBody();
    for (int c = 0; c < body.names_size(); ++c) body.set_names(c, "b" + std::to_string(c));
    for (const int toes : {body::kLeftToes, body::kRightToes}) {
      for (int axis = 0; axis < 3; ++axis) body.set_offsets(3 * toes + axis, 0);
    }
    const UdpLink link(daemon.udp);
    link.Send(rig.Datagram(native::Kind::kBody, body.SerializeAsString()));
    Paced(30, 120, [&](int) {
      link.Send(rig.Frame([](v1::SourceFrame& frame) { frame.set_body_crc(0); }));
    });
    if (by_hand) {
      EXPECT_GT(control.CounterSoon("pipeline.frames", 20), 0U) << daemon.Log();
    } else {
      EXPECT_GT(control.CounterSoon("pipeline.bodies_refused", 1), 0U) << daemon.Log();
      EXPECT_EQ(control.Counter("pipeline.frames"), 0U);
      EXPECT_NE(daemon.Log().find("nothing that tells left from right"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace styled::support

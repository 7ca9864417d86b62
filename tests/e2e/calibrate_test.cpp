#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

// The canonical skeleton with hanging arms in its zero pose, of a dialect whose zero pose is a
// T-pose. ("auto" would bind it as it stands.)
struct HangingRig {
  Rig rig{"anna"};
  v1::Body body;

  HangingRig() : body(rig.MakeBody()) {
    body.set_dialect("canonical");
    for (const int arm : {7, 8, 11, 12}) {  // lower arms and hands
      body.set_offsets(3 * arm + 1, -std::abs(body.offsets(3 * arm)));
      body.set_offsets(3 * arm, 0);
    }
  }
  Bytes Body() { return rig.Datagram(native::Kind::kBody, body.SerializeAsString()); }
  // A frame in T-pose, or with the right knee bent.
  Bytes Frame(bool bent = false) {
    return rig.Frame([bent](v1::SourceFrame& frame) {
      frame.set_body_crc(0);
      const auto turn = [&frame](int joint, float z, float w) {
        frame.set_rotations(4 * joint + 2, z);
        frame.set_rotations(4 * joint + 3, w);
      };
      for (int i = 0; i < frame.rotations_size(); ++i) frame.set_rotations(i, i % 4 == 3 ? 1 : 0);
      turn(6, 0.70710678F, 0.70710678F);
      turn(10, -0.70710678F, 0.70710678F);
      if (bent) turn(18, 0.6F, 0.8F);
    });
  }
};

v1::Reply Calibrate(ControlClient& control, const std::string& performer, bool clear = false) {
  v1::Request request;
  request.set_performer(performer);
  request.mutable_calibrate()->set_clear(clear);
  return control.Ask(request);
}

void Stand(const UdpLink& link, HangingRig& rig, int frames, bool bent = false) {
  Paced(frames, 120, [&](int) { link.Send(rig.Frame(bent)); });
}

TEST(CalibrateTest, ARigOfUnknownRestWaitsIsCalibratedInOneCallAndStaysSoOverARestart) {
  TemporaryFolder state;
  Daemon daemon({"state.dir=\"" + (state / "kept") + "\""});
  HangingRig rig;
  {
    Subscriber subscriber(daemon.publish, {"body/", "styled/"});
    ControlClient control(daemon.control);
    const UdpLink link(daemon.udp);
    EXPECT_EQ(Calibrate(control, "rig.anna").code(), v1::CODE_UNKNOWN_PERFORMER);
    link.Send(rig.Body());
    Stand(link, rig, 30);
    EXPECT_GT(control.CounterSoon("pipeline.uncalibrated", 30), 0U);
    EXPECT_EQ(control.Counter("pipeline.frames"), 0U);
    EXPECT_TRUE(subscriber.Frames().empty());

    Stand(link, rig, 30, true);
    const auto moved = Calibrate(control, "rig.anna");
    EXPECT_EQ(moved.code(), v1::CODE_NOT_READY);
    EXPECT_NE(moved.reason().find("rightLowerLeg turned"), std::string::npos) << moved.reason();
    Stand(link, rig, 90, true);
    const auto bent = Calibrate(control, "rig.anna");
    EXPECT_EQ(bent.code(), v1::CODE_BAD_POSE);
    EXPECT_NE(bent.reason().find("rightLowerLeg"), std::string::npos) << bent.reason();

    Stand(link, rig, 90);
    const auto done = Calibrate(control, "rig.anna");
    ASSERT_EQ(done.code(), v1::CODE_OK) << done.reason();
    EXPECT_LT(done.calibrate().worst_degrees(), 2);
    ASSERT_EQ(done.applied_size(), 1);
    ASSERT_TRUE(subscriber.WaitForBody());
    Stand(link, rig, 30);
    ASSERT_TRUE(subscriber.WaitForFrames(20, "styled/rig.anna/canonical/"));
    const auto frame = subscriber.Frames("styled/rig.anna/canonical/").back();
    for (int i = 0; i < frame.rotations_size(); ++i) {
      EXPECT_NEAR(frame.rotations(i), i % 4 == 3 ? 1 : 0, 0.02) << i;
    }
    EXPECT_EQ(control.Performer("rig.anna").dialect(), "calibrated");
  }
  ASSERT_EQ(daemon.Stop(), 0);
  daemon.Start();
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  rig.rig.session += 1;
  link.Send(rig.Body());
  Stand(link, rig, 30);
  EXPECT_GT(control.CounterSoon("pipeline.frames", 30), 0U) << daemon.Log();
  EXPECT_EQ(Calibrate(control, "rig.anna", true).code(), v1::CODE_BAD_POSE)
      << "without it the rig cannot be bound: nothing changes";
  EXPECT_EQ(control.Performer("rig.anna").dialect(), "calibrated");
}

}  // namespace
}  // namespace styled::support

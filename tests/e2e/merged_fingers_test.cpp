// A second source that gives a performer its fingers: hand tracking beside a body without fingers.
#include <gtest/gtest.h>

#include <cmath>

#include "model/rig/tail.h"
#include "sim/rigs/vmc.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

using body::Quat;
using body::Vec3;

constexpr double kDegrees = 57.29578;

Bytes Sent(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

// One sending application, with its own clock.
class App {
 public:
  App(const std::string& address, std::vector<std::string> quirks) : link_(address) {
    rigs::Options options;
    options.quirks = std::move(quirks);
    rig_ = std::move(rigs::MakeVmc(options).value());
  }
  void Send(const body::Pose& pose) {
    rigs::Frame frame;
    frame.index = static_cast<std::uint64_t>(count_);
    frame.time_s = static_cast<double>(count_++) / 120;
    frame.poses = {&pose, 1};
    rig_->Encode(frame, [this](auto datagram) { link_.Send(Sent(datagram)); });
  }
  double time_s() const { return static_cast<double>(count_ - 1) / 120; }

 private:
  UdpLink link_;
  std::unique_ptr<rigs::Rig> rig_;
  int count_ = 0;
};

Quat Rotation(const v1::Frame& frame, int joint) {
  const float* const q = frame.rotations().data() + static_cast<std::ptrdiff_t>(4 * joint);
  return {q[3], q[0], q[1], q[2]};
}

int JointOf(const v1::Body& body, std::string_view name) {
  for (int j = 0; j < body.names_size(); ++j) {
    if (body.names(j) == name) return j;
  }
  return -1;
}

class MergedFingers : public testing::Test {
 protected:
  static std::string Sources(const std::string& parts) {
    return "[[source]]\nname = \"app\"\ntype = \"vmc\"\nlisten = \"127.0.0.1:0\"\n"
           "[[source]]\nname = \"hands\"\ntype = \"vmc\"\nlisten = \"127.0.0.1:0\"\n"
           "merge_into = \"app.app\"\nparts = [" +
           parts + "]\n";
  }
  v1::Body BodyOf(Subscriber& subscriber, v1::Output output) {
    v1::Body found;
    for (const v1::Body& body : subscriber.Bodies()) {
      if (body.output() == output) found = body;
    }
    return found;
  }
};

TEST_F(MergedFingers, OfASenderOfHandsAloneReachEveryWayOut) {
  Daemon daemon({}, Sources("\"fingers\""));
  const std::string canonical = "styled/app.app/canonical/", rig = "styled/app.app/rig/";
  Subscriber subscriber(daemon.publish, {"body/", canonical, rig});
  App body(daemon.listens.at(2), {"t-first"}), hands(daemon.listens.at(3), {"hands"});
  body::Pose pose, turned;  // the hands in the hands sender's frames do not matter
  for (Quat& q : turned.rotations) q = Quat(Eigen::AngleAxisf(0.7F, Vec3(1, 2, 3).normalized()));
  Paced(240, 120, [&](int) {
    hands.Send(turned);
    body.Send(pose);
  });
  ASSERT_TRUE(subscriber.WaitForFrames(400, "styled/")) << daemon.Log();
  for (const auto& [topic, output] :
       {std::pair{canonical, v1::OUTPUT_CANONICAL}, {rig, v1::OUTPUT_RIG}}) {
    const v1::Body shape = BodyOf(subscriber, output);
    const v1::Frame frame = subscriber.Frames(topic).back();
    ASSERT_EQ(frame.rotations_size(), 4 * shape.names_size()) << topic;
    const double bend = kDegrees * rigs::HandsBend_rad(hands.time_s());
    for (std::size_t t = 0; t < rig::kTailLeftEye; ++t) {
      const std::string name(rig::kTailNames[t]);
      const int joint = JointOf(shape, name);
      ASSERT_GE(joint, 0) << topic << name;
      const bool thumb = name.find("Thumb") != std::string::npos;
      const double degrees = kDegrees * Rotation(frame, joint).angularDistance(Quat::Identity());
      // A frame or two may lie between the two senders' last ones.
      EXPECT_NEAR(degrees, thumb ? 0 : bend, 4) << topic << name;
      const float about_z = Rotation(frame, joint).z() * (Rotation(frame, joint).w() < 0 ? -1 : 1);
      if (!thumb && bend > 10) EXPECT_EQ(about_z < 0, name.starts_with("left")) << name;
    }
  }
  ControlClient control(daemon.control);
  EXPECT_EQ(control.Counter("pipeline.performers"), 1U);
  EXPECT_EQ(control.Counter("pipeline.bodies_refused"), 0U);
}

TEST_F(MergedFingers, OfOneHandLeaveTheOtherAsItIs) {
  Daemon daemon({}, Sources("\"leftFingers\""));
  const std::string canonical = "styled/app.app/canonical/";
  Subscriber subscriber(daemon.publish, {"body/", canonical});
  App body(daemon.listens.at(2), {"t-first"}), hands(daemon.listens.at(3), {"hands"});
  Paced(180, 120, [&](int) {
    hands.Send({});
    body.Send({});
  });
  ASSERT_TRUE(subscriber.WaitForFrames(100, "styled/")) << daemon.Log();
  const v1::Body shape = BodyOf(subscriber, v1::OUTPUT_CANONICAL);
  EXPECT_EQ(shape.names_size(), body::kJointCount + 15);
  EXPECT_GE(JointOf(shape, "leftIndexProximal"), 0);
  EXPECT_EQ(JointOf(shape, "rightIndexProximal"), -1);
}

}  // namespace
}  // namespace styled::support

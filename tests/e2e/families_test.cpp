// The daemon runs the network of any family that its weights file names.
#include <gtest/gtest.h>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/unit/net/offset/weights.h"

namespace styled::support {
namespace {

body::Quat RotationOf(const v1::Frame& frame, int joint) {
  return body::Quat(Eigen::Map<const Eigen::Vector4f>(frame.rotations().data() +
                                                      4 * static_cast<std::ptrdiff_t>(joint)));
}

TEST(FamiliesTest, AConstantOffsetIsStreamedLive) {
  const TemporaryFolder folder;
  const std::string weights = folder / "offset.safetensors";
  offset::WriteTestWeights(weights);
  Daemon daemon({}, "", {}, weights);
  Subscriber subscriber(daemon.publish, {"body/rig.a/", "styled/rig.a/rig/", "source/rig.a/"});
  ControlClient control(daemon.control);
  const v1::Reply reply = control.SetStyle("rig.a", "stooped", 1, 0);
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  EXPECT_EQ(control.SetStyle("rig.a", "style1").code(), v1::CODE_UNKNOWN_STYLE);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  constexpr int kFrames = 120;
  Paced(kFrames, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_TRUE(subscriber.WaitForFrames(kFrames, "styled/")) << daemon.Log();
  const auto styled = subscriber.Frames("styled/"), source = subscriber.Frames("source/");
  ASSERT_EQ(source.size(), styled.size());
  for (std::size_t i = kFrames / 2; i < styled.size(); ++i) {
    ASSERT_EQ(styled[i].styles_size(), 1) << i;
    EXPECT_EQ(styled[i].styles(0).style(), "bent");
    EXPECT_NEAR(
        RotationOf(styled[i], body::kSpine).angularDistance(RotationOf(source[i], body::kSpine)),
        offset::kBent_rad, 1e-2)
        << i;
    EXPECT_LT(
        RotationOf(styled[i], body::kHead).angularDistance(RotationOf(source[i], body::kHead)),
        1e-3)
        << i;
  }
}

}  // namespace
}  // namespace styled::support

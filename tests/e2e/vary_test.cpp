// Variations of a style per performer, over real sockets: of two who do the same, the one that is
// varied moves differently, and again alike when the variation is taken back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "model/body/pose.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::support {
namespace {

using testing::HasSubstr;

// Statistics over the past fade in seconds.
constexpr float kAlike_rad = 0.01F, kDifferent_rad = 0.03F;

std::string VaryingWeights(const std::string& file) {
  const std::vector<std::byte> bytes = stgcn_causal::RandomWeights(4, 16, 1).Bytes();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return file;
}

v1::Request Set(const std::string& performer) {
  v1::Request request;
  request.set_performer(performer);
  request.mutable_set()->set_transition_ms(50);
  return request;
}
v1::Request Vary(const std::string& performer, float number) {
  v1::Request request = Set(performer);
  request.mutable_set()->set_vary(number);
  return request;
}

class VaryTest : public testing::Test {
 protected:
  VaryTest() {
    for (Rig& rig : rigs_) {
      link_.Send(rig.Body());
      EXPECT_EQ(control_.SetStyle("rig." + rig.performer, "style2", 1, 0).code(), v1::CODE_OK);
    }
    EXPECT_TRUE(subscriber_.WaitForBody());
  }

  // Both move for this many frames; their last ones.
  std::array<v1::Frame, 2> Move(int frames) {
    const std::size_t before = subscriber_.Frames("styled/").size();
    Paced(frames, 240, [&](int) {
      for (Rig& rig : rigs_) link_.Send(rig.Frame());
    });
    const auto count = static_cast<std::size_t>(frames) * rigs_.size();
    EXPECT_TRUE(subscriber_.WaitForFrames(before + count, "styled/")) << daemon_.Log();
    return {subscriber_.Frames("styled/rig.a/").back(), subscriber_.Frames("styled/rig.b/").back()};
  }
  // The largest angle between two poses' joints.
  static float Apart_rad(const v1::Frame& a, const v1::Frame& b) {
    float most = 0;
    for (int at = 0; at + 3 < a.rotations_size(); at += 4) {
      const auto joint = [at](const v1::Frame& frame) {
        return body::Quat(Eigen::Map<const Eigen::Vector4f>(frame.rotations().data() + at));
      };
      most = std::max(most, joint(a).angularDistance(joint(b)));
    }
    return most;
  }
  float Apart_rad(const std::array<v1::Frame, 2>& both) { return Apart_rad(both[0], both[1]); }
  void Do(const v1::Request& request) {
    const v1::Reply reply = control_.Ask(request);
    EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  }

  TemporaryFolder folder_;
  // Random weights reconstruct nothing: a network that knew no pose would show no style.
  Daemon daemon_{{"model.out_of_domain_begin_rad=3.9", "model.out_of_domain_end_rad=4",
                  "model.limb_gate=false", "state.dir=" + (folder_ / "state")},
                 "",
                 {},
                 VaryingWeights(folder_ / "w")};
  Subscriber subscriber_{daemon_.publish, {"body/", "styled/rig.a/rig/", "styled/rig.b/rig/"}};
  ControlClient control_{daemon_.control};
  UdpLink link_{daemon_.udp};
  std::array<Rig, 2> rigs_{Rig("a"), Rig("b")};
};

TEST_F(VaryTest, AValueOutOfRangeIsRefusedAndChangesNothing) {
  for (const float bad : {-1.0F, 2.5F, 100.0F}) {
    const v1::Reply reply = control_.Ask(Vary("rig.a", bad));
    EXPECT_EQ(reply.code(), v1::CODE_OUT_OF_RANGE);
    EXPECT_THAT(reply.reason(), HasSubstr("expected a whole number from 0 to 99"));
  }
  v1::Request far = Set("rig.a");
  far.mutable_set()->set_vary_amount(2);
  EXPECT_EQ(control_.Ask(far).code(), v1::CODE_OUT_OF_RANGE);
  v1::Request slow = Set("rig.a");
  slow.mutable_set()->set_drift_s(601);
  EXPECT_EQ(control_.Ask(slow).code(), v1::CODE_OUT_OF_RANGE);
  EXPECT_EQ(control_.Performer("rig.a").look().vary(), 0);
  EXPECT_LT(Apart_rad(Move(60)), kAlike_rad);
}

TEST_F(VaryTest, AVariationChangesTheMotionAndZeroGivesItBack) {
  EXPECT_LT(Apart_rad(Move(60)), kAlike_rad) << "two who do the same";
  Do(Vary("rig.a", 7));
  const auto varied = Move(120);
  EXPECT_GT(Apart_rad(varied), kDifferent_rad);
  ASSERT_EQ(varied[0].styles_size(), 1) << "its style is what it was";
  EXPECT_EQ(varied[0].styles(0).style(), "style2");
  Do(Vary("rig.b", 7));
  EXPECT_LT(Apart_rad(Move(360)), kAlike_rad) << "the same variation is the same motion";
  Do(Vary("rig.a", 0));
  EXPECT_GT(Apart_rad(Move(120)), kDifferent_rad);
  Do(Vary("rig.b", 0));
  EXPECT_LT(Apart_rad(Move(360)), kAlike_rad);
}

TEST_F(VaryTest, EachHasTheirOwnAndDriftMovesOn) {
  v1::Request each = Set("*");
  each.mutable_set()->set_vary_each(true);
  Do(each);
  EXPECT_GT(Apart_rad(Move(120)), kDifferent_rad) << "rig.a and rig.b";
  each.mutable_set()->set_vary_each(false);
  each.mutable_set()->set_vary(3);
  Do(each);
  EXPECT_LT(Apart_rad(Move(360)), kAlike_rad);
  // Both drift, the same way.
  each.mutable_set()->set_drift_s(1);
  Do(each);
  Move(360);
  v1::Request stops = Set("rig.b");
  stops.mutable_set()->set_drift_s(0);
  Do(stops);
  EXPECT_GT(Apart_rad(Move(120)), kDifferent_rad) << "one is back at the third variation";
}

TEST_F(VaryTest, ItSurvivesARestartAndALikedStyleVariesToo) {
  v1::Request request = Vary("rig.a", 7);
  request.mutable_set()->set_vary_amount(0.5F);
  request.mutable_set()->set_drift_s(30);
  Do(request);
  v1::Request like;
  like.mutable_like()->set_name("mine");
  like.mutable_like()->mutable_vary()->set_style("style1");
  like.mutable_like()->mutable_vary()->set_seed(3);
  Do(like);
  EXPECT_EQ(control_.SetStyle("rig.a", "mine").code(), v1::CODE_OK);
  Move(10);
  EXPECT_EQ(control_.SetStyle("rig.a", "style1").code(), v1::CODE_OK);
  ASSERT_EQ(daemon_.Stop(), 0);
  daemon_.Start();
  const v1::Look look = ControlClient(daemon_.control).Performer("rig.a").look();
  EXPECT_EQ(look.vary(), 7);
  EXPECT_EQ(look.vary_amount(), 0.5F);
  EXPECT_EQ(look.drift_s(), 30);
  EXPECT_FALSE(look.vary_each());
}

TEST(VaryWithoutVariations, AStyleThatHasNoneIsShownAsItIs) {
  Daemon daemon;
  ControlClient control(daemon.control);
  EXPECT_EQ(control.Ask(Vary("rig.a", 7)).code(), v1::CODE_OK);
  v1::Reply reply = control.SetStyle("rig.a", "style1");
  EXPECT_EQ(reply.code(), v1::CODE_OK);
  EXPECT_EQ(reply.applied(0).not_varied(), "style1");
  v1::Request drift = Set("*");
  drift.mutable_set()->set_drift_s(5);
  reply = control.Ask(drift);
  EXPECT_EQ(reply.code(), v1::CODE_OK);
  EXPECT_EQ(reply.applied(0).not_varied(), "style1");
  EXPECT_EQ(control.Performer("rig.a").look().drift_s(), 5);
}

}  // namespace
}  // namespace styled::support

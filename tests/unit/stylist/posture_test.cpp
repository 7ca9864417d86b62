// Where a network shows nothing of a style, its posture is kept.
#include "model/stylist/posture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "model/feet/legs.h"
#include "model/stylist/stylist.h"

namespace styled::stylist {
namespace {

using body::Pose;
using body::Quat;
using body::Vec3;
using body::WorldPose;

constexpr float kStoop_rad = 0.3F;

// Three styles: one with a posture that the network does not show, one with the same posture, which
// it shows by the given share, and one that has none.
class Stooping final : public net::Stylizer {
 public:
  Stooping() {
    model_.styles = {{"neutral", {}}, {"silent", {}}, {"shown", {}}, {"other", {}}};
    net::Posture posture;
    posture.fill(Vec3::Zero());
    posture[0] = Vec3(kStoop_rad, 0, 0);  // spine
    posture[4] = Vec3(0, 0.1F, 0.2F);     // left shoulder
    model_.styles[1].posture = model_.styles[2].posture = posture;
  }
  const net::Model& model() const noexcept override { return model_; }
  std::unique_ptr<net::Stream> MakeStream() const override { return std::make_unique<Nothing>(); }
  void Start(net::Stream&) const noexcept override {}
  void Step(std::span<const net::StepJob> jobs) const noexcept override {
    for (const net::StepJob& job : jobs) {
      net::Prediction& out = *job.out;
      out.reconstruction.rotations = job.pose->rotations;
      out.reconstruction.velocities_m_s.fill(0);
      out.reconstruction.hips_height_m = job.pose->hips_position_m.y();
      out.styled = out.reconstruction;
      for (const net::StyleWeight& style : job.styles) {
        if (style.style != 2) continue;
        for (std::size_t i = 0; i < net::kPostureJoints.size(); ++i) {
          const Vec3 turn = style.weight * shown * (*model_.styles[2].posture)[i];
          Quat& rotation = out.styled.rotations[net::kPostureJoints[i]];
          rotation = rotation * body::Exp(turn);
        }
      }
    }
  }
  float shown = 1;

 private:
  struct Nothing final : net::Stream {
    std::span<const std::byte> memory() const noexcept override { return {}; }
  };
  net::Model model_;
};

Pose Standing() {
  Pose pose;
  pose.rotations[body::kLeftUpperArm] = body::Exp(Vec3(0.3F, 0, -1.1F));
  pose.rotations[body::kRightUpperArm] = body::Exp(Vec3(-0.4F, 0.1F, 0.4F));
  return pose;
}

struct PostureTest : testing::Test {
  const std::shared_ptr<const rig::Binding> binding =
      std::make_shared<const rig::Binding>(feet::HumanoidBinding());
  const std::shared_ptr<Stooping> network = std::make_shared<Stooping>();
  Options options;
  Settings settings;
  std::unique_ptr<Stylist> stylist;
  Output out{binding->skeleton()};
  std::int64_t time_ns = 0;

  void SetUp() override {
    options.ground = options.feet = false;
    settings.transition_s = 0.2F;
    Begin();
  }
  void Begin() { stylist = std::make_unique<Stylist>(network, binding, options); }
  void Show(int style, float weight = 1) {
    settings.mix[0] = {style, weight};
    stylist->Set(settings);
  }
  // Returns the largest turn of the spine meanwhile, rad.
  float Perform(const Pose& pose, double seconds) {
    const rig::RigPose rest(binding->skeleton());
    rig::RigPose in(binding->skeleton());
    binding->Unbind(pose, rest, in);
    float most = 0;
    for (int i = 0; i < static_cast<int>(seconds * 120); ++i) {
      stylist->Process(time_ns += 8'333'333, in, out);
      most = std::max(most, Turn(body::kSpine).norm());
    }
    return most;
  }
  Vec3 Turn(body::Joint joint) const {
    return body::Log(out.canonical_input.rotations[joint].conjugate() *
                     out.canonical.rotations[joint]);
  }
};

TEST_F(PostureTest, WhatTheNetworkDoesNotShowIsKept) {
  Perform(Standing(), 0.5);
  Show(1);
  EXPECT_LT(Perform(Standing(), 3), kStoop_rad * 1.01F);
  EXPECT_NEAR(Turn(body::kSpine).x(), kStoop_rad, 0.01);
  EXPECT_NEAR(Turn(body::kLeftShoulder).z(), 0.2, 0.01);
  // Half of a style has half of its posture.
  Show(1, 0.5F);
  Perform(Standing(), 3);
  EXPECT_NEAR(Turn(body::kSpine).x(), kStoop_rad / 2, 0.01);
}

TEST_F(PostureTest, TheArmsKeepTheirDirectionInTheWorld) {
  Show(1);
  Perform(Standing(), 3);
  WorldPose before, after;
  body::ForwardKinematics(out.canonical_input, before);
  body::ForwardKinematics(out.canonical, after);
  for (const auto arm : {body::kLeftUpperArm, body::kRightUpperArm, body::kLeftHand}) {
    EXPECT_LT(before.rotations[arm].angularDistance(after.rotations[arm]), 2e-3F) << arm;
  }
  EXPECT_GT(before.rotations[body::kHead].angularDistance(after.rotations[body::kHead]), 0.25F);
}

TEST_F(PostureTest, WhatTheNetworkShowsIsNotAddedAgain) {
  Perform(Standing(), 0.5);
  Show(2);
  EXPECT_LT(Perform(Standing(), 4), kStoop_rad * 1.25F) << "nor while it sets in";
  EXPECT_NEAR(Turn(body::kSpine).x(), kStoop_rad, 0.01);
  // A posture shown in part is filled up to less than the whole.
  network->shown = 0.4F;
  Perform(Standing(), 4);
  EXPECT_NEAR(Turn(body::kSpine).x(), 0.9F * kStoop_rad, 0.01);
}

TEST_F(PostureTest, ItSetsInAndEndsWithoutAJump) {
  settings.transition_s = 1;  // faster ones are the mix's own
  Perform(Standing(), 0.5);
  Show(1);
  Vec3 last = Vec3::Zero(), speed = Vec3::Zero();
  float largest = 0;  // change of speed from frame to frame, rad/s
  for (int frame = 0; frame < 480; ++frame) {
    if (frame == 240) Show(0, 0);
    Perform(Standing(), 1.0 / 120);
    const Vec3 now = (Turn(body::kSpine) - last) * 120;
    largest = std::max(largest, (now - speed).norm());
    speed = now;
    last = Turn(body::kSpine);
  }
  EXPECT_LT(largest, 0.06F);
  EXPECT_TRUE(out.flags & kBypass) << "nothing of it is left";
  EXPECT_EQ(Turn(body::kSpine).norm(), 0);
}

TEST_F(PostureTest, WhoLiesCrouchesOrHangsKeepsTheirOwn) {
  Pose lies = Standing();
  lies.rotations[body::kHips] = body::Exp(Vec3(-1.5F, 0, 0));
  lies.hips_position_m.y() = 0.1F;
  Pose hangs = Standing();
  hangs.rotations[body::kHips] = body::Exp(Vec3(0, 0, 3.1F));
  Pose bows = Standing();
  bows.rotations[body::kSpine] = body::Exp(Vec3(1.8F, 0, 0));
  Pose crouches = Standing();
  for (const auto leg : {body::kLeftUpperLeg, body::kRightUpperLeg}) {
    crouches.rotations[leg] = body::Exp(Vec3(-2.3F, 0, 0));
    crouches.rotations[static_cast<std::size_t>(leg) + 1] = body::Exp(Vec3(2.5F, 0, 0));
  }
  Show(1);
  for (const Pose& pose : {lies, hangs, bows, crouches}) {
    Perform(Standing(), 2);
    Perform(pose, 0.35);
    EXPECT_LT(Turn(body::kSpine).norm(), 0.1F * kStoop_rad)
        << "hips at " << pose.hips_position_m.y() << ", spine "
        << pose.rotations[body::kSpine].coeffs().transpose();
  }
  Pose sits = Standing();  // on a chair
  for (const auto leg : {body::kLeftUpperLeg, body::kRightUpperLeg}) {
    sits.rotations[leg] = body::Exp(Vec3(-1.5F, 0, 0));
    sits.rotations[static_cast<std::size_t>(leg) + 1] = body::Exp(Vec3(1.5F, 0, 0));
  }
  Perform(sits, 3);
  EXPECT_NEAR(Turn(body::kSpine).x(), kStoop_rad, 0.01);
}

TEST_F(PostureTest, OnlyPartsThatAreStyledAreTurned) {
  settings.parts = *body::FindParts("head,legs");
  Show(1);
  Perform(Standing(), 3);
  EXPECT_EQ(Turn(body::kSpine).norm(), 0);
  EXPECT_EQ(Turn(body::kLeftShoulder).norm(), 0);
}

TEST_F(PostureTest, AStyleThatIsRemovedLosesItsPosture) {
  settings.input_style = 1;
  Show(0);
  Perform(Standing(), 3);
  EXPECT_NEAR(Turn(body::kSpine).x(), -kStoop_rad, 0.01);
}

TEST_F(PostureTest, ItIsOptional) {
  options.posture = 0.5F;
  Begin();
  Show(1);
  Perform(Standing(), 3);
  EXPECT_NEAR(Turn(body::kSpine).x(), kStoop_rad / 2, 0.01);
  options.posture = 0;
  Begin();
  Show(1);
  Perform(Standing(), 3);
  EXPECT_EQ(Turn(body::kSpine).norm(), 0);
  options.posture = 1;
  Begin();
  Show(3);
  Perform(Standing(), 3);
  EXPECT_EQ(Turn(body::kSpine).norm(), 0) << "a style that has none";
}

}  // namespace
}  // namespace styled::stylist

#include "daemon/perform/performer/smoothing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "model/body/pose.h"

namespace styled::pipeline {
namespace {

constexpr std::int64_t kStep_ns = 1'000'000'000 / 120;
constexpr float kDegree = 0.017453293F;

rig::RigPose OneJoint(const rig::Quat& rotation, const rig::Vec3& position = rig::Vec3::Zero()) {
  rig::RigPose pose;
  pose.rotations = {rotation};
  pose.translations = {position};
  return pose;
}
rig::Quat About(float angle_rad) { return body::Exp(rig::Vec3(0, 0, angle_rad)); }
float AngleOf(const rig::RigPose& pose) { return body::Log(pose.rotations[0]).z(); }

PoseSmoothing Filter(float rest_hz, float per_speed = 0.7F) { return {{rest_hz, per_speed}, 1, 1}; }

TEST(PoseSmoothing, WithoutACutoffNothingChanges) {
  PoseSmoothing none, off = Filter(0);
  for (int i = 0; i < 10; ++i) {
    const float angle = 0.3F * static_cast<float>(i % 2);
    for (PoseSmoothing* const filter : {&none, &off}) {
      rig::RigPose pose = OneJoint(About(angle));
      filter->Apply(pose, i * kStep_ns);
      EXPECT_EQ(pose.rotations[0].coeffs(), About(angle).coeffs());
    }
  }
}

TEST(PoseSmoothing, UntrackedJointsStayAndSpoilNothing) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  PoseSmoothing filter = Filter(2);
  rig::RigPose pose = OneJoint(About(0.5F), {1, 2, 3});
  filter.Apply(pose, 0);
  pose = OneJoint({kNan, kNan, kNan, kNan}, {kNan, 0, 0});
  filter.Apply(pose, kStep_ns);
  EXPECT_TRUE(std::isnan(pose.rotations[0].w()));
  EXPECT_TRUE(std::isnan(pose.translations[0].x()));
  pose = OneJoint(rig::Quat(0, 0, 0, 0), {1, 2, 3});
  filter.Apply(pose, 2 * kStep_ns);
  EXPECT_EQ(pose.rotations[0].coeffs().norm(), 0);
  pose = OneJoint(About(0.5F), {1, 2, 3});
  filter.Apply(pose, 3 * kStep_ns);
  EXPECT_NEAR(AngleOf(pose), 0.5F, 1e-5F);
  EXPECT_NEAR(pose.translations[0].z(), 3, 1e-5F);
}

// Noise of half a degree on a joint at rest: at 120 Hz a low-pass of 2 Hz leaves 0.22 of it; the
// noise's own speed opens it a little.
TEST(PoseSmoothing, JitterAtRestIsRemoved) {
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0, 0.5F * kDegree);
  PoseSmoothing filter = Filter(2, 0.7F);
  double in = 0, out = 0;
  for (int i = 0; i < 2400; ++i) {
    const float angle = noise(random);
    rig::RigPose pose = OneJoint(About(angle));
    filter.Apply(pose, i * kStep_ns);
    if (i < 240) continue;
    in += double{angle} * angle;
    out += double{AngleOf(pose)} * AngleOf(pose);
  }
  EXPECT_LT(std::sqrt(out / in), 0.4);
}

// A steady turn: the lag is the angle that is missing over the speed.
float Lag_s(PoseSmoothing filter, float speed) {
  rig::RigPose pose;
  float angle = 0;
  for (int i = 0; i < 240; ++i) {
    angle = std::remainder(speed * static_cast<float>(i) / 120, 6.2831853F);
    pose = OneJoint(About(angle));
    filter.Apply(pose, i * kStep_ns);
  }
  return std::abs(std::remainder(angle - AngleOf(pose), 6.2831853F)) / speed;
}

TEST(PoseSmoothing, AFastTurnIsLessLateThanASlowOne) {
  const float slow = Lag_s(Filter(2), 0.1F), fast = Lag_s(Filter(2), 3);
  EXPECT_LT(slow, 0.08F);  // 1 / (2 pi 2 Hz)
  EXPECT_GT(slow, 0.05F);
  EXPECT_LT(fast, 0.5F * slow);
  EXPECT_NEAR(Lag_s(Filter(2, 0), 3), 0.08F, 0.01F) << "without growth the lag stays";
}

TEST(PoseSmoothing, APositionIsFilteredInMetres) {
  // The same way in metres and in centimetres.
  PoseSmoothing metres = Filter(1), centimetres({1, 0.7F}, 1, 0.01F);
  for (int i = 0; i < 120; ++i) {
    const rig::Vec3 at(0.01F * static_cast<float>(i), 0, 0);
    rig::RigPose m = OneJoint(About(0), at), cm = OneJoint(About(0), 100 * at);
    metres.Apply(m, i * kStep_ns);
    centimetres.Apply(cm, i * kStep_ns);
    EXPECT_NEAR(100 * m.translations[0].x(), cm.translations[0].x(), 1e-2F);
  }
}

TEST(PoseSmoothing, AGapAStepBackAndARestartRestartTheFilter) {
  for (const std::int64_t later : {PoseSmoothing::kGap_ns + 1, std::int64_t{-1}, std::int64_t{0}}) {
    PoseSmoothing filter = Filter(1);
    rig::RigPose pose = OneJoint(About(0));
    filter.Apply(pose, 1000);
    if (later == 0) filter.Reset();
    pose = OneJoint(About(1));
    filter.Apply(pose, 1000 + later);
    EXPECT_NEAR(AngleOf(pose), 1, 1e-5F) << later;
  }
}

}  // namespace
}  // namespace styled::pipeline

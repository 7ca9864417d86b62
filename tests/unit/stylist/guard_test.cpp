// Whatever the weights compute and the rigs send, the stylist's output is a valid pose.
#include "model/stylist/guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "model/feet/legs.h"
#include "model/stylist/avatar.h"
#include "model/stylist/grounding.h"
#include "model/stylist/stylist.h"
#include "tests/support/units.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::stylist {
namespace {

using support::kNaN;
constexpr float kLow_m = 0.97F, kHigh_m = 1.3F;
static_assert(kLow_m < erd::kAwake_m && erd::kAwake_m < kHigh_m);

void ExpectPose(std::span<const body::Vec3> translations, std::span<const body::Quat> rotations,
                const std::string& what) {
  for (const body::Vec3& translation : translations) ASSERT_TRUE(translation.allFinite()) << what;
  for (const body::Quat& rotation : rotations) ASSERT_NEAR(rotation.norm(), 1, 1e-3) << what;
}

float GuardApart_rad(const body::Pose& a, const body::Pose& b) {
  float most = 0;
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    most = std::max(most, body::Log(a.rotations[joint].conjugate() * b.rotations[joint]).norm());
  }
  return most;
}

struct GuardTest : testing::Test {
  std::shared_ptr<const rig::Binding> binding =
      std::make_shared<const rig::Binding>(feet::HumanoidBinding());
  Output out{binding->skeleton()};
  Avatar avatar{binding, binding, rig::RigPose(binding->skeleton()), {}};
  bool avatar_sound = true;

  static Settings Style(int style) {
    Settings settings;
    settings.mix[0] = {style, 1.0F};
    settings.transition_s = 0;
    return settings;
  }
  rig::RigPose PoseAt(int frame, float height_m = kLow_m) const {
    rig::RigPose pose(binding->skeleton());
    const float t = static_cast<float>(frame) / 120;
    pose.translations[0] = rig::Vec3(0.2F * std::sin(t), height_m, 0.8F * t);
    for (std::size_t joint = 0; joint < pose.rotations.size(); ++joint) {
      const float swing = 0.2F * std::sin(6 * t + static_cast<float>(joint));
      pose.rotations[joint] = rig::Quat(Eigen::AngleAxisf(swing, rig::Vec3::UnitX()));
    }
    return pose;
  }
  void Feed(Stylist& stylist, int frame, const rig::RigPose& in) {
    stylist.Process(std::llround(1e9 * frame / 120), in, out);
    avatar_sound = avatar.Process(std::llround(1e9 * frame / 120), out);
    const std::string what = "frame " + std::to_string(frame);
    ExpectPose(out.rig.translations, out.rig.rotations, "rig, " + what);
    ExpectPose(out.source.translations, out.source.rotations, "source, " + what);
    ExpectPose({&out.canonical.hips_position_m, 1}, out.canonical.rotations, "canonical, " + what);
    ExpectPose(avatar.pose().translations, avatar.pose().rotations, "avatar, " + what);
  }
  void ExpectThePerformersOwn() const {
    EXPECT_TRUE(out.flags & kFailed);
    EXPECT_TRUE(out.flags & kBypass);
    EXPECT_EQ(out.in_force_count, 0);
    for (std::size_t joint = 0; joint < out.rig.rotations.size(); ++joint) {
      ASSERT_EQ(out.rig.rotations[joint].coeffs(), out.source.rotations[joint].coeffs());
      ASSERT_EQ(out.rig.translations[joint], out.source.translations[joint]);
      ASSERT_EQ(out.canonical.rotations[joint].coeffs(),
                out.canonical_input.rotations[joint].coeffs());
    }
  }
};

TEST_F(GuardTest, WildWeightsLeaveThePerformersOwnPoseAndSaySo) {
  for (const char* const tensor : {"head.rotation.weight", "feature.deviation"}) {
    erd::WeightsFile file = erd::RandomWeights(5, 1);
    for (float& value : file.tensor(tensor).values) value *= 1e30F;
    for (const bool absolute : {false, true}) {
      Stylist stylist(erd::StylizerOf(file), binding, {});
      Settings settings = Style(2);
      settings.absolute = absolute;
      for (int frame = 1; frame < 120; ++frame) {
        if (frame == 30) stylist.Set(settings);
        rig::RigPose in = PoseAt(frame);
        if (frame == 60) in.rotations[3].x() = kNaN;
        Feed(stylist, frame, in);
        ExpectThePerformersOwn();
        EXPECT_EQ((out.flags & kHeld) != 0, frame == 60);
        EXPECT_EQ((out.flags & kConcealed), 0U);
        ASSERT_FALSE(HasFatalFailure()) << tensor << ", frame " << frame;
      }
    }
  }
}

// Contacts come from the performer's own feet, which are not affected.
TEST_F(GuardTest, WildWeightsDoNotSpoilTheContacts) {
  erd::WeightsFile file = erd::RandomWeights(5, 1);
  for (float& value : file.tensor("head.rotation.weight").values) value *= 1e30F;
  Stylist wild(erd::StylizerOf(file), binding, {}), plain(erd::RandomStylizer(5, 1), binding, {});
  Output expected(binding->skeleton());
  for (int frame = 1; frame < 240; ++frame) {
    const rig::RigPose in = PoseAt(frame < 100 ? 1 : frame);  // stands, then walks
    plain.Process(std::llround(1e9 * frame / 120), in, expected);
    Feed(wild, frame, in);
    EXPECT_EQ(out.contacts, expected.contacts) << frame;
    if (frame == 99) {
      EXPECT_NE(out.contacts, 0U);
    }
  }
}

TEST_F(GuardTest, ABadStepSpoilsNoLaterOneAndTheStyleIsFadedInAgain) {
  Options options;
  options.limb_gate = false;  // a random network knows no limb at all
  Stylist stylist(erd::StylizerOf(erd::SleepingWeights(5, 1)), binding, options);
  stylist.Set(Style(2));
  int frame = 1;
  for (; frame < 120; ++frame) {
    Feed(stylist, frame, PoseAt(frame));
    ASSERT_FALSE(out.flags & (kFailed | kBypass)) << frame;
  }
  const float styled_rad = GuardApart_rad(out.canonical, out.canonical_input);
  EXPECT_GT(styled_rad, 0.02F);
  int failed = 0;
  for (; frame < 160; ++frame) {
    Feed(stylist, frame, PoseAt(frame, kHigh_m));
    if ((out.flags & kFailed) == 0) continue;
    ++failed;
    ExpectThePerformersOwn();
  }
  EXPECT_EQ(failed, 40) << "at 120 Hz one of the four states steps in every frame";
  body::Pose before = out.canonical;
  for (const int end = frame + 120; frame < end; ++frame) {
    Feed(stylist, frame, PoseAt(frame));
    EXPECT_FALSE(out.flags & kFailed) << frame;
    EXPECT_LT(GuardApart_rad(before, out.canonical), 0.1F) << "no pop, frame " << frame;
    before = out.canonical;
  }
  EXPECT_FALSE(out.flags & kBypass);
  EXPECT_GT(GuardApart_rad(out.canonical, out.canonical_input), 0.5F * styled_rad);
}

// The result is the same together with others and alone.
TEST_F(GuardTest, AFailingStylistDisturbsNoOtherInTheSameCall) {
  erd::WeightsFile file = erd::SleepingWeights(5, 1);
  const auto network = erd::StylizerOf(file);
  Stylist alone(network, binding, {}), beside(network, binding, {}), high(network, binding, {});
  alone.Set(Style(2));
  beside.Set(Style(2));
  high.Set(Style(2));
  Output expected(binding->skeleton()), of_high(binding->skeleton());
  int failed = 0;
  for (int frame = 1; frame < 120; ++frame) {
    const rig::RigPose in = PoseAt(frame), in_high = PoseAt(frame, kHigh_m);
    const std::int64_t time_ns = std::llround(1e9 * frame / 120);
    alone.Process(time_ns, in, expected);
    const std::array<Stylist::Job, 2> jobs{Stylist::Job{&high, time_ns, &in_high, &of_high},
                                           Stylist::Job{&beside, time_ns, &in, &out}};
    Stylist::ProcessTogether(jobs);
    failed += (of_high.flags & kFailed) != 0 ? 1 : 0;
    ASSERT_EQ(out.flags, expected.flags);
    for (std::size_t joint = 0; joint < out.rig.rotations.size(); ++joint) {
      ASSERT_EQ(out.rig.rotations[joint].coeffs(), expected.rig.rotations[joint].coeffs());
    }
  }
  EXPECT_GT(failed, 20);
}

TEST_F(GuardTest, GoodWeightsNeverFail) {
  Stylist stylist(erd::RandomStylizer(5, 1), binding, {});
  stylist.Set(Style(3));
  for (int frame = 1; frame < 400; ++frame) {
    Feed(stylist, frame, PoseAt(frame));
    ASSERT_FALSE(out.flags & kFailed) << frame;
    ASSERT_TRUE(avatar_sound);
  }
}

// An avatar has a guard of its own, because its feet have state, too.
TEST_F(GuardTest, AnAvatarIsGivenThePerformersOwnWhereTheStyledPoseIsNone) {
  out.source = PoseAt(1);
  out.canonical_input.rotations[body::kLeftLowerArm] =
      rig::Quat(Eigen::AngleAxisf(0.5F, rig::Vec3::UnitY()));
  out.canonical = out.canonical_input;
  EXPECT_TRUE(avatar.Process(0, out));
  out.canonical.rotations[body::kHead].x() = kNaN;
  for (int frame = 1; frame < 10; ++frame) {
    EXPECT_FALSE(avatar.Process(frame * 8'000'000LL, out));
    ExpectPose(avatar.pose().translations, avatar.pose().rotations, "spoilt");
    EXPECT_LT(avatar.pose().rotations[body::kLeftLowerArm].angularDistance(
                  out.canonical_input.rotations[body::kLeftLowerArm]),
              1e-3F);
  }
  out.canonical = out.canonical_input;
  EXPECT_TRUE(avatar.Process(100'000'000, out));
  ExpectPose(avatar.pose().translations, avatar.pose().rotations, "afterwards");
}

// Finite but absurd values: what a hostile sender can put into a valid datagram.
TEST_F(GuardTest, AbsurdInputLeavesAPoseOnEveryTopic) {
  std::mt19937 random(5);
  const std::array<float, 12> absurd{1e30F,  -1e30F, 3e38F, 1e9F,  -9.9e8F, 1e8F,
                                     1e-30F, 1e-42F, 1e19F, 1e-3F, 2e-3F,   kNaN};
  const auto any = [&] { return absurd[random() % absurd.size()]; };
  Options options;
  options.jump_accept_frames = 2;  // so that the values are accepted
  const auto network = erd::RandomStylizer(5, 1);
  const rig::BindingSpec humanoid = binding->spec();
  for (int round = 0; round < 60; ++round) {
    rig::BindingSpec spec = humanoid;  // units of a hand's breadth, of the Earth, of an atom
    for (rig::Vec3& offset : spec.skeleton.offsets) {
      offset *= std::array{10.0F, 1e-7F, 9e5F}[static_cast<std::size_t>(round) % 3];
    }
    binding = std::make_shared<const rig::Binding>(rig::Binding::Make(std::move(spec)).value());
    avatar = Avatar(binding, binding, rig::RigPose(binding->skeleton()), {});
    Stylist stylist(network, binding, options);
    stylist.Set(Style(1 + round % 4));
    const int kind = round % 5;
    for (int frame = 1; frame < 80; ++frame) {
      rig::RigPose in = PoseAt(frame);
      in.translations[0] /= binding->scale();
      if (frame > 20 && frame < 60) {
        const auto joint = random() % in.rotations.size();
        const auto axis = static_cast<Eigen::Index>(random() % 3);
        if (kind == 0) in.translations[0][axis] = any();
        if (kind == 1) in.rotations[joint].coeffs() *= any();
        if (kind == 2) in.rotations[joint].coeffs()[axis] = any();
        if (kind == 3) in.translations[0].setConstant(9e8F * (frame % 8 < 4 ? 1.0F : -1.0F));
        if (kind == 4) {
          for (auto& rotation : in.rotations) rotation.coeffs().setConstant(any());
        }
      }
      Feed(stylist, frame, in);
      ASSERT_FALSE(HasFatalFailure()) << "kind " << kind << ", frame " << frame;
    }
    ASSERT_FALSE(out.flags & kFailed) << "kind " << kind << ": nothing stays behind";
  }
}

// After forty metres of stride the hips are there, and nothing else may be.
TEST_F(GuardTest, AStrideMovesTheHipsAlone) {
  const body::Vec3 moved_m(0, 0, 40);
  const body::Pose own;
  body::Pose pose = own;
  EXPECT_FALSE(IsSound(pose, own, moved_m));
  pose.hips_position_m += moved_m;
  EXPECT_FALSE(IsSound(pose, own));
  EXPECT_TRUE(IsSound(pose, own, moved_m));
  pose.hips_position_m += moved_m;
  EXPECT_FALSE(IsSound(pose, own, moved_m));

  const rig::RigPose given(binding->skeleton());
  rig::RigPose styled = given;
  Shift(*binding, moved_m, styled);
  EXPECT_FALSE(IsSound(*binding, styled, given));
  EXPECT_TRUE(IsSound(*binding, styled, given, moved_m));
  const auto hand = static_cast<std::size_t>(binding->spec().source_joint[body::kLeftHand]);
  styled.translations[hand].z() += 40 / binding->scale();
  EXPECT_FALSE(IsSound(*binding, styled, given, moved_m));
}

TEST_F(GuardTest, EveryFaultOfAPoseIsSeen) {
  const body::Pose own;
  body::Pose pose = own;
  EXPECT_TRUE(IsSound(pose, own));
  for (const float bad : {kNaN, std::numeric_limits<float>::infinity(), 0.9F, -1.1F}) {
    pose = own;
    pose.rotations[body::kRightToes].w() = bad;
    EXPECT_FALSE(IsSound(pose, own)) << bad;
  }
  for (const float bad : {kNaN, -std::numeric_limits<float>::infinity(), 7.0F, 1e30F}) {
    pose = own;
    pose.hips_position_m.z() = bad;
    EXPECT_FALSE(IsSound(pose, own)) << bad;
  }
  const rig::RigPose given(binding->skeleton());
  const float metre = 1 / binding->scale();
  rig::RigPose styled = given;
  styled.translations[2].x() += 4 * metre;
  EXPECT_TRUE(IsSound(*binding, styled, given));
  styled.translations[2].x() += 2 * metre;
  EXPECT_FALSE(IsSound(*binding, styled, given));

  net::Prediction step;
  const auto good = [&step] {
    for (net::Decoded* decoded : {&step.reconstruction, &step.styled}) {
      decoded->rotations.fill(body::Quat::Identity());
      decoded->velocities_m_s.fill(0);
      decoded->hips_height_m = 1;
    }
  };
  good();
  EXPECT_TRUE(IsSound(step));
  step.styled.rotations[20].z() = kNaN;
  EXPECT_FALSE(IsSound(step));
  good();
  step.reconstruction.velocities_m_s[62] = kNaN;
  EXPECT_FALSE(IsSound(step));
  good();
  step.styled.hips_height_m = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(IsSound(step));
}

}  // namespace
}  // namespace styled::stylist

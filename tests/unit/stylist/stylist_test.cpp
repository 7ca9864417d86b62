#include "model/stylist/stylist.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "model/body/heading.h"
#include "model/rig/dialects.h"
#include "tests/support/units.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::stylist {
namespace {

using support::kNaN;

rig::Skeleton CanonicalSkeleton() {
  rig::Skeleton skeleton;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    skeleton.names.emplace_back(body::kHumanoid[static_cast<std::size_t>(joint)].name);
    skeleton.parents.push_back(body::kHumanoid[static_cast<std::size_t>(joint)].parent);
    skeleton.offsets.push_back(body::Offset(joint));
  }
  return skeleton;
}

bool SameBits(const rig::RigPose& a, const rig::RigPose& b) {
  const std::size_t joints = a.rotations.size();
  return std::memcmp(a.rotations.data(), b.rotations.data(), joints * sizeof(rig::Quat)) == 0 &&
         std::memcmp(a.translations.data(), b.translations.data(), joints * sizeof(rig::Vec3)) == 0;
}

float Apart_rad(const body::Pose& a, const body::Pose& b) {
  float most = 0;
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    most = std::max(most, body::Log(a.rotations[joint].conjugate() * b.rotations[joint]).norm());
  }
  return most;
}

// A body that walks on the spot along a slow curve: enough to keep every feature changing.
rig::RigPose PoseAt(double time_s, const rig::Skeleton& skeleton) {
  rig::RigPose pose(skeleton);
  const auto t = static_cast<float>(time_s);
  pose.translations[0] =
      rig::Vec3(0.5F * std::sin(0.3F * t), 0.97F + 0.01F * std::sin(12 * t), 0.8F * t);
  for (std::size_t joint = 0; joint < pose.rotations.size(); ++joint) {
    const float swing = 0.2F * std::sin(6 * t + static_cast<float>(joint));
    pose.rotations[joint] = rig::Quat(Eigen::AngleAxisf(swing, rig::Vec3::UnitX()));
  }
  pose.rotations[0] = rig::Quat(Eigen::AngleAxisf(0.3F * std::cos(0.3F * t), rig::Vec3::UnitY()));
  return pose;
}

struct StylistTest : testing::Test {
  std::shared_ptr<const net::Stylizer> network = erd::RandomStylizer(5, 1);
  rig::Skeleton skeleton = CanonicalSkeleton();
  std::shared_ptr<const rig::Binding> binding = [this] {
    auto bound = rig::BindDialect(skeleton, "canonical");
    EXPECT_TRUE(bound.ok()) << (bound.ok() ? "" : bound.status().message());
    return std::make_shared<const rig::Binding>(std::move(bound.value()));
  }();
  Options options = [] {
    Options ungated;
    ungated.limb_gate = false;  // a random network knows no limb at all
    return ungated;
  }();
  Output out{skeleton};

  static Settings Style(int style, float weight = 1.0F, float transition_s = 0) {
    Settings settings;
    settings.mix[0] = {style, weight};
    settings.transition_s = transition_s;
    return settings;
  }
  static std::int64_t Time(int frame, double rate_hz = 120) {
    return std::llround(1e9 * frame / rate_hz);
  }
  void Feed(Stylist& stylist, int frame, double rate_hz = 120) {
    const std::int64_t time_ns = Time(frame, rate_hz);
    stylist.Process(time_ns, PoseAt(static_cast<double>(time_ns) * 1e-9, skeleton), out);
  }
};

TEST_F(StylistTest, WithoutAStyleTheSourceLeavesBitForBit) {
  Stylist stylist(network, binding, options);
  for (int frame = 0; frame < 100; ++frame) {
    rig::RigPose in = PoseAt(frame / 120.0, skeleton);
    in.rotations[3].coeffs() *= 1.0001F;  // not exactly of unit length, as rigs send it
    stylist.Process(Time(frame), in, out);
    ASSERT_TRUE(SameBits(out.rig, in));
    ASSERT_TRUE(out.flags & kBypass);
  }
}

// The pose is the same as of one that does not rest; the network's time is saved.
TEST_F(StylistTest, ARestingStylistFadesOutAndThenRunsNoStepOfTheNetwork) {
  Stylist resting(network, binding, options), waking(network, binding, options);
  for (Stylist* const stylist : {&resting, &waking}) stylist->Set(Style(2));
  Output other(skeleton);
  for (int frame = 0; frame < 240; ++frame) {
    if (frame == 60) {
      resting.Rest(true);
      for (Stylist* const stylist : {&resting, &waking}) stylist->Set(Style(-1, 0, 0.1F));
    }
    const std::int64_t time_ns = Time(frame);
    const rig::RigPose in = PoseAt(static_cast<double>(time_ns) * 1e-9, skeleton);
    waking.Process(time_ns, in, other);
    Feed(resting, frame);
    ASSERT_TRUE(SameBits(out.rig, other.rig)) << frame;
    if (frame > 60 + 120) {
      ASSERT_EQ(out.steps, 0) << frame;
      ASSERT_GT(other.steps, 0) << frame;
      ASSERT_TRUE(SameBits(out.rig, in)) << frame;
    }
  }
}

TEST_F(StylistTest, AfterARestTheStyleFadesInWithoutAJump) {
  Stylist stylist(network, binding, options);
  stylist.Rest(true);
  for (int frame = 0; frame < 120; ++frame) Feed(stylist, frame);
  EXPECT_EQ(out.steps, 0);
  stylist.Rest(false);
  stylist.Set(Style(2, 1, 0.5F));
  body::Pose last = out.canonical, last_input = out.canonical_input;
  float largest_rad = 0;
  for (int frame = 120; frame < 360; ++frame) {
    Feed(stylist, frame);
    EXPECT_GT(out.steps, 0);
    const float moved_rad = Apart_rad(last, out.canonical);
    largest_rad = std::max(largest_rad, moved_rad - Apart_rad(last_input, out.canonical_input));
    last = out.canonical;
    last_input = out.canonical_input;
  }
  EXPECT_GT(Apart_rad(out.canonical, out.canonical_input), 1e-3F) << "the style is back";
  EXPECT_LT(largest_rad, 0.1F) << "of a frame; at once it would be most of the style";
}

TEST_F(StylistTest, AStyleChangesThePoseFromTheFirstFrame) {
  Stylist stylist(network, binding, options);
  stylist.Set(Style(2));
  Feed(stylist, 0);
  EXPECT_FALSE(out.flags & kBypass);
  EXPECT_TRUE(out.flags & kNewSession);
  EXPECT_GT(Apart_rad(out.canonical, out.canonical_input), 1e-3F);
  ASSERT_EQ(out.in_force_count, 1);
  EXPECT_EQ(out.in_force[0].style, 2);
}

TEST_F(StylistTest, PartsThatAreNotStyledStayAsCaptured) {
  for (const std::string_view word : {"arms", "head", "legs", "upper", "right-leg"}) {
    Stylist stylist(network, binding, options);
    Stylist whole(network, binding, options);
    Settings some = Style(2);
    some.parts = *body::FindParts(word);
    stylist.Set(some);
    whole.Set(Style(2));
    for (int frame = 0; frame < 60; ++frame) {
      Feed(whole, frame);
      const body::Pose all = out.canonical;
      Feed(stylist, frame);
      for (int joint = 0; joint < body::kJointCount; ++joint) {
        const bool styled = (some.parts & body::Bit(body::PartOf(joint))) != 0;
        // If the torso or the legs are styled, the legs change, because the feet are held.
        const bool held = word != "arms" && word != "head";
        if (held && joint >= body::kLeftUpperLeg) continue;
        const body::Quat& expected =
            (styled ? all : out.canonical_input).rotations[static_cast<std::size_t>(joint)];
        const body::Quat& got = out.canonical.rotations[static_cast<std::size_t>(joint)];
        ASSERT_LT(body::Log(expected.conjugate() * got).norm(), 1e-5F)
            << word << ", frame " << frame << ", joint " << joint;
      }
    }
  }
}

TEST_F(StylistTest, AStyleOfThePerformersOwnIsTakenAway) {
  options.change_tau_s = 0;
  options.feet = options.ground = false;
  Settings to_neutral = Style(0, 1, 0.3F);
  to_neutral.input_style = 3;
  Stylist stylist(network, binding, options);
  Feed(stylist, 0);
  EXPECT_TRUE(out.flags & kBypass) << "nothing was asked for";
  stylist.Set(to_neutral);
  body::Pose before = out.canonical;
  for (int frame = 1; frame < 60; ++frame) {
    Feed(stylist, frame);
    EXPECT_LT(Apart_rad(before, out.canonical), 0.15F) << "faded in, frame " << frame;
    before = out.canonical;
  }
  EXPECT_FALSE(out.flags & kBypass);
  EXPECT_GT(Apart_rad(out.canonical, out.canonical_input), 1e-2F);

  // Requesting the input style changes nothing; requesting no style is bypass.
  Settings to_own = Style(3);
  to_own.input_style = 3;
  stylist.Set(to_own);
  for (int frame = 60; frame < 240; ++frame) Feed(stylist, frame);
  EXPECT_LT(Apart_rad(out.canonical, out.canonical_input), 1e-5F);
  Settings none;
  none.input_style = 3;
  stylist.Set(none);
  for (int frame = 240; frame < 480; ++frame) Feed(stylist, frame);
  EXPECT_TRUE(out.flags & kBypass);
}

TEST_F(StylistTest, BeingToldOfAStyleOfHisOwnIsNoJump) {
  options.feet = options.ground = false;  // they have fades of their own
  Settings nothing_asked, to_neutral = Style(0, 1, 0.6F);
  nothing_asked.input_style = to_neutral.input_style = 3;
  Stylist stylist(network, binding, options);
  stylist.Set(nothing_asked);
  for (int frame = 0; frame < 60; ++frame) Feed(stylist, frame);
  EXPECT_TRUE(out.flags & kBypass);
  stylist.Set(Settings());
  Feed(stylist, 60);
  EXPECT_TRUE(out.flags & kBypass);

  // Nor in the middle of a fade.
  stylist.Set(to_neutral);
  body::Pose before;
  for (int frame = 61; frame < 120; ++frame) Feed(stylist, frame);
  EXPECT_GT(Apart_rad(out.canonical, out.canonical_input), 1e-2F);
  stylist.Set(Settings());
  for (int frame = 120; frame < 230; ++frame) {
    before = out.canonical;
    Feed(stylist, frame);
    EXPECT_LT(Apart_rad(before, out.canonical), 0.1F) << "frame " << frame;
  }
}

TEST_F(StylistTest, BypassIsEnteredByAFadeAndThenExact) {
  Stylist stylist(network, binding, options);
  stylist.Set(Style(2));
  for (int frame = 0; frame < 120; ++frame) Feed(stylist, frame);
  Settings none;
  none.transition_s = 0.3F;
  stylist.Set(none);
  int first_exact = -1;
  body::Pose before = out.canonical;
  for (int frame = 120; frame < 480; ++frame) {
    Feed(stylist, frame);
    EXPECT_LT(Apart_rad(before, out.canonical), 0.1F) << "no pop at frame " << frame;
    before = out.canonical;
    if (first_exact < 0 && (out.flags & kBypass)) first_exact = frame;
  }
  EXPECT_GT(first_exact, 120 + 36);
  EXPECT_LT(first_exact, 120 + 36 + 120);
  EXPECT_TRUE(SameBits(out.rig, out.source));
}

// A switch takes as long as its displacement needs, however short the fade; a cut takes no time.
TEST_F(StylistTest, ASwitchThrowsNoLimb) {
  // Styles that are far apart: their columns of the decoder's input are large.
  erd::WeightsFile weights = erd::RandomWeights(5, 1);
  net::NamedTensor& decoder = weights.tensor("decoder.0.weight");
  const auto width = static_cast<std::size_t>(decoder.shape[1]);
  for (std::size_t i = 0; i < decoder.values.size(); ++i) {
    if (i % width >= width - 5) decoder.values[i] *= 20;
  }
  network = erd::StylizerOf(weights);
  options.feet = false;
  options.change_tau_s = 0.01F;
  const auto hardest_mps2 = [this](float transition_s, int faded_at = 0) {
    Stylist stylist(network, binding, options);
    stylist.Set(Style(2));
    std::array<body::WorldPose, 3> world;
    float hardest = 0;
    const auto at = [&world](int frame) -> body::WorldPose& {
      return world[static_cast<std::size_t>(frame) % world.size()];
    };
    for (int frame = 0; frame < 360; ++frame) {
      if (frame == faded_at) stylist.Set(Style(2, 1, 0.1F));
      if (frame == 240) stylist.Set(Style(3, 1, transition_s));
      stylist.Process(Time(frame), PoseAt(0, skeleton), out);  // stands still
      body::ForwardKinematics(out.canonical, at(frame));
      for (std::size_t joint = 0; frame >= 240 && joint < body::kJointCount; ++joint) {
        const body::Vec3 second = at(frame).positions_m[joint] -
                                  2 * at(frame - 1).positions_m[joint] +
                                  at(frame - 2).positions_m[joint];
        hardest = std::max(hardest, second.norm() * 120 * 120);
      }
    }
    return hardest;
  };
  const float cut = hardest_mps2(0);
  const float quick = hardest_mps2(0.02F);
  EXPECT_GT(cut, 500);
  EXPECT_LT(quick, 0.25F * cut);
  EXPECT_LT(hardest_mps2(1), 0.5F * quick);
  EXPECT_NEAR(hardest_mps2(0, 220), cut, 0.05F * cut) << "a cut soon after a fade is one, too";
}

TEST_F(StylistTest, TheSameStreamGivesTheSameBits) {
  Stylist a(network, binding, options), b(network, binding, options);
  Output other(skeleton);
  for (int frame = 0; frame < 300; ++frame) {
    if (frame == 50) a.Set(Style(1, 1, 0.2F)), b.Set(Style(1, 1, 0.2F));
    if (frame == 150) a.Set(Style(3, 0.5F, 0.2F)), b.Set(Style(3, 0.5F, 0.2F));
    const rig::RigPose in = PoseAt(frame / 120.0, skeleton);
    a.Process(Time(frame), in, out);
    b.Process(Time(frame), in, other);
    ASSERT_TRUE(SameBits(out.rig, other.rig)) << frame;
  }
}

// More stylists than are processed at a time, of different rates, styles, clocks and phases; one
// with gaps, so that several ticks are due in a frame; one on other weights.
TEST_F(StylistTest, TogetherIsBitForBitOneByOne) {
  constexpr int kPerformers = 19;
  const auto other = erd::RandomStylizer(5, 2);
  std::vector<Stylist> alone, together;
  std::vector<Output> out_alone, out_together;
  for (int k = 0; k < kPerformers; ++k) {
    for (auto* crowd : {&alone, &together}) {
      crowd->emplace_back(k == 6 ? other : network, binding, options);
      if (k % 4 != 0) crowd->back().Set(Style(k % 4, 0.5F + 0.1F * static_cast<float>(k % 3)));
    }
    out_alone.emplace_back(skeleton);
    out_together.emplace_back(skeleton);
  }
  for (int frame = 1; frame < 60; ++frame) {
    std::vector<rig::RigPose> in;
    std::vector<Stylist::Job> jobs;
    for (int k = 0; k < kPerformers; ++k) {
      in.push_back(PoseAt(0.3 * k + frame / 120.0, skeleton));
    }
    for (int k = 0; k < kPerformers; ++k) {
      const auto i = static_cast<std::size_t>(k);
      if (k == 3 && frame % 20 > 13) continue;  // gaps
      const std::int64_t time_ns = Time(frame, k % 2 == 0 ? 120 : 50) + 1'000'000 * k;
      alone[i].Process(time_ns, in[i], out_alone[i]);
      jobs.push_back({&together[i], time_ns, &in[i], &out_together[i]});
    }
    Stylist::ProcessTogether(jobs);
    for (std::size_t i = 0; i < kPerformers; ++i) {
      ASSERT_TRUE(SameBits(out_alone[i].rig, out_together[i].rig)) << frame << ", " << i;
      ASSERT_EQ(out_alone[i].flags, out_together[i].flags) << frame << ", " << i;
      ASSERT_EQ(out_alone[i].reconstruction_rad, out_together[i].reconstruction_rad);
    }
  }
}

TEST_F(StylistTest, PrewarmingChangesNothing) {
  Stylist warmed(network, binding, options), cold(network, binding, options);
  Output other(skeleton);
  warmed.Set(Style(1));
  cold.Set(Style(1));
  Rehearsal rehearsal(network, binding, options);
  rehearsal.Prewarm(warmed);
  for (int frame = 1; frame < 40; ++frame) {
    Feed(warmed, frame);
    rehearsal.Prewarm(warmed);
    cold.Process(Time(frame), PoseAt(static_cast<double>(Time(frame)) * 1e-9, skeleton), other);
    ASSERT_TRUE(SameBits(out.rig, other.rig)) << frame;
  }
}

// A rehearsal takes as much memory as a stylist: with one for each, half as many performers fit.
TEST_F(StylistTest, StylistsOfAsManyJointsShareARehearsalThatChangesNoneOfThem) {
  const auto shared = Rehearsal::Shared(network, binding, options);
  EXPECT_EQ(Rehearsal::Shared(network, binding, options), shared);
  Stylist warmed(network, binding, options), second(network, binding, options),
      cold(network, binding, options);
  Output other(skeleton);
  warmed.Set(Style(1));
  second.Set(Style(2));
  cold.Set(Style(1));
  for (int frame = 0; frame < 40; ++frame) {
    shared->Prewarm(second);
    Feed(second, frame);
    shared->Prewarm(warmed);
    Feed(warmed, frame);
    cold.Process(Time(frame), PoseAt(static_cast<double>(Time(frame)) * 1e-9, skeleton), other);
    ASSERT_TRUE(SameBits(out.rig, other.rig)) << frame;
  }
}

TEST_F(StylistTest, TheChangeDoesNotDependOnWhereThePerformerStandsOrFaces) {
  Stylist here(network, binding, options), there(network, binding, options);
  here.Set(Style(2));
  there.Set(Style(2));
  const rig::Quat turn(Eigen::AngleAxisf(2.1F, rig::Vec3::UnitY()));
  Output moved(skeleton);
  for (int frame = 0; frame < 240; ++frame) {
    rig::RigPose in = PoseAt(frame / 120.0, skeleton);
    here.Process(Time(frame), in, out);
    in.translations[0] = turn * in.translations[0] + rig::Vec3(3, 0, -7);
    in.rotations[0] = turn * in.rotations[0];
    there.Process(Time(frame), in, moved);
    rig::RigPose back = moved.rig;
    back.rotations[0] = turn.conjugate() * back.rotations[0];
    for (std::size_t joint = 0; joint < skeleton.names.size(); ++joint) {
      ASSERT_LT(body::Log(back.rotations[joint].conjugate() * out.rig.rotations[joint]).norm(),
                2e-3F)
          << frame << " " << skeleton.names[joint];
    }
  }
}

TEST_F(StylistTest, TheLowestFootStaysAsHighAsTheInputs) {
  Stylist stylist(network, binding, options);
  Settings settings = Style(4, 1.5F);
  stylist.Set(settings);
  for (int frame = 0; frame < 240; ++frame) {
    Feed(stylist, frame);
    body::WorldPose in, styled;
    body::ForwardKinematics(out.canonical_input, in);
    body::ForwardKinematics(out.canonical, styled);
    // Softened by 1 cm between the feet and smoothed over time. Without grounding the difference
    // would be metres.
    ASSERT_NEAR(body::LowestFoot_m(in), body::LowestFoot_m(styled), 0.03F) << frame;
    ASSERT_NEAR(out.rig.translations[0].y(), out.canonical.hips_position_m.y(), 1e-4F);
  }
}

TEST_F(StylistTest, AShortGapIsBridgedAndFlagged) {
  Stylist straight(network, binding, options), holed(network, binding, options);
  straight.Set(Style(1));
  holed.Set(Style(1));
  Output whole(skeleton);
  for (int frame = 0; frame < 200; ++frame) {
    const rig::RigPose in = PoseAt(frame / 120.0, skeleton);
    straight.Process(Time(frame), in, whole);
    if (frame >= 100 && frame < 106) continue;
    holed.Process(Time(frame), in, out);
    EXPECT_EQ((out.flags & kConcealed) != 0, frame == 106) << frame;
  }
  EXPECT_LT(Apart_rad(whole.canonical, out.canonical), 0.02F);
}

TEST_F(StylistTest, ALongGapStartsAnewWithoutAPop) {
  Stylist stylist(network, binding, options);
  stylist.Set(Style(1));
  for (int frame = 0; frame < 200; ++frame) Feed(stylist, frame);
  const body::Pose change_before = out.canonical, input_before = out.canonical_input;
  const double resume = 200 + 120 * 2;
  stylist.Process(Time(static_cast<int>(resume)), PoseAt(199 / 120.0, skeleton), out);
  EXPECT_TRUE(out.flags & kConcealed);
  EXPECT_LT(Apart_rad(input_before, out.canonical_input), 1e-5F);
  EXPECT_LT(Apart_rad(change_before, out.canonical), 1e-3F)
      << "the fade begins at what was applied";
}

// The gap is as long as every other one of this sender, and still is not bridged.
TEST_F(StylistTest, AClockThatAlwaysStepsFarIsNeverBridged) {
  Stylist stylist(network, binding, options);
  for (int frame = 0; frame < 30; ++frame) {
    stylist.Process(1'000'000'000'000LL * (frame + 1), PoseAt(frame, skeleton), out);
    EXPECT_LE(out.steps, 1) << frame;
    EXPECT_EQ(out.flags & kConcealed, frame == 1 ? kConcealed : 0U) << "a habit from then on";
  }
}

TEST_F(StylistTest, BadJointsAreHeldAndNamedAndNothingElseSuffers) {
  Stylist stylist(network, binding, options);
  stylist.Set(Style(1));
  for (int frame = 0; frame < 60; ++frame) Feed(stylist, frame);
  rig::RigPose in = PoseAt(60 / 120.0, skeleton);
  in.rotations[7].coeffs().setConstant(kNaN);
  in.rotations[9].coeffs().setZero();
  stylist.Process(Time(60), in, out);
  EXPECT_TRUE(out.flags & kHeld);
  EXPECT_EQ(out.held.count(), 2U);
  EXPECT_TRUE(out.held.test(7) && out.held.test(9));
  for (const rig::Quat& q : out.rig.rotations) EXPECT_NEAR(q.norm(), 1.0F, 1e-4F);
}

TEST_F(StylistTest, NothingThatComesInMakesAnythingNonFiniteGoOut) {
  Stylist stylist(network, binding, options);
  Settings settings = Style(1, 1.0F, 0.1F);
  settings.mix[1] = {3, 0.5F};
  stylist.Set(settings);
  unsigned seed = 7;
  const auto random = [&seed] { return seed = seed * 1664525U + 1013904223U; };
  std::int64_t time_ns = 0;
  for (int frame = 0; frame < 3000; ++frame) {
    rig::RigPose in = PoseAt(frame / 120.0, skeleton);
    for (int k = 0; k < 4; ++k) {
      std::uint32_t bits = random();
      float poison = 0;
      std::memcpy(&poison, &bits, 4);
      auto& q = in.rotations[random() % in.rotations.size()];
      q.coeffs()[static_cast<Eigen::Index>(random() % 4)] = poison;
      if (random() % 8 == 0) {
        in.translations[0][static_cast<Eigen::Index>(random() % 3)] = poison;
      }
    }
    time_ns += 1 + random() % 40'000'000;
    stylist.Process(time_ns, in, out);
    ASSERT_TRUE(out.canonical.hips_position_m.allFinite());
    for (std::size_t joint = 0; joint < out.rig.rotations.size(); ++joint) {
      ASSERT_TRUE(out.rig.translations[joint].allFinite()) << frame;
      ASSERT_NEAR(out.rig.rotations[joint].norm(), 1.0F, 1e-3F) << frame << " " << joint;
    }
  }
}

TEST_F(StylistTest, AResetBeginsANewSessionWhateverItsClock) {
  Stylist stylist(network, binding, options);
  stylist.Set(Style(1));
  for (int frame = 1000; frame < 1100; ++frame) Feed(stylist, frame);
  stylist.Reset();
  Feed(stylist, 0);
  EXPECT_TRUE(out.flags & kNewSession);
  ASSERT_EQ(out.in_force_count, 1);
  Feed(stylist, 1);
  EXPECT_FALSE(out.flags & kNewSession);
}

// The last pose, mirrored, shows the last style, mirrored, and then the style fades to what the
// network finds: no limb jumps. The other side of the room is not a jump that is held.
TEST_F(StylistTest, AMirroredPerformerShowsTheirStyleAsItsMirrorImage) {
  const auto mirrored = [](const rig::RigPose& pose) {
    rig::RigPose other = pose;
    other.translations[0] = rig::Mirrored(pose.translations[0]);
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      other.rotations[static_cast<std::size_t>(joint)] =
          rig::Mirrored(pose.rotations[static_cast<std::size_t>(body::MirrorJoint(joint))]);
    }
    return other;
  };
  // Feet that are held start again, as where a performer jumps.
  options.feet = false;
  for (const bool gated : {false, true}) {
    options.limb_gate = gated;
    Stylist stylist(network, binding, options), unaware(network, binding, options);
    Output other(skeleton);
    rig::RigPose last(skeleton);
    for (int frame = 0; frame < 120; ++frame) {
      last = PoseAt(static_cast<double>(frame) / 120, skeleton);
      last.translations[0].x() += 3;
      for (Stylist* const s : {&stylist, &unaware}) {
        s->Set(Style(2));
        s->Process(Time(frame), last, s == &stylist ? out : other);
      }
    }
    body::Pose expected;
    body::Mirror(out.canonical, expected);
    stylist.Mirror();
    unaware.Reset();
    stylist.Process(Time(120), mirrored(last), out);
    unaware.Process(Time(120), mirrored(last), other);
    EXPECT_TRUE(out.flags & kNewSession);
    EXPECT_FALSE(out.flags & kHeld);
    EXPECT_EQ(out.in_force_count, 1);
    EXPECT_LT(Apart_rad(out.canonical, expected), 1e-2F) << gated;
    EXPECT_GT(Apart_rad(other.canonical, expected), 5e-2F) << gated << ": a plain restart";
    EXPECT_LT((out.canonical.hips_position_m - expected.hips_position_m).norm(), 0.02F) << gated;
    // From there on nothing jumps.
    body::Pose before = out.canonical, before_input = out.canonical_input;
    for (int frame = 121; frame < 240; ++frame) {
      rig::RigPose pose = PoseAt(static_cast<double>(frame) / 120, skeleton);
      pose.translations[0].x() += 3;
      stylist.Process(Time(frame), mirrored(pose), out);
      EXPECT_LT(Apart_rad(before, out.canonical) - Apart_rad(before_input, out.canonical_input),
                0.1F)
          << gated << " " << frame;
      before = out.canonical;
      before_input = out.canonical_input;
    }
  }
}

TEST_F(StylistTest, AForeignPoseFadesTheStyleOutAndIsFlagged) {
  options.out_of_domain_begin_rad = 0;  // a random network knows no pose at all
  options.out_of_domain_end_rad = 1e-3F;
  Stylist stylist(network, binding, options);
  stylist.Set(Style(1));
  for (int frame = 0; frame < 240; ++frame) Feed(stylist, frame);
  EXPECT_TRUE(out.flags & kOutOfDomain);
  EXPECT_LT(Apart_rad(out.canonical, out.canonical_input), 0.01F);
}

TEST_F(StylistTest, ALyingPerformerIsNotStyledUntilTheyStandUp) {
  options.out_of_domain_begin_rad = 100;  // a random network knows no pose at all
  options.out_of_domain_end_rad = 101;
  Stylist stylist(network, binding, options);
  stylist.Set(Style(1));
  const auto feed = [&](int frame, float tilt_rad) {
    rig::RigPose pose = PoseAt(frame / 120.0, skeleton);
    pose.rotations[0] =
        rig::Quat(Eigen::AngleAxisf(-tilt_rad, rig::Vec3::UnitX())) * pose.rotations[0];
    stylist.Process(Time(frame), pose, out);
  };
  int frame = 0;
  for (; frame < 120; ++frame) feed(frame, 0.3F);
  EXPECT_FALSE(out.flags & kOutOfDomain);
  EXPECT_GT(Apart_rad(out.canonical, out.canonical_input), 1e-2F);
  for (int i = 0; i <= 60; ++i) feed(frame++, 1.6F * static_cast<float>(i) / 60);
  EXPECT_TRUE(out.flags & kOutOfDomain);
  for (int i = 0; i < 60; ++i) feed(frame++, 1.6F);
  EXPECT_LT(Apart_rad(out.canonical, out.canonical_input), 1e-4F);
  for (; frame < 480; ++frame) feed(frame, 0.3F);
  EXPECT_FALSE(out.flags & kOutOfDomain);
  EXPECT_GT(Apart_rad(out.canonical, out.canonical_input), 1e-2F);
}

TEST_F(StylistTest, LimbsThatTheNetworkDoesNotKnowKeepTheirOwnMotion) {
  options.ground = options.feet = options.bypass = false;
  Stylist ungated(network, binding, options);
  options.limb_gate = true;
  Stylist gated(network, binding, options);
  for (Stylist* stylist : {&ungated, &gated}) {
    stylist->Set(Style(2));
    for (int frame = 0; frame < 240; ++frame) Feed(*stylist, frame);
    float most_rad = 0;
    for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
      const float styled_rad = body::Log(out.canonical_input.rotations[joint].conjugate() *
                                         out.canonical.rotations[joint])
                                   .norm();
      const float shown =
          out.limb_weights[static_cast<std::size_t>(LimbOf(body::PartOf(static_cast<int>(joint))))];
      most_rad = std::max(most_rad, styled_rad);
      if (shown == 0) {
        EXPECT_LT(styled_rad, 1e-3F) << joint;
      }
    }
    const float least = *std::min_element(out.limb_weights.begin(), out.limb_weights.end());
    EXPECT_GT(*std::max_element(out.limb_errors_m.begin(), out.limb_errors_m.end()), 0.3F);
    EXPECT_EQ(least, stylist == &gated ? 0 : 1);
    if (stylist == &ungated) {
      EXPECT_GT(most_rad, 0.01F);
    }
  }
}

TEST_F(StylistTest, TheAbsoluteOutputIsTheDecodersOwn) {
  Stylist stylist(network, binding, options);
  Settings settings = Style(2);
  settings.absolute = true;
  options.out_of_domain_begin_rad = 100;
  options.out_of_domain_end_rad = 101;
  options.feet = false;
  Stylist unfaded(network, binding, options);
  unfaded.Set(settings);
  const std::unique_ptr<net::Stream> stream = network->MakeStream();
  for (int frame = 0; frame < 60; ++frame) {
    Feed(unfaded, frame, 30);
    net::Prediction step;
    const net::StyleWeight active{2, 1.0F};
    const net::StepJob job{&out.canonical_input, 0, {&active, 1}, stream.get(), &step};
    network->Step({&job, 1});
    for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
      body::Quat wanted = step.styled.rotations[joint];
      if (joint == body::kHips) wanted = body::Yaw(step.heading_rad) * wanted;
      ASSERT_LT(body::Log(wanted.conjugate() * out.canonical.rotations[joint]).norm(), 1e-3F)
          << frame << " " << joint;
    }
  }
}

// Weights whose second style walks half as fast again.
erd::WeightsFile StridingWeights() {
  erd::WeightsFile file = erd::RandomWeights(5, 1);
  for (const auto& [style, walk_mps] : {std::pair(0, 0.8), std::pair(2, 1.2)}) {
    file.metadata["styles"][style]["walk_mps"] = walk_mps;
    file.metadata["styles"][style]["run_mps"] = 2 * walk_mps;
  }
  return file;
}
std::shared_ptr<const net::Stylizer> Striding() { return erd::StylizerOf(StridingWeights()); }

TEST_F(StylistTest, AStrideTakesTheBodyAlongAndNoSettingMakesItJump) {
  options.change_tau_s = 0;
  Stylist stylist(Striding(), binding, options);
  Settings settings = Style(2, 1, 0.1F);
  settings.root = Root::kStride;
  stylist.Set(settings);
  int frame = 0;
  rig::Vec3 last = rig::Vec3::Zero();
  const auto go = [&](double seconds) {
    for (const int end = frame + static_cast<int>(120 * seconds); frame < end; ++frame) {
      Feed(stylist, frame);
      EXPECT_LT((out.rig.translations[0] - out.canonical.hips_position_m).norm(), 0.15F)
          << "on both skeletons alike, but for the height";
      rig::Vec3 step = out.rig.translations[0] - last;
      step.y() = 0;
      if (frame > 0) EXPECT_LT(step.norm() * 120, 1.5F) << "frame " << frame;
      last = out.rig.translations[0];
    }
    return out.rig.translations[0].z() - out.source.translations[0].z();
  };
  EXPECT_NEAR(go(5), 5 * 0.4, 0.2);
  EXPECT_FALSE(out.flags & kFailed);
  settings.root = Root::kFollow;
  stylist.Set(settings);
  const float kept = go(2);
  EXPECT_NEAR(go(2), kept, 1e-4F) << "the offset stays";
  stylist.Set({});
  go(5);
  EXPECT_TRUE(out.flags & kBypass);
  EXPECT_NEAR(go(1), kept, 1e-4F) << "in bypass, too";
  EXPECT_TRUE(SameBits(out.rig,
                       [this] {
                         rig::RigPose moved = out.source;
                         moved.translations[0] = out.rig.translations[0];
                         return moved;
                       }()))
      << "nothing else is changed";
  stylist.Reset();
  Feed(stylist, frame++);
  EXPECT_TRUE(SameBits(out.rig, out.source)) << "a reset brings the performer home";
}

TEST_F(StylistTest, AStrideNeedsAStyleOfTheLegs) {
  for (const std::string_view word : {"arms", "left-leg", "all"}) {
    Stylist stylist(Striding(), binding, options);
    Settings settings = Style(2);
    settings.root = Root::kStride;
    settings.parts = *body::FindParts(word);
    stylist.Set(settings);
    for (int frame = 0; frame < 240; ++frame) Feed(stylist, frame);
    if (word == "all") {
      EXPECT_GT(out.travel.moved_m.norm(), 0.5F);
    } else {
      EXPECT_EQ(out.travel.moved_m.norm(), 0) << word;
    }
  }
}

// Where time is warped, a stride has another length of steps; without the option nothing is.
TEST_F(StylistTest, TheCadenceIsOfAStyleOfTheLegsAndOnlyWhereItIsAskedFor) {
  for (const auto& [word, own_cadence] :
       {std::pair("all", true), std::pair("all", false), std::pair("arms", true)}) {
    options.own_cadence = own_cadence;
    erd::WeightsFile file = StridingWeights();
    file.metadata["styles"][0]["walk_spm"] = 100;
    file.metadata["styles"][2]["walk_spm"] = 125;
    Stylist stylist(erd::StylizerOf(file), binding, options);
    Settings settings = Style(2);
    settings.parts = *body::FindParts(word);
    stylist.Set(settings);
    for (int frame = 0; frame < 240; ++frame) Feed(stylist, frame);
    const bool warped = own_cadence && settings.parts == body::kAllParts;
    EXPECT_NEAR(out.cadence, warped ? 1.25F : 1, warped ? 0.05F : 0) << word << own_cadence;
    EXPECT_EQ(out.travel.moved_m.norm(), 0) << "the way is the performer's";
  }
}

TEST_F(StylistTest, ManyMetresOfStrideAreSound) {
  Stylist stylist(Striding(), binding, options);
  Settings settings = Style(2);
  settings.root = Root::kStride;
  stylist.Set(settings);
  for (int frame = 0; frame < 2000; ++frame) {
    const double time_s = frame / 20.0;
    rig::RigPose pose = PoseAt(time_s, skeleton);
    pose.translations[0].z() = static_cast<float>(1.6 * time_s);  // it runs: 1.5 times as fast
    stylist.Process(std::llround(1e9 * time_s), pose, out);
    ASSERT_FALSE(out.flags & kFailed) << "frame " << frame;
  }
  EXPECT_GT(out.travel.moved_m.norm(), 40);
}

}  // namespace
}  // namespace styled::stylist

#include "model/feet/feet.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <utility>

#include "tests/unit/feet/walker.h"
#include "tests/unit/rig/rigs.h"

namespace styled::feet {
namespace {

using Frames = std::vector<rig::RigPose>;
constexpr double kSeconds = 6;

bool SameBits(const rig::RigPose& a, const rig::RigPose& b) {
  return std::memcmp(a.rotations.data(), b.rotations.data(), a.rotations.size() * sizeof(Quat)) ==
             0 &&
         std::memcmp(a.translations.data(), b.translations.data(),
                     a.translations.size() * sizeof(Vec3)) == 0;
}

using PoseAt = std::function<rig::RigPose(double)>;

Frames Hold(Feet& feet, double rate_hz, const PoseAt& input, const PoseAt& styled, float weight = 1,
            const Travel& travel = {}) {
  Frames out;
  for (int i = 0; i < kSeconds * rate_hz; ++i) {
    const double time_s = i / rate_hz;
    const rig::RigPose in = input(time_s);
    out.push_back(styled(time_s));
    feet.Process(static_cast<float>(i == 0 ? 0 : 1 / rate_hz), weight,
                 {in.translations, in.rotations}, {out.back().translations, out.back().rotations},
                 travel);
  }
  return out;
}

struct FeetTest : testing::Test {
  const rig::Binding binding = HumanoidBinding();
  const Legs legs{binding};
  const Walker walker;
  const PoseAt input = [this](double t) { return walker.At(t); };
  const PoseAt styled = [this](double t) { return walker.Styled(t); };
  Feet feet{binding, binding, {}};

  static std::vector<Placed> World(const Legs& of, const rig::RigPose& pose) {
    std::vector<Placed> placed(of.joints().size());
    of.Place({pose.translations, pose.rotations}, placed);
    return placed;
  }
  Vec3 Toes(const rig::RigPose& pose, int side) const {
    return World(legs, pose)[static_cast<std::size_t>(legs.leg(side).toes)].position_m;
  }
  // Speed over the floor, cm/s, of a foot whose own contact has lasted for a while.
  double Skate(double rate_hz, const PoseAt& at) const {
    double sum = 0, count = 0;
    for (int i = 1; i < kSeconds * rate_hz; ++i) {
      for (int side = 0; side < kLegs; ++side) {
        const double phase = walker.Phase(i / rate_hz, side);
        if (i / rate_hz < 2 || phase < 0.15 || phase > Walker::kStance - 0.02) continue;
        Vec3 step = Toes(at(i / rate_hz), side) - Toes(at((i - 1) / rate_hz), side);
        step.y() = 0;
        sum += 100 * step.norm() * rate_hz;
        ++count;
      }
    }
    return sum / count;
  }
  static PoseAt Played(const Frames& frames, double rate_hz) {
    return [&frames, rate_hz](double t) {
      return frames[static_cast<std::size_t>(std::lround(t * rate_hz))];
    };
  }
};

TEST_F(FeetTest, WithoutWeightTheyOnlyWatch) {
  const Frames out = Hold(feet, 120, input, styled, 0);
  for (std::size_t i = 0; i < out.size(); ++i) {
    ASSERT_TRUE(SameBits(out[i], walker.Styled(static_cast<double>(i) / 120)));
  }
  EXPECT_NE(feet.contacts().bits(), 0U);
}

TEST_F(FeetTest, AnUnstyledPoseIsLeftAsItIs) {
  const Frames out = Hold(feet, 120, input, input);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const rig::RigPose in = walker.At(static_cast<double>(i) / 120);
    for (std::size_t joint = 0; joint < in.rotations.size(); ++joint) {
      ASSERT_LT(body::Angle_rad(in.rotations[joint], out[i].rotations[joint]), 2e-3) << i;
    }
    ASSERT_LT((in.translations[0] - out[i].translations[0]).norm(), 1e-4F);
  }
}

TEST_F(FeetTest, APlantedFootStaysWhileTheStyleWouldHaveItSlide) {
  const Frames out = Hold(feet, 120, input, styled);
  EXPECT_GT(Skate(120, styled), 15);
  EXPECT_LT(Skate(120, Played(out, 120)), 1);
}

// A walker whose steps are `scale` times as long as the performer's, while the body goes as far.
PoseAt WithSteps(const Walker& walker, const Legs& legs, float scale) {
  return [&walker, &legs, scale](double t) {
    rig::RigPose pose = walker.At(t);
    std::vector<Placed> placed(legs.joints().size());
    legs.Place({pose.translations, pose.rotations}, placed);
    const auto at = [&](int joint) -> const Placed& {
      return placed[static_cast<std::size_t>(joint)];
    };
    for (int side = 0; side < kLegs; ++side) {
      const Legs::Leg& leg = legs.leg(side);
      Vec3 ankle = at(leg.foot).position_m;
      ankle.z() += (scale - 1) * (ankle.z() - at(legs.hips()).position_m.z());
      const TwoBoneTurns turns = ReachFor({at(leg.upper).position_m, at(leg.lower).position_m,
                                           at(leg.foot).position_m, Vec3::UnitX()},
                                          ankle);
      const auto local = [&](int joint) -> Quat& {
        return pose
            .rotations[static_cast<std::size_t>(legs.joints()[static_cast<std::size_t>(joint)])];
      };
      local(leg.upper) = turns.upper * local(leg.upper);
      local(leg.lower) = at(leg.upper).rotation.conjugate() * turns.lower * at(leg.upper).rotation *
                         local(leg.lower);
    }
    return pose;
  };
}

// Without the fit the lock has to draw the foot, up to its reach, and back in the swing.
TEST_F(FeetTest, AStepOfAnotherLengthIsMadeAsLongAsTheWayAsks) {
  Travel travel;
  travel.along = Vec3::UnitZ();
  const auto ahead_m = [this](const rig::RigPose& pose) {
    return Toes(pose, 0).z() - pose.translations[0].z();
  };
  for (const float scale : {0.7F, 1.2F}) {
    const PoseAt stepping = WithSteps(walker, legs, scale);
    Feet fresh(binding, binding, {});
    const Frames out = Hold(fresh, 120, input, stepping, 1, travel);
    EXPECT_GT(Skate(120, stepping), 12) << scale;
    EXPECT_LT(Skate(120, Played(out, 120)), 2) << scale;
    // In the swing, too, the foot is where the performer's is.
    float most_m = 0;
    for (int i = 360; i < 720; ++i) {
      const double t = i / 120.0;
      const float own_m = ahead_m(input(t));
      most_m = std::max(most_m, std::abs(ahead_m(out[static_cast<std::size_t>(i)]) - own_m));
    }
    EXPECT_LT(most_m, 0.027F) << scale;
  }
}

// The largest acceleration of any joint, m/s², over the frames `from` to `to` at 120 Hz.
float Largest(const Legs& legs, const PoseAt& at, int from, int to) {
  float most = 0;
  std::array<std::vector<Placed>, 3> last;
  for (int i = from - 2; i < to; ++i) {
    auto& now = last[static_cast<std::size_t>(i % 3)];
    const rig::RigPose pose = at(i / 120.0);
    now.resize(legs.joints().size());
    legs.Place({pose.translations, pose.rotations}, now);
    if (i < from) continue;
    for (std::size_t joint = 0; joint < now.size(); ++joint) {
      const auto back = [&](int k) -> const Vec3& {
        return last[static_cast<std::size_t>((i - k) % 3)][joint].position_m;
      };
      most = std::max(most, (back(0) - 2 * back(1) + back(2)).norm() * 120 * 120);
    }
  }
  return most;
}

// A style that lifts its foot while the performer's still stands is released smoothly.
TEST_F(FeetTest, AFootThatTheStyleSwingsIsNotHeld) {
  const PoseAt stands = [this](double) { return walker.At(0.33); };
  const PoseAt swings = [this](double t) {
    rig::RigPose pose = walker.At(0.33);
    pose.translations[0].z() += 0.5F * (1 - std::cos(8 * static_cast<float>(t)));  // 4 m/s
    return pose;
  };
  const Frames out = Hold(feet, 120, stands, swings);
  EXPECT_LT(Largest(legs, Played(out, 120), 10, 600), 3 * Largest(legs, swings, 10, 600));
}

TEST_F(FeetTest, TheLockAddsNoJolt) {
  const auto largest = [this](const PoseAt& at) { return Largest(legs, at, 60, 6 * 120); };
  const Frames out = Hold(feet, 120, input, styled);
  EXPECT_LT(largest(Played(out, 120)), 1.5F * std::max(largest(input), largest(styled)));
  // The negative control: a lock that begins and ends at once.
  Options abrupt;
  abrupt.blend_in_s = abrupt.blend_out_s = 0;
  abrupt.contact_high_m = abrupt.contact_low_m + 1e-5F;
  abrupt.return_s = 1e-3F;
  Feet harsh(binding, binding, abrupt);
  const Frames jolted = Hold(harsh, 120, input, styled);
  EXPECT_GT(largest(Played(jolted, 120)), 1.5F * std::max(largest(input), largest(styled)));
}

TEST_F(FeetTest, TheFrameRateDoesNotMatter) {
  Feet reference_feet(binding, binding, {});
  const Frames reference = Hold(reference_feet, 240, input, styled);
  for (const int every : {2, 4, 10}) {
    const double rate_hz = 240.0 / every;
    Feet other(binding, binding, {});
    const Frames out = Hold(other, rate_hz, input, styled);
    EXPECT_LT(Skate(rate_hz, Played(out, rate_hz)), 1.5) << rate_hz;
    double sum = 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
      for (int side = 0; side < kLegs; ++side) {
        const float apart =
            (Toes(out[i], side) - Toes(reference[i * static_cast<std::size_t>(every)], side))
                .norm();
        ASSERT_LT(apart, 0.05F) << rate_hz << " Hz, frame " << i;
        sum += apart;
      }
    }
    EXPECT_LT(sum / static_cast<double>(2 * out.size()), 0.01) << rate_hz;
  }
}

TEST_F(FeetTest, NeitherPlaceNorHeadingNorSideMatters) {
  const Frames here = Hold(feet, 120, input, styled);
  const Quat turn(Eigen::AngleAxisf(2.1F, Vec3::UnitY()));
  const auto moved = [&](const PoseAt& at) -> PoseAt {
    return [&turn, at](double t) {
      rig::RigPose pose = at(t);
      pose.translations[0] = turn * pose.translations[0] + Vec3(3, 0.4F, -7);
      pose.rotations[0] = turn * pose.rotations[0];
      return pose;
    };
  };
  const auto mirrored = [](const rig::RigPose& pose) {
    body::Pose from, to;
    from.hips_position_m = pose.translations[0];
    std::copy(pose.rotations.begin(), pose.rotations.end(), from.rotations.begin());
    body::Mirror(from, to);
    rig::RigPose out = pose;
    out.translations[0] = to.hips_position_m;
    std::copy(to.rotations.begin(), to.rotations.end(), out.rotations.begin());
    return out;
  };
  Feet there_feet(binding, binding, {}), mirror_feet(binding, binding, {});
  const Frames there = Hold(there_feet, 120, moved(input), moved(styled));
  const Frames mirror = Hold(
      mirror_feet, 120, [&](double t) { return mirrored(input(t)); },
      [&](double t) { return mirrored(styled(t)); });
  for (std::size_t i = 0; i < here.size(); ++i) {
    const rig::RigPose unmirrored = mirrored(mirror[i]);
    for (std::size_t joint = 1; joint < here[i].rotations.size(); ++joint) {
      ASSERT_LT(body::Angle_rad(here[i].rotations[joint], there[i].rotations[joint]), 3e-3) << i;
      ASSERT_LT(body::Angle_rad(here[i].rotations[joint], unmirrored.rotations[joint]), 3e-3) << i;
    }
  }
}

TEST_F(FeetTest, AnyRigGivesTheSameAndItsBonesKeepTheirLengths) {
  body::Random random(3);
  const rig::StrangeRig strange = rig::MakeStrangeRig(random, 100);
  const auto made = rig::Binding::Make(strange.spec);
  ASSERT_TRUE(made.ok());
  const rig::Binding& other = made.value();
  const rig::RigPose rest(other.skeleton());
  const auto canonical = [](const rig::RigPose& pose) {
    body::Pose out;
    out.hips_position_m = pose.translations[0];
    std::copy(pose.rotations.begin(), pose.rotations.end(), out.rotations.begin());
    return out;
  };
  const auto on_rig = [&](const PoseAt& at) -> PoseAt {
    return [&, at](double t) {
      rig::RigPose out(other.skeleton());
      other.Unbind(canonical(at(t)), rest, out);
      return out;
    };
  };
  Feet rig_feet(other, other, {});
  const Frames out = Hold(rig_feet, 120, on_rig(input), on_rig(styled));
  const Frames reference = Hold(feet, 120, input, styled);
  const auto hips = static_cast<std::size_t>(other.spec().source_joint[body::kHips]);
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (std::size_t joint = 1; joint < out[i].translations.size(); ++joint) {
      if (joint == hips) continue;
      ASSERT_EQ(out[i].translations[joint], other.skeleton().offsets[joint]);
    }
    body::Pose bound;
    other.Bind(out[i], bound);
    for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
      ASSERT_LT(body::Angle_rad(bound.rotations[joint], reference[i].rotations[joint]), 4e-3)
          << i << " " << body::kHumanoid[joint].name;
    }
    ASSERT_LT((bound.hips_position_m - reference[i].translations[0]).norm(), 1e-3F);
  }
}

TEST_F(FeetTest, JointsWithinAThighAreCarriedAlong) {
  rig::BindingSpec spec = rig::HumanoidSpec();
  rig::Skeleton& skeleton = spec.skeleton;
  // A twist joint half way down the left thigh, rotated against it; the knee is its child.
  const Quat turned(Eigen::AngleAxisf(0.7F, Vec3(1, 2, 3).normalized()));
  const int knee = body::kLeftLowerLeg;
  skeleton.names.insert(skeleton.names.begin() + knee, "twist");
  skeleton.parents.insert(skeleton.parents.begin() + knee, body::kLeftUpperLeg);
  skeleton.offsets.insert(skeleton.offsets.begin() + knee, Vec3(0, -0.2F, 0));
  spec.rest_rotations.insert(spec.rest_rotations.begin() + knee, turned);
  for (int& joint : spec.source_joint) joint += joint >= knee;
  for (std::size_t i = knee + 1; i < skeleton.parents.size(); ++i) {
    skeleton.parents[i] += skeleton.parents[i] >= knee;
  }
  skeleton.parents[knee + 1] = knee;
  skeleton.offsets[knee + 1] = turned.conjugate() * Vec3(0, -0.22F, 0);
  const auto made = rig::Binding::Make(spec);
  ASSERT_TRUE(made.ok()) << made.status().message();
  rig::RigPose rest(made.value().skeleton());
  rest.rotations[knee] = turned;
  const auto on_rig = [&](const PoseAt& at) -> PoseAt {
    return [&, at](double t) {
      const rig::RigPose of = at(t);
      body::Pose pose;
      pose.hips_position_m = of.translations[0];
      std::copy(of.rotations.begin(), of.rotations.end(), pose.rotations.begin());
      rig::RigPose out(made.value().skeleton());
      made.value().Unbind(pose, rest, out);
      return out;
    };
  };
  Feet rig_feet(made.value(), made.value(), {});
  const Frames out = Hold(rig_feet, 120, on_rig(input), on_rig(styled));
  const Frames reference = Hold(feet, 120, input, styled);
  const Legs rig_legs(made.value());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto placed = World(rig_legs, out[i]);
    for (int side = 0; side < kLegs; ++side) {
      const Vec3& toes = placed[static_cast<std::size_t>(rig_legs.leg(side).toes)].position_m;
      ASSERT_LT((toes - Toes(reference[i], side)).norm(), 2e-3F) << i;
    }
  }
}

TEST_F(FeetTest, ALegWithoutAFootIsLeftAlone) {
  rig::BindingSpec spec = rig::HumanoidSpec();
  spec.source_joint[body::kLeftFoot] = -1;
  const auto made = rig::Binding::Make(spec);
  ASSERT_TRUE(made.ok());
  Feet one(made.value(), made.value(), {});
  const Frames out = Hold(one, 120, input, styled);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const rig::RigPose as_styled = walker.Styled(static_cast<double>(i) / 120);
    for (const int joint : {body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot}) {
      const auto j = static_cast<std::size_t>(joint);
      ASSERT_TRUE(out[i].rotations[j].coeffs() == as_styled.rotations[j].coeffs());
    }
  }
}

TEST_F(FeetTest, NoFootSinksBelowThePerformersFloor) {
  const PoseAt sunk = [this](double t) {
    rig::RigPose pose = walker.Styled(t);
    pose.translations[0].y() -= 0.05F;
    return pose;
  };
  float deepest = 0, styled_deepest = 0;
  const Frames out = Hold(feet, 120, input, sunk);
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (int side = 0; side < kLegs; ++side) {
      deepest = std::max(deepest, 0.02F - Toes(out[i], side).y());
      styled_deepest =
          std::max(styled_deepest, 0.02F - Toes(sunk(static_cast<double>(i) / 120), side).y());
    }
  }
  EXPECT_GT(styled_deepest, 0.04F);
  EXPECT_LT(deepest, 0.01F);
}

// The performer, standing in the walker's pose at `time_s`.
PoseAt Frozen(const Walker& walker, double time_s) {
  return [&walker, time_s](double) { return walker.At(time_s); };
}

TEST_F(FeetTest, AFootThatSwingsIntoTheFloorIsStoppedSoftly) {
  const double swing_s = (0.8 - 10.0 + 11.0) * Walker::kCycle_s;  // the left foot is 10 cm up
  const PoseAt diving = [&](double t) {
    rig::RigPose pose = walker.At(swing_s);
    pose.translations[0].y() -= 0.1F * (1 - std::cos(16 * static_cast<float>(t)));  // 1.6 m/s
    return pose;
  };
  const Frames out = Hold(feet, 120, Frozen(walker, swing_s), diving);
  float lowest = 1;
  for (const rig::RigPose& pose : out) lowest = std::min(lowest, Toes(pose, 0).y());
  EXPECT_GT(lowest, 0.02F - 0.01F);
  // From 1.6 m/s within 1 cm it would be 128 m/s².
  EXPECT_LT(Largest(legs, Played(out, 120), 10, 600), 120);
}

TEST_F(FeetTest, ASessionMayBeginWhileTheStyleMoves) {
  float first = 0, own = 0;
  for (const double begin_s : {0.0, 0.1, 0.2, 0.3, 0.4, 0.5}) {
    const PoseAt in = [&](double t) { return walker.At(begin_s + t); };
    const PoseAt bobbing = [&](double t) {
      rig::RigPose pose = walker.At(begin_s + t);
      pose.translations[0].y() += 0.05F * static_cast<float>(std::sin(14 * (t + begin_s)));
      return pose;
    };
    Feet fresh(binding, binding, {});
    const Frames out = Hold(fresh, 120, in, bobbing);
    first = std::max(first, Largest(legs, Played(out, 120), 2, 20));
    own = std::max(own, Largest(legs, bobbing, 2, 20));
  }
  EXPECT_LT(first, 1.2F * own);
}

TEST_F(FeetTest, AFootThatRollsOverItsTipIsNotThrown) {
  const double stance_s = (0.3 - 10.0 + 11.0) * Walker::kCycle_s;
  const auto foot =
      static_cast<std::size_t>(legs.joints()[static_cast<std::size_t>(legs.leg(0).foot)]);
  const PoseAt rolling = [&](double t) {
    rig::RigPose pose = walker.At(stance_s);
    const float angle = 0.95F * (1 - std::cos(10 * static_cast<float>(t)));
    pose.rotations[foot] = pose.rotations[foot] * Quat(Eigen::AngleAxisf(angle, Vec3::UnitX()));
    return pose;
  };
  const Frames out = Hold(feet, 120, Frozen(walker, stance_s), rolling);
  // The direction in which the foot is pitched reverses where it stands on its tip; without the
  // fade that takes 340 m/s².
  EXPECT_LT(Largest(legs, Played(out, 120), 10, 600), 250);
}

// A performer who stands with both knees bent by `bend_rad`, the hips `hips_m` above the floor.
rig::RigPose Standing(const rig::Binding& binding, float bend_rad, float hips_m) {
  rig::RigPose pose(binding.skeleton());
  pose.translations[0].y() = hips_m;
  const auto turn = [&pose](int joint, float angle_rad) {
    pose.rotations[static_cast<std::size_t>(joint)] =
        Quat(Eigen::AngleAxisf(angle_rad, Vec3::UnitX()));
  };
  for (const int joint : {body::kLeftUpperLeg, body::kRightUpperLeg}) turn(joint, -bend_rad / 2);
  for (const int joint : {body::kLeftLowerLeg, body::kRightLowerLeg}) turn(joint, bend_rad);
  for (const int joint : {body::kLeftFoot, body::kRightFoot}) turn(joint, -bend_rad / 2);
  return pose;
}

// A style that straightens legs raises the body above the performer's, one that bends them lowers
// it; the feet stay on the floor, and the knees are the style's.
TEST_F(FeetTest, TheHipsMoveSoThatALegThatStandsKeepsItsStyledKnee) {
  for (const auto& [own_rad, styled_rad] : {std::pair(0.8F, 0.5F), std::pair(0.5F, 0.8F)}) {
    const float hips_m = 0.02F - Toes(Standing(binding, own_rad, 0), 0).y();
    const float wanted_m = 0.02F - Toes(Standing(binding, styled_rad, 0), 0).y();
    ASSERT_GT(std::abs(wanted_m - hips_m), 0.03F);
    Feet fresh(binding, binding, {});
    const auto stands = [&, bend_rad = own_rad](double) {
      return Standing(binding, bend_rad, hips_m);
    };
    const auto bent = [&, bend_rad = styled_rad](double) {
      return Standing(binding, bend_rad, hips_m);
    };
    const rig::RigPose out = Hold(fresh, 120, stands, bent).back();
    EXPECT_NEAR(out.translations[0].y(), wanted_m, 0.005F) << styled_rad;
    EXPECT_NEAR(body::Angle_rad(out.rotations[body::kLeftLowerLeg], Quat::Identity()), styled_rad,
                0.04F);
    EXPECT_NEAR(Toes(out, 0).y(), 0.02F, 0.003F) << styled_rad;
  }
}

TEST_F(FeetTest, ALockThatIsDrawnTooFarDragsAlong) {
  // The performer stands; the style walks away.
  const PoseAt stands = [this](double) { return walker.At(0.33); };
  const PoseAt leaves = [this](double t) {
    rig::RigPose pose = walker.At(0.33);
    pose.translations[0].z() += 0.3F * static_cast<float>(t);
    return pose;
  };
  const Options options;
  const Frames out = Hold(feet, 120, stands, leaves);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Vec3 wanted = Toes(leaves(static_cast<double>(i) / 120), 0);
    ASSERT_LT((Toes(out[i], 0) - wanted).norm(), 1.1F * options.reach_m) << i;
  }
  EXPECT_LT((Toes(out[30], 0) - Toes(out[0], 0)).norm(), 0.01F) << "held at first";
}

TEST_F(FeetTest, ABodyThatTravelsAtItsOwnSpeedPlantsItsFeetOnItsOwnWay) {
  for (const float factor : {0.7F, 1.3F}) {
    // The performer's own pose, carried along less or more of the floor.
    const auto moved_m = [&](double t) {
      return Vec3(0, 0, (factor - 1) * static_cast<float>(walker.speed_mps * t));
    };
    const PoseAt carried = [&](double t) {
      rig::RigPose pose = walker.At(t);
      pose.translations[0] += moved_m(t);
      return pose;
    };
    Feet fresh(binding, binding, {});
    Frames out;
    for (int i = 0; i < kSeconds * 120; ++i) {
      const rig::RigPose in = walker.At(i / 120.0);
      out.push_back(carried(i / 120.0));
      fresh.Process(i == 0 ? 0.0F : 1 / 120.0F, 1, {in.translations, in.rotations},
                    {out.back().translations, out.back().rotations},
                    {moved_m(i / 120.0), factor - 1, Vec3::UnitZ()});
    }
    const PoseAt played = Played(out, 120);
    EXPECT_GT(Skate(120, carried), 20) << factor;
    EXPECT_LT(Skate(120, played), 4) << factor;
    // Two steps later the foot stands two of its own steps ahead.
    const double stands_s = 2.3 * Walker::kCycle_s;
    const auto toes_m = [&](int cycles) {
      return Toes(played(stands_s + cycles * Walker::kCycle_s), 0).z();
    };
    const double own_m = factor * walker.speed_mps * Walker::kCycle_s;
    EXPECT_NEAR(toes_m(1) - toes_m(0), own_m, 0.03) << factor;
    EXPECT_NEAR(toes_m(2) - toes_m(1), own_m, 0.03) << factor;
  }
}

TEST_F(FeetTest, AGapKeepsWhatWasHeldAndARestForgets) {
  (void)Hold(feet, 120, input, styled);
  const rig::RigPose in = walker.At(20);
  rig::RigPose out = walker.Styled(20);
  feet.Process(14, 1, {in.translations, in.rotations}, {out.translations, out.rotations});
  for (int side = 0; side < kLegs; ++side) {
    EXPECT_LT((Toes(out, side) - Toes(walker.Styled(20), side)).norm(), 0.15F);
  }
  feet.Reset();
  const Frames again = Hold(feet, 120, input, styled);
  Feet fresh(binding, binding, {});
  const Frames reference = Hold(fresh, 120, input, styled);
  for (std::size_t i = 0; i < again.size(); ++i) ASSERT_TRUE(SameBits(again[i], reference[i])) << i;
}

}  // namespace
}  // namespace styled::feet

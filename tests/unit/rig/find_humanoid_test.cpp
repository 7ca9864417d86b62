#include "model/rig/find_humanoid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "tests/unit/rig/random_bodies.h"
#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

using testing::HasSubstr;

std::string NameOf(const Skeleton& skeleton, int joint) {
  return joint < 0 ? "nothing" : skeleton.names[static_cast<std::size_t>(joint)];
}

constexpr std::array kNeeded = {body::kHips,         body::kHead,          body::kLeftUpperArm,
                                body::kLeftLowerArm, body::kRightUpperArm, body::kRightLowerArm,
                                body::kLeftUpperLeg, body::kLeftLowerLeg,  body::kRightUpperLeg,
                                body::kRightLowerLeg};

bool IsComplete(const std::array<int, kJointCount>& map) {
  return std::all_of(kNeeded.begin(), kNeeded.end(),
                     [&](int c) { return map[static_cast<std::size_t>(c)] >= 0; });
}

// The first canonical joint that is mapped to another joint than it should be, with both; "" if
// none is. Hands, feet, toes, neck and shoulders may be missing; spine and chest must be in order
// among the trunk's joints.
std::string FirstWrong(const RandomBody& body, const std::array<int, kJointCount>& map) {
  for (int c = 0; c < kJointCount; ++c) {
    const auto at = static_cast<std::size_t>(c);
    const bool trunk = c == body::kSpine || c == body::kChest;
    const bool required = std::find(kNeeded.begin(), kNeeded.end(), c) != kNeeded.end();
    if (map[at] < 0 && !required) continue;
    if (trunk ? std::find(body.trunk.begin(), body.trunk.end(), map[at]) != body.trunk.end()
              : map[at] == body.joint[at]) {
      continue;
    }
    return std::string(kHumanoid[at].name) + " is " + NameOf(body.skeleton, map[at]) + ", not " +
           NameOf(body.skeleton, body.joint[at]);
  }
  return "";
}

TEST(FindHumanoid, BindsEveryConvention) {
  for (const Convention& convention : Conventions()) {
    Skeleton skeleton = HumanoidSkeleton();
    for (int c = 0; c < kJointCount; ++c) {
      skeleton.names[static_cast<std::size_t>(c)] = NameBy(convention, c);
    }
    const auto found = FindHumanoid(skeleton);
    ASSERT_TRUE(found.ok()) << convention.tool << ": " << found.status().message();
    for (int c = 0; c < kJointCount; ++c) {
      EXPECT_EQ(found.value().joint[static_cast<std::size_t>(c)], c)
          << convention.tool << ": " << kHumanoid[static_cast<std::size_t>(c)].name;
    }
    EXPECT_GT(found.value().confidence, 0.8F) << convention.tool;
    EXPECT_EQ(found.value().remark, "") << convention.tool;
  }
}

// The dumbest methods are counted beside it: names by the tables of conventions.
TEST(FindHumanoid, BindsNoRandomBodyWronglyWithoutAWord) {
  constexpr int kBodies = 2000;
  int right = 0, said = 0, asked = 0, names_right = 0, names_wrong = 0;
  for (unsigned seed = 0; seed < kBodies; ++seed) {
    const RandomBody body = MakeRandomBody(seed);
    const auto names = MapJointNames(body.skeleton);
    const bool complete = std::all_of(kNeeded.begin(), kNeeded.end(), [&](int c) {
      return names[static_cast<std::size_t>(c)] >= 0;
    });
    if (complete) ++(FirstWrong(body, names).empty() ? names_right : names_wrong);

    const auto found = body.pose ? FindHumanoid(body.skeleton, {}, std::span(&*body.pose, 1))
                                 : FindHumanoid(body.skeleton);
    if (!found.ok()) {
      ++asked;
      EXPECT_THAT(found.status().message(), HasSubstr("by hand, for example")) << body.built;
      continue;
    }
    if (!IsComplete(found.value().joint)) {  // Binding::Make refuses it and names what is missing
      ++asked;
      continue;
    }
    const std::string wrong = FirstWrong(body, found.value().joint);
    ++(wrong.empty() ? right : said);
    EXPECT_TRUE(wrong.empty() || !found.value().remark.empty())
        << "seed " << seed << " (" << body.built << "): " << wrong;
  }
  std::cout << "of " << kBodies << " bodies: right " << right << ", with a remark and not as built "
            << said << ", asked about " << asked << "; by tables of names alone: right "
            << names_right << ", wrong " << names_wrong << ", refused "
            << kBodies - names_right - names_wrong << "\n";
  EXPECT_GT(right, kBodies * 8 / 10);
}

// Joints with names of no meaning, each hanging from an earlier one.
struct Bone {
  int parent;
  Vec3 offset;
};
Skeleton Nameless(const std::vector<Bone>& bones) {
  Skeleton skeleton;
  for (const Bone& bone : bones) {
    skeleton.names.push_back("bone" + std::to_string(skeleton.joint_count()));
    skeleton.parents.push_back(bone.parent);
    skeleton.offsets.push_back(bone.offset);
  }
  return skeleton;
}
// A chain of bones from a joint; returns its last one.
int Chain(std::vector<Bone>& bones, int parent, const std::vector<Vec3>& offsets) {
  for (const Vec3& offset : offsets) {
    bones.push_back({parent, offset});
    parent = static_cast<int>(bones.size()) - 1;
  }
  return parent;
}
Vec3 X(float x) { return {x, 0, 0}; }
Vec3 Y(float y) { return {0, y, 0}; }

// Hips, trunk, neck and head; returns the arms' parent.
int Trunk(std::vector<Bone>& bones) {
  const int chest = Chain(bones, 0, {Y(0.13F), Y(0.11F)});
  Chain(bones, chest, {Y(0.19F), Y(0.08F)});
  return chest;
}
void Arms(std::vector<Bone>& bones, int chest, float height = 0.15F) {
  for (const float x : {1.0F, -1.0F}) {
    Chain(bones, chest, {Vec3(0.15F * x, height, 0), X(0.27F * x), X(0.25F * x)});
  }
}
void Legs(std::vector<Bone>& bones, int hips, float spread = 0.09F, bool toes = true) {
  for (const float x : {1.0F, -1.0F}) {
    std::vector<Vec3> leg{Vec3(spread * x, -0.05F, 0), Y(-0.42F), Y(-0.42F)};
    if (toes) leg.emplace_back(0, -0.07F, 0.13F);
    Chain(bones, hips, leg);
  }
}

TEST(FindHumanoid, AsksAboutTreesThatCanBeReadInTwoWays) {
  struct Row {
    const char* what;
    Skeleton skeleton;
  };
  std::vector<Row> rows;
  const auto body = [](const auto& add) {
    std::vector<Bone> bones{{-1, Y(0.98F)}};
    add(bones);
    return Nameless(bones);
  };
  rows.push_back({"four arms", body([](auto& bones) {
                    const int chest = Trunk(bones);
                    Arms(bones, chest);
                    Arms(bones, chest, 0.05F);
                    Legs(bones, 0);
                  })});
  rows.push_back({"four legs", body([](auto& bones) {
                    Arms(bones, Trunk(bones));
                    Legs(bones, 0);
                    Legs(bones, 0, 0.2F);
                  })});
  rows.push_back(
      {"wings like arms", body([](auto& bones) {
         const int chest = Trunk(bones);
         Arms(bones, chest);
         for (const float x : {1.0F, -1.0F}) {
           Chain(bones, chest, {Vec3(0.12F * x, 0.1F, -0.1F), X(0.3F * x), X(0.28F * x)});
         }
         Legs(bones, 0);
       })});
  rows.push_back({"two people", body([](auto& bones) {
                    bones[0].offset = Vec3::Zero();
                    for (const float x : {0.0F, 1.0F}) {
                      const int hips = Chain(bones, 0, {Vec3(x, 0.98F, 0)});
                      const int chest = Chain(bones, hips, {Y(0.13F), Y(0.11F)});
                      Chain(bones, chest, {Y(0.19F), Y(0.08F)});
                      Arms(bones, chest);
                      Legs(bones, hips);
                    }
                  })});
  rows.push_back({"two heads", body([](auto& bones) {
                    const int chest = Trunk(bones);
                    Chain(bones, chest, {Vec3(0.1F, 0.19F, 0), Y(0.08F)});
                    Arms(bones, chest);
                    Legs(bones, 0);
                  })});
  rows.push_back({"neither toes nor sides", body([](auto& bones) {
                    Arms(bones, Trunk(bones));
                    Legs(bones, 0, 0.09F, false);
                  })});
  rows.push_back({"a tail like a neck and limbs alike", body([](auto& bones) {
                    const int chest = Trunk(bones);
                    Chain(bones, 0, {Y(-0.19F), Y(-0.08F)});
                    for (const float x : {1.0F, -1.0F}) {
                      Chain(bones, chest, {X(0.15F * x), X(0.3F * x), X(0.3F * x)});
                      Chain(bones, 0, {X(0.15F * x), X(0.3F * x), X(0.3F * x)});
                    }
                  })});
  rows.push_back({"arms of five equal bones", body([](auto& bones) {
                    const int chest = Trunk(bones);
                    for (const float x : {1.0F, -1.0F}) {
                      Chain(bones, chest, std::vector<Vec3>(6, X(0.13F * x)));
                    }
                    Legs(bones, 0);
                  })});
  rows.push_back({"a skirt as long as the legs", body([](auto& bones) {
                    Arms(bones, Trunk(bones));
                    Legs(bones, 0);
                    for (const float x : {1.0F, -1.0F}) {
                      Chain(bones, 0, {Vec3(0.15F * x, 0, 0), Y(-0.4F), Y(-0.4F), Y(-0.1F)});
                    }
                  })});
  rows.push_back({"a spider", body([](auto& bones) {
                    Chain(bones, 0, {Y(0.1F), Y(0.1F)});
                    for (int pair = 0; pair < 4; ++pair) {
                      for (const float x : {1.0F, -1.0F}) {
                        const float z = 0.1F * static_cast<float>(pair);
                        Chain(bones, pair < 2 ? 0 : 1,
                              {Vec3(0.1F * x, 0, z), X(0.3F * x), X(0.3F * x), X(0.1F * x)});
                      }
                    }
                  })});
  ASSERT_GE(rows.size(), 10U);
  for (const Row& row : rows) {
    const auto found = FindHumanoid(row.skeleton);
    EXPECT_FALSE(found.ok()) << row.what << ": bound with confidence " << found.value().confidence;
    if (found.ok()) continue;
    std::cout << row.what << ": " << found.status().message() << "\n";
    EXPECT_THAT(found.status().message(), HasSubstr("by hand, for example")) << row.what;
  }
}

TEST(FindHumanoid, AJointGivenByHandEndsTheDoubt) {
  std::vector<Bone> bones{{-1, Y(0.98F)}};
  const int chest = Trunk(bones);
  Arms(bones, chest);
  Arms(bones, chest, 0.05F);
  Legs(bones, 0);
  const Skeleton skeleton = Nameless(bones);
  ASSERT_FALSE(FindHumanoid(skeleton).ok());
  const std::size_t upper = 11;  // the left one of the second pair
  const auto found = FindHumanoid(skeleton, {{"leftUpperArm", skeleton.names[upper]}});
  ASSERT_TRUE(found.ok()) << found.status().message();
  EXPECT_EQ(found.value().joint[body::kLeftUpperArm], static_cast<int>(upper));
  EXPECT_EQ(found.value().joint[body::kLeftHand], static_cast<int>(upper) + 2);
}

TEST(FindHumanoid, SidesWithoutNamesComeFromToesOrFromBentKnees) {
  for (const bool toes : {true, false}) {
    std::vector<Bone> bones{{-1, Y(0.98F)}};
    Arms(bones, Trunk(bones));
    Legs(bones, 0, 0.09F, toes);
    const Skeleton skeleton = Nameless(bones);
    RigPose pose(skeleton);
    const std::size_t left = 11, right = toes ? 15 : 14;
    for (const std::size_t thigh : {left, right}) {
      pose.rotations[thigh] = Quat(Eigen::AngleAxisf(toes ? 0.0F : -0.4F, Vec3::UnitX()));
      pose.rotations[thigh + 1] = Quat(Eigen::AngleAxisf(toes ? 0.0F : 0.8F, Vec3::UnitX()));
    }
    const auto found = FindHumanoid(skeleton, {}, std::span(&pose, 1));
    ASSERT_TRUE(found.ok()) << found.status().message();
    EXPECT_EQ(found.value().joint[body::kLeftUpperLeg], static_cast<int>(left));
    EXPECT_EQ(found.value().joint[body::kRightLowerLeg], static_cast<int>(right) + 1);
    EXPECT_EQ(found.value().joint[body::kLeftUpperArm], 5);
    EXPECT_EQ(found.value().reason, "by the tree alone");
  }
}

TEST(FindHumanoid, NamesThatContradictTheTreeAreSaid) {
  Skeleton skeleton = HumanoidSkeleton();
  std::swap(skeleton.names[body::kLeftUpperArm], skeleton.names[body::kHead]);
  std::swap(skeleton.names[body::kRightLowerLeg], skeleton.names[body::kLeftHand]);
  const auto found = FindHumanoid(skeleton);
  ASSERT_TRUE(found.ok()) << found.status().message();
  for (int c = 0; c < kJointCount; ++c) {
    EXPECT_EQ(found.value().joint[static_cast<std::size_t>(c)], c);
  }
  EXPECT_THAT(found.value().remark, HasSubstr("another part of the body than the tree"));
}

TEST(FindHumanoid, LimbsNumberedThroughoutAreReadByTheTree) {
  Skeleton skeleton = HumanoidSkeleton();
  for (const auto& [first, count, name] : {std::tuple{int{body::kLeftShoulder}, 4, "Arm"},
                                           std::tuple{int{body::kLeftUpperLeg}, 4, "Leg"}}) {
    for (int i = 0; i < count; ++i) {
      const std::string number = i == 0 ? "" : std::to_string(i);
      skeleton.names[static_cast<std::size_t>(first + i)] = "Left" + std::string(name) + number;
      skeleton.names[static_cast<std::size_t>(body::MirrorJoint(first + i))] =
          "Right" + std::string(name) + number;
    }
  }
  const auto found = FindHumanoid(skeleton);
  ASSERT_TRUE(found.ok()) << found.status().message();
  for (int c = 0; c < kJointCount; ++c) {
    EXPECT_EQ(found.value().joint[static_cast<std::size_t>(c)], c);
  }
}

// Only the likeliest limbs of a joint are paired.
TEST(FindHumanoid, ASkirtOfFortyChainsDoesNotHideTheLegs) {
  Skeleton skeleton = HumanoidSkeleton();
  for (int chain = 0; chain < 40; ++chain) {
    int parent = body::kHips;
    for (int i = 0; i < 4; ++i) {
      skeleton.names.push_back("Skirt_" + std::to_string(chain) + "_" + std::to_string(i));
      skeleton.parents.push_back(parent);
      skeleton.offsets.emplace_back(i == 0 ? 0.005F * static_cast<float>(chain) - 0.1F : 0.0F,
                                    i == 0 ? 0.0F : -0.15F, 0.1F);
      parent = skeleton.joint_count() - 1;
    }
  }
  const auto found = FindHumanoid(skeleton);
  ASSERT_TRUE(found.ok()) << found.status().message();
  for (int c = 0; c < kJointCount; ++c) {
    EXPECT_EQ(found.value().joint[static_cast<std::size_t>(c)], c);
  }
}

TEST(FindHumanoid, SidesThatDisagreeAreSaid) {
  const auto remark = [](std::initializer_list<int> exchanged) {
    Skeleton skeleton = HumanoidSkeleton();
    for (const int c : exchanged) {
      std::swap(skeleton.names[static_cast<std::size_t>(c)],
                skeleton.names[static_cast<std::size_t>(body::MirrorJoint(c))]);
    }
    return FindHumanoid(skeleton).value().remark;
  };
  EXPECT_EQ(remark({}), "");
  EXPECT_THAT(
      remark({body::kLeftShoulder, body::kLeftUpperArm, body::kLeftLowerArm, body::kLeftHand}),
      HasSubstr("is above the leg"));
  EXPECT_THAT(
      remark({body::kLeftShoulder, body::kLeftUpperArm, body::kLeftLowerArm, body::kLeftHand,
              body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot, body::kLeftToes}),
      HasSubstr("toes or knees say left"));
}

TEST(FindHumanoid, RefusesJointsByHandThatCannotBe) {
  const Skeleton skeleton = HumanoidSkeleton();
  const auto complaint = [&](const JointNames& given) {
    return FindHumanoid(skeleton, given).status().message();
  };
  EXPECT_EQ(complaint({{"leftArm", "head"}}),
            "joints: found \"leftArm\", expected a joint of the canonical humanoid, e.g. "
            "leftUpperArm");
  EXPECT_EQ(complaint({{"neck", "Neck"}}), "joints.neck: the rig has no joint \"Neck\"");
  EXPECT_EQ(complaint({{"neck", "head"}, {"head", "head"}}),
            "joints: \"head\" is given for neck and for head");
}

}  // namespace
}  // namespace styled::rig

#include "model/train/persons.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/unit/body/random_pose.h"
#include "tests/unit/judge/walk.h"

namespace styled::train {
namespace {

using judge::kRate_hz;
using judge::Walk;

// A person with a bent neck; `person` empty: the set's performer.
TrainingClip Clip(const std::string& person, float bent_rad, std::vector<body::Pose> poses) {
  TrainingClip clip;
  clip.person = person;
  for (body::Pose& pose : poses) {
    pose.rotations[body::kNeck] = body::Exp(body::Vec3(bent_rad, 0, 0));
  }
  clip.poses = std::move(poses);
  return clip;
}

float Neck_rad(const TrainingClip& clip) {
  return body::Angle_rad(clip.poses.back().rotations[body::kNeck], body::Quat::Identity());
}

std::vector<TrainingClip> Own() { return {Clip("", 0, Walk(0)), Clip("", 0, Walk(0, 0, 0))}; }

TEST(RemovePersons, EachByThemselvesAndInEveryClip) {
  std::vector<TrainingClip> clips = Own();
  clips.push_back(Clip("a", 0.4F, Walk(0.7F)));
  clips.push_back(Clip("b", -0.2F, Walk(0)));
  auto raised = Clip("a", 0.4F, Walk(0, 0, 0));
  for (body::Pose& pose : raised.poses) {  // an act, of which nothing is learned
    pose.rotations[body::kLeftUpperArm] = body::Quat::Identity();
    pose.rotations[body::kRightUpperArm] = body::Quat::Identity();
  }
  clips.push_back(raised);
  const auto own = clips[0].poses;
  const Status status = RemovePersons(kRate_hz, clips);
  ASSERT_TRUE(status.ok()) << status.message();
  for (std::size_t clip = 2; clip < clips.size(); ++clip) {
    EXPECT_LT(Neck_rad(clips[clip]), 0.03F) << clip;
  }
  EXPECT_EQ(clips[4].poses[0].hips_position_m, raised.poses[0].hips_position_m);
  for (std::size_t at = 0; at < own.size(); ++at) {
    ASSERT_EQ(clips[0].poses[at].rotations[body::kNeck].coeffs(),
              own[at].rotations[body::kNeck].coeffs())
        << "the set's own performers stay as they are";
  }
}

TEST(RemovePersons, SaysWhoNeverStandsOrWalks) {
  std::vector<TrainingClip> clips = Own();
  auto lying = Clip("c", 0, Walk(0, 0, 0));
  for (body::Pose& pose : lying.poses) {
    pose.rotations[body::kHips] = body::Exp(body::Vec3(1.57F, 0, 0));
  }
  clips.push_back(lying);
  const Status status = RemovePersons(kRate_hz, clips);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.message().find("\"c\""), std::string::npos) << status.message();
}

TEST(RemovePersons, NeedsPerformersOfTheSet) {
  std::vector<TrainingClip> clips{Clip("a", 0.4F, Walk(0))};
  EXPECT_FALSE(RemovePersons(kRate_hz, clips).ok());
  clips[0].person.clear();
  EXPECT_TRUE(RemovePersons(kRate_hz, clips).ok()) << "nobody is asked for";
}

}  // namespace
}  // namespace styled::train

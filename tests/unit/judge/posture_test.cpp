#include "model/train/judge/posture.h"

#include <gtest/gtest.h>

#include <fstream>

#include "model/net/load.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/judge/walk.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::judge {
namespace {

using body::Vec3;

// A walk with a constant turn of one joint.
train::TrainingClip TurnedClip(int style, int content, body::Joint joint, const Vec3& turn,
                               float own_rad = 0) {
  train::TrainingClip clip;
  clip.style = style;
  clip.content = content;
  clip.poses = Walk(1);
  for (body::Pose& pose : clip.poses) {
    pose.rotations[body::kSpine] = body::Exp(Vec3(own_rad, 0, 0));
    pose.rotations[joint] = pose.rotations[joint] * body::Exp(turn);
  }
  return clip;
}

TEST(MeasurePostures, IsTheMeanOverTheActsThatNeutralHas) {
  const std::vector<train::TrainingClip> clips{
      // A performer who bends in an act does so in neutral, too.
      TurnedClip(0, 0, body::kSpine, Vec3::Zero()),
      TurnedClip(0, 1, body::kSpine, Vec3::Zero(), 0.5F),
      TurnedClip(1, 0, body::kSpine, Vec3(0.2F, 0, 0)),
      TurnedClip(1, 1, body::kSpine, Vec3(0.4F, 0, 0), 0.5F),
      TurnedClip(1, 2, body::kSpine, Vec3(1, 0, 0)),  // an act that neutral lacks
      TurnedClip(2, 2, body::kHead, Vec3(1, 0, 0)),
      TurnedClip(3, 0, body::kLeftShoulder, Vec3(0, 0, 0.2F))};
  const auto postures = MeasurePostures(clips, 5);
  ASSERT_EQ(postures.size(), 5U);
  EXPECT_FALSE(postures[0]) << "neutral";
  ASSERT_TRUE(postures[1]);
  EXPECT_LT(((*postures[1])[0] - Vec3(0.3F, 0, 0)).norm(), 0.01F);
  EXPECT_LT((*postures[1])[3].norm(), 0.01F) << "the head";
  EXPECT_FALSE(postures[2]) << "no act in common";
  ASSERT_TRUE(postures[3]);
  EXPECT_LT(((*postures[3])[4] - Vec3(0, 0, 0.1F)).norm(), 0.01F) << "symmetric";
  EXPECT_LT(((*postures[3])[5] - Vec3(0, 0, -0.1F)).norm(), 0.01F);
  EXPECT_FALSE(postures[4]) << "no clips";
}

TEST(WritePostures, GoesIntoTheStylesOfTheseNames) {
  const support::TemporaryFolder folder;
  const std::filesystem::path file = folder / "random.safetensors";
  const auto bytes = erd::RandomWeights(3, 1).Bytes();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  std::vector<std::optional<net::Posture>> postures(3);
  postures[2].emplace().fill(Vec3(0.1F, 0.2F, 0.3F));
  const std::vector<std::string> names{"neutral", "other", "style2"};
  const Status status = WritePostures(postures, names, file);
  ASSERT_TRUE(status.ok()) << status.message();
  const auto network = net::Load(file);
  ASSERT_TRUE(network.ok()) << network.status().message();
  const net::Styles& styles = network.value()->model().styles;
  EXPECT_FALSE(styles[1].posture);
  ASSERT_TRUE(styles[2].posture);
  EXPECT_EQ((*styles[2].posture)[5], Vec3(0.1F, 0.2F, 0.3F));
}

}  // namespace
}  // namespace styled::judge

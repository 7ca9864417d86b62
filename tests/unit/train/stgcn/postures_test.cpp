// Mean poses of clips and cells, and random new ones.

#include "model/train/stgcn/postures.h"

#include <gtest/gtest.h>

#include <optional>

#include "tests/unit/train/walker.h"

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

// Two domains that share the first content; only the first is of one act. Clips of the second
// domain lean their chest by a known angle, each a little more.
struct PosturesTest : testing::Test {
  std::vector<TrainingClip> clips;
  Statistics statistics;
  stgcn::FeatureParameters parameters;
  std::optional<WindowStore> store;
  std::optional<Postures> postures;

  void Add(int style, int content, float lean_rad) {
    TrainingClip clip = Walker(120, 0.0F);
    clip.style = style;
    clip.content = content;
    for (body::Pose& pose : clip.poses) {
      pose.rotations[body::kChest] =
          body::Quat(Eigen::AngleAxisf(lean_rad, Eigen::Vector3f::UnitX()));
    }
    clips.push_back(clip);
  }

  void SetUp() override {
    Add(0, 0, 0.0F);
    Add(0, 0, 0.0F);
    Add(0, 1, 0.0F);
    Add(1, 0, 0.3F);
    Add(1, 0, 0.5F);
    Add(1, 1, 0.4F);
    Add(1, 2, 0.4F);
    statistics = ComputeStatistics(clips, stgcn::FeatureParameters());
    stgcn::SetHemisphere(statistics.mean, parameters);
    store.emplace(clips, statistics, parameters, 8);
    postures.emplace(*store, 2, std::vector<bool>{true, false, true});
  }

  static Sample From(int clip, int domain, int content, int reference, int target) {
    Sample sample;
    sample.source = {clip, 0, false};
    sample.domain = domain;
    sample.content = content;
    sample.reference1 = {reference, 0, false};
    sample.target = target;
    return sample;
  }
  Tensor PostureOf(int clip) const { return store->FramesOf(clip).mean(0); }
};

double LargestApart(const Tensor& a, const Tensor& b) { return (a - b).abs().max().item<double>(); }

TEST_F(PosturesTest, AnOutputIsWantedWhereItsReferenceStands) {
  // All clips are the same walk, so that a walk by clip 4 should stand exactly as clip 4 does.
  for (const int reference : {3, 4}) {
    Tensor shift;
    ASSERT_TRUE(postures->Wanted(From(0, 0, 0, reference, 1), shift));
    EXPECT_LT(LargestApart(PostureOf(0) + shift, PostureOf(reference)), 1e-4);
  }
  Tensor less, more;
  ASSERT_TRUE(postures->Wanted(From(0, 0, 0, 3, 1), less));
  ASSERT_TRUE(postures->Wanted(From(0, 0, 0, 4, 1), more));
  EXPECT_GT(LargestApart(less, more), 0.1) << "the two references differ";
}

TEST_F(PosturesTest, AMirroredReferenceIsWantedMirrored) {
  Sample sample = From(0, 0, 0, 4, 1);
  sample.reference1.mirrored = true;
  Tensor shift, mirrored;
  ASSERT_TRUE(postures->Wanted(From(0, 0, 0, 4, 1), shift));
  ASSERT_TRUE(postures->Wanted(sample, mirrored));
  stgcn::Features features;
  const Tensor own = (PostureOf(4) - 0.5 * (PostureOf(3) + PostureOf(4))).contiguous();
  std::copy_n(own.data_ptr<float>(), features.size(), features.begin());
  stgcn::MirrorFeatures(features, features);
  const Tensor image =
      torch::from_blob(features.data(), {body::kJointCount, stgcn::kChannels}).clone();
  EXPECT_LT(LargestApart(mirrored - shift, image - own), 1e-4);
}

TEST_F(PosturesTest, NothingIsWantedWhereThereIsNoTelling) {
  Tensor shift;
  EXPECT_FALSE(postures->Wanted(From(0, 0, 0, 5, 1), shift)) << "a raise of either hand";
  EXPECT_FALSE(postures->Wanted(From(6, 1, 2, 0, 0), shift)) << "the target has no such content";
}

TEST_F(PosturesTest, DrawnPosturesAreBetweenAndBeyondThoseOfClips) {
  std::mt19937_64 random(1), again(1);
  const Tensor way = PostureOf(4) - PostureOf(0);
  double least = 1e9, most = -1e9;
  for (int i = 0; i < 200; ++i) {
    const Tensor shift = postures->Draw(random);
    EXPECT_EQ(LargestApart(shift, postures->Draw(again)), 0) << "deterministic";
    const double along = ((shift * way).sum() / way.square().sum()).item<double>();
    least = std::min(least, along);
    most = std::max(most, along);
  }
  EXPECT_LT(least, -0.5);
  EXPECT_GT(most, 0.9);
  EXPECT_LT(most, 1.6);
}

}  // namespace
}  // namespace styled::train::st_gcn

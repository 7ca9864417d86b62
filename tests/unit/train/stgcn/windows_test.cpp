#include "model/train/stgcn/windows.h"

#include <gtest/gtest.h>

#include <map>

#include "model/train/stgcn/kinematics.h"
#include "model/train/stgcn/networks.h"
#include "tests/unit/train/walker.h"

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

constexpr int kFrames = static_cast<int>(kWindowFrames);

// Two domains; the second has one content more. Clips of every length.
std::vector<TrainingClip> Clips() {
  std::vector<TrainingClip> clips;
  const auto add = [&clips](int frames, int style, int content, int source) {
    TrainingClip clip = Walker(frames, static_cast<float>(clips.size()));
    clip.style = style;
    clip.content = content;
    clip.source = source;
    clips.push_back(clip);
  };
  add(200, 0, 0, 0);
  add(100, 0, 1, 0);
  add(40, 1, 0, 0);
  add(40, 1, 0, 0);
  add(40, 1, 0, 0);
  add(40, 1, 0, 0);
  add(300, 1, 1, 1);
  add(100, 1, 2, 0);
  return clips;
}

struct Data {
  explicit Data(int hop = 8) : clips(Clips()) {
    statistics = ComputeStatistics(clips, stgcn::FeatureParameters());
    stgcn::SetHemisphere(statistics.mean, parameters);
    store.emplace(clips, statistics, parameters, hop);
  }
  std::vector<TrainingClip> clips;
  Statistics statistics;
  stgcn::FeatureParameters parameters;
  std::optional<WindowStore> store;
};

double LargestError(const Tensor& a, const Tensor& b) { return (a - b).abs().max().item<double>(); }

TEST(StatisticsTest, AreThoseOfClipsAndTheirMirrorImages) {
  std::vector<TrainingClip> clips = Clips();
  const Statistics of_clips = ComputeStatistics(clips, stgcn::FeatureParameters());
  for (TrainingClip& clip : clips) {
    for (body::Pose& pose : clip.poses) body::Mirror(pose, pose);
  }
  const Statistics of_images = ComputeStatistics(clips, stgcn::FeatureParameters());
  stgcn::Features image;
  stgcn::MirrorFeatures(of_clips.mean, image);
  for (std::size_t i = 0; i < image.size(); ++i) {
    EXPECT_NEAR(image[i], of_clips.mean[i], 1e-6) << i;
    EXPECT_NEAR(of_images.mean[i], of_clips.mean[i], 1e-5) << i;
    EXPECT_NEAR(of_images.deviation[i], of_clips.deviation[i], 1e-4) << i;
    EXPECT_GE(of_clips.deviation[i], i % 7 < 3 ? 0.02F : 0.05F);
  }
  for (const int channel : {0, 2}) {
    EXPECT_EQ(of_clips.mean[channel], 0);
    EXPECT_EQ(of_clips.deviation[channel], 1);
  }
}

TEST(StatisticsTest, WithoutFloorsDeviationsAreThoseOfTheClips) {
  std::vector<TrainingClip> clips = Clips();
  for (TrainingClip& clip : clips) {  // a head that never turns
    for (body::Pose& pose : clip.poses) pose.rotations[body::kHead] = body::Quat::Identity();
  }
  const Statistics floored = ComputeStatistics(clips, stgcn::FeatureParameters());
  const Statistics bare = ComputeStatistics(clips, stgcn::FeatureParameters(), false);
  int smaller = 0;
  for (std::size_t i = 0; i < bare.deviation.size(); ++i) {
    EXPECT_EQ(bare.mean[i], floored.mean[i]);
    EXPECT_GE(bare.deviation[i], 1e-5F) << "usable as a divisor";
    if (bare.deviation[i] < floored.deviation[i]) ++smaller;
    if (bare.deviation[i] > floored.deviation[i]) {
      EXPECT_EQ(bare.deviation[i], 1) << "of a constant";
    }
  }
  EXPECT_GT(smaller, 10);
}

TEST(WindowStoreTest, AWindowIsStandardizedFeaturesOfTheClip) {
  const Data data;
  const Tensor window = data.store->Read({{0, 8, false}});
  stgcn::HeadingState state;
  stgcn::Features features;
  for (int t = 0; t < 8 + kFrames; ++t) {
    stgcn::ComputeFeatures(data.clips[0].poses[t], data.parameters, state, features);
    if (t < 8) continue;
    for (int i = 0; i < stgcn::kFeatureCount; ++i) {
      const float expected = (features[i] - data.statistics.mean[i]) / data.statistics.deviation[i];
      ASSERT_NEAR(window[0][t - 8][i / 7][i % 7].item<float>(), expected, 1e-5);
    }
  }
}

TEST(WindowStoreTest, AMirroredWindowIsOneOfTheMirroredClip) {
  Data data;
  const Tensor mirrored = data.store->Read({{0, 8, true}});
  for (body::Pose& pose : data.clips[0].poses) body::Mirror(pose, pose);
  const WindowStore images(data.clips, data.statistics, data.parameters, 8);
  EXPECT_LT(LargestError(mirrored, images.Read({{0, 8, false}})), 1e-4);
  EXPECT_GT(LargestError(mirrored, data.store->Read({{0, 8, false}})), 0.1)
      << "the walker is not symmetric";
}

TEST(WindowStoreTest, AShortClipIsRepeatedAtBothEnds) {
  const Data data;
  ASSERT_EQ(data.store->Starts(2), std::vector<int>{-12});
  const Tensor window = data.store->Read({{2, -12, false}})[0];
  for (int t = 0; t < 12; ++t) {
    EXPECT_TRUE(torch::equal(window[t], window[12]));
    EXPECT_TRUE(torch::equal(window[kFrames - 1 - t], window[51]));
  }
  EXPECT_FALSE(torch::equal(window[12], window[13]));
}

TEST(WindowStoreTest, TheLastWindowEndsWithItsClip) {
  const Data data(16);
  EXPECT_EQ(data.store->Starts(1), (std::vector<int>{0, 16, 32, 36}));
  EXPECT_EQ(data.store->Starts(0).back(), 136);
}

// The second domain: four clips of one window, one of 30 windows, one of 5 (hop 8).
TEST(SamplerTest, WithoutEvenContentsEveryWindowOfADomainIsAsLikely) {
  const Data data;
  Sampler sampler(
      *data.store,
      {.domains = 2, .contents = 3, .shared_contents = false, .even_contents = false, .seed = 4});
  ASSERT_TRUE(sampler.HasAll());
  std::map<int, double> clips, references, contents;
  double sources = 0, targets = 0;
  for (const Sample& sample : sampler.Next(20000)) {
    EXPECT_TRUE(sample.paired);
    EXPECT_EQ(sample.content, data.store->ContentOf(sample.source.clip, sample.source.start));
    EXPECT_EQ(data.store->StyleOf(sample.source.clip), sample.domain);
    EXPECT_EQ(data.store->StyleOf(sample.reference1.clip), sample.target);
    if (sample.domain == 1) {
      ++sources;
      ++clips[sample.source.clip];
      ++contents[sample.content];
    }
    if (sample.target == 1) {
      ++targets;
      ++references[sample.reference1.clip];
    }
  }
  double windows = 0;
  for (int clip = 2; clip < 8; ++clip) {
    windows += static_cast<double>(data.store->Starts(clip).size());
  }
  for (int clip = 2; clip < 8; ++clip) {
    const double share = static_cast<double>(data.store->Starts(clip).size()) / windows;
    EXPECT_NEAR(clips[clip] / sources, share, 0.02) << clip;
    EXPECT_NEAR(references[clip] / targets, share, 0.02) << clip;
  }
  EXPECT_NEAR(contents[0] / sources, 4 / windows, 0.02);  // evenly it would be a third
}

TEST(SamplerTest, RealAndTransferredWindowsOfADomainHaveTheSameContents) {
  const Data data;
  Sampler sampler(*data.store, {.domains = 2, .contents = 3, .unpaired = 0.1, .seed = 3});
  ASSERT_TRUE(sampler.HasAll());
  std::map<std::pair<int, int>, int> real, made;
  int unpaired = 0, mirrored = 0, count = 0;
  for (const Sample& sample : sampler.Next(8000)) {
    const TrainingClip& clip = data.clips[sample.source.clip];
    EXPECT_EQ(clip.style, sample.domain);
    EXPECT_EQ(clip.content, sample.content);
    EXPECT_EQ(data.clips[sample.reference1.clip].style, sample.target);
    EXPECT_EQ(data.clips[sample.reference2.clip].style, sample.target);
    EXPECT_EQ(sample.same_clip.clip, sample.source.clip);
    EXPECT_EQ(sample.same_clip.mirrored, sample.source.mirrored);
    if (data.store->Starts(sample.source.clip).size() > 1) {
      EXPECT_NE(sample.same_clip.start, sample.source.start);
    }
    mirrored += sample.source.mirrored;
    ++count;
    if (!sample.paired) {
      ++unpaired;
      continue;
    }
    ++real[{sample.domain, sample.content}];
    ++made[{sample.target, sample.content}];
  }
  EXPECT_NEAR(unpaired, 0.1 * count, 0.02 * count);
  EXPECT_NEAR(mirrored, 0.5 * count, 0.03 * count);
  for (const auto& [cell, times] : real) {
    EXPECT_NEAR(made[cell], times, 0.05 * count) << cell.first << ' ' << cell.second;
  }
}

TEST(SamplerTest, WithoutSharedContentsAllCount) {
  const Data data;
  Sampler sampler(*data.store,
                  {.domains = 2, .contents = 3, .shared_contents = false, .mirror = false});
  bool foreign = false;
  for (const Sample& sample : sampler.Next(500)) {
    EXPECT_TRUE(sample.paired);
    EXPECT_FALSE(sample.source.mirrored);
    foreign = foreign || (sample.content == 2 && sample.target == 0);
  }
  EXPECT_TRUE(foreign);
}

TEST(SamplerTest, AShareOfTheSourcesIsNeutral) {
  const Data data;
  for (const double neutral : {0.0, 0.5, 1.0}) {
    Sampler sampler(*data.store,
                    {.domains = 2, .contents = 3, .neutral = neutral, .mirror = false});
    int plain = 0, plain_targets = 0;
    for (const Sample& sample : sampler.Next(4000)) {
      EXPECT_EQ(data.clips[sample.source.clip].style, sample.domain);
      plain += sample.domain == 0 ? 1 : 0;
      plain_targets += sample.target == 0 ? 1 : 0;
    }
    EXPECT_NEAR(plain, 4000 * (0.5 + 0.5 * neutral), 100) << neutral;
    EXPECT_NEAR(plain_targets, 2000, 100) << neutral;
  }
}

TEST(SamplerTest, ARestoredSamplerContinues) {
  const Data data;
  const Sampler::Options options{.domains = 2, .contents = 3, .seed = 9};
  Sampler first(*data.store, options), second(*data.store, options);
  first.Next(100);
  second.Restore(first.Save());
  const auto a = first.Next(50), b = second.Next(50);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].source.clip, b[i].source.clip);
    EXPECT_EQ(a[i].source.start, b[i].source.start);
    EXPECT_EQ(a[i].reference2.start, b[i].reference2.start);
  }
  EXPECT_THROW(second.Restore("no numbers"), std::exception);
}

TEST(SamplerTest, NoticesADomainWithoutWindows) {
  const Data data;
  EXPECT_FALSE(Sampler(*data.store, {.domains = 3, .contents = 3}).HasAll());
}

// Positions that follow from the rotations are those of the body's own kinematics.
TEST(KinematicsTest, RealMotionIsPublishedUnchanged) {
  const Data data;
  const Kinematics kinematics(data.statistics, torch::kCPU);
  const Tensor window = data.store->Read({{0, 8, false}, {6, 16, true}});
  EXPECT_LT(LargestError(kinematics.Published(window), window), 1e-3);
}

TEST(KinematicsTest, WrongPositionsAreReplacedAndRotationsMadeUnit) {
  const Data data;
  const Kinematics kinematics(data.statistics, torch::kCPU);
  const Tensor window = data.store->Read({{0, 8, false}});
  Tensor raw = window * kinematics.deviation() + kinematics.mean();
  raw.narrow(-1, 3, 4).mul_(1.7);
  raw.narrow(-2, 1, 20).narrow(-1, 0, 3).add_(0.3);  // all but the hips
  raw.select(-2, 0).select(-1, 0).add_(0.2);         // the hips' x, which is nothing
  const Tensor wrong = (raw - kinematics.mean()) / kinematics.deviation();
  EXPECT_LT(LargestError(kinematics.Published(wrong), window), 2e-3);
}

TEST(KinematicsTest, GradientsReachRotationsAndHipsHeightAlone) {
  const Data data;
  const Kinematics kinematics(data.statistics, torch::kCPU);
  const Tensor window = data.store->Read({{0, 8, false}}).requires_grad_(true);
  const Tensor gradient = torch::autograd::grad(
      {kinematics.Published(window).narrow(-1, 0, 3).square().sum()}, {window})[0];
  EXPECT_GT(gradient.select(-2, 0).select(-1, 1).abs().min().item<double>(), 0);
  EXPECT_GT(gradient.select(-2, body::kSpine).narrow(-1, 3, 4).abs().sum().item<double>(), 0);
  EXPECT_EQ(gradient.narrow(-2, 1, 20).narrow(-1, 0, 3).abs().max().item<double>(), 0);
}

}  // namespace
}  // namespace styled::train::st_gcn

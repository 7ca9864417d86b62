#include <gtest/gtest.h>

#include <cmath>

#include "model/train/baselines/baseline.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/train/walker.h"

namespace styled::train::baselines {
namespace {

using torch::Tensor;

// Two styles of one content, which differ in the pose of the arms.
struct BaselinesTest : testing::Test {
  clip::Manifest manifest;
  std::vector<TrainingClip> clips;
  support::TemporaryFolder folder;

  void SetUp() override {
    manifest.styles = {{"neutral", {}, {}}, {"odd", {}, {}}};
    manifest.contents = {"walk"};
    for (int i = 0; i < 12; ++i) clips.push_back(Clip(i % 2, 80, 0.4F * static_cast<float>(i)));
  }
  static TrainingClip Clip(int style, int frames, float phase) {
    TrainingClip clip = Walker(frames, phase);
    clip.style = style;
    for (body::Pose& pose : clip.poses) {
      if (style == 1) pose.rotations[body::kLeftUpperArm] = body::Exp(body::Vec3(0, 0, 1));
    }
    return clip;
  }
};

TEST_F(BaselinesTest, AbermansWidthIsChosenByItsMultiplyAdds) {
  const double wanted = 47.1e6;
  const int channels = AbermanChannels(wanted);
  EXPECT_LT(std::abs(AbermanMacs(channels) - wanted), std::abs(AbermanMacs(channels + 1) - wanted));
  EXPECT_LT(std::abs(AbermanMacs(channels) - wanted), std::abs(AbermanMacs(channels - 1) - wanted));
  EXPECT_NEAR(AbermanMacs(channels) / wanted, 1, 0.01);
}

TEST_F(BaselinesTest, MaterialIsStandardizedWithItsOwnParameters) {
  const Material material(manifest, clips);
  EXPECT_EQ(material.parameters.heading_tau_s, stgcn::FeatureParameters().heading_tau_s);
  stgcn::FeatureParameters wanted;
  stgcn::SetHemisphere(material.statistics.mean, wanted);
  EXPECT_EQ(material.parameters.hemisphere, wanted.hemisphere);
  const Tensor clip = MakeHolden(material, 1)->Read(clips[0].poses, nullptr);
  EXPECT_LT(clip.abs().max().item<double>(), 10);
}

// Without training: what counts is that each frame gets its prediction, and that codes are used.
TEST_F(BaselinesTest, AStreamGivesOnePredictionForEachPoseAndFollowsItsCode) {
  const Material material(manifest, clips);
  for (const bool holden : {false, true}) {
    const auto network = holden ? MakeHolden(material, 10) : MakeAberman(material, 8);
    network->TrainOrLoad({.iterations = 1, .batch = 4}, folder / (holden ? "h" : "a"));
    const net::StyleCode neutral =
        network->MakeCode({.sources = {{.style = 0, .seed = {}, .reference = {}}}});
    const net::StyleCode odd =
        network->MakeCode({.sources = {{.style = 1, .seed = {}, .reference = {}}}});
    EXPECT_EQ(network->Nearest(odd).style, 1);
    EXPECT_EQ(network->Nearest(neutral).style, 0);
    for (const int frames : {4, 37, 80}) {
      const TrainingClip clip = Clip(0, frames, 1);
      double apart_rad = 0;
      std::vector<net::Prediction> of_neutral;
      for (const net::StyleCode& code : {neutral, odd}) {
        const auto stream = network->MakeStream(code, 0, net::Extent::kWhole);
        net::Prediction out;
        for (const body::Pose& pose : clip.poses) {
          stream->Add(pose);
          EXPECT_FALSE(stream->Pop(out)) << "a clip is styled at its end";
        }
        stream->End();
        int taken = 0;
        for (; stream->Pop(out); ++taken) {
          for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
            ASSERT_NEAR(out.styled.rotations[joint].norm(), 1, 1e-4);
            ASSERT_NEAR(out.reconstruction.rotations[joint].norm(), 1, 1e-4);
            if (of_neutral.size() == clip.poses.size()) {
              apart_rad += of_neutral[static_cast<std::size_t>(taken)]
                               .styled.rotations[joint]
                               .angularDistance(out.styled.rotations[joint]);
            }
          }
          if (of_neutral.size() < clip.poses.size()) of_neutral.push_back(out);
        }
        EXPECT_EQ(taken, frames);
      }
      EXPECT_GT(apart_rad, 0) << "another code, another output";
    }
  }
}

TEST_F(BaselinesTest, TrainingReproducesClipsAndIsReadAgain) {
  const Material material(manifest, clips);
  const torch::NoGradGuard no_grad;
  for (const bool holden : {false, true}) {
    const auto make = [&] { return holden ? MakeHolden(material, 1) : MakeAberman(material, 16); };
    const auto error = [&](const Baseline& network) {
      const Tensor clip = network.Read(Clip(0, 64, 0.3F).poses, nullptr);
      return (network.Own(clip) - clip).square().mean().item<double>();
    };
    const auto raw = make();
    raw->TrainOrLoad({.iterations = 1, .batch = 4}, folder / (holden ? "h1" : "a1"));
    const auto trained = make();
    trained->TrainOrLoad({.iterations = 60, .batch = 8}, folder / (holden ? "h2" : "a2"));
    EXPECT_LT(error(*trained), 0.6 * error(*raw)) << (holden ? "holden" : "aberman");
    const auto read = make();
    read->TrainOrLoad({.iterations = 1, .batch = 4}, folder / (holden ? "h2" : "a2"));
    EXPECT_EQ(error(*read), error(*trained));
  }
}

// The two styles of the clips differ by a constant: neighbours find it, of a clip that they do not
// have, and half of it at half the strength.
TEST_F(BaselinesTest, NeighboursTurnAFrameAsTheirStyleDiffers) {
  const Material material(manifest, clips);
  const torch::NoGradGuard no_grad;
  const auto network = MakeNeighbours(material);
  network->TrainOrLoad({}, folder / "n");
  const torch::Tensor clip = network->Read(Clip(0, 64, 0.3F).poses, nullptr);
  const torch::Tensor real = network->Read(Clip(1, 64, 0.3F).poses, nullptr);
  const auto styled = [&](float strength) {
    net::StyleRequest request{.sources = {{.style = 1, .seed = {}, .reference = {}}}};
    request.strength = strength;
    const net::StyleCode code = network->MakeCode(request);
    return network->Styled(clip, torch::tensor(code));
  };
  const double apart = (real - clip).square().mean().item<double>();
  EXPECT_LT((styled(1) - real).square().mean().item<double>(), 0.3 * apart);
  EXPECT_TRUE(torch::allclose(styled(0.5F) - clip, 0.5 * (styled(1) - clip), 1e-4, 1e-4));
  EXPECT_TRUE(torch::equal(styled(0), clip));
  const std::vector<body::Pose> example = Clip(1, 64, 0.1F).poses;
  const net::StyleCode of_example =
      network->MakeCode({.sources = {{.style = -1, .seed = {}, .reference = example}}});
  EXPECT_EQ(network->Nearest(of_example).style, 1) << "without a label";
}

TEST_F(BaselinesTest, AFileOfAnotherNetworkOrOfOtherClipsIsRefused) {
  const Material material(manifest, clips);
  const std::string file = folder / "a";
  MakeAberman(material, 8)->TrainOrLoad({.iterations = 1, .batch = 4}, file);
  EXPECT_NO_THROW(MakeAberman(material, 8)->TrainOrLoad({.iterations = 1, .batch = 4}, file));
  EXPECT_THROW(MakeAberman(material, 9)->TrainOrLoad({.iterations = 1, .batch = 4}, file),
               c10::Error);
  std::vector<TrainingClip> fewer(clips.begin(), clips.end() - 2);
  const Material other(manifest, fewer);
  EXPECT_THROW(MakeAberman(other, 8)->TrainOrLoad({.iterations = 1, .batch = 4}, file), c10::Error);
}

TEST_F(BaselinesTest, ASeedDecidesTheTraining) {
  const Material material(manifest, clips);
  const Tensor clip = MakeAberman(material, 8)->Read(clips[0].poses, nullptr);
  const auto output = [&](std::uint64_t seed, const char* name) {
    const auto network = MakeAberman(material, 8, seed);
    network->TrainOrLoad({.iterations = 2, .batch = 4}, folder / name);
    const torch::NoGradGuard no_grad;
    return network->Own(clip);
  };
  const Tensor first = output(1, "1");
  EXPECT_TRUE(first.equal(output(1, "again")));
  EXPECT_FALSE(first.equal(output(2, "2")));
}

// Without a weight of the style, a clip is only encoded and decoded; with one, its mean pose
// becomes that of the example.
TEST_F(BaselinesTest, HoldensStyleWeightDecidesHowFarTheExampleIsFollowed) {
  const torch::NoGradGuard no_grad;
  const Material material(manifest, clips);
  const auto plain = MakeHolden(material, 0);
  const auto strong = MakeHolden(material, 100);
  plain->TrainOrLoad({.iterations = 60, .batch = 8}, folder / "w");
  strong->TrainOrLoad({.iterations = 1, .batch = 4}, folder / "w");
  const Tensor content = plain->Read(Clip(0, 64, 0.3F).poses, nullptr);
  const Tensor style = plain->Read(Clip(1, 64, 0.9F).poses, nullptr);
  const Tensor wanted = plain->CodeOf(style);
  EXPECT_LT((plain->Styled(content, wanted) - plain->Own(content)).abs().max().item<double>(),
            0.05);
  const Tensor target = plain->Own(style).mean(1);
  const auto off = [&](const Tensor& clip) {
    return (clip.mean(1) - target).norm().item<double>();
  };
  EXPECT_LT(off(strong->Styled(content, wanted)), 0.5 * off(plain->Own(content)));
}

}  // namespace
}  // namespace styled::train::baselines

#include "model/trial/trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "model/feet/legs.h"
#include "model/net/kernels/kernel.h"
#include "model/net/load.h"
#include "model/stylist/stylist.h"
#include "model/synthetic/performer.h"
#include "tests/unit/net/erd/random_weights.h"
#include "tests/unit/net/stgcn/random_weights.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::trial {
namespace {

using erd::RandomWeights;
using erd::WeightsFile;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr int kStyles = 5;

WeightsFile Scaled(const std::string& tensor, float by) {
  WeightsFile file = RandomWeights(kStyles, 1);
  for (float& value : file.tensor(tensor).values) value *= by;
  return file;
}

std::string Refusal(const WeightsFile& file) {
  return Parse(file.Bytes(), "wild.safetensors").status().message();
}

// With margin: the bounds are for broken networks, not for poor ones.
void ExpectWellWithin(const Figures& figures) {
  EXPECT_LT(figures.reconstruction_rad, 0.75F * kMost.reconstruction_rad);
  EXPECT_LT(figures.change_rad, 0.75F * kMost.change_rad);
  EXPECT_LT(figures.velocity_m_s, 0.1F * kMost.velocity_m_s);
  EXPECT_LT(figures.height_m, 0.1F * kMost.height_m);
}

TEST(TrialTest, ShippedWeightsPassWithRoomToSpare) {
  for (const std::string name : {"v2", "open"}) {
    const auto network = net::Load(std::string(STYLED_SHIPPED "/") + name + ".safetensors");
    ASSERT_TRUE(network.ok()) << network.status().message();
    Figures figures;
    const Status status = Try(*network.value(), name, &figures);
    ASSERT_TRUE(status.ok()) << status.message();
    ExpectWellWithin(figures);
    std::printf("%s: reconstruction %.2f rad, change %.2f rad, %.1f m/s, %.2f m\n", name.c_str(),
                figures.reconstruction_rad, figures.change_rad, figures.velocity_m_s,
                figures.height_m);
  }
}

// The largest and the root mean square turn of a joint between two lists of poses, degrees.
struct Apart {
  double largest_deg = 0, rms_deg = 0;
};
Apart Between(const std::vector<body::Pose>& a, const std::vector<body::Pose>& b) {
  Apart apart;
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
      const double deg =
          a[i].rotations[joint].angularDistance(b[i].rotations[joint]) * 180 / std::numbers::pi;
      apart.largest_deg = std::max(apart.largest_deg, deg);
      squares += deg * deg;
    }
  }
  apart.rms_deg = std::sqrt(squares / static_cast<double>(a.size() * body::kJointCount));
  return apart;
}

// A built-in performer in a style, 10 s at 120 Hz.
std::vector<body::Pose> Styled(const std::shared_ptr<const net::Stylizer>& network, int style,
                               std::uint64_t seed) {
  const auto binding = std::make_shared<const rig::Binding>(feet::HumanoidBinding());
  stylist::Stylist stylist(network, binding, {});
  stylist::Settings settings;
  if (style > 0) settings.mix[0] = {style, 1};
  stylist.Set(settings);
  synthetic::Performer performer({.seed = seed});
  stylist::Output out(binding->skeleton());
  rig::RigPose in(binding->skeleton());
  std::vector<body::Pose> poses;
  for (int frame = 0; frame < 1200; ++frame) {
    body::Pose pose;
    performer.Pose(frame / 120.0, pose);
    binding->Unbind(pose, in, in);
    stylist.Process(std::int64_t{frame} * 1'000'000'000 / 120, in, out);
    poses.push_back(out.canonical);
  }
  return poses;
}

// Beside what the style itself does, which no method that leaves it out can pass.
class RoundedTrialTest : public testing::TestWithParam<std::string> {};

TEST_P(RoundedTrialTest, GivesNearlyTheSamePoses) {
  const std::string file = STYLED_SHIPPED "/v2.safetensors";
  const auto rounded = net::Load(file, net::PrecisionNamed(GetParam()));
  ASSERT_TRUE(rounded.ok()) << rounded.status().message();
  const auto network = net::Load(file);
  ASSERT_TRUE(network.ok()) << network.status().message();
  const net::Styles& styles = network.value()->model().styles;
  Apart worst;
  double least_style_deg = 1e9;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const auto own = Styled(network.value(), 0, seed);
    for (int style = 1; style < static_cast<int>(styles.size()); ++style) {
      const auto poses = Styled(network.value(), style, seed);
      const Apart by_rounding = Between(poses, Styled(rounded.value(), style, seed));
      const Apart by_style = Between(poses, own);
      EXPECT_GT(by_rounding.rms_deg, 0) << "nothing was rounded";
      EXPECT_LT(by_rounding.rms_deg, 0.05 * by_style.rms_deg) << styles[style].name;
      worst = {std::max(worst.largest_deg, by_rounding.largest_deg),
               std::max(worst.rms_deg, by_rounding.rms_deg)};
      least_style_deg = std::min(least_style_deg, by_style.rms_deg);
    }
  }
  std::printf(
      "rounding turns joints by %.2f degrees (rms of the worst style), at most %.1f; the "
      "style that does least by %.1f\n",
      worst.rms_deg, worst.largest_deg, least_style_deg);
  EXPECT_LT(worst.largest_deg, 10);
}
INSTANTIATE_TEST_SUITE_P(Precisions, RoundedTrialTest, testing::Values("int8"),
                         [](const auto& precision) { return precision.param; });

TEST(TrialTest, RandomWeightsPassWithRoomToSpare) {
  Figures worst;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const auto network = erd::RandomStylizer(2 + static_cast<int>(seed) % 15, seed);
    Figures figures;
    const Status status = Try(*network, "random", &figures);
    ASSERT_TRUE(status.ok()) << seed << ": " << status.message();
    ExpectWellWithin(figures);
    worst.reconstruction_rad = std::max(worst.reconstruction_rad, figures.reconstruction_rad);
    worst.change_rad = std::max(worst.change_rad, figures.change_rad);
    worst.velocity_m_s = std::max(worst.velocity_m_s, figures.velocity_m_s);
    worst.height_m = std::max(worst.height_m, figures.height_m);
  }
  std::printf("random: reconstruction %.2f rad, change %.2f rad, %.1f m/s, %.2f m\n",
              worst.reconstruction_rad, worst.change_rad, worst.velocity_m_s, worst.height_m);
}

TEST(TrialTest, FiniteButWildWeightsAreRefusedByName) {
  const auto refused = AllOf(StartsWith("wild.safetensors: the trial run"), HasSubstr("style '"),
                             HasSubstr("frame 0 of "), HasSubstr("joint hips: "),
                             HasSubstr("expected a rotation of length 1, found nan"));
  EXPECT_THAT(Refusal(Scaled("head.rotation.weight", 1e30F)), refused);
  EXPECT_THAT(Refusal(Scaled("feature.deviation", 1e30F)), refused);
  EXPECT_THAT(Refusal(Scaled("feature.mean", 1e30F)), refused);
  EXPECT_THAT(Refusal(Scaled("decoder.1.weight", 1e30F)), refused);
}

TEST(TrialTest, AStyleThatIsWildAloneIsNamed) {
  WeightsFile file = RandomWeights(kStyles, 1);
  net::NamedTensor& decoder = file.tensor("decoder.0.weight");
  const auto width = static_cast<std::size_t>(decoder.shape[1]);
  for (std::size_t i = 0; i < decoder.values.size(); ++i) {
    if (i % width == width - kStyles + 3) decoder.values[i] *= 1e30F;  // the column of style 3
  }
  EXPECT_THAT(Refusal(file), AllOf(HasSubstr("style 'style3', frame 0 of"),
                                   HasSubstr("the styled pose: expected a rotation of length 1")));
}

TEST(TrialTest, AbsurdButFiniteOutputIsRefusedWithTheBound) {
  EXPECT_THAT(Refusal(Scaled("head.velocity.bias", 1e8F)),
              HasSubstr("expected a velocity of at most 1000 m/s, found "));
  EXPECT_THAT(Refusal(Scaled("head.height.bias", 1e8F)),
              HasSubstr("expected a height of at most 100 m, found "));
  // Every joint rotated by half a turn.
  WeightsFile file = RandomWeights(kStyles, 1);
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    file.tensor("head.rotation.bias").values[4 * joint] = 1e6F;
  }
  EXPECT_THAT(Refusal(file), HasSubstr("the reconstruction's distance from the pose: expected at "
                                       "most 1.8 rad over all joints (rms), found 3."));
}

// Every tensor of the file, made huge, tiny and zero, on a motion that is not the trial's.
TEST(TrialTest, WhateverPassesGivesASoundPoseInEveryFrame) {
  const auto binding = std::make_shared<const rig::Binding>(feet::HumanoidBinding());
  synthetic::Performer performer({.seed = 9, .script = {{synthetic::Motion::kRun, 1}}});
  std::vector<rig::RigPose> motion(90, rig::RigPose(binding->skeleton()));
  for (std::size_t frame = 0; frame < motion.size(); ++frame) {
    body::Pose pose;
    performer.Pose(static_cast<double>(frame) / 60, pose);
    motion[frame].translations[0] = pose.hips_position_m;
    std::copy(pose.rotations.begin(), pose.rotations.end(), motion[frame].rotations.begin());
  }
  int passed = 0, refused = 0;
  for (const net::NamedTensor& tensor : RandomWeights(3, 1).tensors) {
    for (const float by : {1e30F, 1e15F, 1e-30F, 0.0F}) {
      WeightsFile file = RandomWeights(3, 1);
      for (float& value : file.tensor(tensor.name).values) value *= by;
      const auto network = Parse(file.Bytes(), tensor.name);
      ++(network.ok() ? passed : refused);
      if (!network.ok()) continue;
      stylist::Stylist stylist(network.value(), binding, {});
      stylist::Settings settings;
      settings.mix[0] = {2, 1.0F};
      stylist.Set(settings);
      stylist::Output out(binding->skeleton());
      for (std::size_t frame = 0; frame < motion.size(); ++frame) {
        stylist.Process(static_cast<std::int64_t>(frame) * 16'666'667, motion[frame], out);
        ASSERT_EQ(out.flags & stylist::kFailed, 0U) << tensor.name << " x " << by;
      }
    }
  }
  EXPECT_GT(passed, 0);
  EXPECT_GT(refused, 0);
}

// Networks that need whole clips are tried on the same performer, with the same bounds.
TEST(TrialTest, RandomWeightsOfAClipNetworkPassAndWildOnesAreRefused) {
  Figures worst;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto any = net::ParseAny(stgcn::RandomWeights(3, 16, seed).Bytes(), "random");
    ASSERT_TRUE(any.ok()) << any.status().message();
    Figures figures;
    const Status status = Try(*any.value().clips, "random", &figures);
    ASSERT_TRUE(status.ok()) << seed << ": " << status.message();
    worst.reconstruction_rad = std::max(worst.reconstruction_rad, figures.reconstruction_rad);
    worst.change_rad = std::max(worst.change_rad, figures.change_rad);
  }
  std::printf("random st-gcn: reconstruction %.2f rad, change %.2f rad\n", worst.reconstruction_rad,
              worst.change_rad);
  EXPECT_GT(worst.change_rad, 0.01F);

  const auto refusal = [](const std::string& tensor, std::size_t from, std::size_t to, float by) {
    stgcn::WeightsFile file = stgcn::RandomWeights(3, 16, 1);
    std::vector<float>& values = file.tensor(tensor).values;
    for (std::size_t i = from; i < std::min(to, values.size()); ++i) values[i] *= by;
    const auto any = net::ParseAny(file.Bytes(), "wild");
    return any.ok() ? Try(*any.value().clips, "wild").message() : any.status().message();
  };
  constexpr std::size_t kAll = 1U << 30;
  EXPECT_THAT(refusal("g.dec2.tconv2.weight", 0, kAll, 1e38F),
              AllOf(StartsWith("wild: the trial run on the built-in performer failed: style "
                               "'neutral', frame 0 of 105, joint "),
                    HasSubstr("expected a rotation of length 1, found ")));
  // Only the second domain's codes.
  EXPECT_THAT(refusal("codes.mean", 64, 128, 1e38F), HasSubstr("style 'style1', frame 0 of"));
  EXPECT_THAT(refusal("e.heads.weight", 2UL * 64 * 64, kAll, 1e38F),
              HasSubstr("style 'style2' as the performer's own, frame 0 of"));
  // Only examples without a label.
  for (const char* const tensor : {"e.free.weight", "e.free.bias"}) {
    EXPECT_THAT(refusal(tensor, 0, kAll, 1e30F), HasSubstr("the style of an example, frame 0 of"));
  }
  // Only variations; one layer alone cannot fail, because its output ends in a tanh.
  stgcn::WeightsFile file = stgcn::RandomWeights(3, 16, 1);
  for (const char* const tensor : {"f.fc1.weight", "f.fc2.weight"}) {
    for (float& value : file.tensor(tensor).values) value *= 1e38F;
  }
  const auto wild = net::ParseAny(file.Bytes(), "wild");
  ASSERT_TRUE(wild.ok()) << wild.status().message();
  EXPECT_THAT(
      Try(*wild.value().clips, "wild").message(),
      HasSubstr("style 'neutral', variation 1: expected finite numbers in its code, found nan"));
}

// A live network with a space of styles is also tried by an example.
TEST(TrialTest, RandomCausalWeightsPassAndWildExamplesAreRefused) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto network = stgcn_causal::RandomWeights(3, 16, seed);
    const auto parsed = Parse(network.Bytes(), "random");
    ASSERT_TRUE(parsed.ok()) << seed << ": " << parsed.status().message();
  }
  const auto refusal = [](const std::string& tensor) {
    stgcn::WeightsFile file = stgcn_causal::RandomWeights(3, 16, 1);
    for (float& value : file.tensor(tensor).values) value *= 1e30F;
    return Parse(file.Bytes(), "wild").status().message();
  };
  EXPECT_THAT(refusal("e.free.weight"), HasSubstr("style 'of an example', frame 0 of"));
  EXPECT_THAT(refusal("g.dec2.tconv2.weight"), HasSubstr("style 'neutral', frame 0 of"));
}

TEST(TrialTest, AFileIsTriedAsItIsLoaded) {
  EXPECT_THAT(Load("no/such/weights").status().message(), HasSubstr("no/such/weights"));
  EXPECT_TRUE(Load(STYLED_SHIPPED "/v2.safetensors").ok());
  EXPECT_TRUE(LoadAny(STYLED_SHIPPED "/v2.safetensors").ok());
}

}  // namespace
}  // namespace styled::trial

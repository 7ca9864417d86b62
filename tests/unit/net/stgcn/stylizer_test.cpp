#include "model/net/stgcn/stylizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "model/body/heading.h"
#include "model/net/load.h"
#include "model/net/stgcn/codes.h"
#include "model/synthetic/performer.h"
#include "tests/unit/net/stgcn/random_weights.h"

namespace styled::stgcn {
namespace {

using net::Extent;
using net::Prediction;

std::vector<body::Pose> Walk(int frames) {
  synthetic::Options options;
  options.script = {{synthetic::Motion::kWalk, 3.0}, {synthetic::Motion::kRun, 2.0}};
  synthetic::Performer performer(std::move(options));
  std::vector<body::Pose> poses(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) performer.Pose(i / 30.0, poses[static_cast<std::size_t>(i)]);
  return poses;
}

std::shared_ptr<const net::ClipStylizer> StylizerOf(const WeightsFile& file) {
  const auto any = net::ParseAny(file.Bytes(), "random");
  EXPECT_TRUE(any.ok()) << any.status().message();
  return any.value().clips;
}

std::vector<Prediction> Predict(const net::ClipStylizer& stylizer, const net::StyleCode& code,
                                std::span<const body::Pose> poses, Extent extent,
                                std::size_t* most_late = nullptr, int input_style = 0) {
  const auto stream = stylizer.MakeStream(code, input_style, extent);
  std::vector<Prediction> all;
  Prediction out;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    stream->Add(poses[i]);
    while (stream->Pop(out)) all.push_back(out);
    if (most_late != nullptr) *most_late = std::max(*most_late, i + 1 - all.size());
  }
  stream->End();
  while (stream->Pop(out)) all.push_back(out);
  EXPECT_FALSE(stream->Pop(out));
  return all;
}

float Apart_rad(const net::Decoded& a, const net::Decoded& b) {
  float most = 0;
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    const float apart = a.rotations[joint].angularDistance(b.rotations[joint]);
    if (!(apart <= most)) most = apart;
  }
  return most;
}

struct StgcnStylizerTest : testing::Test {
  net::StyleCode Named(int style, float strength = 1) const {
    net::StyleRequest request;
    request.sources = {{style, {}, {}, 1}};
    request.strength = strength;
    return stylizer->MakeCode(request);
  }

  WeightsFile file = RandomWeights(4, 16, 1);
  std::shared_ptr<const Network> network = NetworkOf(file);
  std::shared_ptr<const net::ClipStylizer> stylizer = StylizerOf(file);
};

TEST_F(StgcnStylizerTest, AClipIsEncodedOnceAndDecodedInItsOwnAndTheRequestedStyle) {
  const std::vector<body::Pose> poses = Walk(93);
  for (const int own : {0, 2}) {
    const auto found = Predict(*stylizer, Named(3), poses, Extent::kByLength, nullptr, own);
    ASSERT_EQ(found.size(), poses.size());
    HeadingState heading;
    std::vector<Features> clip(poses.size()), reconstructed(poses.size()), styled(poses.size());
    std::vector<float> heading_rad;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      heading_rad.push_back(ComputeFeatures(poses[i], network->features(), heading, clip[i]));
    }
    Scratch scratch;
    Network::Content content;
    network->Encode(clip, content, scratch);
    network->Decode(content, network->space().EncodeStyle(clip, own, scratch), reconstructed,
                    scratch);
    network->Decode(content, network->space().mean_code(3), styled, scratch);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_EQ(found[i].heading_rad, heading_rad[i]);
      for (const auto& [features, decoded] : {std::pair(&reconstructed, &found[i].reconstruction),
                                              std::pair(&styled, &found[i].styled)}) {
        body::Pose expected;  // in the world: the hips turned by the heading
        PoseOf((*features)[i], heading_rad[i], expected);
        EXPECT_EQ(decoded->hips_height_m, expected.hips_position_m.y());
        for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
          body::Quat in_world = decoded->rotations[joint];
          if (joint == body::kHips) in_world = body::Yaw(heading_rad[i]) * in_world;
          EXPECT_NEAR(in_world.norm(), 1, 1e-4F);
          EXPECT_LT(in_world.angularDistance(expected.rotations[joint]), 1e-3F) << i;
        }
      }
    }
  }
}

TEST_F(StgcnStylizerTest, AnyLengthGivesOnePredictionPerPose) {
  for (const int frames : {1, 2, 7, 8, 9, 11, 64, 600, 601, 700}) {
    const auto found = Predict(*stylizer, Named(1), Walk(frames), Extent::kByLength);
    ASSERT_EQ(found.size(), static_cast<std::size_t>(frames));
    for (const Prediction& one : found) {
      ASSERT_NEAR(one.styled.rotations[5].norm(), 1, 1e-3F);
      ASSERT_NEAR(one.reconstruction.rotations[0].norm(), 1, 1e-3F);
    }
  }
}

TEST_F(StgcnStylizerTest, ALongClipIsNormalizedInWindowsAndAShortOneAsAWhole) {
  const std::vector<body::Pose> poses = Walk(kLongestWhole + 1);
  const auto short_clip = std::span(poses).first(kLongestWhole);
  const auto same = [](const std::vector<Prediction>& a, const std::vector<Prediction>& b) {
    float most = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      most = std::max(most, Apart_rad(a[i].styled, b[i].styled));
    return most == 0;
  };
  const auto by_length = [&](std::span<const body::Pose> clip) {
    return Predict(*stylizer, Named(1), clip, Extent::kByLength);
  };
  EXPECT_TRUE(
      same(by_length(short_clip), Predict(*stylizer, Named(1), short_clip, Extent::kWhole)));
  EXPECT_TRUE(same(by_length(poses), Predict(*stylizer, Named(1), poses, Extent::kWindows)));
  EXPECT_FALSE(same(by_length(poses), Predict(*stylizer, Named(1), poses, Extent::kWhole)));
}

TEST_F(StgcnStylizerTest, WindowsWaitForNoMoreThanOne) {
  std::size_t late = 0;
  EXPECT_EQ(Predict(*stylizer, Named(1), Walk(2000), Extent::kWindows, &late).size(), 2000U);
  EXPECT_LE(late, static_cast<std::size_t>(kWindow));
}

// Where one window ends and the next begins, the blend is smooth: no step from frame to frame is
// much larger than in the whole clip.
TEST_F(StgcnStylizerTest, WindowsBlendWithoutASeam) {
  const std::vector<body::Pose> poses = Walk(900);
  const auto largest_step = [&](Extent extent) {
    const auto found = Predict(*stylizer, Named(2), poses, extent);
    float most = 0;
    for (std::size_t i = 1; i < found.size(); ++i) {
      most = std::max(most, Apart_rad(found[i].styled, found[i - 1].styled));
    }
    return most;
  };
  EXPECT_LT(largest_step(Extent::kWindows), 1.3F * largest_step(Extent::kWhole));
}

// The overlap of two windows by itself: features of both, the later one's share sin².
TEST_F(StgcnStylizerTest, AnOverlapIsFadedBySinesSquared) {
  const std::vector<body::Pose> poses = Walk(kWindow + kHop);
  HeadingState heading;
  std::vector<Features> clip(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ComputeFeatures(poses[i], network->features(), heading, clip[i]);
  }
  const auto styled = [&](int begin) {
    Scratch scratch;
    Network::Content content;
    std::vector<Features> out(kWindow);
    network->Encode(std::span(clip).subspan(static_cast<std::size_t>(begin), kWindow), content,
                    scratch);
    network->Decode(content, network->space().mean_code(2), out, scratch);
    return out;
  };
  const std::vector<Features> first = styled(0), second = styled(kHop);
  const auto found = Predict(*stylizer, Named(2), poses, Extent::kWindows);
  ASSERT_EQ(found.size(), poses.size());
  const auto most_apart = [&](const auto& share) {
    float most = 0;
    for (std::size_t i = 0; i < kHop; ++i) {
      Features faded;
      for (std::size_t k = 0; k < faded.size(); ++k) {
        faded[k] = first[kHop + i][k] + share(i) * (second[i][k] - first[kHop + i][k]);
      }
      net::Decoded expected;
      ToDecoded(faded, expected);
      most = std::max(most, Apart_rad(found[kHop + i].styled, expected));
    }
    return most;
  };
  EXPECT_LT(most_apart([](std::size_t i) {
              return std::pow(std::sin(M_PI_2 * (static_cast<double>(i) + 0.5) / kHop), 2);
            }),
            2e-3F);
  EXPECT_GT(most_apart([](std::size_t) { return 1.0; }), 4e-3F) << "the windows differ";
}

TEST_F(StgcnStylizerTest, CodesAreMadeOfMeansNoiseAndReferences) {
  const std::vector<body::Pose> example = Walk(90);
  net::StyleRequest request;
  request.amount = 0.5F;
  request.strength = 0.9F;
  request.sources = {{1, {}, {}, 0.2F}, {2, 11, {}, 0.3F}, {-1, {}, example, 0.5F}};
  const net::StyleCode found = stylizer->MakeCode(request);
  HeadingState heading;
  std::vector<Features> clip(example.size());
  for (std::size_t i = 0; i < clip.size(); ++i) {
    ComputeFeatures(example[i], network->features(), heading, clip[i]);
  }
  Scratch scratch;
  const Code& neutral = network->space().mean_code(0);
  const Code expected =
      neutral + 0.9F * (0.2F * (network->space().mean_code(1) - neutral) +
                        0.3F * (Varied(network->space(), 11, 2, 0.5F) - neutral) +
                        0.5F * (network->space().EncodeStyle(clip, kFreeHead, scratch) - neutral));
  ASSERT_EQ(found.size(), static_cast<std::size_t>(kCode));
  EXPECT_LT((Eigen::Map<const Code>(found.data()) - expected).cwiseAbs().maxCoeff(), 1e-5F);
  EXPECT_EQ(stylizer->Nearest(Named(3)).style, 3);
}

TEST_F(StgcnStylizerTest, WildWeightsGiveRotationsThatAreNone) {
  WeightsFile wild = file;
  for (float& value : wild.tensor("g.dec1.tconv1.weight").values) value *= 1e38F;
  const auto network_of_wild = StylizerOf(wild);
  const auto found = Predict(*network_of_wild, Named(1), Walk(20), Extent::kWhole);
  bool sound = true;
  for (const body::Quat& q : found[5].styled.rotations)
    sound = sound && std::abs(q.norm() - 1) < 1e-3F;
  EXPECT_FALSE(sound);
}

TEST(StgcnFamily, IsRefusedWhereFramesAreStyledOneByOne) {
  const WeightsFile file = RandomWeights(2, 16, 1);
  EXPECT_THAT(net::Parse(file.Bytes(), "file").status().message(),
              testing::AllOf(testing::HasSubstr("file: key 'family': expected \"style-erd\" or "),
                             testing::HasSubstr("found \"st-gcn\": it styles whole clips")));
  EXPECT_EQ(net::ClipFamilyNames(), "\"st-gcn\"");
  const auto any = net::ParseAny(file.Bytes(), "file");
  ASSERT_TRUE(any.ok());
  EXPECT_EQ(any.value().frames, nullptr);
  EXPECT_EQ(any.value().model().family, "st-gcn");
}

}  // namespace
}  // namespace styled::stgcn

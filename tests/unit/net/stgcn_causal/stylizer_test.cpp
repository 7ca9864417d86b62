#include "model/net/stgcn_causal/stylizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "model/body/heading.h"
#include "model/net/load.h"
#include "model/synthetic/performer.h"
#include "model/trial/trial.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::stgcn_causal {
namespace {

using net::Prediction;
using net::StyleWeight;

std::vector<body::Pose> Walk(int frames) {
  synthetic::Options options;
  options.script = {{synthetic::Motion::kWalk, 2.0}, {synthetic::Motion::kTurnLeft, 1.0}};
  synthetic::Performer performer(std::move(options));
  std::vector<body::Pose> poses(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) performer.Pose(i / 30.0, poses[static_cast<std::size_t>(i)]);
  return poses;
}

// Bit for bit.
bool Same(const net::Decoded& a, const net::Decoded& b) {
  bool same = a.hips_height_m == b.hips_height_m && a.velocities_m_s == b.velocities_m_s;
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    same = same && a.rotations[joint].coeffs() == b.rotations[joint].coeffs();
  }
  return same;
}
bool Same(const Prediction& a, const Prediction& b) {
  return Same(a.reconstruction, b.reconstruction) && Same(a.styled, b.styled) &&
         a.heading_rad == b.heading_rad;
}

struct CausalStylizer : testing::Test {
  CausalStylizer() {
    const auto loaded = net::Parse(file.Bytes(), "random");
    EXPECT_TRUE(loaded.ok()) << loaded.status().message();
    stylizer = loaded.value();
  }

  WeightsFile file = RandomWeights(6, 16, 1);
  std::shared_ptr<const Network> network = CausalNetwork(file);
  std::shared_ptr<const net::Stylizer> stylizer;
};

TEST_F(CausalStylizer, ItsFamilyIsOfLiveStreams) {
  EXPECT_EQ(stylizer->model().family, kFamily);
  EXPECT_EQ(stylizer->model().styles.size(), 6U);
  const auto any = net::ParseAny(file.Bytes(), "random");
  ASSERT_TRUE(any.ok()) << any.status().message();
  EXPECT_NE(any.value().frames, nullptr);
  EXPECT_EQ(any.value().clips, nullptr);
}

TEST_F(CausalStylizer, PosesGoThroughTheFeaturesAndComeBackAsLocalRotations) {
  const std::vector<body::Pose> poses = Walk(60);
  const std::vector<StyleWeight> active{{2, 1.0F}};
  const auto stream = stylizer->MakeStream();
  State state = network->MakeState();
  stgcn::HeadingState heading;
  for (const body::Pose& pose : poses) {
    Prediction found;
    const net::StepJob job{&pose, 1, active, stream.get(), &found};
    stylizer->Step({&job, 1});

    Features features;
    Output out;
    const float heading_rad = stgcn::ComputeFeatures(pose, network->features(), heading, features);
    network->Step(features, 1, active, state, out);
    EXPECT_EQ(found.heading_rad, heading_rad);
    // The change is measured from between reconstruction and input: back to the network's own pose.
    for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
      const body::Quat& from = found.reconstruction.rotations[joint];
      body::Quat input = pose.rotations[joint];
      if (joint == body::kHips) input = body::Yaw(-heading_rad) * input;
      body::Quat& styled = found.styled.rotations[joint];
      styled = from.slerp(kTowardInput, input) * (from.conjugate() * styled);
    }
    for (const auto& [decoded, expected] :
         {std::pair(&found.reconstruction, &out.reconstruction), {&found.styled, &out.styled}}) {
      EXPECT_EQ(decoded->hips_height_m, (*expected)[stgcn::kChannels * body::kHips + 1]);
      // Parent by parent the local rotations give the output's global ones again.
      std::array<body::Quat, body::kJointCount> global;
      for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
        const int parent = body::kHumanoid[joint].parent;
        global[joint] = decoded->rotations[joint];
        if (parent >= 0) global[joint] = global[static_cast<std::size_t>(parent)] * global[joint];
        Eigen::Vector4f wanted(expected->data() + stgcn::kChannels * joint + 3);
        wanted.normalize();
        EXPECT_GT(std::abs(global[joint].coeffs().dot(wanted)), 1 - 1e-5F) << joint;
      }
      for (const float velocity : decoded->velocities_m_s) EXPECT_EQ(velocity, 0);
    }
  }
}

// A style that fades in begins at the reconstruction, and its own pose is weighted with it.
TEST_F(CausalStylizer, WhatIsMeasuredFromTheInputFadesWithTheStyle) {
  const std::vector<body::Pose> poses = Walk(30);
  const auto weak = stylizer->MakeStream(), none = stylizer->MakeStream();
  float off = 0;
  for (const body::Pose& pose : poses) {
    Prediction faint, bare;
    const std::vector<StyleWeight> active{{2, 1e-4F}};
    const net::StepJob job{&pose, 0, active, weak.get(), &faint};
    stylizer->Step({&job, 1});
    const net::StepJob other{&pose, 0, {}, none.get(), &bare};
    stylizer->Step({&other, 1});
    EXPECT_TRUE(Same(bare.styled, bare.reconstruction));
    for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
      off = std::max(off,
                     faint.styled.rotations[joint].angularDistance(bare.styled.rotations[joint]));
    }
  }
  EXPECT_LT(off, 2e-3F);
}

// The example's code comes from the same networks as the offline family's; its bias follows.
TEST_F(CausalStylizer, AnExampleHasTheCodeOfTheOfflineNetwork) {
  const auto offline = net::ParseAny(stgcn::RandomWeights(6, 16, 1).Bytes(), "offline");
  ASSERT_TRUE(offline.ok()) << offline.status().message();
  ASSERT_NE(stylizer->space(), nullptr);
  const std::vector<body::Pose> example = Walk(100);
  const net::StyleSource alone{.style = -1, .seed = {}, .reference = example};
  const net::StyleSource labelled{.style = 2, .seed = {}, .reference = example};
  const net::StyleSource varied{.style = 3, .seed = 7, .reference = {}};
  for (const net::StyleSource& source : {alone, labelled, varied}) {
    const net::StyleRequest request{.sources = {source}, .amount = 0.7F, .strength = 0.9F};
    net::StyleCode code = stylizer->space()->MakeCode(request);
    code.resize(64);
    EXPECT_EQ(code, offline.value().clips->MakeCode(request));
  }
}

TEST_F(CausalStylizer, AStyleIsAddedWhileItsStreamsGoOn) {
  const net::StyleCode code = stylizer->space()->MakeCode({.sources = {{.style = 2}}});
  const auto more = stylizer->With(6, {.name = "mine"}, code);
  ASSERT_NE(more, nullptr);
  EXPECT_EQ(stylizer->model().styles.size(), 6U);
  ASSERT_EQ(more->model().styles.size(), 7U);
  EXPECT_EQ(more->model().styles[6].name, "mine");
  EXPECT_TRUE(more->SharesStreams(*stylizer) && stylizer->SharesStreams(*more));

  // A stream that began without the new style, beside one in the style that it is a copy of.
  const std::vector<body::Pose> poses = Walk(40);
  const auto stream = stylizer->MakeStream(), beside = stylizer->MakeStream();
  for (std::size_t frame = 0; frame < poses.size(); ++frame) {
    const bool late = frame >= 20;
    const std::vector<StyleWeight> added{{late ? 6 : 2, 1.0F}}, own{{2, 1.0F}};
    Prediction found, expected;
    const net::StepJob job{&poses[frame], 0, added, stream.get(), &found};
    (late ? *more : *stylizer).Step({&job, 1});
    const net::StepJob other{&poses[frame], 0, own, beside.get(), &expected};
    stylizer->Step({&other, 1});
    EXPECT_TRUE(Same(found, expected)) << frame;
  }

  // Another in its place; the file's own styles and the other network stay.
  const net::StyleCode next = stylizer->space()->MakeCode({.sources = {{.style = 4}}});
  const auto replaced = more->With(6, {.name = "next"}, next);
  EXPECT_EQ(replaced->model().styles.size(), 7U);
  EXPECT_EQ(replaced->model().styles[6].name, "next");
  EXPECT_EQ(more->model().styles[6].name, "mine");
  EXPECT_EQ(replaced->space()->Nearest(next).style, 4);
}

TEST_F(CausalStylizer, StreamsOfOtherWeightsAreNotShared) {
  const auto other = net::Parse(file.Bytes(), "again");
  ASSERT_TRUE(other.ok());
  EXPECT_FALSE(stylizer->SharesStreams(*other.value()));
}

// Performers without a style, in one, in several, switching, and with an input style.
TEST_F(CausalStylizer, TogetherIsBitForBitOneByOne) {
  constexpr std::size_t kPerformers = 21;
  const std::vector<body::Pose> poses = Walk(60);
  std::vector<std::unique_ptr<net::Stream>> alone, together;
  for (std::size_t k = 0; k < kPerformers; ++k) {
    alone.push_back(stylizer->MakeStream());
    together.push_back(stylizer->MakeStream());
  }
  for (std::size_t frame = 0; frame < 12; ++frame) {
    std::vector<std::vector<StyleWeight>> active(kPerformers);
    std::vector<Prediction> out_alone(kPerformers), out_together(kPerformers);
    std::vector<net::StepJob> jobs;
    for (std::size_t k = 0; k < kPerformers; ++k) {
      for (std::size_t s = 0; s < k % 5; ++s) {
        active[k].push_back({static_cast<int>(1 + (k + s + frame / 4) % 6), 0.4F});
      }
      const int own = k % 4 == 3 ? 2 : 0;
      const body::Pose& pose = poses[frame + k];
      const net::StepJob job{&pose, own, active[k], alone[k].get(), &out_alone[k]};
      stylizer->Step({&job, 1});
      jobs.push_back({&pose, own, active[k], together[k].get(), &out_together[k]});
    }
    stylizer->Step(jobs);
    for (std::size_t k = 0; k < kPerformers; ++k) {
      ASSERT_TRUE(Same(out_alone[k], out_together[k])) << frame << " " << k;
    }
  }
}

TEST_F(CausalStylizer, AStartedStreamIsAsANewOne) {
  const std::vector<body::Pose> poses = Walk(60);
  const std::vector<StyleWeight> active{{3, 1.0F}};
  const auto used = stylizer->MakeStream(), fresh = stylizer->MakeStream();
  Prediction out, expected;
  for (const body::Pose& pose : poses) {
    const net::StepJob job{&pose, 0, active, used.get(), &out};
    stylizer->Step({&job, 1});
  }
  stylizer->Start(*used);
  for (std::size_t i = 30; i < 60; ++i) {
    const std::array<net::StepJob, 2> jobs{
        {{&poses[i], 0, active, used.get(), &out}, {&poses[i], 0, active, fresh.get(), &expected}}};
    stylizer->Step(jobs);
    ASSERT_TRUE(Same(out, expected)) << i;
  }
}

// A step writes into what memory() names, and that stays where it is.
TEST_F(CausalStylizer, MemoryIsWhatAStepWrites) {
  const std::vector<body::Pose> poses = Walk(2);
  const auto stream = stylizer->MakeStream();
  const std::span<const std::byte> memory = stream->memory();
  ASSERT_FALSE(memory.empty());
  const std::vector<std::byte> before(memory.begin(), memory.end());
  Prediction out;
  const net::StepJob job{poses.data(), 0, {}, stream.get(), &out};
  stylizer->Step({&job, 1});
  EXPECT_EQ(stream->memory().data(), memory.data());
  EXPECT_EQ(stream->memory().size(), memory.size());
  EXPECT_FALSE(std::equal(memory.begin(), memory.end(), before.begin()));
}

// A program that runs a user's weights tries them first.
TEST_F(CausalStylizer, SoundWeightsPassTheTrialRunAndWildOnesDoNot) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const auto bytes = RandomWeights(3, 16, seed).Bytes();
    const auto tried = trial::Parse(bytes, "random");
    EXPECT_TRUE(tried.ok()) << seed << ": " << tried.status().message();
  }
  const auto refusal = [](const std::string& tensor, std::size_t from, float by) {
    WeightsFile wild = RandomWeights(3, 16, 1);
    std::vector<float>& values = wild.tensor(tensor).values;
    for (std::size_t i = from; i < values.size(); ++i) values[i] *= by;
    return trial::Parse(wild.Bytes(), "wild").status().message();
  };
  EXPECT_THAT(refusal("g.dec2.tconv2.weight", 0, 1e38F),
              testing::HasSubstr("style 'neutral', frame 0 of 105, joint "));
  EXPECT_THAT(refusal("codes.mean", 2 * stgcn::kCode, 1e38F),
              testing::HasSubstr("style 'style2', frame 0 of"));
}

}  // namespace
}  // namespace styled::stgcn_causal

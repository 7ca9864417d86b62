// The fit of a style on the random weights of the runtime's tests: a network that is not trained
// has styles, too.
#include "model/train/stgcn_causal/refiner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "model/net/styles.h"
#include "model/train/checkpoint.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"
#include "tests/unit/train/walker.h"

namespace styled::train::st_gcn_causal {
namespace {

using testing::HasSubstr;
using torch::Tensor;

class RefinerTest : public testing::Test {
 protected:
  RefinerTest()
      : file_(std::filesystem::temp_directory_path() / ("refine" + std::to_string(getpid()))) {
    Write(stgcn_causal::RandomWeights(3, 16, 5));
    auto loaded = ReadStudent(file_);
    EXPECT_TRUE(loaded.ok()) << loaded.status().message();
    network_ = std::move(loaded.value());
  }
  ~RefinerTest() override { std::filesystem::remove(file_); }

  void Write(const stgcn_causal::WeightsFile& weights) {
    const std::vector<std::byte> bytes = weights.Bytes();
    std::ofstream(file_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }

  // A style in full form, all of whose numbers matter.
  std::vector<float> Full() const {
    torch::manual_seed(7);
    const VectorSizes sizes(network_.student->shape);
    FullStyle style = StyleOf(std::vector<float>(static_cast<std::size_t>(sizes.full())),
                              network_.student->shape);
    style.code = network_.codes.narrow(0, 1, 1) + 0.1 * torch::randn_like(style.code);
    style.bias = 0.2 * torch::randn_like(style.bias);
    style.additions = 0.2 * torch::randn_like(style.additions);
    return VectorOf(style);
  }

  // The take is the neutral motion with lifted arms and a bent back.
  RefineMotion Motion() const {
    const auto frames = [this](const std::vector<body::Pose>& poses) {
      return FramesOf({poses}, network_.statistics, network_.network->features());
    };
    std::vector<body::Pose> neutral = Walker(400).poses, take = neutral;
    for (body::Pose& pose : take) {
      pose.rotations[body::kSpine] = pose.rotations[body::kSpine] * body::Exp({0.4F, 0, 0});
      pose.rotations[body::kLeftUpperArm] =
          pose.rotations[body::kLeftUpperArm] * body::Exp({0, 0, 0.5F});
    }
    const Parts first = Split(frames(take), 0.25), second = Split(frames(neutral), 0.25);
    return {.take = first.first,
            .neutral = second.first,
            .judged_take = first.last,
            .judged_neutral = second.last};
  }

  FullStyle Start() const {
    const VectorSizes sizes(network_.student->shape);
    const float* const code = network_.codes.data_ptr<float>() + sizes.code;
    return StyleOf({code, code + sizes.code}, network_.student->shape);
  }

  const std::filesystem::path file_;
  LoadedStudent network_;
};

TEST_F(RefinerTest, OtherWeightsAreRefused) {
  const auto refused = [this](auto change) {
    stgcn_causal::WeightsFile weights = stgcn_causal::RandomWeights(3, 16, 5);
    change(weights.metadata);
    Write(weights);
    const auto read = ReadStudent(file_);
    EXPECT_FALSE(read.ok());
    return read.ok() ? "" : read.status().message();
  };
  EXPECT_THAT(refused([](auto& header) { header["family"] = "st-gcn"; }),
              HasSubstr("key 'family': expected \"st-gcn-causal\", found \"st-gcn\""));
  EXPECT_THAT(refused([](auto& header) { header["memory"] = 30; }),
              HasSubstr("key 'memory': expected 21, found 30"));
  EXPECT_THAT(refused([](auto& header) { header["start_frames"] = 4; }),
              HasSubstr("key 'start_frames': expected 16, found 4"));
  EXPECT_THAT(refused([](auto& header) {
                header["spacing"] = {1, 4, 2, 1};
              }),
              HasSubstr("key 'spacing': expected [2,4,2,1], found [1,4,2,1]"));
  EXPECT_THAT(ReadStudent("/nonexistent").status().message(), HasSubstr("/nonexistent"));
}

TEST_F(RefinerTest, FlagsThatCannotWorkAreRefused) {
  const auto refused = [](auto change) {
    RefineConfig config;
    change(config);
    return Check(config).message();
  };
  EXPECT_THAT(refused([](auto& c) { c.w_moments = -1; }), HasSubstr("--w-moments"));
  EXPECT_THAT(refused([](auto& c) { c.w_small = std::nan(""); }), HasSubstr("--w-small"));
  EXPECT_THAT(refused([](auto& c) { c.code_alone = 1.5; }), HasSubstr("--code-alone"));
  EXPECT_THAT(refused([](auto& c) { c.batch = 0; }), HasSubstr("--batch"));
  EXPECT_TRUE(Check(RefineConfig()).ok());
}

TEST_F(RefinerTest, AVectorIsAStyleInEachOfItsForms) {
  const st_gcn::Shape& shape = network_.student->shape;
  const VectorSizes sizes(shape);
  EXPECT_EQ(sizes.full(), 64 + 147 + 18 * 16);
  EXPECT_FALSE(sizes.Allow(63));
  EXPECT_FALSE(sizes.Allow(65));
  const std::vector<float> full = Full();
  EXPECT_EQ(VectorOf(StyleOf(full, shape)), full);
  for (const std::size_t size : {64UL, 64UL + 147}) {
    std::vector<float> padded(full.begin(), full.begin() + static_cast<long>(size));
    ASSERT_TRUE(sizes.Allow(size));
    const std::vector<float> read = VectorOf(StyleOf(padded, shape));
    padded.resize(full.size());
    EXPECT_EQ(read, padded);
  }
}

// Frame by frame at run time, and as a window here.
TEST_F(RefinerTest, TheRuntimeMakesTheSameOfAStyleInFullForm) {
  const torch::NoGradGuard no_grad;
  const std::vector<float> full = Full();
  const auto network = network_.network->With(3, {.name = "new"}, full);
  constexpr int64_t kFrames = 50;
  const auto poses = Walker(kFrames).poses;
  const Graph graph(torch::kCPU, torch::kFloat32, kFrames);
  const Tensor window =
      FramesOf({poses}, network_.statistics, network_.network->features())[0].unsqueeze(0);
  const Tensor content = network_.student->Encode(graph, window);
  const FullStyle style = StyleOf(full, network_.student->shape);
  const Tensor expected = network_.student->Decode(graph, content, style);
  const Tensor code_alone = network_.student->Decode(graph, content, style.code);

  stgcn_causal::State state = network->MakeState();
  stgcn::HeadingState heading;
  stgcn::Features features;
  stgcn_causal::Output output;
  const net::StyleWeight active[] = {{3, 1.0F}};
  double largest = 0, without = 0;
  for (int64_t t = 0; t < kFrames; ++t) {
    stgcn::ComputeFeatures(poses[static_cast<std::size_t>(t)], network->features(), heading,
                           features);
    network->Step(features, 0, active, state, output);
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      for (int channel = 0; channel < stgcn::kChannels; ++channel) {
        if (joint == body::kHips && (channel == 0 || channel == 2)) continue;
        const auto i = static_cast<std::size_t>(stgcn::kChannels * joint + channel);
        const float standardized =
            (output.styled[i] - network_.statistics.mean[i]) / network_.statistics.deviation[i];
        const auto off = [&](const Tensor& of) {
          return std::abs(of[0][t][joint][channel].item<float>() - standardized);
        };
        largest = std::max(largest, static_cast<double>(off(expected)));
        without = std::max(without, static_cast<double>(off(code_alone)));
      }
    }
  }
  EXPECT_LT(largest, 1e-3);
  EXPECT_GT(without, 0.1) << "the control";
}

// With the shipped weights: a network that is not trained has no change of style to fit.
TEST_F(RefinerTest, AFitLowersLossAndFigures) {
  auto shipped = ReadStudent(STYLED_SHIPPED "/graph.safetensors");
  ASSERT_TRUE(shipped.ok()) << shipped.status().message();
  network_ = std::move(shipped.value());
  RefineConfig config;
  config.precision = "fp32";
  config.batch = 4;
  const RefineMotion motion = Motion();
  Refiner refiner(config, network_, motion, Start());
  const RefineFigures start = refiner.Measure(refiner.style());
  double first = 0, last = 0;
  constexpr int kSteps = 40;
  for (int step = 0; step < kSteps; ++step) {
    const double loss = refiner.Step(step / static_cast<double>(kSteps));
    if (step < 5) first += loss;
    if (step >= kSteps - 5) last += loss;
  }
  EXPECT_LT(last, 0.8 * first);
  EXPECT_LT(refiner.Measure(refiner.style()).score(), 0.9 * start.score());
  EXPECT_TRUE(refiner.Finite());
}

TEST_F(RefinerTest, ItIsTheSameEachTimeAndGoesOnFromAStyle) {
  RefineConfig config;
  config.precision = "fp32";
  config.batch = 2;
  const RefineMotion motion = Motion();
  const auto fit = [&](const FullStyle& start, double from) {
    Refiner refiner(config, network_, motion, start);
    for (int step = 0; step < 8; ++step) refiner.Step(from + 0.01 * step);
    return VectorOf(refiner.style());
  };
  const std::vector<float> once = fit(Start(), 0.5);
  EXPECT_EQ(once, fit(Start(), 0.5));
  const FullStyle style = StyleOf(once, network_.student->shape);
  Refiner again(config, network_, motion, style);
  EXPECT_EQ(VectorOf(again.style()), once);
  EXPECT_LE(again.Measure(style).score(), again.Measure(Start()).score());
  // At first the code is fitted alone.
  const FullStyle code_alone = StyleOf(fit(Start(), 0), network_.student->shape);
  EXPECT_EQ(code_alone.bias.abs().max().item<double>(), 0);
  EXPECT_EQ(code_alone.additions.abs().max().item<double>(), 0);
  EXPECT_GT((code_alone.code - Start().code).abs().max().item<double>(), 0);
}

TEST(RefineMotionTest, ShortClipsBeginLate) {
  const Tensor clip = torch::arange(5).to(torch::kFloat32).view({5, 1, 1}).expand({5, 21, 7});
  std::mt19937_64 random(1);
  const Tensor window = DrawWindows({clip}, 8, 1, random);
  for (int64_t t = 0; t < 8; ++t) {
    EXPECT_EQ(window[0][t][0][0].item<float>(), static_cast<float>(std::max<int64_t>(t - 3, 0)));
  }
  const Parts parts = Split({clip}, 0.4);
  EXPECT_EQ(parts.first[0].size(0), 3);
  EXPECT_EQ(parts.last[0].size(0), 2);
  EXPECT_EQ(Split({clip.narrow(0, 0, 2)}, 0.01).last[0].size(0), 1);
}

TEST(RefineMotionTest, MirroredTwiceIsTheSame) {
  torch::manual_seed(1);
  const Tensor clip = torch::randn({4, 21, 7});
  const Frames mirrored = Mirrored({clip});
  EXPECT_FALSE(torch::equal(mirrored[0], clip));
  EXPECT_TRUE(torch::equal(Mirrored(mirrored)[0], clip));
}

}  // namespace
}  // namespace styled::train::st_gcn_causal

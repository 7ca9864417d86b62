// Every way in which a weights file of this family can be wrong, and the values read from a correct
// one. The common keys and the container are tests/unit/net/erd/load_test.cpp's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "tests/unit/net/stgcn/each_tensor.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::stgcn_causal {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr int kDomains = 3, kWidth = 16;

Status Load(const WeightsFile& file) { return Network::Parse(file.Bytes(), "file").status(); }

struct Broken {
  const char* what;
  std::function<void(WeightsFile&)> breaks;
  std::string message;  // occurs in the error
};

std::function<void(WeightsFile&)> Set(const std::string& key, const json& value) {
  return [key, value](WeightsFile& file) { file.metadata[key] = value; };
}
std::function<void(WeightsFile&)> Add(const std::string& tensor) {
  return [tensor](WeightsFile& file) { file.tensors.push_back({tensor, {1}, {0}}); };
}

std::vector<Broken> BrokenFiles() {
  const std::string spacing = "key 'spacing': expected 4 whole numbers from 1 to 16, found ";
  const std::string memory = "key 'memory': expected a whole number from 2 to 1000, found ";
  const std::string start = "key 'start_frames': expected a whole number from 1 to 1000, found ";
  return {
      {"Tau", Set("heading_tau_s", -0.1),
       "key 'heading_tau_s': expected a number >= 0 and <= 60, found -0.1"},
      {"Code", Set("code", 32), "key 'code': expected 64, found 32"},
      {"Contents", Set("contents", 5), "key 'contents': expected an array of strings, found 5"},
      {"Width", Set("width", 40), "key 'width': expected a multiple of 16 up to 96, found 40"},
      {"SpacingNumber", Set("spacing", 2), spacing + "2"},
      {"SpacingOfThree", Set("spacing", {2, 4, 2}), spacing + "[2,4,2]"},
      {"SpacingOfFive", Set("spacing", {2, 4, 2, 1, 1}), spacing + "[2,4,2,1,1]"},
      {"SpacingZero", Set("spacing", {2, 4, 0, 1}), spacing + "[2,4,0,1]"},
      {"SpacingHuge", Set("spacing", {2, 4, 17, 1}), spacing + "[2,4,17,1]"},
      {"SpacingNegative", Set("spacing", {2, 4, -2, 1}), spacing + "[2,4,-2,1]"},
      {"SpacingFraction", Set("spacing", {2, 4, 2, 1.0}), spacing + "[2,4,2,1.0]"},
      {"SpacingText", Set("spacing", {2, 4, "2", 1}), spacing + "[2,4,\"2\",1]"},
      {"MemoryOne", Set("memory", 1), memory + "1"},
      {"MemoryHuge", Set("memory", 1001), memory + "1001"},
      {"MemoryFraction", Set("memory", 21.5), memory + "21.5"},
      {"MemoryText", Set("memory", "21"), memory + "\"21\""},
      {"StartFramesZero", Set("start_frames", 0), start + "0"},
      {"StartFramesHuge", Set("start_frames", 1e15), start + "1"},
      {"WidthOfAnother", Set("width", 32),
       "tensor 'g.in.weight': expected F32 [32,7], found F32 [16,7]"},
      {"Noise", Set("noise", 8), "key 'noise': expected 16, found 8"},
      {"Window", Set("window", 32), "key 'window': expected 64, found 32"},
      {"StartOfASkip", Add("g.enc1.skip.start_mean"), "tensor 'g.enc1.skip.start_mean': unknown"},
      {"Deviation", [](WeightsFile& file) { file.tensor("features.deviation").values[100] = 0; },
       "tensor 'features.deviation': expected values > 0, found 0.0"},
      {"MeanWithoutRotation",
       [](WeightsFile& file) {
         for (std::size_t i = 3; i < 7; ++i) file.tensor("features.mean").values[i] = 0;
       },
       "tensor 'features.mean': expected a rotation for hips, found one of length 0.0"},
  };
}

class BrokenWeights : public testing::TestWithParam<Broken> {};

TEST_P(BrokenWeights, AreRefusedWithTheReason) {
  WeightsFile file = RandomWeights(kDomains, kWidth, 1);
  ASSERT_TRUE(Load(file).ok()) << Load(file).message();  // valid before the case breaks it
  GetParam().breaks(file);
  const Status status = Load(file);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.message(), testing::StartsWith("file: "));
  EXPECT_THAT(status.message(), HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(Load, BrokenWeights, testing::ValuesIn(BrokenFiles()),
                         [](const auto& info) { return std::string(info.param.what); });

TEST(CausalLoad, RefusesEachMissingKeyOfItsOwn) {
  for (const char* const key : {"heading_tau_s", "width", "code", "noise", "window", "contents",
                                "spacing", "memory", "start_frames"}) {
    WeightsFile file = RandomWeights(kDomains, kWidth, 1);
    file.metadata.erase(key);
    EXPECT_EQ(Load(file).message(), "file: key '" + std::string(key) + "': missing");
  }
}

TEST(CausalLoad, RefusesEachTensorThatIsNotAsItShouldBe) {
  const WeightsFile file = RandomWeights(kDomains, kWidth, 1);
  ASSERT_EQ(file.tensors.size(), 125U);
  stgcn::ExpectEachTensorIsChecked(file, Load);
}

TEST(CausalLoad, ReadsWhatIsWritten) {
  WeightsFile file = RandomWeights(kDomains, kWidth, 1);
  file.metadata["heading_tau_s"] = 0.5;
  const auto network = CausalNetwork(file);
  EXPECT_EQ(network->model().family, "st-gcn-causal");
  EXPECT_EQ(network->model().styles[2].name, "style2");
  EXPECT_EQ(network->style_count(), kDomains);
  EXPECT_EQ(network->width(), kWidth);
  EXPECT_EQ(network->features().rate_hz, 30);
  EXPECT_EQ(network->features().heading_tau_s, 0.5F);
  const std::vector<float>& mean = file.tensor("features.mean").values;
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    const Eigen::Map<const Eigen::Vector4f> q(mean.data() + stgcn::kChannels * joint + 3);
    EXPECT_LT((network->features().hemisphere[joint].coeffs() - q.normalized()).norm(), 1e-6F);
  }
}

TEST(CausalLoad, TakesAsManyDomainsAndAsLongMemoriesAsItMay) {
  EXPECT_TRUE(Load(RandomWeights(1, kWidth, 1)).ok());
  WeightsFile file = RandomWeights(net::kMaxStyles, kWidth, 1);
  file.metadata["spacing"] = {16, 1, 16, 16};
  file.metadata["memory"] = 1000;
  file.metadata["start_frames"] = 1000;
  EXPECT_TRUE(Load(file).ok()) << Load(file).message();
}

TEST(CausalLoad, NamesTheFile) {
  EXPECT_THAT(Network::Load("no/such/weights").status().message(),
              HasSubstr("no/such/weights: no such file"));
}

}  // namespace
}  // namespace styled::stgcn_causal

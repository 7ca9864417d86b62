// Every way in which a weights file of this family can be wrong, and the values read from a correct
// one. The common keys and the container are tests/unit/net/erd/load_test.cpp's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "model/net/stgcn/code_space.h"
#include "tests/unit/net/stgcn/each_tensor.h"
#include "tests/unit/net/stgcn/random_weights.h"

namespace styled::stgcn {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr int kDomains = 3, kWidth = 16;

Status Load(const WeightsFile& file) { return Network::Parse(file.Bytes(), "file").status(); }

struct Broken {
  const char* what;
  std::function<void(WeightsFile&)> breaks;
  std::vector<std::string> message;  // each of these occurs in the message
};

std::function<void(WeightsFile&)> Set(const std::string& key, const json& value) {
  return [key, value](WeightsFile& file) { file.metadata[key] = value; };
}
std::function<void(WeightsFile&)> Reshape(const std::string& name,
                                          const std::vector<std::int64_t>& shape) {
  return [name, shape](WeightsFile& file) {
    std::int64_t count = 1;
    for (const std::int64_t size : shape) count *= size;
    file.tensor(name).shape = shape;
    file.tensor(name).values.assign(static_cast<std::size_t>(count), 0.1F);
  };
}
std::function<void(WeightsFile&)> Put(const std::string& name, std::size_t at, float value) {
  return [name, at, value](WeightsFile& file) { file.tensor(name).values[at] = value; };
}

std::vector<Broken> BrokenFiles() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  return {
      {"TauNegative",
       Set("heading_tau_s", -0.1),
       {"key 'heading_tau_s': expected a number >= 0 and <= 60, found -0.1"}},
      {"Code", Set("code", 32), {"key 'code': expected 64, found 32"}},
      {"CodeFraction", Set("code", 64.0), {"key 'code': expected 64, found 64.0"}},
      {"Noise", Set("noise", 8), {"key 'noise': expected 16, found 8"}},
      {"Window", Set("window", 32), {"key 'window': expected 64, found 32"}},
      {"ContentsNumber",
       Set("contents", 5),
       {"key 'contents': expected an array of strings, found 5"}},
      {"ContentsOfNumbers",
       Set("contents", json::array({"walk", 5})),
       {"key 'contents': expected an array of strings, found [\"walk\",5]"}},
      {"NormalizationOfNone",
       Set("normalization", "none"),
       {"key 'normalization': expected \"neighbours\" or \"subset\", found \"none\""}},
      {"NormalizationNumber", Set("normalization", 1), {"key 'normalization'", "found 1"}},
      {"WidthZero", Set("width", 0), {"key 'width': expected a multiple of 16 up to 96, found 0"}},
      {"WidthNegative", Set("width", -16), {"key 'width'", "found -16"}},
      {"WidthNotAMultiple", Set("width", 40), {"key 'width'", "found 40"}},
      {"WidthHuge", Set("width", 1 << 30), {"key 'width'", "found 1073741824"}},
      {"WidthText", Set("width", "16"), {"key 'width'", "found \"16\""}},
      {"WidthFraction", Set("width", 16.0), {"key 'width'", "found 16.0"}},
      {"WidthOfAnother",
       Set("width", 32),
       {"tensor 'g.in.weight': expected F32 [32,7], found F32 [16,7]"}},
      {"UnknownTensor",
       [](WeightsFile& file) {
         file.tensors.push_back({"d.in.weight", {1}, {0}});
       },
       {"tensor 'd.in.weight': unknown"}},
      {"NormInTheStyleEncoder",
       [](WeightsFile& file) {
         file.tensors.push_back({"e.res1.norm1.scale", {1}, {0}});
       },
       {"tensor 'e.res1.norm1.scale': unknown"}},
      {"HeadsOfTwoDomains",
       Reshape("e.heads.weight", {2, 64, 64}),
       {"tensor 'e.heads.weight': expected F32 [3,64,64], found F32 [2,64,64]"}},
      {"TapsFirst",
       Reshape("g.dec1.tconv1.weight", {3, 32, 32}),
       {"tensor 'g.dec1.tconv1.weight': expected F32 [32,32,3], found F32 [3,32,32]"}},
      {"NodesFirst",
       Reshape("e.conv.weight", {64, 64, 5, 16}),
       {"tensor 'e.conv.weight': expected F32 [64,64,16,5], found F32 [64,64,5,16]"}},
      {"NodeBiasOfTheFinerLevel",
       Reshape("g.dec1.gconv1.node_bias", {10, 32}),
       {"tensor 'g.dec1.gconv1.node_bias': expected F32 [5,32], found F32 [10,32]"}},
      {"InfiniteCode",
       Put("codes.mean", 5, kInfinity),
       {"tensor 'codes.mean': expected finite values, found inf at 5"}},
      {"DeviationZero",
       Put("features.deviation", 100, 0),
       {"tensor 'features.deviation': expected values > 0, found 0.0", "at 100"}},
      {"MeanWithoutRotation",
       [](WeightsFile& file) {
         for (std::size_t i = 3; i < 7; ++i) {
           file.tensor("features.mean").values[kChannels * body::kHead + i] = 0;
         }
       },
       {"tensor 'features.mean': expected a rotation for head, found one of length 0.0"}},
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
  EXPECT_LT(status.message().size(), 300U);
  for (const std::string& part : GetParam().message) {
    EXPECT_THAT(status.message(), HasSubstr(part));
  }
}

INSTANTIATE_TEST_SUITE_P(Load, BrokenWeights, testing::ValuesIn(BrokenFiles()),
                         [](const auto& info) { return std::string(info.param.what); });

TEST(StgcnLoad, RefusesEachMissingKeyOfItsOwn) {
  for (const char* const key : {"heading_tau_s", "width", "code", "noise", "window", "contents"}) {
    WeightsFile file = RandomWeights(kDomains, kWidth, 1);
    file.metadata.erase(key);
    EXPECT_EQ(Load(file).message(), "file: key '" + std::string(key) + "': missing");
  }
}

TEST(StgcnLoad, RefusesEachTensorThatIsNotAsItShouldBe) {
  const WeightsFile file = RandomWeights(kDomains, kWidth, 1);
  ASSERT_EQ(file.tensors.size(), 109U);
  ExpectEachTensorIsChecked(file, Load);
}

TEST(StgcnLoad, ReadsWhatIsWritten) {
  WeightsFile file = RandomWeights(kDomains, kWidth, 1);
  file.metadata["heading_tau_s"] = 0.5;
  const auto network = NetworkOf(file);
  EXPECT_EQ(network->model().family, "st-gcn");
  EXPECT_EQ(network->model().styles[2].name, "style2");
  EXPECT_EQ(network->space().domain_count(), kDomains);
  EXPECT_EQ(network->width(), kWidth);
  EXPECT_EQ(network->features().rate_hz, 30);
  EXPECT_EQ(network->features().heading_tau_s, 0.5F);
  const std::vector<float>& codes = file.tensor("codes.mean").values;
  EXPECT_EQ(network->space().mean_code(1)[3], codes[kCode + 3]);
  const std::vector<float>& mean = file.tensor("features.mean").values;
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    const Eigen::Map<const Eigen::Vector4f> q(mean.data() + kChannels * joint + 3);
    EXPECT_LT((network->features().hemisphere[joint].coeffs() - q.normalized()).norm(), 1e-6F);
  }
}

TEST(StgcnLoad, TakesAsManyDomainsAsItMay) {
  EXPECT_TRUE(Load(RandomWeights(1, kWidth, 1)).ok());
  EXPECT_TRUE(Load(RandomWeights(net::kMaxStyles, kWidth, 1)).ok());
}

TEST(StgcnLoad, NamesTheFile) {
  EXPECT_THAT(Network::Load("no/such/weights").status().message(),
              HasSubstr("no/such/weights: no such file"));
}

}  // namespace
}  // namespace styled::stgcn

// Every way in which a weights file can be wrong, one by one, and the values read from a correct
// one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/unit/net/erd/random_weights.h"

namespace styled::erd {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr int kStyles = 3;

struct Broken {
  const char* what;
  std::function<void(WeightsFile&)> breaks;
  std::vector<std::string> message;  // each of these occurs in the message
};

std::function<void(WeightsFile&)> Set(const std::string& key, const json& value) {
  return [key, value](WeightsFile& file) { file.metadata[key] = value; };
}
std::function<void(WeightsFile&)> Drop(const std::string& key) {
  return [key](WeightsFile& file) { file.metadata.erase(key); };
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
std::function<void(WeightsFile&)> Remove(const std::string& name) {
  return [name](WeightsFile& file) {
    std::erase_if(file.tensors, [&name](const NamedTensor& t) { return t.name == name; });
  };
}

json Styles(const std::vector<std::string>& names) {
  json styles = json::array();
  for (const std::string& name : names) {
    styles.push_back({{"name", name}, {"aliases", json::array()}});
  }
  return styles;
}

// Of each joint x, y, z of 0 and this w.
json Turns(float w) {
  json turns = json::array();
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    for (const float number : {0.0F, 0.0F, 0.0F, w}) turns.push_back(number);
  }
  return turns;
}

std::vector<Broken> BrokenFiles() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::vector<Broken> cases{
      {"VersionFour", Set("version", 4), {"key 'version': expected 1 to 3, found 4"}},
      {"VersionNegative", Set("version", -1), {"key 'version': expected 1 to 3, found -1"}},
      {"FamilyNumber", Set("family", 1), {"key 'family': expected a string, found 1"}},
      {"VersionText", Set("version", "1"), {"key 'version': expected 1 to 3, found \"1\""}},
      {"VersionFraction", Set("version", 1.0), {"key 'version': expected 1 to 3, found 1.0"}},
      {"ReferenceText",
       Set("reference", "T-pose"),
       {"key 'reference': expected an object, found \"T-pose\""}},
      {"ReferenceOfOneGait",
       Set("reference", {{"walking", Turns(1)}}),
       {"key 'reference.standing': expected 84 numbers, a unit quaternion per joint, found none"}},
      {"ReferenceTooShort",
       Set("reference", {{"standing", {0, 0, 0, 1}}, {"walking", Turns(1)}, {"running", Turns(1)}}),
       {"key 'reference.standing': expected 84 numbers"}},
      {"ReferenceOfText",
       Set("reference",
           {{"standing", json::array({"a"})}, {"walking", Turns(1)}, {"running", Turns(1)}}),
       {"key 'reference.standing': expected 84 numbers"}},
      {"ReferenceOfNoRotations",
       Set("reference", {{"standing", Turns(1)}, {"walking", Turns(2)}, {"running", Turns(1)}}),
       {"key 'reference.walking': expected 84 numbers, a unit quaternion per joint, found hips of "
        "length 2.0"}},
      {"OtherHumanoid",
       Set("humanoid_hash", "0123456789abcdef"),
       {"key 'humanoid_hash': expected \"", "found \"0123456789abcdef\""}},
      {"StylesNotArray", Set("styles", "neutral"), {"key 'styles': expected 1 to 32 objects"}},
      {"NoStyles", Set("styles", json::array()), {"expected 1 to 32 objects, found 0"}},
      {"TooManyStyles",
       Set("styles", Styles(std::vector<std::string>(33, "x"))),
       {"expected 1 to 32 objects, found 33"}},
      {"StyleNotObject", Set("styles", json::array({"neutral"})), {"key 'styles[0]': expected {"}},
      {"StyleWithoutAliases",
       Set("styles", json::array({{{"name", "neutral"}}})),
       {"key 'styles[0]': expected {"}},
      {"StyleNameEmpty",
       Set("styles", Styles({"neutral", ""})),
       {"key 'styles[1].name': expected a string that is not empty, found \"\""}},
      {"StyleNameNumber",
       Set("styles", json::array({{{"name", 1}, {"aliases", json::array()}}})),
       {"key 'styles[0].name': expected a string"}},
      {"NameWithEscape",
       Set("styles", Styles({"neutral", "\x1b[2Jold"})),
       {"key 'styles[1].name': expected a name without control characters, found "
        "\"\\u001b[2Jold\""}},
      {"NameOfTwoLines",
       Set("styles", Styles({"neutral", "old\nstyled: ok"})),
       {"key 'styles[1].name': expected a name without control characters"}},
      {"AliasThatTurnsTheLine",
       [](WeightsFile& file) { file.metadata["styles"][1]["aliases"] = {"\u202eold"}; },
       {"key 'styles[1].aliases': expected a name without control characters"}},
      {"NeutralIsNotFirst",
       Set("styles", Styles({"old", "Neutral"})),
       {"key 'styles[1]': expected a style, since the first is neutral"}},
      {"StyleNameTwice",
       Set("styles", Styles({"neutral", "old", "OLD"})),
       {"key 'styles[2].name': expected a name or alias that occurs once, found \"OLD\""}},
      {"AliasTaken",
       [](WeightsFile& file) { file.metadata["styles"][2]["aliases"] = {"style1"}; },
       {"key 'styles[2].aliases': expected a name or alias that occurs once"}},
      {"ContentsText", Set("contents", ""), {"key 'contents': expected 0 to 64 names, found \"\""}},
      {"TooManyContents",
       Set("contents", std::vector<std::string>(65, "x")),
       {"key 'contents': expected 0 to 64 names, found 65"}},
      {"ContentNumber",
       Set("contents", {"walk", 1}),
       {"key 'contents[1]': expected a name without control characters, found 1"}},
      {"ContentEmpty",
       Set("contents", {""}),
       {"key 'contents[0]': expected a name without control characters, found \"\""}},
      {"ContentTwice",
       Set("contents", {"walk", "Walk"}),
       {"key 'contents[1]': expected a name that occurs once, other than unknown, found "
        "\"Walk\""}},
      {"ContentUnknown",
       Set("contents", {"unknown"}),
       {"key 'contents[0]': expected a name that occurs once, other than unknown, found "
        "\"unknown\""}},
      {"ContentsWithoutRise", Set("contents", {"walk", "run"}), {"key 'content_rise_s': missing"}},
      {"ContentRiseZero",
       [](WeightsFile& file) {
         AddContents(file, 2, 3);
         file.metadata["content_rise_s"] = 0;
       },
       {"key 'content_rise_s': expected a number > 0 and <= 60, found 0"}},
      {"RecognizerWithoutContents",
       [](WeightsFile& file) {
         AddContents(file, 2, 3);
         file.metadata["contents"] = json::array();
       },
       {"tensor 'encoder.0.weight': expected F32 [64,214], found F32 [64,216]"}},
      {"ContentsWithoutRecognizer",
       [](WeightsFile& file) {
         file.metadata["contents"] = {"walk", "run"};
         file.metadata["content_rise_s"] = 0.3;
       },
       {"tensor 'recognizer.0.weight': expected F32 [64,211], found none"}},
      {"RateZero", Set("rate_hz", 0), {"key 'rate_hz': expected a number > 0", "found 0"}},
      {"RateNegative", Set("rate_hz", -30), {"key 'rate_hz': expected a number > 0"}},
      {"RateHuge", Set("rate_hz", 1e9), {"key 'rate_hz': expected a number > 0 and <= 1000"}},
      {"RateNull", Set("rate_hz", nullptr), {"key 'rate_hz'", "found null"}},
      {"TauNegative",
       Set("heading_tau_s", -0.1),
       {"key 'heading_tau_s': expected a number >= 0 and <= 60, found -0.1"}},
      {"TauText", Set("heading_tau_s", "0.25"), {"key 'heading_tau_s'"}},
      {"Latent", Set("latent", 48), {"key 'latent': expected 32, found 48"}},
      {"Encoder", Set("encoder", {128}), {"key 'encoder': expected [64], found [128]"}},
      {"EncoderDeeper", Set("encoder", {64, 64}), {"key 'encoder': expected [64], found [64,64]"}},
      {"Decoder",
       Set("decoder", {58, 86, 184}),
       {"key 'decoder': expected [58,86,128], found [58,86,184]"}},
      {"NeutralLayers", Set("neutral_layers", 4), {"key 'neutral_layers': expected 6, found 4"}},
      {"StyleLayers", Set("style_layers", 6), {"key 'style_layers': expected 4, found 6"}},
      {"Gates", Set("gates", "iofg"), {"key 'gates': expected \"ifgo\", found \"iofg\""}},
      {"TrainingText", Set("training", "x"), {"key 'training': expected an object"}},
      {"LicenceNumber", Set("licence", 1), {"key 'licence': expected a string, found 1"}},
      {"LongValueIsShortened", Set("licence", std::vector<int>(1000, 1)), {"key 'licence'", "..."}},
      {"MetadataNotObject",
       [](WeightsFile& file) { file.metadata = json::array(); },
       {"key 'styled': expected an object, found []"}},
      {"UnknownTensor",
       [](WeightsFile& file) {
         file.tensors.push_back({"decoder.3.weight", {1}, {0}});
       },
       {"tensor 'decoder.3.weight': unknown"}},
      {"TensorOfAFourthStyle",
       [](WeightsFile& file) {
         file.tensors.push_back({"recurrent.3.0.h0", {1}, {0}});
       },
       {"tensor 'recurrent.3.0.h0': unknown"}},
      {"TensorOfASeventhLayer",
       [](WeightsFile& file) {
         file.tensors.push_back({"recurrent.0.6.h0", {1}, {0}});
       },
       {"tensor 'recurrent.0.6.h0': unknown"}},
      {"EncoderOfFourStyles",
       Reshape("encoder.0.weight", {64, 215}),
       {"tensor 'encoder.0.weight': expected F32 [64,214], found F32 [64,215]"}},
      {"Transposed",
       Reshape("encoder.1.weight", {64, 32}),
       {"tensor 'encoder.1.weight': expected F32 [32,64], found F32 [64,32]"}},
      {"Flattened",
       Reshape("recurrent.2.3.input", {4096}),
       {"tensor 'recurrent.2.3.input': expected F32 [128,32], found F32 [4096]"}},
      {"BiasAsColumn",
       Reshape("decoder.2.bias", {128, 1}),
       {"tensor 'decoder.2.bias': expected F32 [128], found F32 [128,1]"}},
      {"NanInTheLastLayer",
       Put("head.height.weight", 127, kNan),
       {"tensor 'head.height.weight': expected finite values, found nan at 127"}},
      {"InfinityInAState",
       Put("recurrent.0.5.c0", 0, kInfinity),
       {"tensor 'recurrent.0.5.c0': expected finite values, found inf at 0"}},
      {"MinusInfinityInMean",
       Put("feature.mean", 3, -kInfinity),
       {"tensor 'feature.mean': expected finite values, found -inf at 3"}},
      {"DeviationZero",
       Put("feature.deviation", 100, 0),
       {"tensor 'feature.deviation': expected values > 0, found 0.0", "at 100"}},
      {"DeviationNegative",
       Put("feature.deviation", 0, -1),
       {"tensor 'feature.deviation': expected values > 0, found -1.0", "at 0"}},
      {"MeanWithoutRotation",
       [](WeightsFile& file) {
         for (int i = 0; i < 4; ++i) file.tensor("feature.mean").values[4 * body::kHead + i] = 0;
       },
       {"tensor 'feature.mean': expected a rotation for head, found one of length 0.0"}},
  };
  return cases;
}

Status Load(const WeightsFile& file) { return Network::Parse(file.Bytes(), "file").status(); }

class BrokenWeights : public testing::TestWithParam<Broken> {};

TEST_P(BrokenWeights, AreRefusedWithTheReason) {
  WeightsFile file = RandomWeights(kStyles, 1);
  ASSERT_TRUE(Load(file).ok()) << Load(file).message();  // valid before the case breaks it
  GetParam().breaks(file);
  const Status status = Load(file);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.message(), StartsWith("file: "));
  EXPECT_LT(status.message().size(), 300U);
  for (const std::string& part : GetParam().message) {
    EXPECT_THAT(status.message(), HasSubstr(part));
  }
}

INSTANTIATE_TEST_SUITE_P(Load, BrokenWeights, testing::ValuesIn(BrokenFiles()),
                         [](const auto& info) { return std::string(info.param.what); });

TEST(Load, RefusesEachMissingKey) {
  const WeightsFile whole = RandomWeights(kStyles, 1);
  ASSERT_EQ(whole.metadata.size(), 15U);
  for (const auto& [key, value] : whole.metadata.items()) {
    WeightsFile file = whole;
    Drop(key)(file);
    EXPECT_EQ(Load(file).message(), "file: key '" + key + "': missing");
  }
}

TEST(Load, RefusesEachMissingTensor) {
  const WeightsFile whole = RandomWeights(kStyles, 1);
  ASSERT_EQ(whole.tensors.size(), 2U + 4U + 5 * (6U + 2 * 4U) + 6U + 6U);
  for (const NamedTensor& tensor : whole.tensors) {
    WeightsFile file = whole;
    Remove(tensor.name)(file);
    const std::string shape = json(tensor.shape).dump();
    EXPECT_EQ(Load(file).message(),
              "file: tensor '" + tensor.name + "': expected F32 " + shape + ", found none");
  }
}

TEST(Load, RefusesEachTensorOfAnotherShape) {
  const WeightsFile whole = RandomWeights(kStyles, 1);
  for (const NamedTensor& tensor : whole.tensors) {
    WeightsFile file = whole;
    std::vector<std::int64_t> shape = tensor.shape;
    ++shape.back();
    Reshape(tensor.name, shape)(file);
    EXPECT_EQ(Load(file).message(), "file: tensor '" + tensor.name + "': expected F32 " +
                                        json(tensor.shape).dump() + ", found F32 " +
                                        json(shape).dump());
  }
}

TEST(Load, RefusesEachNonFiniteTensor) {
  const WeightsFile whole = RandomWeights(kStyles, 1);
  for (const NamedTensor& tensor : whole.tensors) {
    WeightsFile file = whole;
    file.tensor(tensor.name).values.back() = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THAT(Load(file).message(),
                HasSubstr("tensor '" + tensor.name + "': expected finite values, found nan at " +
                          std::to_string(tensor.values.size() - 1)));
  }
}

TEST(Load, RefusesEachTensorOfContentsThatIsMissingOrOfAnotherShape) {
  const WeightsFile whole = RandomWeightsWithContents(kStyles, 4, 1);
  ASSERT_TRUE(Load(whole).ok()) << Load(whole).message();
  ASSERT_EQ(whole.tensors.size(), RandomWeights(kStyles, 1).tensors.size() + 11U);
  for (const NamedTensor& tensor : whole.tensors) {
    WeightsFile file = whole;
    Remove(tensor.name)(file);
    const std::string expected =
        "file: tensor '" + tensor.name + "': expected F32 " + json(tensor.shape).dump();
    EXPECT_EQ(Load(file).message(), expected + ", found none");
    file = whole;
    std::vector<std::int64_t> shape = tensor.shape;
    ++shape.front();
    Reshape(tensor.name, shape)(file);
    EXPECT_EQ(Load(file).message(), expected + ", found F32 " + json(shape).dump());
  }
}

TEST(Load, TakesAsManyContentsAsItMay) {
  const auto network =
      Network::Parse(RandomWeightsWithContents(2, net::kMaxContents, 1).Bytes(), "file");
  ASSERT_TRUE(network.ok()) << network.status().message();
  EXPECT_EQ(network.value()->content_count(), 64);
  EXPECT_EQ(network.value()->model().contents.back(), "content64");
  EXPECT_EQ(NetworkOf(RandomWeights(2, 1))->content_count(), 0);
}

TEST(Load, RefusesHalfPrecision) {
  // F16 with the same shape: the writer knows only F32, so the header is edited by hand.
  std::vector<std::byte> bytes = RandomWeights(kStyles, 1).Bytes();
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t at = text.find("\"F32\"");
  bytes[at + 1] = std::byte{'I'};  // I32: the same number of bytes
  const auto network = Network::Parse(bytes, "file");
  ASSERT_FALSE(network.ok());
  EXPECT_THAT(network.status().message(), AllOf(HasSubstr("expected F32"), HasSubstr("found I32")));
}

TEST(Load, RefusesOtherMetadata) {
  const WeightsFile file = RandomWeights(kStyles, 1);
  const auto message = [&file](const std::map<std::string, std::string>& metadata) {
    return Network::Parse(net::SerializeSafetensors(file.tensors, metadata), "file")
        .status()
        .message();
  };
  const std::string text = file.metadata.dump();
  EXPECT_EQ(message({}), "file: __metadata__: expected the one key 'styled', found no such key");
  EXPECT_THAT(message({{"styled", text}, {"format", "pt"}}), HasSubstr("found 2 keys"));
  EXPECT_EQ(message({{"styled", "{"}}), "file: key 'styled': not JSON: line 1, column 2");
  EXPECT_EQ(message({{"styled", R"({"version":1,"version":1})"}}),
            "file: key 'styled': key 'version' twice");
  EXPECT_EQ(message({{"styled", text}}), "");
}

TEST(Load, RefusesEveryTruncation) {
  const std::vector<std::byte> bytes = RandomWeights(1, 1).Bytes();
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 7) {
    EXPECT_FALSE(Network::Parse(std::span(bytes).first(size), "file").ok()) << size;
  }
  EXPECT_FALSE(Network::Parse(std::span(bytes).first(bytes.size() - 1), "file").ok());
}

TEST(Load, NamesTheFile) {
  EXPECT_THAT(Network::Load("no/such/weights").status().message(),
              HasSubstr("no/such/weights: no such file"));
}

TEST(Load, ReadsMetadata) {
  WeightsFile file = RandomWeights(kStyles, 1);
  file.metadata["rate_hz"] = 60;
  file.metadata["heading_tau_s"] = 0;
  const auto network = Network::Parse(file.Bytes(), "file");
  ASSERT_TRUE(network.ok()) << network.status().message();
  const net::Model& model = network.value()->model();
  const FeatureParameters& features = network.value()->features();
  EXPECT_EQ(network.value()->style_count(), kStyles);
  EXPECT_EQ(model.styles[0].name, "neutral");
  EXPECT_EQ(model.styles[2].name, "style2");
  EXPECT_THAT(model.styles[2].aliases, testing::ElementsAre("s2"));
  EXPECT_EQ(model.licence, "CC0-1.0");
  EXPECT_EQ(json::parse(model.training)["command"], "random");
  EXPECT_EQ(model.family, "style-erd");
  EXPECT_EQ(model.rate_hz, 60);
  EXPECT_EQ(features.rate_hz, 60);
  EXPECT_EQ(features.heading_tau_s, 0);
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const auto& mean = file.tensor("feature.mean").values;
    const Eigen::Vector4f q(mean[4 * joint], mean[4 * joint + 1], mean[4 * joint + 2],
                            mean[4 * joint + 3]);
    EXPECT_LT((features.hemisphere[joint].coeffs() - q.normalized()).norm(), 1e-6F);
  }
}

TEST(Load, TakesAsManyStylesAsItMay) {
  EXPECT_TRUE(Load(RandomWeights(1, 1)).ok());
  EXPECT_TRUE(Load(RandomWeights(net::kMaxStyles, 1)).ok());
}

}  // namespace
}  // namespace styled::erd

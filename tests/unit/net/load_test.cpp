// Reading of the common part of any family's weights file.
#include "model/net/load.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/net/weights_file.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::net {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Load, AFileOfVersionOneIsOfStyleErd) {
  erd::WeightsFile file = erd::RandomWeights(3, 1);
  file.metadata["version"] = 1;
  file.metadata.erase("family");
  const auto network = Parse(file.Bytes(), "file");
  ASSERT_TRUE(network.ok()) << network.status().message();
  EXPECT_EQ(network.value()->model().family, "style-erd");
  EXPECT_EQ(network.value()->model().styles.size(), 3U);
}

TEST(Load, AFileOfVersionTwoNamesItsFamily) {
  erd::WeightsFile file = erd::RandomWeights(3, 1);
  ASSERT_TRUE(Parse(file.Bytes(), "file").ok());
  file.metadata.erase("family");
  EXPECT_EQ(Parse(file.Bytes(), "file").status().message(), "file: key 'family': missing");
}

TEST(Load, AnUnknownFamilyIsRefusedWithTheKnownOnes) {
  erd::WeightsFile file = erd::RandomWeights(3, 1);
  file.metadata["family"] = "transformer";
  EXPECT_THAT(Parse(file.Bytes(), "file").status().message(),
              AllOf(HasSubstr("file: key 'family': expected "), HasSubstr("\"style-erd\""),
                    HasSubstr("found \"transformer\"")));
}

TEST(Load, StylesMayHaveTheirEvidence) {
  erd::WeightsFile file = erd::RandomWeights(4, 1);
  file.metadata["styles"][1]["recognized"] = 0.75;
  file.metadata["styles"][1]["recorded_s"] = 61.5;
  file.metadata["styles"][2]["recognized"] = 0.8;
  const auto network = Parse(file.Bytes(), "file");
  ASSERT_TRUE(network.ok()) << network.status().message();
  const Styles& styles = network.value()->model().styles;
  EXPECT_EQ(styles[1].recognized, 0.75F);
  EXPECT_EQ(styles[1].recorded_s, 61.5F);
  EXPECT_TRUE(IsWeak(styles[1]));
  EXPECT_FALSE(IsWeak(styles[2]));
  EXPECT_FALSE(IsWeak(styles[3])) << "not measured";
  EXPECT_EQ(HeaderOf(network.value()->model())["styles"][1]["recorded_s"], 61.5);
  file.metadata["styles"][2]["recognized"] = 1.5;
  EXPECT_EQ(Parse(file.Bytes(), "file").status().message(),
            "file: key 'styles[2].recognized': expected a number from 0 to 1, found 1.5");
}

TEST(Load, StylesMayHaveTheirSpeeds) {
  erd::WeightsFile file = erd::RandomWeights(3, 1);
  file.metadata["styles"][0]["walk_mps"] = 1.25;
  file.metadata["styles"][0]["run_mps"] = 3;
  const auto network = Parse(file.Bytes(), "file");
  ASSERT_TRUE(network.ok()) << network.status().message();
  const Model& model = network.value()->model();
  EXPECT_EQ(model.styles[0].walk_mps, 1.25F);
  EXPECT_EQ(model.styles[0].run_mps, 3);
  EXPECT_EQ(model.styles[1].walk_mps, 0) << "not measured";
  EXPECT_EQ(HeaderOf(model)["styles"][0]["walk_mps"], 1.25);
  EXPECT_FALSE(HeaderOf(model)["styles"][1].contains("walk_mps"));
  for (const nlohmann::json& wrong : {nlohmann::json(0), nlohmann::json(-1), nlohmann::json(16),
                                      nlohmann::json("fast"), nlohmann::json(nullptr)}) {
    file.metadata["styles"][2]["run_mps"] = wrong;
    EXPECT_EQ(
        Parse(file.Bytes(), "file").status().message(),
        "file: key 'styles[2].run_mps': expected a number from 0.05 to 15, found " + wrong.dump());
  }
}

TEST(Load, StylesMayHaveAPosture) {
  erd::WeightsFile file = erd::RandomWeights(3, 1);
  nlohmann::json turns = nlohmann::json::array();
  for (int i = 0; i < 18; ++i) turns.push_back(0.125 * i - 1);
  file.metadata["styles"][1]["posture"] = turns;
  const auto network = Parse(file.Bytes(), "file");
  ASSERT_TRUE(network.ok()) << network.status().message();
  const Model& model = network.value()->model();
  ASSERT_TRUE(model.styles[1].posture);
  EXPECT_EQ((*model.styles[1].posture)[1], body::Vec3(-0.625F, -0.5F, -0.375F)) << "the chest";
  EXPECT_FALSE(model.styles[2].posture) << "not measured";
  EXPECT_EQ(HeaderOf(model)["styles"][1]["posture"], turns);
  EXPECT_FALSE(HeaderOf(model)["styles"][2].contains("posture"));
  nlohmann::json far = turns;
  far[17] = 1.7;
  nlohmann::json few = turns;
  few.erase(0);
  for (const nlohmann::json& wrong :
       {nlohmann::json("bowed"), nlohmann::json(nullptr), nlohmann::json::array(), far, few}) {
    file.metadata["styles"][2]["posture"] = wrong;
    const std::string reason = Parse(file.Bytes(), "file").status().message();
    EXPECT_TRUE(
        reason.starts_with("file: key 'styles[2].posture': expected 18 numbers from -1.6 to "
                           "1.6, a turn in rad per joint, found "))
        << reason;
  }
}

TEST(Load, AFileMayHaveBoundsOfItsLimbGate) {
  erd::WeightsFile file = erd::RandomWeights(3, 1);
  const auto gate_of = [&file] { return Parse(file.Bytes(), "file").value()->model().gate; };
  EXPECT_EQ(gate_of(), GateBounds());
  GateBounds bounds;
  bounds.legs = {0.25F, 0.5F};
  file.metadata["gate"] = AsJson(bounds);
  EXPECT_EQ(gate_of(), bounds);
  EXPECT_EQ(HeaderOf(Parse(file.Bytes(), "file").value()->model())["gate"]["legs"][0], 0.25);
  file.metadata["gate"]["trunk"] = {0.3, 0.3};
  EXPECT_EQ(
      Parse(file.Bytes(), "file").status().message(),
      "file: key 'gate.trunk': expected two distances, 0 < begin < end <= 10, found [0.3,0.3]");
  for (const nlohmann::json& wrong :
       {nlohmann::json("open"), nlohmann::json::object(), nlohmann::json{{"arms", {1}}},
        nlohmann::json{{"arms", {-1, 1}}, {"trunk", {1, 2}}, {"legs", {1, 2}}},
        nlohmann::json{{"arms", {1, 11}}, {"trunk", {1, 2}}, {"legs", {1, 2}}},
        nlohmann::json{{"arms", {"1", 2}}, {"trunk", {1, 2}}, {"legs", {1, 2}}}}) {
    file.metadata["gate"] = wrong;
    const std::string reason = Parse(file.Bytes(), "file").status().message();
    EXPECT_TRUE(reason.starts_with("file: key 'gate.arms': expected two distances")) << reason;
  }
}

TEST(Load, StylesMayHaveTheirCadences) {
  erd::WeightsFile file = erd::RandomWeights(3, 1);
  file.metadata["styles"][0]["walk_spm"] = 110.5;
  file.metadata["styles"][0]["run_spm"] = 20;
  file.metadata["styles"][1]["run_spm"] = 400;
  const auto network = Parse(file.Bytes(), "file");
  ASSERT_TRUE(network.ok()) << network.status().message();
  const Model& model = network.value()->model();
  EXPECT_EQ(model.styles[0].walk_spm, 110.5F);
  EXPECT_EQ(model.styles[0].run_spm, 20);
  EXPECT_EQ(model.styles[1].run_spm, 400);
  EXPECT_EQ(model.styles[1].walk_spm, 0) << "not measured";
  EXPECT_EQ(model.styles[0].walk_mps, 0) << "a cadence is no speed";
  EXPECT_EQ(HeaderOf(model)["styles"][0]["walk_spm"], 110.5);
  EXPECT_FALSE(HeaderOf(model)["styles"][1].contains("walk_spm"));
  for (const char* const key : {"walk_spm", "run_spm"}) {
    erd::WeightsFile broken = erd::RandomWeights(3, 1);
    for (const nlohmann::json& wrong :
         {nlohmann::json(0), nlohmann::json(19.9), nlohmann::json(400.1), nlohmann::json(-110),
          nlohmann::json("brisk"), nlohmann::json(nullptr)}) {
      broken.metadata["styles"][2][key] = wrong;
      EXPECT_EQ(Parse(broken.Bytes(), "file").status().message(),
                "file: key 'styles[2]." + std::string(key) +
                    "': expected a number from 20 to 400, found " + wrong.dump());
    }
  }
}

TEST(Load, NamesTheFile) {
  EXPECT_THAT(Load("no/such/weights").status().message(),
              HasSubstr("no/such/weights: no such file"));
}

}  // namespace
}  // namespace styled::net

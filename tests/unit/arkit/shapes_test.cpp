#include "proto/arkit/shapes.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

namespace styled::arkit {
namespace {

std::map<std::string, float> Presets(const std::map<std::string, float>& given) {
  std::array<float, kShapes> shapes{};
  for (const auto& [name, weight] : given) shapes[Find(name).value()] = weight;
  std::array<float, kPresets.size()> presets;
  ToPresets(shapes, presets);
  std::map<std::string, float> out;
  for (std::size_t i = 0; i < presets.size(); ++i) out[std::string(kPresets[i])] = presets[i];
  return out;
}

TEST(ArkitShapes, OtherNamesAreNone) {
  for (const auto* const name : {"", "Joy", "jaw", "jawOpenX", "eyeBlink", "eyeBlink_M", "_L",
                                 "mouth_L", "jaw_R", "headYaw"}) {
    EXPECT_FALSE(Find(name)) << name;
  }
}

TEST(ArkitShapes, EachNameIsFoundInAnyCaseAndWithItsSideShort) {
  EXPECT_EQ(std::set<std::string_view>(kNames.begin(), kNames.end()).size(), kShapes);
  for (std::size_t i = 0; i < kShapes; ++i) {
    std::string name(kNames[i]);
    EXPECT_EQ(Find(name), i);
    name[0] = static_cast<char>(std::toupper(name[0]));
    EXPECT_EQ(Find(name), i) << name;
  }
  EXPECT_EQ(Find("eyeBlink_L"), Find("eyeBlinkLeft"));
  EXPECT_EQ(Find("mouthSmile_R"), Find("mouthSmileRight"));
  EXPECT_NE(Find("mouthLeft"), Find("mouthRight"));
  EXPECT_EQ(SideOf("eyeBlinkLeft").stem, "eyeBlink");
  EXPECT_EQ(SideOf("mouthSmileRight").side, 'R');
  EXPECT_EQ(SideOf("jawOpen").stem, "jawOpen");
  for (const auto* const direction : {"mouthLeft", "mouthRight", "jawLeft", "jawRight"}) {
    EXPECT_EQ(SideOf(direction).side, 0) << direction;
  }
}

TEST(ArkitShapes, APresetIsNotShownBesideItsParts) {
  const auto still = Presets({});
  for (const auto& [name, weight] : still) EXPECT_EQ(weight, 0) << name;
  EXPECT_EQ(Presets({{"eyeBlinkLeft", 1.0F}})["Blink_L"], 1);
  EXPECT_EQ(Presets({{"eyeBlinkLeft", 1.0F}})["Blink_R"], 0);
  const auto open = Presets({{"jawOpen", 1.0F}});
  EXPECT_EQ(open.at("A"), 1);
  EXPECT_EQ(open.at("O"), 0);
  const auto round = Presets({{"jawOpen", 1.0F}, {"mouthFunnel", 1.0F}});
  EXPECT_EQ(round.at("A"), 0);
  EXPECT_EQ(round.at("O"), 1);
  EXPECT_EQ(Presets({{"mouthSmileLeft", 1.0F}, {"mouthSmileRight", 1.0F}})["Joy"], 1);
  EXPECT_EQ(Presets({{"mouthFrownLeft", 1.0F}, {"mouthFrownRight", 1.0F}})["Sorrow"], 1);
}

}  // namespace
}  // namespace styled::arkit

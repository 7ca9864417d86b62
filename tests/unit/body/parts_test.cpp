#include "model/body/parts.h"

#include <gtest/gtest.h>

namespace styled::body {
namespace {

TEST(PartsTest, EveryJointIsInThePartThatItsNameSays) {
  for (int joint = 0; joint < kJointCount; ++joint) {
    const std::string_view name = kHumanoid[static_cast<std::size_t>(joint)].name;
    const auto has = [name](std::string_view word) {
      return name.find(word) != std::string_view::npos;
    };
    const bool left = name.starts_with("left");
    Part expected = Part::kTorso;
    if (has("Shoulder") || has("Arm") || has("Hand")) {
      expected = left ? Part::kLeftArm : Part::kRightArm;
    } else if (has("Leg") || has("Foot") || has("Toes")) {
      expected = left ? Part::kLeftLeg : Part::kRightLeg;
    } else if (name == "neck" || name == "head") {
      expected = Part::kHead;
    }
    EXPECT_EQ(PartOf(joint), expected) << name;
  }
}

TEST(PartsTest, WordsNamePartsAndGroupsAndPartsSayTheirNames) {
  EXPECT_EQ(FindParts("all"), kAllParts);
  EXPECT_EQ(FindParts("arms"), *FindParts("left-arm") | *FindParts("right-arm"));
  EXPECT_EQ(FindParts("upper"), kAllParts & ~*FindParts("legs"));
  EXPECT_EQ(FindParts("head,arms"), *FindParts("arms") | *FindParts("head"));
  EXPECT_FALSE(FindParts("arm"));
  EXPECT_FALSE(FindParts("head,"));
  EXPECT_FALSE(FindParts("head,arm"));
  EXPECT_FALSE(FindParts(""));
  EXPECT_EQ(PartsText(*FindParts("arms")), "left-arm,right-arm");
  EXPECT_EQ(PartsText(kAllParts), "all");
  for (const std::string_view name : kPartNames) {
    ASSERT_TRUE(FindParts(name)) << name;
    EXPECT_EQ(PartsText(*FindParts(name)), name);
    EXPECT_NE(kPartWords.find(name), std::string_view::npos);
  }
}

}  // namespace
}  // namespace styled::body

#include "model/synthetic/script.h"

#include <gtest/gtest.h>

namespace styled::synthetic {
namespace {

TEST(Script, RefusesWhatItDoesNotKnowAndSaysWhatItExpected) {
  for (const auto& [text, expected] : {std::pair{"dance", "'dance': expected one of stand, walk"},
                                       {"walk:2,", ""},
                                       {"walk:2,,run", "'': expected one of"},
                                       {"walk:", "expected seconds"},
                                       {"walk:x", "expected seconds"},
                                       {"walk:0", "expected seconds"},
                                       {"walk:-1", "expected seconds"},
                                       {"walk:nan", "expected seconds"},
                                       {"walk:3601", "expected seconds"},
                                       {"walk:1s", "expected seconds"},
                                       {"Walk:1", "expected one of"}}) {
    const auto script = ParseScript(text);
    if (*expected == '\0') {
      EXPECT_TRUE(script.ok()) << text;
    } else {
      ASSERT_FALSE(script.ok()) << text;
      EXPECT_NE(script.status().message().find(expected), std::string::npos)
          << script.status().message();
    }
  }
}

TEST(Script, ReadsEveryMotionByItsName) {
  for (int i = 0; i < static_cast<int>(Motion::kCount); ++i) {
    const auto motion = static_cast<Motion>(i);
    const auto script = ParseScript(std::string(Name(motion)) + ":2.5");
    ASSERT_TRUE(script.ok());
    ASSERT_EQ(script.value().size(), 1U);
    EXPECT_EQ(script.value()[0].motion, motion);
    EXPECT_EQ(script.value()[0].seconds, 2.5);
  }
}

TEST(Script, KeepsTheOrderAndFillsInMissingSeconds) {
  const auto script = ParseScript("stand:2,walk,turn-left:3");
  ASSERT_TRUE(script.ok());
  ASSERT_EQ(script.value().size(), 3U);
  EXPECT_EQ(script.value()[1].motion, Motion::kWalk);
  EXPECT_EQ(script.value()[1].seconds, 4);
  EXPECT_EQ(script.value()[2].motion, Motion::kTurnLeft);
}

}  // namespace
}  // namespace styled::synthetic

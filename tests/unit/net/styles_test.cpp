#include "model/net/styles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace styled::net {
namespace {

TEST(Styles, AreFoundByNameOrAliasInAnyCase) {
  const Styles styles{{"neutral", {"normal"}}, {"style1", {"s1"}}, {"style2", {"s2"}}};
  EXPECT_EQ(FindStyle(styles, "neutral"), 0);
  EXPECT_EQ(FindStyle(styles, "Normal"), 0);
  EXPECT_EQ(FindStyle(styles, "STYLE2"), 2);
  EXPECT_EQ(FindStyle(styles, "s1"), 1);
  EXPECT_EQ(FindStyle(styles, "style3"), -1);
  EXPECT_EQ(FindStyle(styles, "style"), -1);
  EXPECT_EQ(FindStyle(styles, ""), -1);
}

TEST(ContentNames, AreFoundInAnyCase) {
  const Contents contents{"walk", "Run"};
  EXPECT_EQ(FindContent(contents, "WALK").value(), 0);
  EXPECT_EQ(FindContent(contents, "run").value(), 1);
  EXPECT_EQ(FindContent(contents, "Unknown").value(), kContentUnknown);
  EXPECT_EQ(FindContent(contents, "").value(), kContentRecognized);
  EXPECT_EQ(FindContent({}, "").value(), kContentRecognized);
}

TEST(ContentNames, ThatAreNotKnownAreRefusedWithTheChoices) {
  EXPECT_EQ(FindContent({"walk", "run"}, "kick").status().message(),
            "unknown content 'kick'; expected one of unknown, walk, run");
  for (const char* const name : {"walk", "unknown"}) {
    EXPECT_THAT(FindContent({}, name).status().message(),
                testing::HasSubstr("the network takes no content as input"));
  }
}

}  // namespace
}  // namespace styled::net

#include "model/net/styles.h"

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

}  // namespace
}  // namespace styled::net

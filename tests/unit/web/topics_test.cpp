#include "clients/web/topics.h"

#include <gtest/gtest.h>

#include <string>

namespace styled::web {
namespace {

TEST(TopicsTest, OnlyTheDaemonsTopicsAreKnown) {
  EXPECT_EQ(ParseTopic("styled/rig.a/rig/"), TopicKind::kStyled);
  EXPECT_EQ(ParseTopic("styled/rig.a/canonical/"), TopicKind::kStyled);
  EXPECT_EQ(ParseTopic("source/rig.a/"), TopicKind::kSource);
  EXPECT_EQ(ParseTopic("body/rig.a/"), TopicKind::kBody);
  EXPECT_EQ(ParseTopic("body/"), TopicKind::kEveryBody);
  EXPECT_EQ(ParseTopic("stats/"), TopicKind::kStatistics);
  const std::string long_name = "source/rig." + std::string(33, 'a') + "/";
  for (const std::string odd :
       {"", "/", "styled/", "source/", "stats", "stats/x", "styled/rig.a/", "styled/rig.a/face/",
        "source/rig.a", "source/rig/", "source/rig.a.b/", "source/ rig.a/", "body/rig.a",
        "styled//rig/", "styled/rig.a/rig/x", "/source/rig.a/", "source/rig.a/rig/"}) {
    EXPECT_EQ(ParseTopic(odd), std::nullopt) << odd;
  }
  EXPECT_EQ(ParseTopic(long_name), std::nullopt);
  EXPECT_EQ(ParseTopic(std::string_view("source/rig.\0/", 13)), std::nullopt);
}

}  // namespace
}  // namespace styled::web

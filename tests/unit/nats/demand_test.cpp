#include "clients/nats/demand.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace styled::stylenats {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(NatsDemand, OnlyWhatIsReadIsAskedFor) {
  Demand demand("hall");
  EXPECT_THAT(demand.Subjects(), IsEmpty());
  for (const char* const topic : {"body/", "stats/", "source/rig.a/", "frames/rig/"}) {
    EXPECT_TRUE(demand.Add(topic));
    EXPECT_FALSE(demand.Add(topic)) << "known";
  }
  EXPECT_THAT(demand.Subjects(), IsEmpty()) << "none of them is a frame over NATS";
  demand.Add("styled/rig.a/rig/");
  demand.Add("styled/rig.b/canonical/");
  EXPECT_THAT(demand.Subjects(),
              ElementsAre("styled.hall.rig=2Ea.rig", "styled.hall.rig=2Eb.canonical"));
  EXPECT_TRUE(demand.Remove("styled/rig.a/rig/"));
  EXPECT_FALSE(demand.Remove("styled/rig.a/rig/"));
  EXPECT_THAT(demand.Subjects(), ElementsAre("styled.hall.rig=2Eb.canonical"));
}

TEST(NatsDemand, NoSubjectCoversAnother) {
  Demand demand("hall");
  demand.Add("styled/rig.a/rig/");
  demand.Add("styled/rig.b/rig/");
  demand.Add("styled/rig.a/");
  demand.Add("styled/rig.a/can");
  EXPECT_THAT(demand.Subjects(), ElementsAre("styled.hall.rig=2Ea.*", "styled.hall.rig=2Eb.rig"));
  for (const char* const all : {"", "sty", "styled/", "styled/ri"}) {
    demand.Add(all);
    EXPECT_THAT(demand.Subjects(), ElementsAre("styled.hall.*.*")) << all;
    demand.Remove(all);
  }
}

TEST(NatsDemand, ManySubjectsBecomeOne) {
  Demand demand("a.b");
  for (std::size_t i = 0; i < Demand::kMostSubjects; ++i) {
    demand.Add("styled/rig." + std::to_string(i) + "/rig/");
  }
  EXPECT_EQ(demand.Subjects().size(), Demand::kMostSubjects);
  demand.Add("styled/rig.more/rig/");
  EXPECT_THAT(demand.Subjects(), ElementsAre("styled.a=2Eb.*.*"));
}

TEST(NatsDemand, WantsWhatBeginsSo) {
  Demand demand("hall");
  EXPECT_FALSE(demand.IsSubscribed("body/rig.a/"));
  demand.Add("body/rig.a/");
  EXPECT_TRUE(demand.IsSubscribed("body/rig.a/"));
  EXPECT_FALSE(demand.IsSubscribed("body/rig.ab/"));
  demand.Add("body/");
  EXPECT_TRUE(demand.IsSubscribed("body/rig.ab/"));
}

TEST(NatsDemand, TopicsAreThoseOfADaemon) {
  EXPECT_EQ(TopicOf("styled.hall.rig=2Ea.rig"), "styled/rig.a/rig/");
  EXPECT_EQ(TopicOf("styled.hall.rig=2Ea.canonical30"), "") << "the audience tier";
  for (const char* const odd :
       {"", "styled", "styled.hall.rig=2Ea", "styled.hall.rig.a.rig", "other.hall.rig=2Ea.rig",
        "styled.hall..rig", "styled.hall.rig=2ea.rig", "styled.hall.rig=2Fa.rig",
        "styled.hall.rig=2Ea.a=2Fb"}) {
    EXPECT_EQ(TopicOf(odd), "") << odd;
  }
  EXPECT_EQ(BodyTopicOf("hall.body.rig=2Ea.canonical"), "body/rig.a/");
  EXPECT_EQ(BodyTopicOf("hall.performer.rig=2Ea"), "");
  EXPECT_EQ(BodyTopicOf("hall.body.rig=2Ea"), "");
}

}  // namespace
}  // namespace styled::stylenats

#include "daemon/publish/subscriptions.h"

#include <gtest/gtest.h>

namespace styled::publish {
namespace {

using runtime::Counter;

TEST(SubscriptionsTest, APrefixWantsEveryTopicItBegins) {
  runtime::Counters counters;
  Subscriptions subscriptions(10, counters);
  Topic rig{"styled/rig.a/rig/"};
  Topic body{"body/rig.a/"};
  subscriptions.Register(rig);
  subscriptions.Register(body);
  subscriptions.Subscribe("styled/");
  subscriptions.Subscribe("");
  EXPECT_EQ(rig.wanted, 2);
  EXPECT_EQ(body.wanted, 1);
  Topic later{"styled/rig.b/rig/"};
  subscriptions.Register(later);
  EXPECT_EQ(later.wanted, 2) << "known before the performer";
  EXPECT_FALSE(later.asked);
  subscriptions.Unsubscribe("");
  EXPECT_EQ(rig.wanted, 1);
  EXPECT_EQ(body.wanted, 0);
  subscriptions.Unsubscribe("never");
  EXPECT_EQ(counters.Get(Counter::kPublishSubscriptions), 1U);
}

TEST(SubscriptionsTest, OnlyAPrefixOfBundlesRequestsThem) {
  runtime::Counters counters;
  Subscriptions subscriptions(10, counters);
  const Topic& rig = subscriptions.bundle(Subscriptions::kRigBundle);
  const Topic& source = subscriptions.bundle(Subscriptions::kSourceBundle);
  subscriptions.Subscribe("");
  subscriptions.Subscribe("f");
  EXPECT_EQ(rig.wanted, 0);
  subscriptions.Subscribe("frames/");
  subscriptions.Subscribe("frames/rig/");
  EXPECT_EQ(rig.wanted, 2);
  EXPECT_EQ(source.wanted, 1);
  subscriptions.Unsubscribe("");
  subscriptions.Unsubscribe("frames/");
  EXPECT_EQ(rig.wanted, 1);
  EXPECT_EQ(source.wanted, 0);
}

TEST(SubscriptionsTest, ARepeatedOneAsksAgainButCountsOnce) {
  runtime::Counters counters;
  Subscriptions subscriptions(10, counters);
  Topic body{"body/rig.a/"};
  subscriptions.Register(body);
  subscriptions.Subscribe("body/rig.a/");
  EXPECT_TRUE(body.asked);
  body.asked = false;
  subscriptions.Subscribe("body/rig.a/");
  EXPECT_TRUE(body.asked);
  EXPECT_EQ(body.wanted, 1);
  subscriptions.Unsubscribe("body/rig.a/");
  EXPECT_EQ(body.wanted, 0);
}

TEST(SubscriptionsTest, TooManyOrPointlessOnesAreRefused) {
  runtime::Counters counters;
  Subscriptions subscriptions(2, counters);
  Topic stats{"stats/"};
  subscriptions.Register(stats);
  subscriptions.Subscribe("nothing/of/ours/");
  subscriptions.Subscribe("styled/" + std::string(200, 'x'));
  EXPECT_EQ(counters.Get(Counter::kPublishSubscriptionsRefused), 2U);
  subscriptions.Subscribe("st");
  subscriptions.Subscribe("body/rig.a/");
  subscriptions.Subscribe("stats/");
  EXPECT_EQ(counters.Get(Counter::kPublishSubscriptionsRefused), 3U);
  EXPECT_EQ(stats.wanted, 1);
  subscriptions.Subscribe("st");
  EXPECT_EQ(counters.Get(Counter::kPublishSubscriptionsRefused), 3U) << "a repetition fits";
}

}  // namespace
}  // namespace styled::publish

#include "clients/web/hub.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "proto/styled/v1/body.pb.h"

namespace styled::web {
namespace {

using std::chrono::seconds;

struct Tab : Browser {
  void Offer(const MessagePtr& message) override { got.push_back(message); }
  // The messages under `topic` since the last call.
  std::vector<std::string> Pop(const std::string& topic) {
    std::vector<std::string> payloads;
    for (const MessagePtr& message : got) {
      if (message->text || !message->bytes.substr(1).starts_with(topic)) continue;
      EXPECT_EQ(static_cast<std::size_t>(message->bytes[0]), topic.size());
      payloads.push_back(message->bytes.substr(1 + topic.size()));
    }
    std::erase_if(got, [](const MessagePtr& message) { return !message->text; });
    return payloads;
  }
  bool up() const {  // as told last
    const auto last =
        std::find_if(got.rbegin(), got.rend(), [](const auto& message) { return message->text; });
    return nlohmann::json::parse((*last)->bytes)["daemon"]["up"].get<bool>();
  }
  std::vector<MessagePtr> got;
};

class HubTest : public testing::Test {
 protected:
  std::string Body(std::uint64_t hash, v1::Output output) {
    v1::Body body;
    body.set_hash(hash);
    body.set_output(output);
    return body.SerializeAsString();
  }
  void Publish(const std::string& topic, const std::string& payload) {
    hub.Publish(topic, payload, now);
  }

  Hub::Clock::time_point now = Hub::Clock::now();
  Counters counters;
  std::multiset<std::string> asked;
  Hub hub{"tcp://x:1",
          {[this](const std::string& topic) { asked.insert(topic); },
           [this](const std::string& topic) { asked.erase(asked.find(topic)); }},
          counters,
          now};
  Tab a, b;
};

TEST_F(HubTest, TheDaemonIsAskedForWhatSomeBrowserWantsAndForNoMore) {
  EXPECT_EQ(asked, std::multiset<std::string>{"stats/"});
  hub.Join(a);
  hub.Join(b);
  EXPECT_EQ(hub.Subscribe(a, "source/rig.a/"), Subscribed::kOk);
  EXPECT_EQ(hub.Subscribe(a, "source/rig.a/"), Subscribed::kOk) << "again is no other";
  EXPECT_EQ(hub.Subscribe(b, "source/rig.a/"), Subscribed::kOk);
  EXPECT_EQ(hub.Subscribe(b, "stats/"), Subscribed::kOk);
  EXPECT_EQ(asked, (std::multiset<std::string>{"source/rig.a/", "stats/"}));
  Publish("source/rig.a/", "1");
  EXPECT_EQ(a.Pop("source/rig.a/"), std::vector<std::string>{"1"});
  EXPECT_EQ(b.Pop("source/rig.a/"), std::vector<std::string>{"1"});
  hub.Unsubscribe(a, "source/rig.a/");
  hub.Unsubscribe(a, "source/rig.a/");
  hub.Unsubscribe(a, "nothing/");
  EXPECT_TRUE(asked.contains("source/rig.a/"));
  Publish("source/rig.a/", "2");
  EXPECT_TRUE(a.Pop("source/rig.a/").empty());
  EXPECT_EQ(b.Pop("source/rig.a/"), std::vector<std::string>{"2"});
  hub.Leave(b);
  EXPECT_EQ(asked, std::multiset<std::string>{"stats/"});
  Publish("source/rig.a/", "3");
  EXPECT_TRUE(b.Pop("source/rig.a/").empty());
}

TEST_F(HubTest, TopicsOfABrowsersOwnMakingAndTooManyAreRefused) {
  hub.Join(a);
  hub.Join(b);
  for (const char* topic : {"", "source/", "s", "styled/", "body/rig.a"}) {
    EXPECT_EQ(hub.Subscribe(a, topic), Subscribed::kNoTopic) << topic;
  }
  const auto topic = [](std::size_t i) { return "source/rig.p" + std::to_string(i) + "/"; };
  for (std::size_t i = 0; i < Hub::kMaxTopics; ++i) {
    ASSERT_EQ(hub.Subscribe(a, topic(i)), Subscribed::kOk);
  }
  EXPECT_EQ(hub.Subscribe(a, topic(999)), Subscribed::kTooMany);
  EXPECT_EQ(hub.Subscribe(b, topic(0)), Subscribed::kOk);
  std::vector<Tab> tabs(3);
  std::size_t granted = Hub::kMaxTopics;
  for (Tab& tab : tabs) {
    hub.Join(tab);
    for (std::size_t i = 0; i < Hub::kMaxTopics; ++i) {
      granted += hub.Subscribe(tab, topic(1000 + granted)) == Subscribed::kOk ? 1 : 0;
    }
  }
  EXPECT_EQ(granted, Hub::kMaxDistinctTopics);
  EXPECT_EQ(asked.size(), Hub::kMaxDistinctTopics + 1);
  for (Tab& tab : tabs) hub.Leave(tab);
}

TEST_F(HubTest, BodiesComeOnceAndAgainWhenTheyChangeOrSomebodyIsNew) {
  hub.Join(a);
  hub.Subscribe(a, "body/");
  Publish("body/rig.a/", Body(1, v1::OUTPUT_RIG));
  Publish("body/rig.a/", Body(2, v1::OUTPUT_CANONICAL));
  Publish("body/rig.a/", Body(1, v1::OUTPUT_RIG));
  Publish("body/rig.ab/", Body(1, v1::OUTPUT_RIG));
  ASSERT_EQ(a.got.size(), 4U) << "the notice and three bodies";
  EXPECT_NE(a.got[1]->key, a.got[2]->key) << "neither of two bodies supersedes the other";
  Publish("body/rig.a/", Body(3, v1::OUTPUT_RIG));
  EXPECT_EQ(a.got.size(), 5U);
  hub.Join(b);
  hub.Subscribe(b, "body/rig.a/");
  EXPECT_EQ(b.Pop("body/rig.a/"),
            (std::vector<std::string>{Body(3, v1::OUTPUT_RIG), Body(2, v1::OUTPUT_CANONICAL)}));
  Publish("body/rig.a/", "\xFF garbage");
  EXPECT_EQ(counters.upstream_malformed, 1U);

  hub.Leave(a);
  Tab c;
  hub.Join(c);
  hub.Subscribe(c, "body/rig.ab/");
  EXPECT_TRUE(c.Pop("body/rig.ab/").empty()) << "nobody listened for it in between";
  hub.Subscribe(c, "body/rig.a/");
  EXPECT_EQ(c.Pop("body/rig.a/").size(), 2U) << "b still does for this one";
  hub.Leave(c);
}

TEST_F(HubTest, TheDaemonIsUpWhileItsStatisticsCome) {
  hub.Join(a);
  EXPECT_FALSE(a.up());
  EXPECT_EQ(hub.Reason(now + seconds(5)), "no daemon publishes at tcp://x:1 (5 s)");
  v1::Stats stats;
  stats.set_epoch(9);
  Publish("stats/", stats.SerializeAsString());
  EXPECT_TRUE(a.up());
  EXPECT_EQ(hub.Reason(now), "");
  ASSERT_NE(hub.statistics(), nullptr);
  EXPECT_EQ(hub.statistics()->epoch(), 9U);
  hub.Subscribe(a, "stats/");
  EXPECT_EQ(a.Pop("stats/").size(), 1U) << "the last at once";
  hub.Tick(now + Hub::kSilence);
  EXPECT_TRUE(hub.daemon_up());
  hub.Tick(now + Hub::kSilence + std::chrono::milliseconds(1));
  EXPECT_FALSE(hub.daemon_up());
  EXPECT_FALSE(a.up());
  EXPECT_EQ(hub.statistics(), nullptr);
  Publish("stats/", stats.SerializeAsString());
  EXPECT_TRUE(a.up());
  hub.Disconnected(now);
  EXPECT_FALSE(a.up());
}

TEST_F(HubTest, WhatTheDaemonWouldNotPublishIsCountedAndDropped) {
  hub.Join(a);
  hub.Subscribe(a, "body/");
  for (const char* topic : {"body/", "", "styled/x/", "stats/x"}) Publish(topic, "payload");
  Publish("stats/", "\xFF");
  EXPECT_EQ(counters.upstream_malformed, 5U);
  EXPECT_FALSE(hub.daemon_up());
  EXPECT_EQ(a.got.size(), 1U);
}

}  // namespace
}  // namespace styled::web

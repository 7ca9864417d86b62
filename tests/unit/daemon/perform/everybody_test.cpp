// Changes for everybody: whatever the settings of one performer are, they stop no other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "daemon/pipeline/pipeline.h"
#include "proto/styled/look.h"
#include "tests/support/native_frames.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using testing::HasSubstr;

class FixedClock final : public runtime::Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return 0; }
  std::int64_t Wall_ns() const noexcept override { return 0; }
};

class SilentPublisher final : public publish::Publisher {
 public:
  void Send(std::string_view, std::span<const std::byte>) noexcept override {}
  bool NextSubscription(publish::SubscriptionEvent&) override { return false; }
  int fd() const override { return -1; }
};

using Change = std::function<void(v1::Look&)>;
using Changes = std::map<std::string, Change>;

void AddStyle(v1::Look& look, const std::string& style, float weight) {
  auto& mix = *look.add_mix();
  mix.set_style(style);
  mix.set_weight(weight);
}

// None of the network's styles has variations.
const Changes& AllChanges() {
  static const Changes changes = {
      {"a style", [](v1::Look& look) { AddStyle(look, "style1", 1); }},
      {"a style, strong", [](v1::Look& look) { AddStyle(look, "style1", 1.5F); }},
      {"two styles",
       [](v1::Look& look) {
         AddStyle(look, "style1", 0.75F);
         AddStyle(look, "style2", 0.75F);
       }},
      {"vary", [](v1::Look& look) { look.set_vary(7); }},
      {"vary each", [](v1::Look& look) { look.set_vary_each(true); }},
      {"drift", [](v1::Look& look) { look.set_drift_s(5); }},
      {"mirror", [](v1::Look& look) { look.set_mirror(true); }},
      {"strength 1.5", [](v1::Look& look) { look.set_strength(1.5F); }},
      {"strength 0", [](v1::Look& look) { look.set_strength(0); }},
      {"parts", [](v1::Look& look) { look.add_parts(v1::BODY_PART_HEAD); }},
      {"input style", [](v1::Look& look) { look.set_input_style("style2"); }},
      {"neutral of an input style",
       [](v1::Look& look) {
         look.set_input_style("style2");
         AddStyle(look, "neutral", 1);
       }},
      {"no input style", [](v1::Look& look) { look.set_input_style("neutral"); }},
      {"absolute", [](v1::Look& look) { look.set_absolute(true); }},
      {"stride", [](v1::Look& look) { look.set_root(v1::ROOT_STRIDE); }},
      {"preset", [](v1::Look& look) { look.set_preset("both"); }},
      {"clear", [](v1::Look& look) { look.set_clear(true); }},
  };
  return changes;
}

// A daemon with two performers who were only named: rig.a and rig.b.
class NamedPair {
 public:
  NamedPair() {
    auto config = std::make_shared<RuntimeConfig>();
    static const auto network = erd::RandomStylizer(5, 1);
    config->network = network;
    config->presets.push_back({.name = "both", .look = {}});
    AddStyle(config->presets.back().look, "style1", 0.5F);
    AddStyle(config->presets.back().look, "style3", 0.5F);
    for (const auto& [name, change] : AllChanges()) {
      Cue& cue = config->cues.emplace_back();
      cue.name = name;
      cue.performer = "*";
      change(*cue.request.mutable_set());
    }
    pipeline_ = std::make_unique<Pipeline>(
        Dependencies{clock_, counters_, publisher_, mailboxes_}, std::vector<std::string>{"rig"},
        std::vector<std::unique_ptr<source::Transport>>(), std::move(config), 1, 100);
    for (const char* const id : {"rig.a", "rig.b"}) {
      EXPECT_EQ(Set(id, [](v1::Look& look) { look.set_transition_ms(100); }).code(), v1::CODE_OK);
    }
  }
  v1::Reply Ask(const v1::Request& request) {
    auto exchange = std::make_unique<Exchange>();
    exchange->request = request;
    EXPECT_TRUE(mailboxes_.commands.Push(std::move(exchange)));
    while (pipeline_->DoWork() > 0) {
    }
    EXPECT_TRUE(mailboxes_.replies.Pop(exchange));
    return exchange->reply;
  }
  v1::Reply Set(const std::string& performer, const Change& change) {
    v1::Request request;
    request.set_performer(performer);
    change(*request.mutable_set());
    return Ask(request);
  }
  v1::Reply Fire(const std::string& cue) {
    v1::Request request;
    request.mutable_cue()->set_name(cue);
    return Ask(request);
  }
  std::string LookOf(const std::string& performer) {
    v1::Request request;
    request.mutable_status();
    const v1::Reply reply = Ask(request);
    for (const auto& row : reply.status().stats().performers()) {
      if (row.performer() == performer) return row.look().SerializeAsString();
    }
    return "no such performer";
  }

 private:
  FixedClock clock_;
  runtime::Counters counters_;
  SilentPublisher publisher_;
  Mailboxes mailboxes_;
  std::unique_ptr<Pipeline> pipeline_;
};

TEST(Everybody, NoSettingsOfOnePerformerStopAChangeOfTheOthers) {
  int refusals = 0;
  for (const auto& [before, settings] : AllChanges()) {
    for (const auto& [name, change] : AllChanges()) {
      for (const bool by_cue : {false, true}) {
        SCOPED_TRACE(before + ", then for all: " + name + (by_cue ? ", by a cue" : ""));
        NamedPair alone, stage;
        ASSERT_EQ(alone.Set("*", change).code(), v1::CODE_OK);
        ASSERT_EQ(stage.Set("rig.a", settings).code(), v1::CODE_OK);
        const std::string kept = stage.LookOf("rig.a");
        const v1::Reply reply = by_cue ? stage.Fire(name) : stage.Set("*", change);
        EXPECT_EQ(stage.LookOf("rig.b"), alone.LookOf("rig.b"));
        for (const v1::Applied& entry : reply.applied()) {
          if (entry.refused().empty()) continue;
          ++refusals;
          EXPECT_EQ(entry.performer(), "rig.a") << entry.refused();
          EXPECT_THAT(entry.refused(), HasSubstr("rig.a: "));
          EXPECT_EQ(stage.LookOf("rig.a"), kept);
        }
      }
    }
  }
  EXPECT_GT(refusals, 0);  // a strength of 1.5 and weights of 1.5 do not fit
}

TEST(Everybody, AfterPanicTheNextStyleComesBackWhole) {
  for (const auto& [before, settings] : AllChanges()) {
    if (before.find("input") != std::string::npos) continue;  // whose style it is stays
    if (before == "absolute" || before == "stride" || before == "mirror")
      continue;  // and how it is shown
    SCOPED_TRACE(before);
    NamedPair untouched, stage;
    (void)stage.Set("rig.a", settings);
    v1::Request panic;
    panic.mutable_panic();
    EXPECT_EQ(stage.Ask(panic).code(), v1::CODE_OK);
    for (NamedPair* const one : {&untouched, &stage}) {
      EXPECT_EQ(one->Set("rig.a", [](v1::Look& look) { AddStyle(look, "style1", 1); }).code(),
                v1::CODE_OK);
    }
    EXPECT_EQ(stage.LookOf("rig.a"), untouched.LookOf("rig.a"));
  }
}

TEST(Everybody, AStyleWithoutVariationsIsShownAsItIsAndSaysSo) {
  NamedPair stage;
  EXPECT_EQ(stage.Set("rig.a", [](v1::Look& look) { look.set_vary(7); }).applied(0).not_varied(),
            "");
  const v1::Reply reply = stage.Set("rig.a", [](v1::Look& look) { AddStyle(look, "style1", 1); });
  EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  EXPECT_EQ(reply.applied(0).not_varied(), "style1");
}

}  // namespace
}  // namespace styled::pipeline

// Messages from the peer's address that are not the peer's have no effect and are logged.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "tests/unit/standby/pair_test.h"

namespace styled::support {
namespace {

class StrangersTest : public PairTest {
 protected:
  // A message as a leader of a higher term would send it, changed.
  static std::string Bogus(const std::function<void(v1::Journal&)>& change) {
    v1::Journal entry;
    entry.set_version(4);
    entry.set_daemon(3);
    entry.set_epoch(3);
    entry.set_term(1000);
    entry.set_role(v1::ROLE_LEADING);
    entry.set_number(1);
    entry.set_now_ns(5'000'000'000);
    entry.set_wall_ns(1'700'000'000'000'000'000);
    entry.set_hold_ns(100'000'000);
    change(entry);
    return entry.SerializeAsString();
  }
  static std::vector<std::string> AllBogus() {
    std::vector<std::string> all{
        "",
        "no message at all",
        std::string(100'000, '\0'),
        Bogus([](v1::Journal& e) { e.set_version(1); }),
        Bogus([](v1::Journal& e) { e.set_version(5); }),
        Bogus([](v1::Journal& e) { e.set_daemon(0); }),
        Bogus([](v1::Journal& e) { e.set_number(0); }),
        Bogus([](v1::Journal& e) { e.set_number(~0ULL); }),
        Bogus([](v1::Journal& e) { e.set_now_ns(-1); }),
        Bogus([](v1::Journal& e) { e.set_wall_ns(std::numeric_limits<std::int64_t>::max()); }),
        Bogus([](v1::Journal& e) { e.set_role(static_cast<v1::Role>(77)); }),
        Bogus([](v1::Journal& e) { e.set_hold_ns(0); }),
        Bogus([](v1::Journal& e) { e.set_hold_ns(~0ULL); }),
        Bogus([](v1::Journal& e) { e.set_hears(77); })};
    for (const std::uint64_t term : {~0ULL, 1ULL << 63U, (1ULL << 32U) + 1}) {
      all.push_back(Bogus([term](v1::Journal& e) { e.set_term(term); }));
    }
    constexpr int kTooMany = 3000;
    all.push_back(Bogus([](v1::Journal& e) {
      for (int i = 0; i < kTooMany; ++i) e.mutable_beginning()->add_styles(std::to_string(i));
    }));
    all.push_back(Bogus([](v1::Journal& e) {
      for (unsigned i = 0; i < kTooMany; ++i) e.mutable_beginning()->add_fading(i);
    }));
    all.push_back(Bogus([](v1::Journal& e) {
      for (int i = 0; i < kTooMany; ++i) e.mutable_settings()->add_performers("rig.p");
    }));
    return all;
  }
  static bool Says(Node& node, const std::string& what) {
    return std::ranges::any_of(node.Lines(), [&what](const std::string& line) {
      return line.find(what) != std::string::npos;
    });
  }
};

TEST_F(StrangersTest, ALeaderYieldsToNoStranger) {
  Begin();
  Frames(20);
  for (const std::string& message : AllBogus()) {
    wire_.to_a.push_back(message);
    Frames(1);
    EXPECT_EQ(a_->State().role(), "leading") << testing::PrintToString(message.substr(0, 80));
    EXPECT_EQ(a_->State().term(), 1U);
  }
  EXPECT_EQ(a_->publisher.frames.size(), 20U + AllBogus().size());
  EXPECT_GE(a_->State().refused(), AllBogus().size() - 1);  // the one that hears another is heard
  EXPECT_TRUE(Says(*a_, "is ignored: "));
  // The control: one of the pair is heeded.
  wire_.to_a.push_back(Bogus([](v1::Journal& e) { e.set_hears(5); }));
  Turn(1);
  EXPECT_EQ(a_->State().role(), "following");
}

TEST_F(StrangersTest, AStandbyStaysReadyDespiteForeignMessages) {
  StartB();
  Begin();
  Frames(20);
  for (const std::string& message : AllBogus()) {
    const bool parses = message == AllBogus()[13];  // another sender's, in the leader's place
    if (parses) continue;
    wire_.to_b.push_back(message);
    Turn(1);
    EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
    Frames(1);
    EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
    EXPECT_EQ(b_->State().role(), "following");
  }
  EXPECT_EQ(b_->State().different(), 0U);
  EXPECT_GE(b_->State().refused(), AllBogus().size() - 1);
}

// A leader's entry that cannot be repeated: the state is fetched again at once, not after 10 s.
TEST_F(StrangersTest, AnEntryThatCannotBePerformedCostsASecond) {
  StartB();
  Begin();
  Frames(20);
  Turn(12'000);
  Frames(20);
  ASSERT_TRUE(b_->State().ready()) << b_->State().why_not();
  wire_.change = [this](v1::Journal& entry) {
    if (!entry.has_batch()) return;
    entry.mutable_batch()->set_source(99);
    wire_.change = nullptr;
  };
  const auto fetched = b_->State().fetched();
  Frames(1);
  EXPECT_TRUE(Says(*b_, "cannot stand in: frames of source"));
  Frames(125);
  EXPECT_EQ(b_->State().fetched(), fetched + 1);
  EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
}

// More than it reads in a turn, without end.
TEST_F(StrangersTest, AFloodDoesNotPreventATakeover) {
  StartB();
  Begin();
  Frames(20);
  a_.reset();
  const auto flood = [this](int ms) {
    for (int i = 0; i < ms; ++i) {
      while (wire_.to_b.size() < 500) wire_.to_b.emplace_back("no message at all");
      b_->clock.now_ns += 1'000'000;
      (void)b_->Step();
    }
  };
  flood(200);
  wire_.to_b.clear();
  EXPECT_EQ(b_->State().role(), "leading");
  b_ = std::make_unique<Node>(wire_, false, 10, 77'000'000'000, config_, kTopics);
  flood(1200);
  wire_.to_b.clear();
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_NE(b_->State().refused_why().find("not an entry of a journal"), std::string::npos);
}

// The daemon of another pair has the peer's address: it hears its own peer, not this one.
TEST_F(StrangersTest, TheLeaderOfAnotherPairIsIgnored) {
  a_.reset();
  wire_.to_b.clear();
  b_ = std::make_unique<Node>(wire_, false, 9, 77'000'000'000, config_, kTopics);
  std::uint64_t number = 0;
  const auto hear = [&](int ms) {
    for (int i = 0; i < ms; ++i) {
      if (i % 20 == 0) {
        wire_.to_b.push_back(Bogus([&](v1::Journal& e) {
          e.set_number(++number);
          e.set_hears(77);
        }));
      }
      b_->clock.now_ns += 1'000'000;
      b_->Work();
    }
  };
  hear(2400);
  EXPECT_EQ(b_->State().role(), "looking");
  hear(400);
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_EQ(b_->State().term(), 1U);
  hear(5000);
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_TRUE(Says(*b_, "that daemon receives a third one"));
}

}  // namespace
}  // namespace styled::support

#include "daemon/perform/log_limit.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

namespace styled::pipeline {
namespace {

using Kind = LogLimit::Kind;
constexpr std::int64_t kLogSecond_ns = 1'000'000'000;
constexpr source::Machine kTalker{1}, kOther{2};

TEST(LogLimitTest, ARepeatedLineIsLoggedDecreasinglyOftenWithACount) {
  LogLimit limit;
  std::vector<int> logged_s;
  std::uint64_t held_back = 0, all_held_back = 0;
  for (int s = 0; s < 300; ++s) {
    if (!limit.Admit(Kind::kBodyRefused, kTalker, "rig.a", 100 * kLogSecond_ns + s * kLogSecond_ns,
                     held_back)) {
      continue;
    }
    logged_s.push_back(s);
    all_held_back += held_back;
  }
  EXPECT_EQ(logged_s, (std::vector<int>{0, 1, 3, 7, 15, 31, 63, 127, 191, 255}));
  EXPECT_EQ(all_held_back, 255U + 1 - logged_s.size());
}

TEST(LogLimitTest, EachPerformerAndKindHasALimitOfItsOwn) {
  LogLimit limit;
  std::map<std::string, int> said;
  std::uint64_t held_back = 0;
  for (int s = 0; s < 10; ++s) {
    for (int k = 0; k < 12; ++k) {
      const std::string id = "rig.p" + std::to_string(k);
      const source::Machine kTalker{static_cast<std::uint64_t>(k) + 1};
      for (const Kind kind : {Kind::kBodyRefused, Kind::kBodyBound}) {
        said[id] += limit.Admit(kind, kTalker, id, s * kLogSecond_ns, held_back) ? 1 : 0;
      }
    }
  }
  ASSERT_EQ(said.size(), 12U);
  for (const auto& [id, lines] : said) EXPECT_EQ(lines, 8) << id;
}

TEST(LogLimitTest, InventedNamesDoNotFillTheLog) {
  LogLimit limit;
  int lines = 0;
  std::uint64_t held_back = 0;
  for (int i = 0; i < 10'000; ++i) {  // a thousand a second
    lines += limit.Admit(Kind::kBodyBound, kTalker, "rig." + std::to_string(i),
                         i * kLogSecond_ns / 1000, held_back)
                 ? 1
                 : 0;
  }
  EXPECT_GE(lines, 16);
  EXPECT_LE(lines, 16 + 2 * 10);
}

TEST(LogLimitTest, InventedNamesHideNoLineOfAnotherMachine) {
  LogLimit limit;
  std::uint64_t held_back = 0;
  for (int i = 0; i < 3000; ++i) {  // a thousand a second
    (void)limit.Admit(Kind::kBodyRefused, kTalker, "rig." + std::to_string(i),
                      i * kLogSecond_ns / 1000, held_back);
  }
  EXPECT_TRUE(limit.Admit(Kind::kBodyRefused, kOther, "rig.anna", 3 * kLogSecond_ns, held_back));
}

TEST(LogLimitTest, AQuietKeyRestarts) {
  LogLimit limit;
  std::uint64_t held_back = 0;
  for (int s = 0; s < 100; ++s)
    (void)limit.Admit(Kind::kCue, kTalker, "a", s * kLogSecond_ns, held_back);
  EXPECT_TRUE(limit.Admit(Kind::kCue, kTalker, "a", 400 * kLogSecond_ns, held_back));
  EXPECT_TRUE(limit.Admit(Kind::kCue, kTalker, "a", 401 * kLogSecond_ns, held_back));
}

}  // namespace
}  // namespace styled::pipeline

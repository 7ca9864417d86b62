#include "clients/rec/time_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

namespace styled::rec {
namespace {

constexpr std::int64_t kNow_ns = 1'800'000'000'000'000'000;

TEST(TimeText, ReadsWhatPeopleWrite) {
  setenv("TZ", "UTC-2", 1);  // two hours east
  tzset();
  const struct {
    const char* text;
    std::int64_t unix_ns;
  } rows[] = {
      {"1970-01-02T00:00:00Z", 86'400'000'000'000},
      {"2026-11-26T14:03:05Z", 1'795'701'785'000'000'000},
      {"2026-11-26T14:03:05.25Z", 1'795'701'785'250'000'000},
      {"2026-11-26T14:03Z", 1'795'701'780'000'000'000},
      {"2026-11-26T14:03:05", 1'795'694'585'000'000'000},
      {"-90s", kNow_ns - 90'000'000'000},
      {"-1.5m", kNow_ns - 90'000'000'000},
      {"-2h", kNow_ns - 7'200'000'000'000},
      {"-1d", kNow_ns - 86'400'000'000'000},
      {"-0s", kNow_ns},
  };
  for (const auto& row : rows) {
    const auto parsed = ParseTime(row.text, kNow_ns);
    ASSERT_TRUE(parsed.ok()) << parsed.status().message();
    EXPECT_EQ(parsed.value(), row.unix_ns) << row.text;
  }
  EXPECT_EQ(TimeText(1'795'701'785'250'000'000), "2026-11-26T14:03:05.250Z");
}

TEST(TimeText, RefusesEverythingElse) {
  for (const char* text : {"",
                           "-",
                           "-5",
                           "-5x",
                           "--5m",
                           "-5mm",
                           "-nanm",
                           "-infh",
                           "-1e300d",
                           "15m",
                           "now",
                           "2026-11-26",
                           "2026-13-26T14:03:05Z",
                           "2026-11-26T25:00:00Z",
                           "2026-11-26T14:03:05X",
                           "2026-11-26T14:03:05ZZ",
                           "2026-11-26T14:03:05.Z",
                           "2026-11-26T14:03:05.1.2Z",
                           "1960-01-01T00:00:00Z",
                           "2026-11-26 14:03:05"}) {
    const auto parsed = ParseTime(text, kNow_ns);
    EXPECT_FALSE(parsed.ok()) << text;
    if (!parsed.ok()) {
      EXPECT_THAT(parsed.status().message(), ::testing::HasSubstr("expected e.g. ")) << text;
    }
  }
}

}  // namespace
}  // namespace styled::rec

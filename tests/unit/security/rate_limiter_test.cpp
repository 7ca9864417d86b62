#include "daemon/source/rate_limiter.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>

#include <cstring>

#include "daemon/runtime/clock.h"

namespace styled::source {
namespace {

using runtime::kMillisecond_ns;
using runtime::kSecond_ns;

sockaddr_storage From(std::uint32_t address, std::uint16_t port = 1) {
  sockaddr_storage from{};
  auto& v4 = reinterpret_cast<sockaddr_in&>(from);
  v4.sin_family = AF_INET;
  v4.sin_addr.s_addr = htonl(address);
  v4.sin_port = htons(port);
  return from;
}

sockaddr_storage From6(const char* address) {
  sockaddr_storage from{};
  auto& v6 = reinterpret_cast<sockaddr_in6&>(from);
  v6.sin6_family = AF_INET6;
  EXPECT_EQ(inet_pton(AF_INET6, address, &v6.sin6_addr), 1);
  return from;
}

int Burst(RateLimiter& limiter, const sockaddr_storage& from, std::int64_t now_ns, int count) {
  int admitted = 0;
  for (int i = 0; i < count; ++i) admitted += limiter.Admit(from, now_ns) ? 1 : 0;
  return admitted;
}

TEST(RateLimiterTest, ASenderBelowTheLimitLosesNothing) {
  RateLimiter limiter(120, 1);
  for (int i = 0; i < 10000; ++i) {
    ASSERT_TRUE(limiter.Admit(From(1), i * kSecond_ns / 120)) << i;
  }
}

TEST(RateLimiterTest, AFloodIsCutToTheLimit) {
  RateLimiter limiter(1000, 1);
  std::int64_t now_ns = 0;
  int admitted = 0;
  for (int i = 0; i < 100000; ++i, now_ns += kSecond_ns / 10000) {
    admitted += limiter.Admit(From(1), now_ns) ? 1 : 0;
  }
  EXPECT_GE(admitted, 10000) << "ten seconds of the limit";
  EXPECT_LE(admitted, 10000 + 282 + 1) << "and the bucket that was full";
}

TEST(RateLimiterTest, AfterASilenceAtMostAQuarterOfASecondIsAllowedAtOnce) {
  RateLimiter limiter(400, 1);
  EXPECT_EQ(Burst(limiter, From(1), 0, 1000), 132);
  EXPECT_EQ(Burst(limiter, From(1), 100 * kMillisecond_ns, 1000), 40);
  EXPECT_EQ(Burst(limiter, From(1), 100 * kSecond_ns, 1000), 132);
}

TEST(RateLimiterTest, AnAddressIsOneSenderWhateverItsPorts) {
  RateLimiter limiter(400, 1);
  int admitted = 0;
  for (int port = 0; port < 1000; ++port) {
    admitted += limiter.Admit(From(1, static_cast<std::uint16_t>(port)), 0) ? 1 : 0;
  }
  EXPECT_EQ(admitted, 132);
}

TEST(RateLimiterTest, OneThatFloodsTakesNothingFromAnother) {
  RateLimiter limiter(400, 1);
  for (int i = 0; i < 600; ++i) {
    const std::int64_t now_ns = i * kSecond_ns / 120;
    (void)Burst(limiter, From(1), now_ns, 100);
    ASSERT_TRUE(limiter.Admit(From(2), now_ns));
    ASSERT_TRUE(limiter.Admit(From6("fe80::1"), now_ns));
  }
}

TEST(RateLimiterTest, AddressesOfIpVersion6AreToldApartByAllTheirBits) {
  RateLimiter limiter(400, 1);
  for (const char* const address : {"fe80::1", "fe80::2", "fe81::1", "::1"}) {
    EXPECT_EQ(Burst(limiter, From6(address), 0, 1000), 132) << address;
  }
}

// More forged addresses than the table holds: who was there before is served, and those who find no
// place share one bucket.
TEST(RateLimiterTest, ForgedAddressesTakeNothingFromTheKnown) {
  RateLimiter limiter(1000, 4711);
  std::uint32_t forged = 1 << 24;
  std::int64_t now_ns = 0;
  int admitted = 0, tried = 0;
  ASSERT_TRUE(limiter.Admit(From(1), now_ns));
  for (int i = 0; i < 1200; ++i, now_ns += kSecond_ns / 120) {
    ASSERT_TRUE(limiter.Admit(From(1), now_ns)) << i;
    for (int k = 0; k < 200; ++k, ++tried) {
      admitted += limiter.Admit(From(++forged), now_ns) ? 1 : 0;
    }
  }
  // Ten seconds: 512 places, each taken at most once a second, and the shared bucket's.
  EXPECT_LE(admitted, 11 * 512 + 10 * 1000 + 282);
  EXPECT_GT(tried, 10 * admitted);
}

TEST(RateLimiterTest, ASilentAddressIsReplacedByTheNext) {
  RateLimiter limiter(400, 1);
  for (std::uint32_t address = 1; address <= 100000; ++address) {
    (void)Burst(limiter, From(address), 0, 1);
  }
  EXPECT_EQ(Burst(limiter, From(200000), 2 * kSecond_ns, 1000), 132);
}

TEST(RateLimiterTest, NoLimitIsNone) {
  RateLimiter limiter(0, 1);
  EXPECT_EQ(Burst(limiter, From(1), 0, 100000), 100000);
}

}  // namespace
}  // namespace styled::source

#include "clients/vmc/target.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "tests/unit/vmc_out/ear.h"

namespace styled::stylevmc {
namespace {

using testing::HasSubstr;

TEST(ParseTarget, TakesNamesAddressesAndPerformers) {
  const auto plain = ParseTarget("studio-pc:39539");
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(plain.value().performer, "");
  EXPECT_EQ(plain.value().host, "studio-pc");
  EXPECT_EQ(plain.value().port, "39539");
  const auto six = ParseTarget("rig.anna=[fd00::5]:1");
  ASSERT_TRUE(six.ok());
  EXPECT_EQ(six.value().performer, "rig.anna");
  EXPECT_EQ(six.value().host, "fd00::5");
  EXPECT_EQ(six.value().text, "[fd00::5]:1");
}

TEST(ParseTarget, RefusesEachBadOneWithWhatWasExpected) {
  for (const char* bad : {"", "localhost", ":39539", "localhost:", "localhost:0", "localhost:65536",
                          "localhost:-1", "localhost:39539x", "fd00::5:39539", "[]:39539",
                          "anna=localhost:39539", "=localhost:39539", "rig.anna=", "a:b:1"}) {
    const auto target = ParseTarget(bad);
    ASSERT_FALSE(target.ok()) << bad;
    EXPECT_THAT(target.status().message(), HasSubstr(std::string("--to '") + bad + "'"));
    EXPECT_THAT(target.status().message(), HasSubstr("expected"));
  }
}

TEST(Target, AnUnknownHostIsNamed) {
  const auto target = Target::Open(ParseTarget("no-such-host.invalid:39539").value());
  ASSERT_FALSE(target.ok());
  EXPECT_THAT(target.status().message(), HasSubstr("--to no-such-host.invalid:39539: "));
}

// "localhost" is ::1, too; those who listen do so on IPv4.
TEST(Target, PrefersIpv4) {
  const Ear ear;
  auto target = Target::Open(ParseTarget("localhost:" + ear.port()).value());
  ASSERT_TRUE(target.ok()) << target.status().message();
  const std::vector<std::byte> datagram(12, std::byte{7});
  EXPECT_EQ(target.value()->Send(datagram), "");
  EXPECT_EQ(ear.Receive(), datagram);
}

// The answer takes a moment, also on loopback. Each datagram goes out, before it and after.
TEST(Target, TellsThatNoProgramListensUntilOneDoes) {
  std::string port;
  {
    const Ear gone;
    port = gone.port();
  }
  auto target = Target::Open(ParseTarget("127.0.0.1:" + port).value());
  ASSERT_TRUE(target.ok());
  EXPECT_FALSE(target.value()->NoListener());
  const auto send = [&](int value) {
    return target.value()->Send(std::vector<std::byte>(4, static_cast<std::byte>(value)));
  };
  for (int i = 0; i < 200 && !target.value()->NoListener(); ++i) {
    EXPECT_EQ(send(0), "");
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_TRUE(target.value()->NoListener());

  const Ear ear(port);
  for (int i = 1; i <= 100; ++i) {
    EXPECT_EQ(send(i), "");
    EXPECT_EQ(ear.Receive(), std::vector<std::byte>(4, static_cast<std::byte>(i)));
  }
  EXPECT_TRUE(target.value()->NoListener());
  std::this_thread::sleep_for(Target::kTellsFor);
  EXPECT_TRUE(target.value()->NoListener()) << "a performer who pauses proves nothing";
  EXPECT_EQ(send(0), "");
  EXPECT_FALSE(target.value()->NoListener());
}

}  // namespace
}  // namespace styled::stylevmc

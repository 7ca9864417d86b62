#include "clients/doctor/address.h"

#include <gtest/gtest.h>

namespace styled::doctor {
namespace {

TEST(AddressTest, WhatIsNoHostAndPortIsRefused) {
  for (const std::string text : {"", ":7000", "7000", "127.0.0.1", "127.0.0.1:", "127.0.0.1:70000",
                                 "127.0.0.1:-1", "127.0.0.1:7000x", "::1:7000"}) {
    EXPECT_FALSE(ParseEndpoint(text)) << text;
  }
}

TEST(AddressTest, AddressesComeOutAsTheyWentIn) {
  for (const std::string text : {"127.0.0.1:7000", "[::1]:7000", "0.0.0.0:0", "[fd00::2]:65535"}) {
    const auto parsed = ParseEndpoint(text);
    ASSERT_TRUE(parsed) << text;
    EXPECT_EQ(ToString(*parsed), text);
    sockaddr_storage address;
    ASSERT_GT(ToSocket(*parsed, address), 0U) << text;
    EXPECT_EQ(FromSocket(address), *parsed);
  }
}

TEST(AddressTest, IPv4WithinIPv6IsWrittenAsIPv4) {
  sockaddr_storage address;
  ASSERT_GT(ToSocket({"::ffff:192.0.2.7", 9763}, address), 0U);
  EXPECT_EQ(ToString(FromSocket(address)), "192.0.2.7:9763");
  ASSERT_GT(ToSocket({"::ffff:1:2:3", 9763}, address), 0U);
  EXPECT_EQ(ToString(FromSocket(address)), "[::ffff:1:2:3]:9763") << "begins alike, is none";
}

TEST(AddressTest, NamesOfHostsAreNoAddresses) {
  EXPECT_FALSE(IsNumeric("localhost"));
  EXPECT_TRUE(IsNumeric("127.0.0.1"));
  EXPECT_TRUE(IsNumeric("fd00::2"));
}

TEST(AddressTest, GroupsLoopbackAndWildcardsAreKnown) {
  EXPECT_TRUE(IsMulticast("239.255.42.99"));
  EXPECT_TRUE(IsMulticast("ff02::1"));
  EXPECT_FALSE(IsMulticast("192.0.2.1"));
  EXPECT_FALSE(IsMulticast("fd00::2"));
  EXPECT_TRUE(IsLoopback("127.0.0.53"));
  EXPECT_FALSE(IsLoopback("128.0.0.1"));
  EXPECT_TRUE(IsWildcard("::"));
  EXPECT_FALSE(IsWildcard("0.0.0.1"));
}

TEST(AddressTest, NothingThatIsPrintedMovesTheCursor) {
  EXPECT_EQ(Printable("a\x1B[2Jb\n\xFF"), "a?[2Jb??");
  EXPECT_EQ(Printable("0123456789", 4), "0123");
}

}  // namespace
}  // namespace styled::doctor

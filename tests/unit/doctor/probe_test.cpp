// On real sockets of this machine's loopback.
#include "clients/doctor/probe.h"

#include <gtest/gtest.h>
#include <netinet/in.h>

#include <algorithm>

#include "tests/unit/mvn/packets.h"

namespace styled::doctor {
namespace {

using mvn::testing::Bytes;

// A socket bound to `host`, any port, and its port.
struct Bound {
  explicit Bound(const std::string& host, int type = SOCK_DGRAM)
      : fd(socket(AF_INET, type | SOCK_CLOEXEC, 0)) {
    sockaddr_storage address;
    socklen_t size = ToSocket({host, 0}, address);
    EXPECT_EQ(bind(fd.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
    getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &size);
    port = FromSocket(address).port;
  }
  Descriptor fd;
  std::uint16_t port = 0;
};

std::uint16_t FreePort() { return Bound("0.0.0.0").port; }

void Send(int fd, const Endpoint& to, const Bytes& bytes) {
  sockaddr_storage address;
  const socklen_t size = ToSocket(to, address);
  EXPECT_EQ(sendto(fd, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&address), size),
            static_cast<ssize_t>(bytes.size()));
}

class ProbeTest : public testing::Test {
 protected:
  std::vector<Interface> interfaces_ = ListInterfaces();
  Probe probe_{interfaces_};
};

TEST_F(ProbeTest, LoopbackIsListed) {
  const Interface* loopback = FindInterface(interfaces_, "127.0.0.1");
  ASSERT_NE(loopback, nullptr);
  EXPECT_TRUE(loopback->loopback);
  EXPECT_TRUE(loopback->up);
  EXPECT_EQ(FindInterface(interfaces_, loopback->name), loopback);
  EXPECT_EQ(FindInterface(interfaces_, loopback->index), loopback);
  EXPECT_EQ(FindInterface(interfaces_, "no such interface"), nullptr);
  EXPECT_EQ(RouteTo("127.0.0.1"), "127.0.0.1");
  EXPECT_EQ(RouteTo("no address"), "");
}

TEST_F(ProbeTest, APortThatIsHeldEverywhereIsTaken) {
  const Bound other("0.0.0.0");
  const PortState state = probe_.Open(false, other.port, false);
  EXPECT_EQ(state.kind, PortState::Kind::kInUse);
}

TEST_F(ProbeTest, BesideAPortHeldOnOneAddressTheOthersAreHeard) {
  const Bound other("127.0.0.2");
  const PortState state = probe_.Open(false, other.port, false);
  ASSERT_EQ(state.kind, PortState::Kind::kPartly);
  EXPECT_NE(std::ranges::find(state.hosts, "127.0.0.1"), state.hosts.end());
  const Bound sender("127.0.0.1");
  Send(sender.fd.get(), {"127.0.0.1", other.port}, mvn::testing::Quaternions());
  Send(sender.fd.get(), {"127.0.0.2", other.port}, mvn::testing::Quaternions());
  probe_.Run(0.1);
  ASSERT_EQ(probe_.heard().flows().size(), 1U);
  EXPECT_EQ(probe_.heard().flows()[0].to.host, "127.0.0.1");
}

TEST_F(ProbeTest, DatagramsAreHeardWithBothEndsInterfaceAndFormat) {
  const std::uint16_t port = FreePort();
  ASSERT_EQ(probe_.Open(false, port, false).kind, PortState::Kind::kHeard);
  const Bound sender("127.0.0.1");
  // Two addresses of loopback: the target is distinguished though the socket is bound to all.
  for (int i = 0; i < 200; ++i) {
    Send(sender.fd.get(), {"127.0.0.1", port}, mvn::testing::Quaternions());
  }
  Send(sender.fd.get(), {"127.0.0.3", port}, {});
  probe_.Run(0.2);
  const auto& flows = probe_.heard().flows();
  ASSERT_EQ(flows.size(), 2U);
  EXPECT_EQ(ToString(flows[0].to), "127.0.0.1:" + std::to_string(port));
  EXPECT_EQ(ToString(flows[0].from), "127.0.0.1:" + std::to_string(sender.port));
  EXPECT_EQ(flows[0].interface, FindInterface(interfaces_, "127.0.0.1")->name);
  EXPECT_EQ(flows[0].tally.Kinds(Format::kMvn), "quaternions (02) 200");
  EXPECT_EQ(flows[1].to.host, "127.0.0.3");
  EXPECT_EQ(flows[1].tally.Kinds(Format::kUnknown), "empty datagrams 1");
}

TEST_F(ProbeTest, RecordsOfATcpConnectionAreHeardWholeHoweverTheyAreCut) {
  const std::uint16_t port = FreePort();
  ASSERT_EQ(probe_.Open(true, port, false).kind, PortState::Kind::kHeard);
  const Descriptor sender(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_storage address;
  const socklen_t size = ToSocket({"127.0.0.1", port}, address);
  ASSERT_EQ(connect(sender.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
  const Bytes record = mvn::testing::Quaternions();
  Bytes stream;
  for (int i = 0; i < 3; ++i) stream.insert(stream.end(), record.begin(), record.end());
  ASSERT_EQ(send(sender.get(), stream.data(), 900, 0), 900);
  probe_.Run(0.1);
  ASSERT_EQ(probe_.heard().flows().size(), 1U);
  EXPECT_EQ(probe_.heard().flows()[0].datagrams, 1U);
  ASSERT_GT(send(sender.get(), stream.data() + 900, stream.size() - 900, 0), 0);
  probe_.Run(0.1);
  EXPECT_TRUE(probe_.heard().flows()[0].stream);
  EXPECT_EQ(probe_.heard().flows()[0].tally.Kinds(Format::kMvn), "quaternions (02) 3");
}

TEST_F(ProbeTest, AGroupIsJoinedOnEachInterfaceByItself) {
  constexpr const char* kGroup = "239.255.42.98";
  const std::uint16_t port = FreePort();
  const auto joined = probe_.Join(kGroup, port);
  const std::string name = FindInterface(interfaces_, "127.0.0.1")->name;
  const auto loopback = std::ranges::find(joined, name, &GroupState::interface);
  ASSERT_NE(loopback, joined.end());
  if (!loopback->why.empty()) GTEST_SKIP() << "no groups on loopback here: " << loopback->why;
  const Bound sender("127.0.0.1");
  ip_mreqn by{};
  by.imr_ifindex = static_cast<int>(FindInterface(interfaces_, name)->index);
  ASSERT_EQ(setsockopt(sender.fd.get(), IPPROTO_IP, IP_MULTICAST_IF, &by, sizeof by), 0);
  Send(sender.fd.get(), {kGroup, port}, mvn::testing::Quaternions());
  probe_.Run(0.1);
  ASSERT_EQ(probe_.heard().flows().size(), 1U);
  EXPECT_EQ(probe_.heard().flows()[0].to.host, kGroup);
  EXPECT_EQ(probe_.heard().flows()[0].interface, name);
  EXPECT_EQ(probe_.heard().flows()[0].datagrams, 1U) << "heard by one of the sockets alone";
}

}  // namespace
}  // namespace styled::doctor

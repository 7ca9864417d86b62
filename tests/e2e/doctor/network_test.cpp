// Tests that need a network that they can change: interfaces, groups, a firewall, the usual ports.
#include <gmock/gmock.h>

#include "tests/e2e/doctor/stage.h"
#include "tests/support/daemon.h"

namespace styled::support {
namespace {

using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;

class DoctorNetworkTest : public DoctorTest {
 protected:
  void SetUp() override {
    if (!own_network) GTEST_SKIP() << "the kernel gives this test no network of its own";
  }
};

TEST_F(DoctorNetworkTest, OnAUsualPortTheFormatIsFoundWithoutBeingToldWhere) {
  Play("mvn", "127.0.0.1:9763");
  const Report report = Doctor({"--config", Config("mvn", Local(FreePort()))});
  EXPECT_THAT(report.problems, ElementsAre("no_daemon", "wrong_port"));
  EXPECT_THAT(report.Of("wrong_port", "what"), HasSubstr("127.0.0.1:9763"));
}

TEST_F(DoctorNetworkTest, ByItsInterfacesTheFormatIsFoundOnAnyPort) {
  const std::string other = Local(FreePort());
  Play("rokoko", other);
  const Report report = Doctor({"--config", Config("rokoko", Local(FreePort()))}, true);
  EXPECT_THAT(report.problems, ElementsAre("no_daemon", "wrong_port"));
  EXPECT_THAT(report.Of("wrong_port", "what"), HasSubstr("Rokoko Studio arrives at " + other));
}

TEST_F(DoctorNetworkTest, WithoutAConfigurationASourceIsOfferedForWhatArrives) {
  Play("vmc", "127.0.0.1:39540");
  const Report report = Doctor({});
  EXPECT_THAT(report.problems, ElementsAre("no_daemon", "no_source"));
  EXPECT_THAT(report.Of("no_source", "change"), HasSubstr("type = \"vmc\""));
}

TEST_F(DoctorNetworkTest, ALoopbackSourceDoesNotHearWhatIsSentToTheNetwork) {
  if (!Shell("ip address replace 10.77.0.1/32 dev lo")) GTEST_SKIP() << "no ip command";
  const Daemon daemon({},
                      "[[source]]\nname = \"suit\"\ntype = \"mvn\"\nlisten = \"127.0.0.1:0\"\n");
  const std::string port = daemon.listens.at(2).substr(std::string("127.0.0.1:").size());
  Play("mvn", "10.77.0.1:" + port);
  const Report report = Doctor({"--endpoint", daemon.control, "--source", "suit"});
  EXPECT_THAT(report.problems, ElementsAre("wrong_address"));
  EXPECT_THAT(report.Of("wrong_address", "what"), HasSubstr("10.77.0.1:" + port));
  EXPECT_THAT(report.Of("wrong_address", "change"), HasSubstr("listen = \"0.0.0.0:" + port + "\""));
}

// Two virtual cables with both ends in this machine: what leaves by one end arrives at the other.
TEST_F(DoctorNetworkTest, AGroupThatComesByAnotherInterfaceIsFound) {
  const auto cable = [](const std::string& a, const std::string& b, const std::string& net) {
    return Shell("ip link add " + a + " type veth peer name " + b + " && ip link set " + a +
                 " up && ip link set " + b + " up && ip address add " + net + ".1/25 dev " + a +
                 " && ip address add " + net + ".129/25 dev " + b);
  };
  if (!cable("stage0", "stage1", "10.78.0") || !cable("stage2", "stage3", "10.79.0")) {
    GTEST_SKIP() << "no ip command, or no veth in the kernel";
  }
  // The sender is this machine as well; the kernel would otherwise drop its packets as spoofed.
  ASSERT_TRUE(
      Shell("for i in all stage1; do echo 1 > /proc/sys/net/ipv4/conf/$i/accept_local &&"
            " echo 0 > /proc/sys/net/ipv4/conf/$i/rp_filter || exit 1; done"));
  const std::string server = Local(FreePort());
  Play("natnet", server, {"--quirk", "multicast=239.255.42.99:1511@10.78.0.1"});
  const auto source = [&](const std::string& interface) {
    return Config("natnet", "0.0.0.0:0",
                  "server = \"" + server + "\"\ninterface = \"" + interface + "\"");
  };
  for (const std::string interface : {"stage2", "10.79.0.129"}) {
    const Report wrong = Doctor({"--config", source(interface)});
    EXPECT_THAT(wrong.problems, ElementsAre("no_daemon", "multicast_elsewhere")) << wrong.text;
    // The kernel also delivers a group's datagrams to the sender's own interface.
    EXPECT_THAT(wrong.Of("multicast_elsewhere", "change"),
                AnyOf(HasSubstr("interface = \"stage1\""), HasSubstr("interface = \"stage0\"")));
  }
  const Report right = Doctor({"--config", source("stage1")});
  EXPECT_THAT(right.problems, ElementsAre("no_daemon")) << right.text;
  EXPECT_TRUE(Shell("ip link delete stage0 && ip link delete stage2"));
}

TEST_F(DoctorNetworkTest, AFirewallThatDropsThePortIsNamedWithItsRule) {
  const std::string port = std::to_string(FreePort()), place = "127.0.0.1:" + port;
  const bool rule = Shell(
      "nft add table inet stage && nft 'add chain inet stage input "
      "{ type filter hook input priority 0; policy accept; }' && "
      "nft add rule inet stage input udp dport " +
      port + " drop");
  if (!rule) GTEST_SKIP() << "no nft command, or no nftables in the kernel";
  Play("mvn", place);
  const Report report = Doctor({"--config", Config("mvn", place)}, true);
  EXPECT_THAT(report.problems, ElementsAre("no_daemon", "firewall_drops")) << report.text;
  const std::string why = report.Of("firewall_drops", "why");
  EXPECT_THAT(why, HasSubstr("came to lo, and none of them to a program"));
  EXPECT_THAT(why, HasSubstr("inet stage input: drop"));
  EXPECT_TRUE(Shell("nft delete table inet stage"));
  const Report open = Doctor({"--config", Config("mvn", place)}, true);
  EXPECT_THAT(open.problems, ElementsAre("no_daemon")) << open.text;
}

// All simulated rigs at once: where the daemon produces frames, the doctor recognizes the rig and
// reports no problem.
TEST_F(DoctorNetworkTest, NoRigHasFindingsWhileAllFramesArrive) {
  const std::string server = Local(FreePort());
  const std::vector<std::string> types{"mvn", "mocopi", "rokoko", "vmc", "natnet"};
  std::string sources;
  for (const auto& type : types) {
    sources += "[[source]]\nname = \"" + type + "\"\ntype = \"" + type +
               "\"\nlisten = \"127.0.0.1:0\"\n" +
               (type == "natnet" ? "server = \"" + server + "\"\n" : "");
  }
  const Daemon daemon({}, sources);
  for (std::size_t i = 0; i < types.size(); ++i) {
    Play(types[i], types[i] == "natnet" ? server : daemon.listens.at(2 + i));
  }
  const Subscriber subscriber(daemon.publish, {"styled/"});
  for (const auto& type : types) {
    ASSERT_TRUE(subscriber.WaitForFrames(1, "styled/" + type, 20)) << type << daemon.Log();
  }
  EXPECT_EQ(ControlClient(daemon.control).SetStyle("*", "s1").code(), v1::CODE_OK);
  const Report report =
      Doctor({"--endpoint", daemon.control, "--config", daemon.folder / "styled.toml"}, true);
  // Only the two default sources of the daemon receive nothing.
  EXPECT_THAT(report.problems, ElementsAre("nothing_arrives", "nothing_arrives")) << report.text;
  EXPECT_THAT(report.json["findings"].at(0)["source"], AnyOf("rig", "tcp"));
  for (std::size_t i = 0; i + 1 < types.size(); ++i) {
    const auto& traffic = report.json["traffic"];
    const bool named = std::any_of(traffic.begin(), traffic.end(), [&](const auto& flow) {
      return flow["to"] == daemon.listens.at(2 + i) && flow["format"] == types[i];
    });
    EXPECT_TRUE(named) << types[i] << ": " << report.text;
  }
}

}  // namespace
}  // namespace styled::support

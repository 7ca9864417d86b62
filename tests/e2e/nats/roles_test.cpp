// Who may do what at the shipped hub.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/e2e/nats/stage.h"

namespace styled::support {
namespace {

using NatsRolesTest = OnNatsServers;

TEST_F(NatsRolesTest, AViewerSeesAndReadsButNeitherForgesNorCommands) {
  Daemon daemon;
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  NatsUser viewer(servers_.hub_port, "viewer", "styled.>");
  const NatsUser other(servers_.hub_port, "viewer", "styled.>");
  const NatsUser spy(servers_.hub_port, "viewer", "styledctl.>");
  ASSERT_TRUE(viewer.WaitFor(10, "styled.hall.rig=2Ea.rig", 30)) << bridge.Log() << servers_.Log();
  ASSERT_TRUE(viewer.WaitForKey("hall.body.rig=2Ea.rig"));
  const std::string body = *viewer.Get("hall.body.rig=2Ea.rig");

  const char* const forged = "styled.hall.rig=2Ea.forged";
  natsConnection_PublishString(viewer.get(), forged, "x");
  natsConnection_PublishString(viewer.get(), "$KV.styled.hall.body.rig=2Ea.rig", "x");
  natsConnection_Flush(viewer.get());
  v1::Request panic;
  panic.mutable_panic();
  EXPECT_FALSE(viewer.Ask(panic.SerializeAsString(), 1)) << "no answer, no command";
  NatsUser operating(servers_.hub_port, "operator");
  ASSERT_TRUE(operating.Ask(panic));
  Sleep(0.3);
  EXPECT_EQ(other.Size(forged), 0U);
  EXPECT_EQ(spy.Size(), 0U) << "nobody reads others' commands";
  EXPECT_EQ(viewer.Get("hall.body.rig=2Ea.rig"), body);
  EXPECT_EQ(bridge.Count("commands,"), 1) << bridge.Counters();
  // The control of the first check: the bridge's own user may publish there.
  const NatsUser publisher(servers_.hub_port, "bridge");
  natsConnection_PublishString(publisher.get(), forged, "x");
  EXPECT_TRUE(other.WaitFor(1, forged));
}

TEST_F(NatsRolesTest, AGuestSeesTheAudienceTierAlone) {
  Daemon daemon;
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  const NatsUser tier(servers_.hub_port, "guest", "styled.*.*.canonical30");
  const NatsUser all(servers_.hub_port, "guest", "styled.>");
  const NatsUser canonical(servers_.hub_port, "guest", "styled.hall.rig=2Ea.canonical");
  NatsUser guest(servers_.hub_port, "guest");
  ASSERT_TRUE(tier.WaitFor(60, "", 30)) << bridge.Log() << servers_.Log();
  for (const Heard& heard : tier.All()) {
    EXPECT_EQ(heard.subject, "styled.hall.rig=2Ea.canonical30");
  }
  EXPECT_EQ(all.Size(), 0U);
  EXPECT_EQ(canonical.Size(), 0U);
  v1::Request panic;
  panic.mutable_panic();
  EXPECT_FALSE(guest.Ask(panic.SerializeAsString(), 1));
  EXPECT_FALSE(guest.Get("hall.body.rig=2Ea.canonical"));
}

TEST_F(NatsRolesTest, AWrongPasswordEndsItWithAReason) {
  Daemon daemon;
  TemporaryFolder folder;
  Child bridge({STYLENATS_BINARY, "--site", "hall", "--nats",
                "nats://127.0.0.1:" + servers_.leaf_port, "--publish", daemon.publish},
               folder / "log.txt");
  EXPECT_EQ(bridge.Wait(10).value_or(-1), 1);
  EXPECT_THAT(ReadText(folder / "log.txt"), testing::AllOf(testing::HasSubstr("uthorization"),
                                                           testing::HasSubstr("--nats-login")));
}

}  // namespace
}  // namespace styled::support

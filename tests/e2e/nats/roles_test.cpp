// The permissions of the roles at the shipped hub.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/e2e/nats/raw_subscribers.h"
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

// A request to JetStream names the subject of the answer, and that subject needs no permission: the
// answer is a publication of the server's. So viewers have an account of their own, where such a
// subject reaches only viewers.
TEST_F(NatsRolesTest, AViewerCannotMakeTheServerPublishForHim) {
  Daemon daemon;
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  NatsUser viewer(servers_.hub_port, "viewer");
  NatsUser operating(servers_.hub_port, "operator", "styled.>");
  const std::string key = "hall.body.rig=2Ea.rig", other_key = "hall.body.rig=2Ea.canonical";
  ASSERT_TRUE(viewer.WaitForKey(key, 30)) << bridge.Log() << servers_.Log();
  ASSERT_TRUE(viewer.WaitForKey(other_key)) << bridge.Log();
  const std::string body = *viewer.Get(other_key);
  const std::string get = "$JS.API.DIRECT.GET.KV_styled.$KV.styled." + key;
  for (const std::string& to : {std::string("styledctl.hall"), "$KV.styled." + other_key,
                                std::string("styled.hall.rig=2Ea.forged")}) {
    natsConnection_PublishRequestString(viewer.get(), get.c_str(), to.c_str(), "");
  }
  const std::string push =
      R"({"stream_name":"KV_styled","config":{"deliver_subject":"styledctl.hall",)"
      R"("ack_policy":"none","deliver_policy":"all"}})";
  natsMsg* answer = nullptr;
  EXPECT_NE(natsConnection_RequestString(&answer, viewer.get(), "$JS.API.CONSUMER.CREATE.KV_styled",
                                         push.c_str(), 500),
            NATS_OK);
  natsMsg_Destroy(answer);
  Sleep(0.5);
  EXPECT_EQ(bridge.Count("commands,"), 0) << bridge.Counters();
  EXPECT_EQ(viewer.Get(other_key), body);
  EXPECT_EQ(operating.Size("styled.hall.rig=2Ea.forged"), 0U);
  // The control: an operator is of the account of the commands, and trusted with them.
  natsConnection_PublishRequestString(operating.get(), get.c_str(), "styledctl.hall", "");
  EXPECT_TRUE(WaitUntil([&bridge] { return bridge.Count("commands,") == 1; }, 5))
      << bridge.Counters();
}

TEST_F(NatsRolesTest, NobodyReadsTheRepliesToAnotherUser) {
  Daemon daemon;
  const Stylenats bridge(daemon, servers_.leaf_port);
  ASSERT_TRUE(bridge.WaitForLog("connected to ")) << bridge.Log();
  const NatsUser all(servers_.hub_port, "viewer", ">"),
      common(servers_.hub_port, "viewer", "_INBOX.>"),
      operators(servers_.hub_port, "viewer", "_INBOX_operator.>"),
      bridges(servers_.hub_port, "viewer", "_INBOX_bridge.>"),
      by_operator(servers_.hub_port, "operator", "_INBOX_bridge.>"),
      own(servers_.hub_port, "operator", "_INBOX_operator.>");
  NatsUser operating(servers_.hub_port, "operator");
  v1::Request panic;
  panic.mutable_panic();
  ASSERT_TRUE(operating.Ask(panic)) << bridge.Log() << servers_.Log();
  ASSERT_TRUE(WaitUntil([&own] { return own.Size() > 0; }, 5)) << "the control";
  EXPECT_EQ(all.Size() + common.Size() + operators.Size() + bridges.Size() + by_operator.Size(),
            0U);
  // Nor does the bridge answer where it was not asked.
  const NatsUser forger(servers_.hub_port, "bridge");
  natsConnection_PublishString(forger.get(), "_INBOX_operator.forged", "x");
  natsConnection_Flush(forger.get());
  Sleep(0.3);
  EXPECT_EQ(own.Size("_INBOX_operator.forged"), 0U);
}

// The password of a leaf server is of use to leaf servers alone, and lets what they have passed on
// be what a bridge may publish.
TEST_F(NatsRolesTest, WhoHasALeafServersPasswordIsABridgeAndNoMore) {
  Daemon daemon;
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  const NatsUser operating(servers_.hub_port, "operator", "styled.>");
  ASSERT_TRUE(operating.WaitFor(10, "", 30)) << bridge.Log() << servers_.Log();
  EXPECT_FALSE(RawSubscribers({Wire::kNats, servers_.hub_port, "leaf", {"styled.>"}}).ok());
  // The viewer's own leaf server requires no password.
  TemporaryFolder folder;
  const std::string port = FreePort();
  WriteText(folder / "evil.conf", "server_name: evil\nlisten: 127.0.0.1:" + port +
                                      "\nleafnodes { remotes: [ { url: "
                                      "\"nats://leaf:leafword@127.0.0.1:" +
                                      servers_.hub_leaf_port + "\" } ] }\n");
  const Child evil({NATS_SERVER, "-c", folder / "evil.conf"}, folder / "log.txt");
  ASSERT_TRUE(WaitUntil(
      [&folder] {
        return ReadText(folder / "log.txt").find("Leafnode connection created") !=
               std::string::npos;
      },
      10));
  const NatsUser thief(port, "thief", ">");
  Sleep(0.5);
  const long commands = bridge.Count("commands,");
  for (const char* const subject : {"styledctl.hall", "styled.hall.rig=2Ea.forged"}) {
    natsConnection_PublishString(thief.get(), subject, "x");
  }
  natsConnection_Flush(thief.get());
  EXPECT_TRUE(operating.WaitFor(1, "styled.hall.rig=2Ea.forged")) << "as a bridge";
  EXPECT_EQ(bridge.Count("commands,"), commands) << "he cannot command";
  EXPECT_EQ(thief.Size("styled.hall.rig=2Ea.rig"), 0U) << "he sees no frames";
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

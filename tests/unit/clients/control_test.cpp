#include "clients/cpp/control.h"

#include <gtest/gtest.h>

#include "tests/unit/clients/fake_daemon.h"

namespace styled::client {
namespace {

using namespace std::chrono_literals;

std::unique_ptr<Control> Ask(const std::string& endpoint, std::chrono::milliseconds timeout = 2s) {
  auto control = Control::Connect({.endpoint = endpoint, .timeout = timeout});
  EXPECT_TRUE(control.ok());
  return std::move(control.value());
}

TEST(ControlTest, EveryCallCarriesItsCommandAndPerformer) {
  std::vector<v1::Request> seen;
  FakeDaemon daemon([&seen](const v1::Request& request) {
    seen.push_back(request);
    v1::Reply reply;
    if (request.has_list()) reply.mutable_list()->add_styles()->set_name("old");
    if (request.has_status()) reply.mutable_status()->set_version("7.7");
    v1::Applied& applied = *reply.add_applied();
    applied.set_performer(request.performer());
    applied.set_first_sequence(42);
    return reply;
  });
  auto control = Ask(daemon.control());
  v1::ListReply list;
  ASSERT_TRUE(control->List(&list).ok());
  ASSERT_EQ(list.styles_size(), 1);
  EXPECT_EQ(list.styles(0).name(), "old");
  v1::StatusReply status;
  ASSERT_TRUE(control->Status(&status).ok());
  EXPECT_EQ(status.version(), "7.7");
  Applied applied;
  ASSERT_TRUE(control->SetStyle("rig.a", "old", 0.5F, &applied).ok());
  ASSERT_EQ(applied.size(), 1U);
  EXPECT_EQ(applied[0].first_sequence(), 42U);
  v1::Preset preset;
  preset.set_name("scene");
  ASSERT_TRUE(control->Preset("rig.a", preset).ok());
  ASSERT_TRUE(control->Pin("rig.a", true).ok());
  ASSERT_TRUE(control->Reset("rig.a").ok());
  ASSERT_TRUE(control->Clear(kEveryone).ok());
  ASSERT_TRUE(control->Panic().ok());

  daemon.Synchronize();
  ASSERT_EQ(seen.size(), 8U);
  EXPECT_TRUE(seen[0].has_list());
  EXPECT_TRUE(seen[1].has_status());
  EXPECT_EQ(seen[2].performer(), "rig.a");
  EXPECT_EQ(seen[2].set().mix(0).style(), "old");
  EXPECT_FLOAT_EQ(seen[2].set().mix(0).weight(), 1.0F);
  EXPECT_FLOAT_EQ(seen[2].set().strength(), 0.5F);
  EXPECT_FALSE(seen[2].set().has_absolute()) << "what is absent stays";
  EXPECT_EQ(seen[3].preset().name(), "scene");
  EXPECT_TRUE(seen[4].pin().pinned());
  EXPECT_TRUE(seen[5].has_reset());
  EXPECT_TRUE(seen[6].set().clear());
  EXPECT_EQ(seen[6].performer(), "*");
  EXPECT_TRUE(seen[7].has_panic());
  for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_EQ(seen[i].id(), seen[i - 1].id() + 1);
}

TEST(ControlTest, ARefusalGivesCodeAndReasonAndLeavesTheOutputAlone) {
  FakeDaemon daemon([](const v1::Request&) {
    v1::Reply reply;
    reply.set_code(v1::CODE_PINNED);
    reply.set_reason("rig.a is pinned");
    reply.add_applied();
    return reply;
  });
  auto control = Ask(daemon.control());
  Applied applied;
  const CallStatus status = control->Clear("rig.a", &applied);
  EXPECT_EQ(status.kind(), CallStatus::Kind::kRefused);
  EXPECT_EQ(status.code(), v1::CODE_PINNED);
  EXPECT_EQ(status.reason(), "rig.a is pinned");
  EXPECT_TRUE(applied.empty());
}

TEST(ControlTest, AMissingDaemonIsReportedAfterTheTimeoutWithTheEndpoint) {
  auto control = Ask("tcp://127.0.0.1:9", 100ms);
  const auto begin = std::chrono::steady_clock::now();
  const CallStatus status = control->Panic();
  EXPECT_EQ(status.kind(), CallStatus::Kind::kNoAnswer);
  EXPECT_NE(status.reason().find("tcp://127.0.0.1:9"), std::string::npos);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 2s);
}

TEST(ControlTest, ARequestThatTimedOutIsNotSentToALaterDaemon) {
  std::string endpoint;
  {
    const FakeDaemon once;
    endpoint = once.control();
  }
  auto control = Ask(endpoint, 100ms);
  EXPECT_EQ(control->Panic().kind(), CallStatus::Kind::kNoAnswer);
  std::atomic<int> panics = 0, lists = 0;
  FakeDaemon late(
      [&](const v1::Request& request) {
        ++(request.has_panic() ? panics : lists);
        return v1::Reply();
      },
      "tcp://127.0.0.1:*", endpoint);
  CallStatus status;
  for (int i = 0; i < 20; ++i) {
    status = control->List(nullptr);
    if (status.ok()) break;
  }
  EXPECT_TRUE(status.ok()) << status.reason();
  EXPECT_EQ(panics, 0);
  EXPECT_GE(lists, 1);
}

TEST(ControlTest, ALateReplyToAnEarlierCallIsNotTakenForThisOne) {
  std::atomic<int> calls = 0;
  FakeDaemon daemon([&calls](const v1::Request& request) {
    v1::Reply reply;
    if (++calls == 1) reply.set_id(request.id() - 1);
    return reply;
  });
  auto control = Ask(daemon.control(), 200ms);
  EXPECT_EQ(control->List(nullptr).kind(), CallStatus::Kind::kNoAnswer);
  EXPECT_TRUE(control->List(nullptr).ok());
}

TEST(ControlTest, RefusesAnEndpointThatIsNone) {
  const auto control = Control::Connect({.endpoint = "localhost"});
  ASSERT_FALSE(control.ok());
  EXPECT_NE(control.status().message().find("localhost"), std::string::npos);
  EXPECT_FALSE(Control::Connect({.timeout = 0ms}).ok());
}

}  // namespace
}  // namespace styled::client

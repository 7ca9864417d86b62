#include "clients/cpp/asker.h"

#include <gtest/gtest.h>

#include <future>

#include "tests/unit/clients/fake_daemon.h"

namespace styled::client {
namespace {

using namespace std::chrono_literals;
using Kind = CallStatus::Kind;

// Answers everything but examples: a reply with another number is none.
FakeDaemon DaemonWithoutExamples() {
  return FakeDaemon([](const v1::Request& request) {
    v1::Reply reply;
    if (request.has_like()) reply.set_id(1);
    return reply;
  });
}

v1::Request TakeOf(float seconds) {
  v1::Request request;
  request.set_id(7);
  request.mutable_like()->set_learn_s(seconds);
  return request;
}

TEST(AskerTest, AnEndpointThatIsNoneIsRefused) { EXPECT_FALSE(Asker::Start("nonsense").ok()); }

TEST(AskerTest, LikeAndPreviewAreLongRequests) {
  v1::Request request;
  request.mutable_panic();
  EXPECT_FALSE(IsLong(request));
  request.mutable_like();
  EXPECT_TRUE(IsLong(request));
  request.mutable_preview();
  EXPECT_TRUE(IsLong(request));
}

TEST(AskerTest, PanicDoesNotWaitForTakes) {
  FakeDaemon daemon = DaemonWithoutExamples();
  auto asker = Asker::Start(daemon.control());
  ASSERT_TRUE(asker.ok());
  for (int i = 0; i < 6; ++i) {
    ASSERT_TRUE(asker.value()->Ask(TakeOf(60), [](const CallStatus&, const v1::Reply&) {}));
  }
  v1::Request panic;
  panic.set_id(8);
  panic.mutable_panic();
  std::promise<std::pair<Kind, std::uint64_t>> answered;
  ASSERT_TRUE(asker.value()->Ask(panic, [&](const CallStatus& status, const v1::Reply& reply) {
    answered.set_value({status.kind(), reply.id()});
  }));
  auto answer = answered.get_future();
  ASSERT_EQ(answer.wait_for(1500ms), std::future_status::ready);
  EXPECT_EQ(answer.get(), std::make_pair(Kind::kOk, std::uint64_t{8}));
}

TEST(AskerTest, TheEndDoesNotWaitForATake) {
  FakeDaemon daemon = DaemonWithoutExamples();
  std::promise<Kind> ended;
  auto asker = Asker::Start(daemon.control());
  ASSERT_TRUE(asker.ok());
  ASSERT_TRUE(asker.value()->Ask(TakeOf(60), [&](const CallStatus& status, const v1::Reply&) {
    ended.set_value(status.kind());
  }));
  std::this_thread::sleep_for(200ms);  // it is on its way, not waiting
  const auto begun = std::chrono::steady_clock::now();
  asker.value().reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begun, 5s);
  EXPECT_EQ(ended.get_future().get(), Kind::kNoAnswer);
}

}  // namespace
}  // namespace styled::client

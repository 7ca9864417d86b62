#include "clients/rec/steering.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/clients/fake_daemon.h"
#include "tests/unit/rec/fakes.h"

namespace styled::rec {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

recording::Record Command(const std::string& performer) {
  recording::Record record;
  record.mutable_command()->mutable_request()->set_performer(performer);
  record.mutable_command()->mutable_request()->mutable_reset();
  return record;
}

// A daemon that has received so many datagrams, and a few more with each look.
class SteeringTest : public ::testing::Test {
 protected:
  styled::v1::Reply Answer(const styled::v1::Request& request) {
    styled::v1::Reply reply;
    if (request.has_status()) {
      ++looks_;
      received_ = std::min(received_ + per_look_, most_);
      auto& counter = *reply.mutable_status()->mutable_stats()->add_counters();
      counter.set_name("source.received");
      counter.set_value(received_);
      return reply;
    }
    commands_.push_back(request.performer() + " after " + std::to_string(received_));
    if (request.performer() == "rig.unknown") {
      reply.set_code(styled::v1::CODE_UNKNOWN_PERFORMER);
      reply.set_reason("was not seen yet");
    }
    return reply;
  }

  std::uint64_t received_ = 1000, per_look_ = 0, most_ = 1000;
  int looks_ = 0;
  std::vector<std::string> commands_;
  client::FakeDaemon daemon_{
      [this](const styled::v1::Request& request) { return Answer(request); }};
  player::SteadyClock clock_;
};

TEST_F(SteeringTest, NoEndpointAndNobodyThereAreErrors) {
  EXPECT_THAT(Steering::Connect("nonsense", clock_).status().message(), HasSubstr("nonsense"));
  EXPECT_THAT(Steering::Connect("ipc:///tmp/styled-nobody-listens", clock_).status().message(),
              HasSubstr("no daemon answers"));
}

TEST_F(SteeringTest, ACommandWaitsForWhatWasSentBeforeIt) {
  auto steering = Steering::Connect(daemon_.control(), clock_);
  ASSERT_TRUE(steering.ok()) << steering.status().message();
  per_look_ = 3;
  most_ = 1010;
  for (int i = 0; i < 10; ++i) steering.value()->BeforeSending();
  ASSERT_TRUE(steering.value()->Play(Command("rig.a")).ok());
  daemon_.Synchronize();
  EXPECT_THAT(commands_, ElementsAre("rig.a after 1010"));
  EXPECT_EQ(steering.value()->commands(), 1U);
}

TEST_F(SteeringTest, OtherRecordsAskNothing) {
  auto steering = Steering::Connect(daemon_.control(), clock_);
  ASSERT_TRUE(steering.ok());
  const int looks = looks_;
  ASSERT_TRUE(steering.value()->Play(testing::Arrival(0, "x")).ok());
  daemon_.Synchronize();
  EXPECT_EQ(looks_, looks);
  EXPECT_TRUE(commands_.empty());
}

TEST_F(SteeringTest, ManyDatagramsWaitForADaemonThatFallsBehind) {
  auto steering = Steering::Connect(daemon_.control(), clock_);
  ASSERT_TRUE(steering.ok());
  per_look_ = 10;
  most_ = 2000;
  for (std::uint64_t sent = 0; sent < 500; ++sent) {
    steering.value()->BeforeSending();
    daemon_.Synchronize();
    EXPECT_LE(sent + 1, received_ - 1000 + 64 + 1);
  }
}

TEST_F(SteeringTest, ADaemonThatCountsInAnotherWayIsTakenToHaveCaughtUpWhenItStandsStill) {
  auto steering = Steering::Connect(daemon_.control(), clock_);
  ASSERT_TRUE(steering.ok());
  per_look_ = 5;
  most_ = 1003;  // of ten that were sent: it lost some
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 10; ++i) steering.value()->BeforeSending();
    ASSERT_TRUE(steering.value()->Play(Command("rig.a")).ok());
    daemon_.Synchronize();
    most_ += round == 0 ? 10 : 25;  // then none, then more than were sent
  }
  EXPECT_THAT(commands_, ElementsAre("rig.a after 1003", "rig.a after 1013", "rig.a after 1038"));
}

TEST_F(SteeringTest, WhatTheDaemonRefusesIsSaidAndTheRestGoesOn) {
  auto steering = Steering::Connect(daemon_.control(), clock_);
  ASSERT_TRUE(steering.ok());
  EXPECT_TRUE(steering.value()->Play(Command("rig.unknown")).ok());
  EXPECT_TRUE(steering.value()->Play(Command("rig.a")).ok());
  ASSERT_EQ(steering.value()->refused().size(), 1U);
  EXPECT_THAT(steering.value()->refused()[0], HasSubstr("rig.unknown"));
  EXPECT_THAT(steering.value()->refused()[0], HasSubstr("was not seen yet"));
}

TEST_F(SteeringTest, CommandsBeforeThePartThatIsPlayedAreGiven) {
  auto steering = Steering::Connect(daemon_.control(), clock_);
  ASSERT_TRUE(steering.ok());
  steering.value()->Note(Command("rig.a"));
  daemon_.Synchronize();
  EXPECT_EQ(commands_.size(), 1U);
}

}  // namespace
}  // namespace styled::rec

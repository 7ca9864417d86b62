// `stylenats --join` at the shipped hub: what programs on the viewer's machine read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <iostream>
#include <map>

#include "tests/e2e/nats/stage.h"

namespace styled::support {
namespace {

using testing::HasSubstr;

constexpr const char* kRigTopic = "styled/rig.a/rig/";
constexpr const char* kCanonicalTopic = "styled/rig.a/canonical/";

// A daemon whose site "hall" is on the hub, and the other end of it for the user `user`.
class JoinTest : public OnNatsServers {
 protected:
  void SetUp() override {
    OnNatsServers::SetUp();
    if (IsSkipped()) return;
    bridge_ = std::make_unique<Stylenats>(daemon_, servers_.leaf_port);
  }
  void Join(const std::string& user, const std::string& site = "hall") {
    join_ = std::make_unique<Stylenats>(user, servers_.hub_port, publish_, control_,
                                        std::vector<std::string>{"--join"}, site);
  }
  std::string Log() const { return bridge_->Log() + join_->Log() + servers_.Log(); }

  Daemon daemon_;
  TemporaryFolder folder_;
  const std::string publish_ = "ipc://" + (folder_ / "publish"),
                    control_ = "ipc://" + (folder_ / "control");
  std::unique_ptr<Stylenats> bridge_, join_;
};

// By sequence.
std::map<std::uint64_t, std::string> FramesOf(const Subscriber& subscriber,
                                              const std::string& topic) {
  std::map<std::uint64_t, std::string> frames;
  for (const Message& message : subscriber.Messages(topic)) {
    v1::Frame frame;
    EXPECT_TRUE(frame.ParseFromString(message.payload));
    EXPECT_TRUE(frames.emplace(frame.sequence(), message.payload).second) << "twice";
  }
  return frames;
}

TEST_F(JoinTest, ProgramsReadTheSiteAsTheyReadADaemon) {
  Join("viewer");
  const Subscriber sent(daemon_.publish, {"styled/", "body/"});
  const Subscriber read(publish_, {"body/", kRigTopic, "stats/"});
  const Walker walker(daemon_);
  ASSERT_TRUE(read.WaitForFrames(240, kRigTopic, 30)) << Log();
  Sleep(0.3);
  const auto original = FramesOf(sent, kRigTopic);
  std::size_t compared = 0;
  const auto frames = FramesOf(read, kRigTopic);
  for (const auto& [sequence, bytes] : frames) {
    const auto same = original.find(sequence);
    if (same == original.end()) continue;  // the witness has its own socket
    ASSERT_EQ(bytes, same->second) << "the daemon's bytes";
    ++compared;
  }
  EXPECT_GE(compared, 230U);
  EXPECT_EQ(read.Count(kCanonicalTopic), 0U) << "nobody asked for it";
  EXPECT_EQ(join_->Count("passed of 1 subjects"), static_cast<long>(join_->Count("passed of")))
      << join_->Counters();
  // A frame's body is there, and is the daemon's.
  const auto bodies = read.Bodies();
  ASSERT_FALSE(bodies.empty()) << Log();
  v1::Frame frame;
  ASSERT_TRUE(frame.ParseFromString(frames.rbegin()->second));
  EXPECT_TRUE(std::any_of(bodies.begin(), bodies.end(), [&frame](const v1::Body& body) {
    return body.hash() == frame.body_hash() && body.performer() == "rig.a";
  }));
  ASSERT_TRUE(read.WaitFor([&read] { return read.LastStats().has_value(); }, 5)) << Log();
  EXPECT_EQ(read.LastStats()->performers(0).performer(), "rig.a");
  EXPECT_TRUE(read.LastStats()->performers(0).live());
  std::cout << join_->Counters() << "\n";
}

TEST_F(JoinTest, WhoComesLateHasTheBodyAtOnceAndWhatNobodyReadsDoesNotCome) {
  Join("viewer");
  const Walker walker(daemon_);
  {
    const Subscriber first(publish_, {"body/", kRigTopic});
    ASSERT_TRUE(first.WaitForFrames(20, kRigTopic, 30)) << Log();
  }
  ASSERT_TRUE(WaitUntil([this] { return join_->Count("passed of 0 subjects") > 0; }, 5))
      << join_->Counters();
  const Subscriber late(publish_, {"body/rig.a/", kCanonicalTopic});
  ASSERT_TRUE(late.WaitForBody(0.9)) << "before the next second's repetition";
  EXPECT_TRUE(late.WaitForFrames(20, kCanonicalTopic)) << Log();
  // A second subscriber to a topic does not wait for the repetition, either: the repetition would
  // be in time for 3 of 10.
  int at_once = 0;
  for (int i = 0; i < 10; ++i) {
    const Subscriber second(publish_, {"body/rig.a/"});
    at_once += second.WaitForBody(0.3) ? 1 : 0;
    Sleep(0.05);
  }
  EXPECT_GE(at_once, 7) << Log();
}

TEST_F(JoinTest, CommandsGoToTheSiteAndAnswersComeBack) {
  Join("operator");
  const Walker walker(daemon_);
  ControlClient control(control_);
  ASSERT_TRUE(join_->WaitForLog("connected to")) << Log();
  ASSERT_TRUE(WaitUntil([&control] { return control.Status().stats().performers_size() > 0; }, 20))
      << Log();
  const v1::Reply set = control.SetStyle("rig.a", "style1");
  EXPECT_EQ(set.code(), v1::CODE_OK) << set.reason();
  EXPECT_GT(set.applied(0).first_sequence(), 0U);
  EXPECT_EQ(ControlClient(daemon_.control).Performer("rig.a").look().mix(0).style(), "style1");
  EXPECT_EQ(control.SetStyle("rig.a", "nosuch").code(), v1::CODE_UNKNOWN_STYLE)
      << "the daemon's refusal";
  v1::Request large;
  large.mutable_import_style()->set_file(std::string(2'000'000, 'x'));
  const v1::Reply refused = control.Ask(large);
  EXPECT_EQ(refused.code(), v1::CODE_TOO_LARGE);
  EXPECT_THAT(refused.reason(), HasSubstr("max_payload"));
}

TEST_F(JoinTest, ASiteThatNobodyServesIsToldAtOnce) {
  Join("operator", "hal");
  ASSERT_TRUE(join_->WaitForLog("connected to")) << Log();
  const v1::Reply reply = ControlClient(control_).SetStyle("rig.a", "style1");
  EXPECT_EQ(reply.code(), v1::CODE_BUSY);
  EXPECT_THAT(reply.reason(), HasSubstr("no reply from styledctl.hal"));
}

TEST_F(JoinTest, AHubThatIsKilledAndStartedAgainBringsFramesAndBodiesBack) {
  Join("viewer");
  const Walker walker(daemon_);
  const Subscriber read(publish_, {"body/", kRigTopic});
  ASSERT_TRUE(read.WaitForFrames(60, kRigTopic, 30)) << Log();
  servers_.hub->Signal(SIGKILL);
  servers_.hub->Wait(5);
  ASSERT_TRUE(join_->WaitForLog("lost the broker")) << join_->Log();
  servers_.StartHub();
  const std::size_t before = read.Count(kRigTopic);
  ASSERT_TRUE(read.WaitForFrames(before + 60, kRigTopic, 20)) << Log();
  (void)FramesOf(read, kRigTopic);  // none twice
  const Subscriber late(publish_, {"body/"});
  EXPECT_TRUE(late.WaitForBody(15)) << "of the bucket, which was empty\n" << Log();
}

TEST_F(JoinTest, AViewersMachineIsNotOpenToOthers) {
  const Stylenats open("viewer", servers_.hub_port, "tcp://0.0.0.0:7001", control_, {"--join"});
  EXPECT_EQ(open.child->Wait(5).value_or(-1), 2);
  EXPECT_THAT(open.Log(), HasSubstr("--publish tcp://0.0.0.0:7001: expected tcp://127.0.0.1"));
  const Stylenats odd("viewer", servers_.hub_port, "tcp://127.0.0.1:99999", control_, {"--join"});
  EXPECT_EQ(odd.child->Wait(5).value_or(-1), 2);
  EXPECT_THAT(odd.Log(), HasSubstr("port 99999: expected 1 to 65535"));
  const Stylenats twice("viewer", servers_.hub_port, daemon_.publish, control_, {"--join"});
  EXPECT_EQ(twice.child->Wait(5).value_or(-1), 2);
  EXPECT_THAT(twice.Log(), HasSubstr("Address already in use; does a daemon run there?"));
}

}  // namespace
}  // namespace styled::support

// A performer is moved from one real daemon to another, as `stylectl checkpoint` does it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <map>
#include <sstream>

#include "clients/stylectl/cli.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

using testing::HasSubstr;

class CheckpointTest : public testing::Test {
 protected:
  // Rig frames by their source time.
  static std::map<std::uint64_t, v1::Frame> ByTime(const Subscriber& subscriber) {
    std::map<std::uint64_t, v1::Frame> frames;
    for (const v1::Frame& frame : subscriber.Frames("styled/")) {
      frames[frame.source_time_ns()] = frame;
    }
    return frames;
  }
  int Stylectl(const Daemon& daemon, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--endpoint", daemon.control});
    std::ostringstream out, err;
    const int code = stylectl::Run(std::move(arguments), out, err);
    output_ = out.str() + err.str();
    return code;
  }
  static std::vector<std::string> Topics() { return {"body/rig.a/", "styled/rig.a/rig/"}; }

  TemporaryFolder folder_;
  const std::string file_ = folder_ / "a.checkpoint";
  Daemon whole_, first_, second_;
  Rig rig_{"a"};
  std::string output_;
};

// The rig sends to the first daemon, and after the move to the second one; a third gets all of it.
TEST_F(CheckpointTest, NoFrameIsLostByAMoveAndNoneIsAnother) {
  Subscriber whole(whole_.publish, Topics()), first(first_.publish, Topics()),
      second(second_.publish, Topics());
  const UdpLink to_whole(whole_.udp), to_first(first_.udp), to_second(second_.udp);
  ControlClient control_whole(whole_.control), control_first(first_.control);
  const Bytes body = rig_.Body();
  to_whole.Send(body);
  to_first.Send(body);
  ASSERT_TRUE(whole.WaitForBody());
  ASSERT_TRUE(first.WaitForBody());
  constexpr int kFrames = 240, kMove = 130;
  for (int i = 0; i < kFrames; ++i) {
    const Bytes frame = rig_.Frame();
    to_whole.Send(frame);
    (i < kMove ? to_first : to_second).Send(frame);
    const auto so_many = static_cast<std::size_t>(i) + 1;
    ASSERT_TRUE(whole.WaitForFrames(so_many, "styled/"));
    if (i < kMove) ASSERT_TRUE(first.WaitForFrames(so_many, "styled/"));
    if (i == 100) {  // the fade is under way when they move
      for (ControlClient* const control : {&control_whole, &control_first}) {
        ASSERT_EQ(control->SetStyle("rig.a", "style2", 0.8F, 500).code(), v1::CODE_OK);
      }
    }
    if (i == kMove - 1) {
      ASSERT_EQ(Stylectl(first_, {"checkpoint", "take", "rig.a", file_}), 0) << output_;
      EXPECT_THAT(output_, HasSubstr("rig.a before frame 131: written to " + file_));
      ASSERT_EQ(Stylectl(second_, {"checkpoint", "restore", file_}), 0) << output_;
      EXPECT_EQ(output_, "rig.a: restored from frame 131 on\n");
      ASSERT_TRUE(second.WaitForBody()) << "subscribers there have the body before the first frame";
    }
  }
  ASSERT_TRUE(second.WaitForFrames(kFrames - kMove, "styled/")) << second_.Log();
  const auto expected = ByTime(whole);
  auto moved = ByTime(first);
  for (const auto& [time_ns, frame] : ByTime(second)) {
    EXPECT_FALSE(moved.contains(time_ns));
    moved[time_ns] = frame;
  }
  ASSERT_EQ(moved.size(), expected.size());
  ASSERT_EQ(expected.size(), kFrames);
  std::uint64_t sequence = 0;
  for (const auto& [time_ns, frame] : expected) {
    ASSERT_TRUE(moved.contains(time_ns));
    v1::Frame clear = moved[time_ns], wanted = frame;
    EXPECT_EQ(clear.sequence(), ++sequence);
    for (v1::Frame* const one : {&clear, &wanted}) {
      one->set_flags(one->flags() & ~std::uint32_t{v1::FLAG_LATE});  // on a busy machine
      one->clear_epoch();
      one->clear_receive_time_ns();
      one->clear_publish_time_ns();
      one->clear_wall_time_ns();
    }
    ASSERT_TRUE(clear.SerializeAsString() == wanted.SerializeAsString())
        << sequence << ": flags " << clear.flags() << ", expected " << wanted.flags();
  }
}

TEST_F(CheckpointTest, AKilledDaemonGoesOnFromIt) {
  Subscriber before(first_.publish, Topics());
  UdpLink(first_.udp).Send(rig_.Body());
  ASSERT_TRUE(before.WaitForBody());
  ControlClient(first_.control).SetStyle("rig.a", "style3", 1, 0);
  for (int i = 0; i < 60; ++i) UdpLink(first_.udp).Send(rig_.Frame());
  ASSERT_TRUE(before.WaitForFrames(60, "styled/"));
  ASSERT_EQ(Stylectl(first_, {"checkpoint", "take", "rig.a", file_}), 0) << output_;
  kill(first_.child->pid(), SIGKILL);
  (void)first_.child->Wait(5);
  first_.Start();
  Subscriber after(first_.publish, Topics());
  ASSERT_EQ(Stylectl(first_, {"checkpoint", "restore", file_}), 0) << output_;
  ASSERT_TRUE(after.WaitForBody());
  UdpLink(first_.udp).Send(rig_.Frame());
  ASSERT_TRUE(after.WaitForFrames(1, "styled/")) << "without the rig's body";
  const v1::Frame frame = after.Frames("styled/").front();
  EXPECT_EQ(frame.sequence(), 61U);
  EXPECT_EQ(frame.flags() & (v1::FLAG_NEW_SESSION | v1::FLAG_BYPASS), 0U);
  ASSERT_EQ(frame.styles_size(), 1);
  EXPECT_EQ(frame.styles(0).style(), "style3");
}

TEST_F(CheckpointTest, WhatATypistGetsWrong) {
  Subscriber subscriber(first_.publish, Topics());
  EXPECT_EQ(Stylectl(first_, {"checkpoint", "take", "rig.a", file_}), stylectl::kExitRefused);
  EXPECT_THAT(output_, HasSubstr("performer \"rig.a\": expected one that is here"));
  UdpLink(first_.udp).Send(rig_.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  ASSERT_EQ(Stylectl(first_, {"checkpoint", "take", "rig.a", file_, "--json"}), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("\"sequence\":1"));
  EXPECT_EQ(Stylectl(first_, {"checkpoint", "take", "rig.a", file_}), stylectl::kExitUsage);
  EXPECT_THAT(output_, HasSubstr("exists, expected a new file; --overwrite replaces it"));
  EXPECT_EQ(Stylectl(first_, {"checkpoint", "take", "rig.a", file_, "--overwrite"}), 0) << output_;
  EXPECT_EQ(Stylectl(first_, {"checkpoint", "restore", folder_ / "none"}), stylectl::kExitUsage);
  EXPECT_THAT(output_, HasSubstr("none"));
  WriteText(folder_ / "text", "no checkpoint");
  EXPECT_EQ(Stylectl(first_, {"checkpoint", "restore", folder_ / "text"}), stylectl::kExitUsage);
  EXPECT_THAT(output_, HasSubstr("not a checkpoint, expected a file of stylectl checkpoint take"));
  EXPECT_EQ(Stylectl(first_, {"checkpoint", "restore", file_, "usb.a"}), stylectl::kExitRefused);
  EXPECT_THAT(output_, HasSubstr("expected SOURCE.NAME with a source of this daemon"));
  EXPECT_EQ(Stylectl(first_, {"checkpoint"}), stylectl::kExitUsage);
}

TEST_F(CheckpointTest, OtherWeightsAreNamed) {
  Subscriber subscriber(first_.publish, Topics());
  UdpLink(first_.udp).Send(rig_.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  ASSERT_EQ(Stylectl(first_, {"checkpoint", "take", "rig.a", file_}), 0) << output_;
  const std::string weights = folder_ / "other.safetensors";
  WriteRandomWeights(weights, 5, 2);
  const Daemon other({}, "", {}, weights);
  EXPECT_EQ(Stylectl(other, {"checkpoint", "restore", file_}), stylectl::kExitRefused);
  EXPECT_THAT(output_, HasSubstr("expected the contents of weights.safetensors"));
}

}  // namespace
}  // namespace styled::support

// A field problem becomes a test: a recording played into a fresh daemon gives bit-identical styled
// frames, at any speed.
#include <gtest/gtest.h>
#include <signal.h>

#include "proto/recording/writer.h"
#include "tests/e2e/recordings/fixture.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

// A recording of a subscriber: source frames become a rig's datagrams again.
TEST_F(RecordingsTest, WhatWasPublishedIsStyledAgainBitForBitAtItsOwnSpeedAndFlatOut) {
  const std::string file = RecordPublished("loss=0.02,nan=0.02,seed=3", "4");
  std::vector<v1::Frame> frames;
  for (const Record& record : ReadAll(file)) {
    if (record.published().topic() != kStyled) continue;
    frames.emplace_back();
    ASSERT_TRUE(frames.back().ParseFromString(record.published().payload()));
  }
  const auto expected = Digests(frames);
  ASSERT_GT(expected.size(), 400U);
  ASSERT_NE(expected.back().styles, "") << "styled at all";
  EXPECT_TRUE(std::any_of(expected.begin(), expected.end(), [](const Styled& styled) {
    return (styled.flags & v1::FLAG_HELD) != 0;
  })) << "with joints that were held";
  ExpectSame(Replay(file, expected.size(), false), expected, "at its own speed");
  ExpectSame(Replay(file, expected.size(), true), expected, "flat out");
  ExpectSame(Replay(file, expected.size(), true), expected, "flat out again");
  // Negative control: another style must give other poses.
  const auto other = Replay(file, expected.size(), true, nullptr, "style3");
  ASSERT_EQ(other.size(), expected.size());
  EXPECT_NE(other.back().pose, expected.back().pose);
}

// A recording of datagrams, with every fault.
TEST_F(RecordingsTest, WhatArrivedIsStyledAgainBitForBitAtItsOwnSpeedAndFlatOut) {
  const std::string file = folder_ / "arrivals.styrec";
  std::vector<Styled> expected;
  std::uint64_t lost = 0;
  {
    const auto daemon = MakeDaemon();
    const Subscriber subscriber(daemon->publish, {"styled/", "body/"});
    ControlClient control(daemon->control);
    ASSERT_EQ(control.CounterSoon("publish.subscriptions", 2), 2U);
    const auto recorder =
        Start({"receive", "--listen", "udp://127.0.0.1:0", "--forward", daemon->udp, file},
              "receive.txt");
    const std::string bound = Bound("receive.txt", "listening on ");
    ASSERT_NE(bound, "");
    Simulate(bound,
             "loss=0.01,duplicate=0.02,reorder=0.02,corrupt=0.02,truncate=0.01,nan=0.01,late=0.01,"
             "late-ms=20,restart=0.004,restart-pause-ms=400,seed=8",
             "5");
    Stop(*recorder);
    ASSERT_GT(control.Counter("pipeline.sessions"), 1U) << "the sender restarted";
    std::uint64_t received = 0;
    for (const Record& record : ReadAll(file)) received += record.has_arrival() ? 1 : 0;
    ASSERT_EQ(control.CounterSoon("source.received", received), received);
    const auto frames = control.Counter("pipeline.frames");
    ASSERT_TRUE(subscriber.WaitForFrames(frames, kStyled));
    expected = Digests(subscriber.Frames(kStyled));
    lost = control.Counter("pipeline.lost");
  }
  ASSERT_GT(expected.size(), 300U);
  std::uint64_t replay_lost = 0;
  ExpectSame(Replay(file, expected.size(), false, &replay_lost), expected, "at its own speed");
  EXPECT_EQ(replay_lost, lost);
  ExpectSame(Replay(file, expected.size(), true, &replay_lost), expected, "flat out");
  EXPECT_EQ(replay_lost, lost);
}

// A recording made by the daemon: commands are between the arrivals where they took effect.
TEST_F(RecordingsTest, CommandsFallOnTheSameFrameAgain) {
  const std::string file = folder_ / "commands.styrec";
  {
    auto writer = recording::FileWriter::Create(file, {});
    ASSERT_TRUE(writer.ok());
    const auto add = [&](Record& record, int i) {
      record.set_time_ns(i * 8'333'333LL);
      ASSERT_TRUE(writer.value()->Add(record, record.time_ns()).ok());
    };
    Rig rig("sim");
    for (int i = 0; i < 360; ++i) {
      for (const bool body : {true, false}) {
        if (body && i % 120 != 0) continue;
        const Bytes bytes = body ? rig.Body() : rig.Frame();
        Record record;
        record.mutable_arrival()->set_source("rig");
        record.mutable_arrival()->set_datagram(bytes.data(), bytes.size());
        add(record, i);
      }
      if (i != 150 && i != 250) continue;
      Record record;
      auto& request = *record.mutable_command()->mutable_request();
      request.set_performer(kId);
      if (i == 150) {
        request.mutable_set()->add_mix()->set_style("style3");
        request.mutable_set()->mutable_mix(0)->set_weight(1);
        request.mutable_set()->set_transition_ms(100);
      } else {
        request.mutable_panic();
      }
      add(record, i);
    }
    ASSERT_TRUE(writer.value()->Flush().ok());
  }
  const auto first = Replay(file, 360, true);
  ASSERT_EQ(first.size(), 360U);
  const auto wears_it = [&](std::size_t i) {
    return first[i].styles.find("style3") != std::string::npos;
  };
  // The commands follow frames 150 and 250; the second one also fades for 100 ms.
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (i > 250 && i <= 264) continue;
    EXPECT_EQ(wears_it(i), i > 150 && i <= 250) << i;
  }
  ExpectSame(Replay(file, 360, true), first, "again");
}

TEST_F(RecordingsTest, SubscribersOfARecordingGetWhatSubscribersGot) {
  const std::string file = RecordPublished("", "1");
  std::vector<Message> expected;
  for (const Record& record : ReadAll(file)) {
    expected.push_back({record.published().topic(), record.published().payload()});
  }
  const auto player = Start({"play", file, "--publish", "tcp://127.0.0.1:*", "--wait", "20",
                             "--speed", "max", "--as-recorded"},
                            "play.txt");
  const std::string bound = Bound("play.txt", "publishing on ");
  ASSERT_NE(bound, "");
  const Subscriber subscriber(bound, {""});
  EXPECT_EQ(player->Wait(30).value_or(-1), 0) << ReadText(folder_ / "play.txt");
  std::vector<v1::Frame> frames;
  for (const auto& message : expected) {
    if (message.topic.starts_with("body/") || message.topic == "stats/") continue;
    frames.emplace_back();
    ASSERT_TRUE(frames.back().ParseFromString(message.payload));
  }
  ASSERT_TRUE(subscriber.WaitForFrames(frames.size()));
  const auto found = subscriber.Frames();
  ASSERT_EQ(found.size(), frames.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].SerializeAsString(), frames[i].SerializeAsString()) << i;
  }
  EXPECT_GE(subscriber.Bodies().size(), 2U);
}

// Each repetition has a new epoch: a subscriber that drops known frames shows all of them.
TEST_F(RecordingsTest, ALoopIsNewToADaemonAndToSubscribersEachTime) {
  const std::string file = RecordPublished("", "1");
  const auto daemon = MakeDaemon();
  ControlClient control(daemon->control);
  const auto player = Start({"play", file, "--to", "udp://" + daemon->udp, "--publish",
                             "tcp://127.0.0.1:*", "--loop", "--speed", "4"},
                            "play.txt");
  const std::string bound = Bound("play.txt", "publishing on ");
  const Subscriber subscriber(bound, {kStyled, "body/"});
  ASSERT_TRUE(subscriber.WaitFor(
      [&] {
        std::set<std::uint64_t> epochs;
        for (const auto& frame : subscriber.Frames(kStyled)) epochs.insert(frame.epoch());
        return epochs.size() >= 3;
      },
      30));
  ASSERT_TRUE(subscriber.WaitFor([&] { return control.Counter("pipeline.sessions") >= 3; }, 30))
      << daemon->Log();
  Stop(*player);
  EXPECT_EQ(control.Counter("pipeline.second_sender"), 0U);
  EXPECT_EQ(control.Counter("pipeline.reordered"), 0U);
}

TEST_F(RecordingsTest, ARecorderThatIsKilledLeavesAFileThatPlays) {
  const auto daemon = MakeDaemon();
  const std::string file = folder_ / "killed.styrec";
  const auto recorder = Start({"record", "--from", daemon->publish, file}, "record.txt");
  ControlClient control(daemon->control);
  ASSERT_EQ(control.CounterSoon("publish.subscriptions", 4), 4U);
  Simulate("udp://" + daemon->udp, "", "1");
  recorder->Signal(SIGKILL);
  EXPECT_EQ(recorder->Wait(10).value_or(-1), 128 + SIGKILL);
  std::size_t frames =
      0;  // what the rig sent; its styled twin may lie on the other side of the cut
  for (const Record& record : ReadAll(file)) {
    frames += record.published().topic() == "source/rig.sim/" ? 1 : 0;
  }
  EXPECT_GT(frames, 90U) << "at most the last 100 ms are missing";
  EXPECT_EQ(Replay(file, frames, true).size(), frames);
}

TEST_F(RecordingsTest, BadArgumentsEndWithTwoAndBadFilesWithOne) {
  for (const std::vector<std::string>& wrong :
       std::vector<std::vector<std::string>>{{},
                                             {"rewind"},
                                             {"play"},
                                             {"play", "x.styrec"},
                                             {"export", "x.styrec", "--performer", "rig.sim"},
                                             {"record", "--performer", "nobody", "x.styrec"},
                                             {"receive", "x.styrec"}}) {
    EXPECT_EQ(Run(wrong), 2) << testing::PrintToString(wrong);
    EXPECT_NE(output_, "");
  }
  const std::string file = folder_ / "text.styrec";
  WriteText(file, "no recording at all");
  EXPECT_EQ(Run({"info", file}), 1);
  EXPECT_NE(output_.find(file + ": offset 0: found 6E 6F"), std::string::npos) << output_;
  EXPECT_EQ(Run({"record", file}), 1);
  EXPECT_NE(output_.find("exists already"), std::string::npos) << output_;
  EXPECT_EQ(ReadText(file), "no recording at all");
}

}  // namespace
}  // namespace styled::support

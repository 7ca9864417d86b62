// A show over a recording: cues fired by its timecode apply to the same frames in every run.
#include <array>
#include <cstdio>
#include <map>

#include "proto/recording/writer.h"
#include "tests/e2e/recordings/fixture.h"

namespace styled::support {
namespace {

constexpr int kRate = 120, kFrames = 60 * kRate;

// The sequences (of the rig's datagrams) of the frames whose set of styles differs from the
// previous frame's.
using Switches = std::vector<std::pair<std::uint64_t, std::string>>;

std::string Cue(const std::string& name, const std::string& at, const std::string& what) {
  return "[[cue]]\nname = \"" + name + "\"\nat = \"" + at + "\"\n" + what + "\n";
}

class CuesOverARecordingTest : public RecordingsTest {
 protected:
  // Records a minute of a rig with timecode from 01:00:00:00.
  std::string RecordAMinute() const {
    const std::string file = folder_ / "minute.styrec";
    const auto writer = recording::FileWriter::Create(file, recording::BeginningNow("test", "0"));
    EXPECT_TRUE(writer.ok()) << writer.status().message();
    Rig rig("sim");
    std::int64_t time_ns = 1'000'000'000;
    const auto add = [&](const Bytes& datagram) {
      recording::Record record;
      record.set_time_ns(time_ns);
      auto& arrival = *record.mutable_arrival();
      arrival.set_source("rig");
      arrival.set_type("udp");
      arrival.set_listen("udp://127.0.0.1:7000");
      arrival.set_peer("127.0.0.1:50000");
      arrival.set_datagram(datagram.data(), datagram.size());
      EXPECT_TRUE(writer.value()->Add(record, time_ns).ok());
    };
    add(rig.Body());
    for (int frame = 0; frame < kFrames; ++frame) {
      add(rig.Frame([frame](v1::SourceFrame& out) {
        auto& timecode = *out.mutable_timecode();
        timecode.set_hours(1);
        timecode.set_minutes(static_cast<unsigned>(frame / kRate / 60));
        timecode.set_seconds(static_cast<unsigned>(frame / kRate % 60));
        timecode.set_frames(static_cast<unsigned>(frame / 4 % 30));
        timecode.set_rate(30);
      }));
      time_ns += 1'000'000'000 / kRate;
    }
    EXPECT_TRUE(writer.value()->Flush().ok());
    return file;
  }

  // Plays the recording with stylerec into a new daemon as fast as it accepts it: source time
  // drives the cues.
  Switches Perform(const std::string& file, const std::string& cues) {
    const Daemon daemon({"performers.backlog_ms=10000"}, "[style]\ntransition_ms = 0\n" + cues);
    const Subscriber subscriber(daemon.publish, {"styled/", "body/"});
    ControlClient control(daemon.control);
    EXPECT_EQ(control.CounterSoon("publish.subscriptions", 2), 2U);
    EXPECT_EQ(Run({"play", file, "--to", "udp://" + daemon.udp, "--speed", "max", "--control",
                   daemon.control}),
              0)
        << output_;
    EXPECT_TRUE(subscriber.WaitForFrames(kFrames, kStyled)) << daemon.Log();
    EXPECT_EQ(control.Counter("pipeline.lost"), 0U);
    Switches switches;
    std::string last;
    for (const auto& frame : subscriber.Frames(kStyled)) {
      std::string styles;
      for (const auto& style : frame.styles()) styles += style.style() + " ";
      if (styles != last) switches.emplace_back(frame.source_sequence(), styles);
      last = styles;
    }
    return switches;
  }
};

TEST_F(CuesOverARecordingTest, TwentyOverAMinuteComeAtTheSameFramesOnEveryRun) {
  std::string cues;
  std::map<std::uint64_t, std::string> expected;  // source sequence, styles
  for (int i = 0; i < 20; ++i) {
    const std::string style = "style" + std::to_string(1 + i % 4);
    const int second = 2 + 2 * i, frame = i;
    std::array<char, 16> at{};
    std::snprintf(at.data(), at.size(), "01:00:%02d:%02d", second, frame);
    cues += Cue("c" + std::to_string(i), at.data(), "style = \"" + style + "\"");
    // Each of the 30 timecodes of a second is on four frames; the body precedes them.
    expected[static_cast<std::uint64_t>(second * kRate + frame * 4) + 1] = style + " ";
  }
  cues += Cue("not-hers", "01:00:01:00", "performer = \"rig.berta\"\npanic = true");
  const std::string file = RecordAMinute();
  const auto range = Reader::Open(file).value()->FindTimeRange();
  EXPECT_NEAR(static_cast<double>(range.last_ns - range.first_ns) * 1e-9, 60, 0.01);
  const Switches first = Perform(file, cues);
  EXPECT_EQ(first, Switches(expected.begin(), expected.end()));
  EXPECT_EQ(Perform(file, cues), first);
}

}  // namespace
}  // namespace styled::support

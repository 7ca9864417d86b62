// The daemon's own recording, [record] in styled.toml: the recorded datagrams and commands, played
// into another daemon, give the same output; and a failing disk affects no frame.
#include <fcntl.h>
#include <sys/resource.h>

#include "daemon/log/recorder.h"
#include "tests/e2e/recordings/fixture.h"

namespace styled::support {
namespace {

constexpr const char* kStyledTcp = "styled/tcp.sim/rig/";

class DaemonRecordingTest : public RecordingsTest {
 protected:
  DaemonRecordingTest() : file_(folder_ / "take.styrec") {}

  std::unique_ptr<Daemon> Recording(std::vector<std::string> settings = {}) const {
    settings.push_back("record.file=" + file_);
    settings.push_back("performers.takeover_ms=10");
    return std::make_unique<Daemon>(settings);
  }
  // Runs stylesim for both sources at once.
  std::vector<std::unique_ptr<Child>> StartSims(const Daemon& daemon) const {
    const auto start = [&](const std::string& to, const std::string& faults) {
      return std::make_unique<Child>(
          std::vector<std::string>{StylesimBinary(), "--to", to, "--seconds", "4", "--script",
                                   "walk:2,wave-left:1,run:2", "--faults", faults},
          folder_ / "sim.txt");
    };
    std::vector<std::unique_ptr<Child>> sims;
    sims.push_back(start("udp://" + daemon.udp,
                         "loss=0.01,duplicate=0.02,reorder=0.02,corrupt=0.02,truncate=0.01,"
                         "nan=0.01,restart=0.004,restart-pause-ms=400,seed=8"));
    sims.push_back(start("tcp://" + daemon.tcp, "loss=0.02,nan=0.02,seed=5"));
    return sims;
  }
  struct Both {
    std::vector<Styled> udp, tcp;
  };
  // The output of the file in a daemon that has not seen it.
  Both PlayInto(const Both& expected, const std::string& speed) {
    const Daemon daemon({"performers.takeover_ms=10"});
    const Subscriber subscriber(daemon.publish, {"styled/", "body/"});
    ControlClient control(daemon.control);
    EXPECT_EQ(control.CounterSoon("publish.subscriptions", 2), 2U);
    EXPECT_EQ(Run({"play", file_, "--to", "rig=udp://" + daemon.udp, "--to",
                   "tcp=tcp://" + daemon.tcp, "--control", daemon.control, "--speed", speed}),
              0)
        << output_;
    EXPECT_EQ(output_.find("refused"), std::string::npos) << output_;
    EXPECT_TRUE(subscriber.WaitForFrames(expected.udp.size(), kStyled)) << daemon.Log();
    EXPECT_TRUE(subscriber.WaitForFrames(expected.tcp.size(), kStyledTcp)) << daemon.Log();
    return {Digests(subscriber.Frames(kStyled)), Digests(subscriber.Frames(kStyledTcp))};
  }

  std::string file_;
};

TEST_F(DaemonRecordingTest, IsStyledAgainBitForBitWithItsCommandsAtItsOwnSpeedAndFlatOut) {
  Both expected;
  std::uint64_t received = 0;
  {
    const auto daemon = Recording();
    const Subscriber subscriber(daemon->publish, {"styled/", "body/"});
    ControlClient control(daemon->control);
    ASSERT_EQ(control.CounterSoon("publish.subscriptions", 2), 2U);
    ASSERT_EQ(control.SetStyle("*", "style2", 0.9F, 300).code(), v1::CODE_OK);
    auto sims = StartSims(*daemon);
    ASSERT_TRUE(subscriber.WaitForFrames(150, kStyledTcp));
    ASSERT_EQ(control.SetStyle(kId, "style3", 1, 100).code(), v1::CODE_OK);
    ASSERT_NE(control.SetStyle(kId, "no such style").code(), v1::CODE_OK);
    ASSERT_TRUE(subscriber.WaitForFrames(250, kStyledTcp));
    ASSERT_EQ(control.SetStyle("tcp.sim", "style1", 1, 50).code(), v1::CODE_OK);
    for (auto& sim : sims) ASSERT_EQ(sim->Wait(60).value_or(-1), 0);
    // When the counter stops changing, everything sent has been received.
    std::uint64_t before = 1;
    while (received != before) {
      before = received;
      Sleep(0.2);
      received = control.Counter("source.received");
    }
    const auto frames = control.Counter("pipeline.frames");
    ASSERT_TRUE(
        subscriber.WaitFor([&] { return subscriber.Frames("styled/").size() >= frames; }, 10));
    EXPECT_GT(control.Counter("pipeline.sessions"), 2U) << "a sender restarted";
    EXPECT_EQ(control.Counter("record.on"), 1U);
    EXPECT_EQ(daemon->Stop(), 0);
    EXPECT_NE(daemon->Log().find("to " + file_ + ", 0 lost"), std::string::npos) << daemon->Log();
    expected = {Digests(subscriber.Frames(kStyled)), Digests(subscriber.Frames(kStyledTcp))};
  }
  ASSERT_GT(expected.udp.size(), 200U);
  ASSERT_GT(expected.tcp.size(), 400U);
  std::vector<std::uint64_t> first_sequences;
  std::uint64_t datagrams = 0;
  for (const Record& record : ReadAll(file_)) {
    if (record.has_arrival() && record.arrival().source() == "rig") ++datagrams;
    if (!record.has_command() || record.command().applied_size() == 0) continue;
    first_sequences.push_back(record.command().applied(0).first_sequence());
  }
  EXPECT_EQ(first_sequences.size(), 2U) << "the refused command, and the first, are not among them";
  EXPECT_GT(datagrams, expected.udp.size()) << "bodies and what was refused, too";
  for (const char* const speed : {"1", "max", "max"}) {
    const Both found = PlayInto(expected, speed);
    ExpectSame(found.udp, expected.udp, std::string("UDP, speed ") + speed);
    ExpectSame(found.tcp, expected.tcp, std::string("TCP, speed ") + speed);
  }
}

struct RigCase {
  std::string type, faults;
  std::string quirk = "";
  friend void PrintTo(const RigCase& rig, std::ostream* out) { *out << rig.type; }
};

// Rigs whose frames contain the rig's own clock, each frame in one datagram. For SlimeVR, and for
// VMC frames in several datagrams, the output depends on the daemon's clock: tests/golden plays
// these.
class RigRecordingTest : public DaemonRecordingTest, public testing::WithParamInterface<RigCase> {
 protected:
  std::string Source() const {
    return std::string("[[source]]\nname = \"suit\"\ntype = \"") + GetParam().type +
           "\"\nlisten = \"127.0.0.1:0\"\n";
  }
};

TEST_P(RigRecordingTest, IsStyledAgainBitForBitAtItsOwnSpeedAndFlatOut) {
  const std::string topic = "styled/suit.";
  const auto rig_frames = [&](const Subscriber& subscriber) {
    std::vector<v1::Frame> frames = subscriber.Frames(topic);
    std::erase_if(frames, [](const v1::Frame& f) { return f.output() != v1::OUTPUT_RIG; });
    return frames;
  };
  std::vector<Styled> expected;
  {
    const Daemon daemon({"record.file=" + file_, "style.initial=style2"}, Source());
    const Subscriber subscriber(daemon.publish, {topic, "body/"});
    ControlClient control(daemon.control);
    ASSERT_EQ(control.CounterSoon("publish.subscriptions", 2), 2U);
    std::vector<std::string> arguments{StylesimBinary(),
                                       "--as",
                                       GetParam().type,
                                       "--to",
                                       "udp://" + daemon.listens.at(2),
                                       "--rate",
                                       "60",
                                       "--seconds",
                                       "2",
                                       "--script",
                                       "walk:1,wave-left:1",
                                       "--faults",
                                       GetParam().faults};
    if (!GetParam().quirk.empty()) arguments.insert(arguments.end(), {"--quirk", GetParam().quirk});
    Child sim(arguments, folder_ / "sim.txt");
    ASSERT_EQ(sim.Wait(60).value_or(-1), 0) << ReadText(folder_ / "sim.txt");
    ASSERT_TRUE(subscriber.WaitFor(
        [&] { return rig_frames(subscriber).size() >= control.Counter("pipeline.frames"); }, 10));
    Sleep(0.2);
    expected = Digests(rig_frames(subscriber));
  }
  ASSERT_GT(expected.size(), 90U);
  ASSERT_NE(expected.back().styles, "");
  for (const char* const speed : {"1", "max"}) {
    const Daemon daemon({"style.initial=style2"}, Source());
    const Subscriber subscriber(daemon.publish, {topic, "body/"});
    ControlClient control(daemon.control);
    ASSERT_EQ(control.CounterSoon("publish.subscriptions", 2), 2U);
    ASSERT_EQ(Run({"play", file_, "--to", "suit=udp://" + daemon.listens.at(2), "--control",
                   daemon.control, "--speed", speed}),
              0)
        << output_;
    ASSERT_TRUE(
        subscriber.WaitFor([&] { return rig_frames(subscriber).size() >= expected.size(); }, 10))
        << rig_frames(subscriber).size() << " of " << expected.size() << daemon.Log();
    ExpectSame(Digests(rig_frames(subscriber)), expected, std::string("speed ") + speed);
  }
}

constexpr const char* kFaults = "loss=0.02,duplicate=0.02,truncate=0.02,nan=0.02,seed=3";
INSTANTIATE_TEST_SUITE_P(Rigs, RigRecordingTest,
                         testing::Values(RigCase{"vmc", kFaults, "t-first"},
                                         RigCase{"mvn", kFaults}, RigCase{"mocopi", kFaults},
                                         RigCase{"rokoko", kFaults}),
                         [](const auto& test) { return test.param.type; });

TEST_F(DaemonRecordingTest, TheHeaderSaysOfWhatDaemonItIsAndSettingsOfTheLastRunComeFirst) {
  const auto daemon = Recording({"state.dir=" + folder_ / "state"});
  ControlClient control(daemon->control);
  ASSERT_EQ(control.SetStyle(kId, "style2", 0.7F, 300).code(), v1::CODE_OK);
  v1::Request pin;
  pin.set_performer(kId);
  pin.mutable_pin()->set_pinned(true);
  ASSERT_EQ(control.Ask(pin).code(), v1::CODE_OK);
  ASSERT_EQ(daemon->Stop(), 0);
  daemon->Start();
  ASSERT_EQ(daemon->Stop(), 0);
  const std::string second = folder_ / "take-2.styrec";  // the first one is kept
  const auto reader = Reader::Open(second);
  ASSERT_TRUE(reader.ok()) << reader.status().message();
  const auto& header = reader.value()->header();
  EXPECT_EQ(header.program(), "styled");
  EXPECT_EQ(header.weights(), "weights.safetensors in int8");
  EXPECT_EQ(header.weights_hash(),
            recording::HashOfFile(daemon->folder / "weights.safetensors").value() + " in int8");
  EXPECT_NE(header.config().find("high_water_mark = 2000"), std::string::npos);
  EXPECT_NE(header.config().find("# --set record.file: record.file = " + file_), std::string::npos)
      << header.config();
  EXPECT_NE(header.state().find("style2"), std::string::npos);
  std::vector<v1::Request> requests;
  for (const Record& record : ReadAll(second)) requests.push_back(record.command().request());
  ASSERT_GE(requests.size(), 2U);
  const auto& set = requests[requests.size() - 2];
  EXPECT_EQ(set.performer(), kId);
  ASSERT_EQ(set.set().mix_size(), 1);
  EXPECT_EQ(set.set().mix(0).style(), "style2");
  EXPECT_FLOAT_EQ(set.set().mix(0).weight(), 0.7F);
  EXPECT_TRUE(requests.back().pin().pinned());
}

TEST_F(DaemonRecordingTest, ADiskThatIsFullCostsRecordsAndNothingElseUntilThereIsRoomAgain) {
  const auto daemon = Recording();
  const Subscriber subscriber(daemon->publish, {"styled/", "body/"});
  ControlClient control(daemon->control);
  const auto limit = [&](rlim_t bytes) {
    const rlimit size{bytes, RLIM_INFINITY};
    ASSERT_EQ(prlimit(daemon->child->pid(), RLIMIT_FSIZE, &size, nullptr), 0);
  };
  limit(20000);
  const UdpLink link(daemon->udp);
  Rig rig("sim");
  link.Send(rig.Body());
  std::size_t sent = 0;
  const auto play = [&](const std::function<bool()>& until) {
    for (int i = 0; i < 5000 && !until(); ++i) {
      Paced(10, 240, [&](int) { link.Send(rig.Frame()); });
      sent += 10;
    }
  };
  play([&] { return control.Counter("record.lost") > 0; });
  EXPECT_EQ(control.Counter("record.failures"), 1U);
  EXPECT_NE(daemon->Log().find("recording: " + file_ + ": offset "), std::string::npos)
      << daemon->Log();
  const auto written = control.Counter("record.written");
  limit(RLIM_INFINITY);
  play([&] { return control.Counter("record.written") > written; });
  EXPECT_GT(control.Counter("record.written"), written);
  ASSERT_TRUE(subscriber.WaitForFrames(sent, kStyled)) << "the show went on";
  ASSERT_EQ(daemon->Stop(), 0);
  const auto reader = Reader::Open(file_);
  ASSERT_TRUE(reader.ok());
  Record record;
  while (reader.value()->Next(record)) {
  }
  const auto& counts = reader.value()->counts();
  EXPECT_GT(counts.lost_blocks, 0U);
  EXPECT_EQ(counts.skipped_bytes + counts.tail_bytes, 0U) << "no block was left half written";
}

TEST_F(DaemonRecordingTest, WhereNothingCanBeRecordedTheShowGoesOn) {
  WriteText(folder_ / "file", "in the way");
  for (const std::string& wrong : {folder_ / "file/take.styrec", folder_ / "file/"}) {
    file_ = wrong;
    const auto daemon = Recording();
    EXPECT_NE(daemon->Log().find("nothing is recorded: " + folder_ / "file/"), std::string::npos)
        << daemon->Log();
    const Subscriber subscriber(daemon->publish, {"styled/", "body/"});
    ControlClient control(daemon->control);
    EXPECT_EQ(control.CounterSoon("publish.subscriptions", 2), 2U);
    EXPECT_EQ(control.Counter("record.failures"), 1U);
    EXPECT_EQ(control.Counter("record.on"), 0U);
    const UdpLink link(daemon->udp);
    Rig rig("sim");
    link.Send(rig.Body());
    link.Send(rig.Frame());
    EXPECT_TRUE(subscriber.WaitForFrames(1, kStyled));
  }
}

TEST_F(DaemonRecordingTest, WithLessThanMinFreeLeftItPausesAndSaysSo) {
  const auto daemon = Recording({"record.min_free_mb=1073741824"});
  ControlClient control(daemon->control);
  const UdpLink link(daemon->udp);
  Rig rig("sim");
  link.Send(rig.Body());
  link.Send(rig.Frame());
  EXPECT_EQ(control.CounterSoon("record.lost", 2), 2U);
  EXPECT_EQ(control.Counter("record.on"), 0U);
  EXPECT_NE(daemon->Log().find("record.min_free_mb = 1073741824 is free there"), std::string::npos)
      << daemon->Log();
  EXPECT_EQ(daemon->Stop(), 0);
  EXPECT_TRUE(ReadAll(file_).empty());
}

TEST_F(DaemonRecordingTest, NamesAreMadeOfTheTimeAndNoFileIsTouched) {
  const auto name = [](const std::string& pattern) {
    // 2001-09-09 in every time zone.
    return log::FileAt(pattern, 1'000'000'000).string();  // 2001-09-09, everywhere
  };
  EXPECT_EQ(name(folder_ / "take-%Y-%m.styrec"), folder_ / "take-2001-09.styrec");
  EXPECT_TRUE(name(folder_ / "new/").starts_with(folder_ / "new/2001-09-09_"));
  EXPECT_TRUE(name(folder_ / "").ends_with(".styrec"));
  WriteText(folder_ / "a.styrec", "");
  EXPECT_EQ(name(folder_ / "a.styrec"), folder_ / "a-2.styrec");
  WriteText(folder_ / "a-2.styrec", "");
  EXPECT_EQ(name(folder_ / "a.styrec"), folder_ / "a-3.styrec");
}

}  // namespace
}  // namespace styled::support

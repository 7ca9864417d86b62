// VMC between our programs and others' OSC: liblo's oscdump and npm's osc-min read what stylevmc
// and stylesim send, every message and value of it; osc-min and liblo's oscsendfile write what the
// daemon takes for the same poses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <bit>
#include <cmath>

#include "sim/player/performer_motion.h"
#include "sim/rigs/rig_stream.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/unit/vmc/witness.h"
#include "tests/witness/osc/reader.h"

namespace styled::support {
namespace {

constexpr float kDegrees = 57.29578F;
constexpr double kRate_hz = 20;  // a busy machine's readers keep up
constexpr int kFrames = 40;
constexpr const char* kScript = "walk:2,wave-left:2";

struct Sent {
  Lines messages;
  Lines frames;  // each frame's messages in lines
  std::vector<body::Pose> poses;
};

// The frames that `stylesim --as vmc` plays, made here.
Sent Play(const Lines& quirks) {
  class Recorded final : public player::Link {
   public:
    Status Send(std::span<const std::byte> datagram) override {
      const auto read = vmc::testing::ReadOurs(datagram);
      EXPECT_TRUE(read.taken);
      messages.insert(messages.end(), read.messages.begin(), read.messages.end());
      return Status::Ok();
    }
    Lines messages;
  };
  const auto script = synthetic::ParseScript(kScript);
  std::vector<std::unique_ptr<player::Motion>> motions;
  motions.push_back(std::make_unique<player::PerformerMotion>(
      synthetic::Vary(1, 0, script.value()), synthetic::VaryProportions(1, 0), kRate_hz));
  auto stream =
      rigs::RigStream::Make(std::move(rigs::Make("vmc", {{"sim"}, kRate_hz, 1, quirks}).value()),
                            std::move(motions), kRate_hz, faults::Parse("").value());
  EXPECT_TRUE(stream.ok());
  Sent sent;
  for (int i = 0; i < kFrames; ++i) {
    Recorded link;
    EXPECT_EQ(stream.value()->Tick(link), player::Sender::Step::kSent);
    sent.poses.push_back(stream.value()->poses()[0]);
    sent.frames.emplace_back();
    for (const std::string& line : link.messages) sent.frames.back() += line + "\n";
    sent.messages.insert(sent.messages.end(), link.messages.begin(), link.messages.end());
  }
  return sent;
}

void RunStylesim(const std::string& to, const Lines& quirks) {
  TemporaryFolder folder;
  Lines arguments{STYLESIM_BINARY, "--as", "vmc",      "--to", "udp://" + to, "--rate", "20",
                  "--seconds",     "2",    "--script", kScript};
  for (const std::string& quirk : quirks) arguments.insert(arguments.end(), {"--quirk", quirk});
  Child stylesim(arguments, folder / "stderr.txt");
  EXPECT_EQ(stylesim.Wait(30).value_or(-1), 0) << ReadText(folder / "stderr.txt");
}

// The hips in VMC's space: Unity's mirrors x.
std::string HipsOf(const body::Vec3& p, const body::Quat& q) {
  std::string line = "/VMC/Ext/Bone/Pos ,sfffffff Hips";
  for (const float value : {-p[0], p[1], p[2], q.x(), -q.y(), -q.z(), q.w()}) {
    char text[16];
    std::snprintf(text, sizeof text, " %08x", std::bit_cast<unsigned>(value));
    line += text;
  }
  return line;
}

// Every line of the hips is one of these; how many there were.
int ExpectHips(const Lines& read, const Lines& known) {
  int count = 0;
  for (const std::string& line : read) {
    if (line.find(" Hips ") == std::string::npos && line.find(" \"Hips\" ") == std::string::npos) {
      continue;
    }
    ++count;
    EXPECT_THAT(known, testing::Contains(line));
  }
  return count;
}

class OscReaderTest : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (const std::string why = Missing(GetParam()); !why.empty()) GTEST_SKIP() << why;
  }
};

TEST_P(OscReaderTest, PrintsEveryMessageAndValueThatStylesimSends) {
  for (const Lines& quirks : std::vector<Lines>{{}, {"t-first"}, {"nested", "full"}, {"single"}}) {
    const Sent sent = Play(quirks);
    ASSERT_GT(sent.messages.size(), kFrames * 23U);
    const Reader reader(GetParam());
    RunStylesim(reader.address(), quirks);
    const Lines read = reader.WaitFor(sent.messages.size());
    SCOPED_TRACE(testing::PrintToString(quirks));
    ExpectTheSame(read, reader.Expect(sent.messages));
    Lines hips;
    for (const body::Pose& pose : sent.poses) {
      body::Quat q = pose.rotations[body::kHips];
      if (quirks == Lines{"t-first"} && q.w() > 0) q.coeffs() = -q.coeffs();
      hips.push_back(HipsOf(pose.hips_position_m, q));
    }
    EXPECT_EQ(ExpectHips(read, reader.Expect(hips)), kFrames);
  }
}

// The output of stylevmc is checked at a second target, a socket of this test, against the frames
// that the daemon published.
TEST_P(OscReaderTest, PrintsEveryMessageAndValueThatStylevmcSends) {
  constexpr const char* kStyled = "styled/rig.a/canonical/";
  Daemon daemon;
  const Reader reader(GetParam());
  const Ear ear;
  TemporaryFolder folder;
  Child stylevmc({STYLEVMC_BINARY, "--publish", daemon.publish, "--to", ear.address(), "--to",
                  reader.address(), "--rate", "20"},
                 folder / "stderr.txt");
  Subscriber published(daemon.publish, {"body/", kStyled});
  const UdpLink link(daemon.udp);
  Rig rig("a");
  Lines sent;
  const auto hear = [&](int wait_ms) {
    for (Bytes bytes; !(bytes = ear.Receive(wait_ms)).empty();) {
      const auto read = vmc::testing::ReadOurs(bytes);
      EXPECT_TRUE(read.taken);
      sent.insert(sent.end(), read.messages.begin(), read.messages.end());
    }
  };
  for (int i = 0; i < 2400 && sent.size() < 1000; ++i) {
    if (i % 60 == 0) link.Send(rig.Body());
    link.Send(rig.Frame());
    hear(0);
    Sleep(1.0 / 120);
  }
  stylevmc.Signal(SIGTERM);
  EXPECT_EQ(stylevmc.Wait(5).value_or(-1), 0) << ReadText(folder / "stderr.txt");
  hear(200);
  ASSERT_GE(sent.size(), 1000U);
  const Lines read = reader.WaitFor(sent.size());
  ExpectTheSame(read, reader.Expect(sent));
  Lines hips;
  for (const auto& frame : published.Frames(kStyled)) {
    const auto& p = frame.root_position();
    const auto& q = frame.rotations();
    hips.push_back(HipsOf({p[0], p[1], p[2]}, {q[3], q[0], q[1], q[2]}));
  }
  EXPECT_GT(ExpectHips(read, reader.Expect(hips)), 30);
}

INSTANTIATE_TEST_SUITE_P(Others, OscReaderTest, testing::Values("oscdump", "osc-min"),
                         [](const auto& info) {
                           return info.param == "oscdump" ? "oscdump" : "oscmin";
                         });

// The daemon, and what another's program sends to it, compared with `sent`.
void ExpectThePoses(const Sent& sent,
                    const std::function<std::string(const std::string&)>& command) {
  Daemon daemon({}, "[[source]]\nname = \"suit\"\ntype = \"vmc\"\nlisten = \"127.0.0.1:0\"\n");
  Subscriber subscriber(daemon.publish, {""});
  ASSERT_TRUE(subscriber.WaitFor([&] { return subscriber.LastStats().has_value(); }, 10));
  const std::string& address = daemon.listens.at(2);
  TemporaryFolder folder;
  Child sender({"/bin/sh", "-c", command(address.substr(address.find(':') + 1))},
               folder / "stderr.txt");
  EXPECT_EQ(sender.Wait(60).value_or(-1), 0) << ReadText(folder / "stderr.txt");
  const std::string topic = "styled/suit.suit/canonical/";
  EXPECT_TRUE(subscriber.WaitForFrames(sent.poses.size(), topic)) << daemon.Log();
  const auto frames = subscriber.Frames(topic);
  ASSERT_EQ(frames.size(), sent.poses.size());
  float worst_deg = 0, worst_m = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto& r = frames[i].rotations();
    for (int j = 0; j < body::kJointCount; ++j) {
      const body::Quat got(r[4 * j + 3], r[4 * j], r[4 * j + 1], r[4 * j + 2]);
      worst_deg = std::max(
          worst_deg,
          kDegrees * got.angularDistance(sent.poses[i].rotations[static_cast<std::size_t>(j)]));
    }
    const auto& p = frames[i].root_position();
    worst_m =
        std::max(worst_m, (body::Vec3(p[0], p[1], p[2]) - sent.poses[i].hips_position_m).norm());
  }
  EXPECT_LT(worst_deg, 0.5F);
  EXPECT_LT(worst_m, 0.005F);
  ControlClient control(daemon.control);
  EXPECT_EQ(control.Counter("source.malformed"), 0U);
  std::cout << worst_deg << " deg, " << 1000 * worst_m << " mm at most\n";
}

TEST(OscSenderTest, WhatOscMinWritesHasTheSamePoses) {
  if (!HasOscMin()) GTEST_SKIP() << "skipped, no osc-min (npm)";
  const Sent sent = Play({"t-first"});
  TemporaryFolder folder;
  std::string text;
  for (const std::string& frame : sent.frames) text += frame + "\n";
  WriteText(folder / "frames.txt", text);
  ExpectThePoses(sent, [&](const std::string& port) {
    return "cd '" OSC_MIN_FOLDER "' && exec node vmc.mjs send " + port + " '" +
           std::string(folder / "frames.txt") + "' 20";
  });
}

// oscdump's text of what stylesim sends, played by its sister: six decimals are left of a float.
TEST(OscSenderTest, WhatOscsendfileWritesHasTheSamePoses) {
  if (!IsHere("oscdump") || !IsHere("oscsendfile")) {
    GTEST_SKIP() << "skipped, no oscdump and oscsendfile (Debian: liblo-tools)";
  }
  const Sent sent = Play({"single"});
  const Reader reader("oscdump");
  RunStylesim(reader.address(), {"single"});
  ASSERT_EQ(reader.WaitFor(sent.messages.size()).size(), sent.messages.size());
  TemporaryFolder folder;
  std::string text;
  for (const std::string& line : Split(ReadText(reader.file()))) {
    if (line.find(Reader::kProbe) == std::string::npos) text += line + "\n";
  }
  WriteText(folder / "dump.txt", text);
  ExpectThePoses(sent, [&](const std::string& port) {
    return "exec oscsendfile 127.0.0.1 " + port + " '" + std::string(folder / "dump.txt") + "' 1";
  });
}

}  // namespace
}  // namespace styled::support

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <thread>

#include "proto/rigs/qtm/packet.h"
#include "sim/rigs/rig.h"
#include "sim/rigs/stream_server.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/support/rig_run.h"

namespace styled::support {
namespace {

using ::testing::HasSubstr;

// Frames sent before the dialogue is over: the stand-in answers once a frame.
constexpr int kQtmHandshake = 15;

TEST(QtmRigTest, PosesAreTheMotionInBothFormsAndHoweverTheyAreCut) {
  const RigResult result = StreamAsRig({.type = "qtm"});
  ExpectTheSameMotion(result, kQtmHandshake);
  ASSERT_FALSE(result.bodies.empty());
  ASSERT_EQ(result.bodies[0].names_size(), 24) << "the rig's own skeleton is published, too";
  EXPECT_EQ(result.bodies[0].names(9), "LeftForeArmRoll");
  EXPECT_THAT(result.log, HasSubstr("QTM RT 1.25, 60 Hz, +Z up, skeletons: sim"));
  const RigResult old = StreamAsRig({.type = "qtm", .quirks = {"flat", "split"}});
  ExpectTheSameMotion(old, 2 * kQtmHandshake);
  EXPECT_THAT(old.log, HasSubstr("QTM RT 1.20, "));
  ExpectTheSameMotion(StreamAsRig({.type = "qtm", .quirks = {"y-up"}}), kQtmHandshake);
}

TEST(QtmRigTest, SeveralSkeletonsAreSeveralPerformers) {
  const RigResult result =
      StreamAsRig({.type = "qtm", .performers = {"anna", "ben", "cleo"}, .frames = 60});
  ExpectTheSameMotion(result, kQtmHandshake);
  EXPECT_EQ(result.Counter("pipeline.performers"), 3U);
}

TEST(QtmRigTest, TimecodeComesThrough) {
  const RigResult result = StreamAsRig({.type = "qtm", .quirks = {"timecode"}, .frames = 120});
  ASSERT_FALSE(result.frames.empty());
  const auto& timecode = result.frames.back().timecode();
  EXPECT_EQ(timecode.hours(), 10U);
  EXPECT_EQ(timecode.seconds(), 1U);
  EXPECT_EQ(timecode.frames(), 29U) << "at 30 frames a second, in the last of 120 at 60 Hz";
}

TEST(QtmRigTest, ASkeletonThatIsNotSeenSendsNothingAndComesBack) {
  // It is seen in the last frame, from which poses are counted back.
  const RigResult result = StreamAsRig({.type = "qtm", .quirks = {"blink"}, .frames = 250});
  EXPECT_LT(result.worst_deg, 0.5F) << result.where;
  EXPECT_LT(result.received, result.sent - 10);
  // Of the frames since the first that came, 5 of 60 are not sent.
  ASSERT_FALSE(result.frames.empty());
  const auto span_ns =
      result.frames.back().source_time_ns() - result.frames.front().source_time_ns();
  const auto shown = static_cast<double>(span_ns) * 1e-9 * 60 * 55 / 60;
  EXPECT_GT(result.received, 0.95 * shown - 5);
  EXPECT_GT(shown, 60) << "it came back at least once";
  EXPECT_EQ(result.Counter("pipeline.performers"), 1U);
}

TEST(QtmRigTest, FaultsAreCountedAndTheRestComesThrough) {
  const RigResult result =
      StreamAsRig({.type = "qtm",
                   .frames = 300,
                   .faults = "loss=0.03,duplicate=0.02,nan=0.02,occlude=0.005,seed=3"});
  EXPECT_GT(result.Counter("pipeline.lost"), 0U);
  EXPECT_GT(result.Counter("pipeline.duplicate"), 0U);
  EXPECT_GT(result.Counter("stylist.held"), 0U);
  EXPECT_GT(result.received, 200);
  for (const auto& frame : result.frames) {
    for (const float value : frame.rotations()) ASSERT_TRUE(std::isfinite(value));
  }
}

TEST(QtmRigTest, ANewMeasurementIsANewSessionOfTheSamePerformer) {
  const RigResult result =
      StreamAsRig({.type = "qtm", .frames = 400, .faults = "restart=0.01,seed=5"});
  EXPECT_GT(result.Counter("pipeline.sessions"), 1U);
  EXPECT_EQ(result.Counter("pipeline.performers"), 1U);
  EXPECT_EQ(result.Counter("source.tcp_accepted"), 1U);
  EXPECT_GT(result.received, result.sent / 2);
}

// A QTM that can go and come back, at one address; its motion is a standing pose.
class Server {
 public:
  explicit Server(std::vector<std::string> quirks = {}) : quirks_(std::move(quirks)) { Start(); }
  ~Server() { Stop(); }
  void Start() {
    rig_ = std::move(rigs::Make("qtm", {{"sim"}, 60, 1, quirks_}).value());
    std::string bound;
    link_ = std::move(rigs::Listen(*rig_, url_, &bound).value());
    url_ = bound;
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  void Stop() {
    thread_ = std::jthread();
    link_.reset();
  }
  std::string keys() const { return "server = \"" + url_.substr(6) + "\"\n"; }
  // Damages the packets of frames, one in `period` at most not; 0: none is damaged.
  std::atomic<unsigned> damage{0};
  std::atomic<std::uint64_t> sent{0};

 private:
  void Run(const std::stop_token& stop) {
    const body::Pose pose;
    std::mt19937 random(7);
    for (std::uint64_t index = 0; !stop.stop_requested(); ++index) {
      link_->Receive({});
      rig_->Encode({index, static_cast<double>(index) / 60, {&pose, 1}},
                   [&](std::span<const std::byte> packet) {
                     Bytes bytes(packet.begin(), packet.end());
                     if (damage != 0 && random() % damage != 0) Damage(bytes, random);
                     (void)link_->Send(bytes);
                     ++sent;
                   });
      Sleep(damage != 0 ? 0.001 : 1.0 / 60);
    }
  }
  static void Damage(Bytes& bytes, std::mt19937& random) {
    switch (random() % 3) {
      case 0:
        for (int i = 0; i < 8; ++i) {
          bytes[random() % bytes.size()] ^= static_cast<std::byte>(1U << random() % 8);
        }
        return;
      case 1:
        bytes.resize(random() % bytes.size());
        return;
      default:
        bytes.insert(bytes.end(), random() % 64, static_cast<std::byte>(random() & 0xFFU));
    }
  }

  std::vector<std::string> quirks_;
  std::string url_ = "tcp://127.0.0.1:0";
  std::unique_ptr<rigs::Rig> rig_;
  std::unique_ptr<player::Link> link_;
  std::jthread thread_;
};

std::string Source(const Server& server) {
  return "[[source]]\nname = \"suit\"\ntype = \"qtm\"\n" + server.keys();
}

constexpr char kQtmTopic[] = "styled/suit.sim/canonical/";

TEST(QtmServerTest, ARestartedServerContinues) {
  Server server;
  Daemon daemon({}, Source(server));
  Subscriber subscriber(daemon.publish, {kQtmTopic});
  ASSERT_TRUE(subscriber.WaitForFrames(30, kQtmTopic)) << daemon.Log();
  server.Stop();
  Sleep(0.3);
  const std::size_t before = subscriber.Count(kQtmTopic);
  server.Start();
  ASSERT_TRUE(subscriber.WaitForFrames(before + 30, kQtmTopic)) << daemon.Log();
  ControlClient control(daemon.control);
  EXPECT_EQ(control.Counter("source.tcp_accepted"), 2U);
  EXPECT_EQ(daemon.Stop(), 0);
  EXPECT_THAT(daemon.Log(), HasSubstr("; trying again every 5 s"));
  EXPECT_THAT(daemon.Log(), HasSubstr("connected again"));
}

TEST(QtmServerTest, AFullServerIsReportedWithItsMessage) {
  const Server server({"full"});
  Daemon daemon({}, Source(server));
  for (int i = 0; i < 100 && daemon.Log().find("refuses") == std::string::npos; ++i) Sleep(0.05);
  EXPECT_THAT(daemon.Log(),
              HasSubstr("refuses: \"Connection refused. Max number of clients reached.\""));
  EXPECT_EQ(daemon.Stop(), 0);
}

TEST(QtmServerTest, TenThousandDamagedPacketsDisturbNobodyElse) {
  Server server;
  Daemon daemon({}, Source(server));
  ControlClient control(daemon.control);
  Subscriber subscriber(daemon.publish, {"body/rig.a/", "styled/rig.a/", kQtmTopic});
  const UdpLink other(daemon.udp);
  styled::support::Rig undisturbed("a");
  other.Send(undisturbed.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  ASSERT_TRUE(subscriber.WaitForFrames(10, kQtmTopic)) << daemon.Log();
  server.damage = 200;
  std::uint64_t frames = 0;
  for (const std::uint64_t end = server.sent + 10000; server.sent < end; ++frames) {
    other.Send(undisturbed.Frame());
    Sleep(0.02);
  }
  server.damage = 0;
  EXPECT_GT(control.Counter("source.malformed"), 1U);
  EXPECT_GT(control.Counter("source.tcp_broken"), 1U);
  EXPECT_EQ(control.Performer("rig.a").received(), frames);
  EXPECT_EQ(control.Performer("rig.a").lost(), 0U);
  const std::size_t before = subscriber.Count(kQtmTopic);
  ASSERT_TRUE(subscriber.WaitForFrames(before + 30, kQtmTopic)) << "it recovers: " << daemon.Log();
  EXPECT_EQ(daemon.Stop(), 0) << daemon.Log();
}

}  // namespace
}  // namespace styled::support

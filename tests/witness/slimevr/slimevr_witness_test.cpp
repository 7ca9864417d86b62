// SlimeVR's trackers by its own npm packages: what they write is what our decoder reads,
// what we answer is what they read, and the emulated trackers' motion comes out of the daemon.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "model/synthetic/performer.h"
#include "proto/rigs/slimevr/udp.h"
#include "sim/rigs/slimevr.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kRate_hz = 50;
constexpr char kTopic[] = "styled/suit.suit/canonical/";
const std::vector<int> kWorn{body::kHips,          body::kChest,         body::kHead,
                             body::kLeftUpperArm,  body::kLeftLowerArm,  body::kRightUpperArm,
                             body::kRightLowerArm, body::kLeftUpperLeg,  body::kLeftLowerLeg,
                             body::kLeftFoot,      body::kRightUpperLeg, body::kRightLowerLeg,
                             body::kRightFoot};

bool HasTrackers() {
  return std::system("command -v node >/dev/null 2>&1") == 0 &&
         std::filesystem::exists(TRACKERS_FOLDER "/node_modules/@slimevr/tracker-emulation");
}

std::string NameOf(int joint) {
  return std::string(body::kHumanoid[static_cast<std::size_t>(joint)].name);
}

std::vector<std::string> Split(const std::string& text, char separator) {
  std::istringstream stream(text);
  std::vector<std::string> parts;
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

// The output of `node trackers.mjs ARGUMENTS`, by lines.
std::vector<std::string> RunTrackers(const std::string& arguments, double seconds) {
  TemporaryFolder folder;
  Child node({"/bin/sh", "-c",
              "cd '" TRACKERS_FOLDER "' && exec node trackers.mjs " + arguments + " > '" +
                  std::string(folder / "out.txt") + "'"},
             folder / "stderr.txt");
  EXPECT_EQ(node.Wait(seconds).value_or(-1), 0) << ReadText(folder / "stderr.txt");
  return Split(ReadText(folder / "out.txt"), '\n');
}

std::string Hex(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) {
    for (const unsigned shift : {4U, 0U}) {
      text += "0123456789abcdef"[std::to_integer<unsigned>(byte) >> shift & 0xFU];
    }
  }
  return text;
}

Bytes FromHex(const std::string& text) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoi(text.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

std::string Encoded(const slimevr::Answer& answer) {
  std::array<std::byte, slimevr::kMaxAnswerSize> bytes;
  return Hex(std::span(bytes).first(slimevr::EncodeAnswer(answer, bytes)));
}

class PacketsTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!HasTrackers()) GTEST_SKIP() << "skipped, no @slimevr/tracker-emulation (npm)";
  }
  // The one packet in the next line.
  template <typename Packet>
  Packet Next() {
    const auto parts = Split(lines_.at(next_++), ' ');
    const Bytes bytes = FromHex(parts.at(1));
    EXPECT_EQ(slimevr::Decode(bytes, datagram_), slimevr::UdpResult::kOk) << parts[0];
    EXPECT_EQ(datagram_.number, 0x0102030405060708U) << parts[0];
    EXPECT_EQ(datagram_.count, 1U) << parts[0];
    const auto* packet = std::get_if<Packet>(datagram_.packets.data());
    EXPECT_NE(packet, nullptr) << parts[0] << " is taken for another";
    return packet == nullptr ? Packet() : *packet;
  }

  std::vector<std::string> lines_;
  std::size_t next_ = 0;
  slimevr::Datagram datagram_;
};

TEST_F(PacketsTest, WhatTheyWriteIsReadWithEveryValueAndOurAnswersByThem) {
  lines_ = RunTrackers("packets " + Encoded(slimevr::Greeting{}) + " " +
                           Encoded(slimevr::Heartbeat{}) + " " + Encoded(slimevr::Ping{77}) + " " +
                           Encoded(slimevr::FeatureFlags{slimevr::kBundles}),
                       30);
  ASSERT_EQ(lines_.size(), 20U);

  const auto handshake = Next<slimevr::Handshake>();
  EXPECT_EQ(handshake.board, 4U);
  EXPECT_EQ(handshake.imu, 13U);
  EXPECT_EQ(handshake.mcu, 2U);
  EXPECT_EQ(handshake.protocol, 13U);
  EXPECT_EQ(handshake.firmware.size(), 5U);
  EXPECT_THAT(handshake.mac, ElementsAre(0x02, 0x53, 0x56, 0, 0, 0x1D));
  Next<slimevr::Heartbeat>();
  EXPECT_THAT(Next<slimevr::LegacyRotation>().orientation.rotation,
              ElementsAre(0.5F, -0.5F, 0.5F, -0.5F));
  const auto rotation = Next<slimevr::Rotation>();
  EXPECT_EQ(rotation.sensor, 3);
  EXPECT_EQ(rotation.kind, 1);
  EXPECT_THAT(rotation.orientation.rotation, ElementsAre(0.6F, 0.0F, -0.8F, 0.0F));
  EXPECT_EQ(rotation.accuracy, 7);
  const auto acceleration = Next<slimevr::Acceleration>();
  EXPECT_THAT(acceleration.acceleration_mps2, ElementsAre(0.25F, -9.75F, 2.0F));
  EXPECT_EQ(acceleration.sensor, 5);
  EXPECT_EQ(Next<slimevr::Ping>().id, 0xDEADBEEFU);
  const auto battery = Next<slimevr::BatteryLevel>();
  EXPECT_FLOAT_EQ(battery.volts, 3.75F);
  EXPECT_FLOAT_EQ(battery.level, 0.5F);
  const auto tap = Next<slimevr::Tap>();
  EXPECT_EQ(tap.sensor, 1);
  EXPECT_EQ(tap.value, 2);
  const auto error = Next<slimevr::Error>();
  EXPECT_EQ(error.sensor, 2);
  EXPECT_EQ(error.code, 9);
  const auto info = Next<slimevr::SensorInfo>();
  EXPECT_EQ(info.sensor, 4);
  EXPECT_EQ(info.status, 1);
  EXPECT_EQ(info.imu, 13);
  EXPECT_EQ(info.position, 0) << "not told";
  const auto magnetometer = Next<slimevr::MagnetometerAccuracy>();
  EXPECT_EQ(magnetometer.sensor, 6);
  EXPECT_FLOAT_EQ(magnetometer.accuracy, 0.5F);
  const auto signal = Next<slimevr::SignalStrength>();
  EXPECT_EQ(signal.sensor, 255);
  EXPECT_EQ(signal.dbm, -61);
  const auto temperature = Next<slimevr::Temperature>();
  EXPECT_EQ(temperature.sensor, 1);
  EXPECT_FLOAT_EQ(temperature.celsius, 36.5F);
  EXPECT_EQ(Next<slimevr::UserAction>().action, slimevr::UserAction::kYawReset);
  EXPECT_EQ(Next<slimevr::FeatureFlags>().bits, 2U);

  EXPECT_EQ(lines_[15], "DeviceBoundSensorInfoPacket " + Encoded(slimevr::SensorInfoAck{3, 1}));
  const std::vector<std::string> answers(lines_.begin() + 16, lines_.end());
  EXPECT_THAT(answers,
              ElementsAre("DeviceBoundHandshakePacket{}", "DeviceBoundHeartbeatPacket{}",
                          "DeviceBoundPingPacket{id: 77}",
                          "DeviceBoundFeatureFlagsPacket{flags: PROTOCOL_BUNDLE_SUPPORT}"));
}

// The measurements and requests of the stand-in's boards, by ticks: the T-pose, the skier's, then
// `poses`, each held for `hold` ticks. Lines of trackers.mjs.
std::string Measured(const std::vector<body::Pose>& poses, int hold) {
  std::string text;
  struct Board {
    std::unique_ptr<rigs::Rig> rig;
    std::vector<Bytes> answers;
  };
  std::vector<Board> boards;
  for (std::size_t k = 0; k < kWorn.size(); ++k) {
    auto rig = rigs::MakeSlimeVr({{"sim"}, kRate_hz, k + 1, {"anyhow", NameOf(kWorn[k])}});
    EXPECT_TRUE(rig.ok()) << rig.status().message();
    boards.push_back({std::move(rig.value()), {}});
  }
  slimevr::Datagram datagram;
  const int intro = 2 * kRate_hz;
  for (int tick = 0; tick < intro + hold * static_cast<int>(poses.size()); ++tick) {
    const auto which = static_cast<std::size_t>(std::max(0, (tick - intro) / hold));
    for (std::size_t k = 0; k < boards.size(); ++k) {
      Board& board = boards[k];
      const auto answer = [&board](const slimevr::Answer& what) {
        Bytes& bytes = board.answers.emplace_back(slimevr::kMaxAnswerSize);
        bytes.resize(slimevr::EncodeAnswer(what, bytes));
      };
      const auto send = [&](std::span<const std::byte> bytes) {
        EXPECT_EQ(slimevr::Decode(bytes, datagram), slimevr::UdpResult::kOk);
        for (const auto& packet : std::span(datagram.packets).first(datagram.count)) {
          const std::string place = std::to_string(tick) + " " + std::to_string(k);
          if (std::holds_alternative<slimevr::Handshake>(packet)) answer(slimevr::Greeting{});
          if (const auto* info = std::get_if<slimevr::SensorInfo>(&packet)) {
            answer(slimevr::SensorInfoAck{info->sensor, info->status});
          } else if (std::holds_alternative<slimevr::FeatureFlags>(packet)) {
            answer(slimevr::FeatureFlags{});
          } else if (const auto* action = std::get_if<slimevr::UserAction>(&packet)) {
            text += place + " " + std::to_string(action->action) + "\n";
          } else if (const auto* rotation = std::get_if<slimevr::Rotation>(&packet)) {
            std::ostringstream line;
            line.precision(9);
            line << place;
            for (const float value : rotation->orientation.rotation) line << ' ' << value;
            text += line.str() + "\n";
          }
        }
      };
      if (tick % (kRate_hz / 2) == 0) answer(slimevr::Heartbeat{});
      const auto answers = std::exchange(board.answers, {});
      for (const Bytes& bytes : answers) board.rig->Receive(bytes, send);
      board.rig->Encode({static_cast<std::uint64_t>(tick), static_cast<double>(tick) / kRate_hz,
                         std::span(&poses[which], 1)},
                        send);
    }
  }
  return text;
}

// Of the parts with a tracker, in the world.
float WorstDegrees(const v1::Frame& frame, const body::Pose& pose) {
  body::Pose got;
  for (int j = 0; j < body::kJointCount; ++j) {
    const auto& r = frame.rotations();
    got.rotations[static_cast<std::size_t>(j)] =
        body::Quat(r[4 * j + 3], r[4 * j], r[4 * j + 1], r[4 * j + 2]);
  }
  body::WorldPose found, expected;
  body::ForwardKinematics(got, found);
  body::ForwardKinematics(pose, expected);
  float worst = 0;
  for (const int joint : kWorn) {
    const auto j = static_cast<std::size_t>(joint);
    worst = std::max(worst, 57.29578F * expected.rotations[j].angularDistance(found.rotations[j]));
  }
  return worst;
}

class TrackersTest : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    if (!HasTrackers()) GTEST_SKIP() << "skipped, no @slimevr/tracker-emulation (npm)";
  }
};

TEST_P(TrackersTest, EmulatedTrackersGiveTheMotionWithinADegree) {
  std::string table;
  for (std::size_t k = 0; k < kWorn.size(); ++k) {
    table += (k > 0 ? ", \"" : "\"") + rigs::SlimeVrTrackerId(k + 1, 0) + "\" = \"" +
             NameOf(kWorn[k]) + "\"";
  }
  Daemon daemon({"performers.takeover_ms=100"},
                "[[source]]\nname = \"suit\"\ntype = \"slimevr\"\nlisten = \"127.0.0.1:0\"\n"
                "trackers = { " +
                    table + " }\n");
  Subscriber subscriber(daemon.publish, {""});
  ASSERT_TRUE(subscriber.WaitFor([&] { return subscriber.LastStats().has_value(); }, 10));

  synthetic::Options options;
  options.script = synthetic::ParseScript("walk:2,wave-left:2,turn-left:2").value();
  synthetic::Performer performer(options);
  std::vector<body::Pose> poses(6);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    performer.Pose(0.3 + 0.9 * static_cast<double>(i), poses[i]);
  }
  TemporaryFolder folder;
  WriteText(folder / "motion.txt", Measured(poses, kRate_hz));
  const std::string& address = daemon.listens.at(2);
  const auto said = RunTrackers("play " + address.substr(address.find(':') + 1) + " '" +
                                    std::string(folder / "motion.txt") + "' " +
                                    std::to_string(kRate_hz) + (GetParam() ? " 1" : " 0"),
                                120);

  // Each pose, in their order.
  const auto frames = subscriber.Frames(kTopic);
  std::size_t at = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    float best = 180;
    for (; at < frames.size() && best >= 1; ++at) {
      best = std::min(best, WorstDegrees(frames[at], poses[i]));
    }
    EXPECT_LT(best, 1) << "pose " << i << " of " << frames.size() << " frames: " << daemon.Log();
  }

  // The messages that the trackers decoded from our answers.
  ASSERT_EQ(said.size(), kWorn.size() + 1);
  for (std::size_t k = 0; k < kWorn.size(); ++k) {
    std::istringstream words(said[k]);
    int board = -1, pings = 0, heartbeats = 0, bundles = 0, errors = -1;
    words >> board >> pings >> heartbeats >> bundles >> errors;
    EXPECT_GT(pings, 5) << said[k];
    EXPECT_GT(heartbeats, 5) << said[k];
    EXPECT_EQ(bundles, 1) << said[k];
    EXPECT_EQ(errors, 0) << said[k];
  }
  ControlClient control(daemon.control);
  EXPECT_EQ(control.Counter("source.malformed"), 0U);
  EXPECT_EQ(control.Counter("source.ignored"), 0U);
  EXPECT_EQ(control.Counter("pipeline.reordered"), 0U);
  if (GetParam()) {
    EXPECT_EQ(said.back(), "searching-for-server") << "a live tracker is at another address";
    EXPECT_GT(control.Counter("source.takeovers_refused"), 2U);
  } else {
    EXPECT_EQ(control.Counter("source.takeovers_refused"), 0U);
  }
  EXPECT_EQ(daemon.Stop(), 0);
  EXPECT_THAT(daemon.Log(), HasSubstr("calibrated hips, chest"));
  if (GetParam()) {
    EXPECT_THAT(daemon.Log(), HasSubstr("025356000001/0 is live at 127.0.0.1:"));
  }
}

INSTANTIATE_TEST_SUITE_P(Npm, TrackersTest, testing::Bool(), [](const auto& info) {
  return info.param ? "BesideAnIntruder" : "Alone";
});

}  // namespace
}  // namespace styled::support

#include "sim/rigs/slimevr.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/synthetic/performer.h"
#include "sim/player/link.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

constexpr double kRate_hz = 100;
constexpr char kTopic[] = "styled/suit.suit/canonical/";

const std::vector<int> kWorn{body::kHips,          body::kChest,         body::kHead,
                             body::kLeftUpperArm,  body::kLeftLowerArm,  body::kRightUpperArm,
                             body::kRightLowerArm, body::kLeftUpperLeg,  body::kLeftLowerLeg,
                             body::kLeftFoot,      body::kRightUpperLeg, body::kRightLowerLeg,
                             body::kRightFoot};

// Each board's quirks.
using Boards = std::vector<std::vector<std::string>>;

std::string NameOf(int joint) {
  return std::string(body::kHumanoid[static_cast<std::size_t>(joint)].name);
}

// The daemon, and boards of trackers with one socket each.
class Stage {
 public:
  explicit Stage(const Boards& boards, const std::string& keys = "")
      : daemon({"performers.takeover_ms=100"},
               "[[source]]\nname = \"suit\"\ntype = \"slimevr\"\nlisten = \"127.0.0.1:0\"\n" +
                   keys + "\n") {
    for (std::size_t k = 0; k < boards.size(); ++k) {
      auto rig = rigs::MakeSlimeVr({{"sim"}, kRate_hz, k + 1, boards[k]});
      auto link = player::Connect("udp://" + daemon.listens.at(2), 1000);
      EXPECT_TRUE(rig.ok() && link.ok());
      boards_.push_back({std::move(rig.value()), std::move(link.value())});
    }
    subscriber = std::make_unique<Subscriber>(daemon.publish, std::vector<std::string>{""});
    EXPECT_TRUE(subscriber->WaitFor([&] { return subscriber->LastStats().has_value(); }, 10));
  }

  // The performer holds a pose.
  void Hold(const body::Pose& pose, double seconds) {
    Paced(static_cast<int>(seconds * kRate_hz), kRate_hz, [&](int) {
      for (Board& board : boards_) {
        if (board.silent) continue;
        const auto send = [&board](std::span<const std::byte> bytes) {
          EXPECT_TRUE(board.link->Send(bytes).ok());
        };
        std::array<std::byte, 256> bytes;
        for (std::size_t size; (size = board.link->Receive(bytes)) > 0;) {
          board.rig->Receive(std::span(bytes).first(size), send);
        }
        board.rig->Encode({index_, static_cast<double>(index_) / kRate_hz, std::span(&pose, 1)},
                          send);
      }
      ++index_;
    });
  }

  void Silence(std::size_t board) { boards_[board].silent = true; }

  // The largest error of the tracked parts' global rotations: the newest frame against the pose.
  float WorstDegrees(const body::Pose& pose) const {
    const auto frames = subscriber->Frames(kTopic);
    if (frames.empty()) return 180;
    body::Pose got;
    for (int j = 0; j < body::kJointCount; ++j) {
      const auto& r = frames.back().rotations();
      got.rotations[static_cast<std::size_t>(j)] =
          body::Quat(r[4 * j + 3], r[4 * j], r[4 * j + 1], r[4 * j + 2]);
    }
    body::WorldPose found, expected;
    body::ForwardKinematics(got, found);
    body::ForwardKinematics(pose, expected);
    float worst = 0;
    for (const int joint : kWorn) {
      const auto j = static_cast<std::size_t>(joint);
      worst =
          std::max(worst, 57.29578F * expected.rotations[j].angularDistance(found.rotations[j]));
    }
    return worst;
  }

  void ExpectTheMotion() {
    synthetic::Options options;
    options.script = synthetic::ParseScript("walk:2,wave-left:2,turn-left:2").value();
    synthetic::Performer performer(options);
    for (double time_s = 0.3; time_s < 6; time_s += 0.9) {
      body::Pose pose;
      performer.Pose(time_s, pose);
      Hold(pose, 0.5);
      EXPECT_LT(WorstDegrees(pose), 1) << time_s;
    }
  }

  Daemon daemon;
  std::unique_ptr<Subscriber> subscriber;

 private:
  struct Board {
    std::unique_ptr<rigs::Rig> rig;
    std::unique_ptr<player::Link> link;
    bool silent = false;
  };
  std::vector<Board> boards_;
  std::uint64_t index_ = 0;
};

Boards OnePerBoard(const std::vector<std::string>& quirks) {
  Boards boards;
  for (const int joint : kWorn) {
    boards.push_back(quirks);
    boards.back().push_back(NameOf(joint));
  }
  return boards;
}

TEST(SlimeVrRigTest, BoardsThatResetByTheirButtonGiveTheMotionWithinADegree) {
  Stage stage(OnePerBoard({"anyhow"}));
  stage.Hold({}, 2);  // the boards connect, and play both resets
  stage.ExpectTheMotion();
  ControlClient control(stage.daemon.control);
  EXPECT_EQ(control.Counter("source.malformed"), 0U);
  EXPECT_EQ(control.Counter("stylist.held"), 0U);
  EXPECT_EQ(stage.daemon.Stop(), 0);
  EXPECT_NE(stage.daemon.Log().find("calibrated hips, chest"), std::string::npos);
}

TEST(SlimeVrRigTest, AFullResetByTheControlSocketGivesTheMotionWithinADegree) {
  Stage stage(Boards{{"no-reset", "unplaced", "compact"}}, [] {
    std::string keys = "trackers = {";
    for (std::size_t k = 0; k < kWorn.size(); ++k) {
      keys += (k > 0 ? ", \"" : " \"") + rigs::SlimeVrTrackerId(1, k) + "\" = \"" +
              NameOf(kWorn[k]) + "\"";
    }
    return keys + " }";
  }());
  stage.Hold({}, 1);
  ASSERT_TRUE(stage.subscriber->WaitForFrames(1, kTopic)) << "the rest pose, until it is reset";
  ControlClient control(stage.daemon.control);
  v1::Request request;
  request.set_performer("suit.suit");
  request.mutable_calibrate()->set_sensors(v1::Calibrate::SENSORS_YAW);
  EXPECT_EQ(control.Ask(request).code(), v1::CODE_NOT_READY) << "no full reset yet";
  request.mutable_calibrate()->set_sensors(v1::Calibrate::SENSORS_FULL);
  const v1::Reply reply = control.Ask(request);
  EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  stage.ExpectTheMotion();
}

TEST(SlimeVrRigTest, TrackersOnNoPartAreNamedInTheLogOnceAndCounted) {
  Stage stage(Boards(1, {"unplaced", "leftFoot"}));
  stage.Hold({}, 2.5);
  ControlClient control(stage.daemon.control);
  EXPECT_GT(control.Counter("source.ignored"), 50U);
  EXPECT_EQ(stage.daemon.Stop(), 0);
  const std::string log = stage.daemon.Log();
  const std::size_t named = log.find(rigs::SlimeVrTrackerId(1, 0) + " is assigned to no joint");
  ASSERT_NE(named, std::string::npos) << log;
  EXPECT_EQ(log.find("is assigned to no joint", named + 40), std::string::npos) << log;
}

TEST(SlimeVrRigTest, ATrackerThatFallsSilentIsHeldAndTheOthersGoOn) {
  Stage stage(OnePerBoard({}));
  stage.Hold({}, 2);
  const std::size_t before = stage.subscriber->Frames(kTopic).size();
  EXPECT_GT(before, 100U);
  stage.Silence(9);  // the left foot
  stage.Hold({}, 1);
  ControlClient control(stage.daemon.control);
  EXPECT_GT(control.Counter("stylist.held"), 0U);
  const auto frames = stage.subscriber->Frames(kTopic);
  EXPECT_GT(frames.size(), before + 80);
  for (const float value : frames.back().rotations()) EXPECT_TRUE(std::isfinite(value));
}

}  // namespace
}  // namespace styled::support

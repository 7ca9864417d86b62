#include "daemon/source/rigs/tracker_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/config/sources.h"
#include "daemon/perform/performer/body_binding.h"
#include "proto/styled/v1/body.pb.h"
#include "tests/support/count_new.h"
#include "tests/support/native_frames.h"
#include "tests/support/units.h"

namespace styled::source {
namespace {

using config::CheckTrackers;
using slimevr::kIsIpv4;
using slimevr::ParseTrackerId;
using slimevr::TrackerId;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using support::kMs;

config::Source Config(std::vector<config::Tracker> trackers = {}) {
  config::Source config;
  config.name = "stage";
  config.type = "slimevr";
  config.trackers = std::move(trackers);
  return config;
}

// A TrackerRig with its events.
struct RigBench final : Receiver {
  explicit RigBench(const config::Source& config) : rig(config) {}

  void Tick(std::int64_t at_ns) {
    outbox.Open(*this, -1);
    rig.Tick(at_ns, outbox);
    outbox.Close();
  }
  int PartOf(std::string_view id, int position = 0) {
    outbox.Open(*this, -1);
    const int part = rig.PartOf(ParseTrackerId(id).value(), position, now_ns, outbox);
    outbox.Close();
    return part;
  }

  void OnFrames(int, std::span<const SourceFrame> received, bool) override {
    for (const SourceFrame& frame : received) {
      sessions.push_back(frame.session);
      if (frame.is_body) {
        ASSERT_TRUE(ReadBody(frame, bodies.emplace_back()));
      } else {
        sequences.push_back(frame.sequence);
        frames.push_back(support::AsMessage(frame));
      }
    }
  }
  void OnNote(int, const std::string& text) override { notes.push_back(text); }

  std::int64_t now_ns = 0;
  runtime::Counters counters;
  Outbox outbox{0, counters};
  TrackerRig rig;
  std::vector<v1::Body> bodies;
  std::vector<v1::SourceFrame> frames;
  std::vector<std::uint64_t> sessions, sequences;
  std::vector<std::string> notes;
};

// Upright and facing ahead is, with +Z up, a quarter turn about x.
slimevr::Orientation Upright(float heading = 0) {
  const float k = 0.70710678F, c = std::cos(heading / 2), s = std::sin(heading / 2);
  return {{k * c, k * s, k * s, k * c}, true};
}

TEST(TrackerId, IsReadAsPeopleWriteIt) {
  const TrackerId expected{0xA848FAC01D42, 1};
  EXPECT_EQ(ParseTrackerId("A848FAC01D42/1"), expected);
  EXPECT_EQ(ParseTrackerId("a8:48:fa:c0:1d:42/1"), expected);
  EXPECT_EQ(ParseTrackerId("A848FAC01D42"), (TrackerId{0xA848FAC01D42, 0}));
  EXPECT_EQ(ParseTrackerId("192.168.1.7/2"), (TrackerId{kIsIpv4 | 0xC0A80107, 2}));
  EXPECT_EQ(ToText(expected), "A848FAC01D42/1");
  EXPECT_EQ(ToText(*ParseTrackerId("000102030405")), "000102030405/0");
  EXPECT_EQ(ToText(*ParseTrackerId("192.168.1.7/2")), "192.168.1.7/2");
}

TEST(TrackerId, IsNotMadeOfOtherText) {
  for (const std::string_view text :
       {"", "A848FAC01D4", "A848FAC01D422", "A848FAC01D4G", "A8:48:FA:C0:1D", "A848FAC01D42/",
        "A848FAC01D42/256", "A848FAC01D42/-1", "A848FAC01D42/1x", "1.2.3", "1.2.3.256", "1.2.3.4.5",
        "1..2.3", "A8 48 FA C0 1D 42", "A:8:4:8:F:A:C:0:1:D:4:2"}) {
    EXPECT_FALSE(ParseTrackerId(text).has_value()) << text;
  }
}

TEST(TrackerTable, IsCheckedRowByRow) {
  const auto message = [](std::vector<config::Tracker> rows) {
    return CheckTrackers(rows).message();
  };
  EXPECT_TRUE(CheckTrackers({{"A848FAC01D42", "hips"}, {"A848FAC01D42/1", "chest"}}).ok());
  EXPECT_THAT(message({{"hips", "A848FAC01D42"}}), HasSubstr("12 hexadecimal"));
  EXPECT_THAT(message({{"A848FAC01D42", "knee"}}), HasSubstr("expected a joint"));
  EXPECT_THAT(message({{"A848FAC01D42", "hips"}, {"a8:48:fa:c0:1d:42/0", "head"}}),
              HasSubstr("given twice"));
  EXPECT_THAT(message({{"A848FAC01D42", "hips"}, {"A848FAC01D43", "hips"}}),
              HasSubstr("another tracker"));
}

TEST(TrackerRig, SaysWhatIsWrongInItsTableAndUsesTheRest) {
  RigBench bench(Config({{"A848FAC01D42", "hips"}, {"A848FAC01D43", "knee"}}));
  bench.Tick(0);
  ASSERT_EQ(bench.notes.size(), 1U);
  EXPECT_THAT(bench.notes[0], HasSubstr("knee"));
  EXPECT_EQ(bench.PartOf("A848FAC01D42"), body::kHips);
  EXPECT_EQ(bench.PartOf("A848FAC01D43"), TrackerRig::kUnassigned);
}

TEST(TrackerRig, NamesEachTrackerOnce) {
  RigBench bench(Config({{"A848FAC01D42", "hips"}}));
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(bench.PartOf("A848FAC01D42"), body::kHips);
    EXPECT_EQ(bench.PartOf("A848FAC01D43/1"), TrackerRig::kUnassigned);
  }
  EXPECT_THAT(bench.notes, ElementsAre(HasSubstr("A848FAC01D42/0 is worn on hips"),
                                       HasSubstr("full reset"), HasSubstr("A848FAC01D43/1")));
}

TEST(TrackerRig, LetsTheTableGoBeforeWhatATrackerSaysOfItself) {
  RigBench bench(Config({{"A848FAC01D42", "head"}, {"A848FAC01D43", "leftFoot"}}));
  EXPECT_EQ(bench.PartOf("A848FAC01D42", 6), body::kHead);
  EXPECT_EQ(bench.PartOf("A848FAC01D44", 6), body::kHips);
  EXPECT_EQ(bench.PartOf("A848FAC01D45", 6), TrackerRig::kUnassigned) << "hips are taken";
  EXPECT_EQ(bench.PartOf("A848FAC01D46", 11), TrackerRig::kUnassigned) << "somebody's in the table";
  EXPECT_EQ(bench.PartOf("A848FAC01D47", 21), TrackerRig::kUnassigned) << "a finger";
  EXPECT_EQ(bench.PartOf("A848FAC01D48", 0), TrackerRig::kUnassigned);
  EXPECT_EQ(bench.PartOf("A848FAC01D48", 20), body::kRightShoulder) << "told later";
  EXPECT_EQ(bench.PartOf("A848FAC01D48", 0), body::kRightShoulder);
}

// SlimeVR's TrackerPosition.kt, by its names.
TEST(TrackerRig, KnowsSlimeVrsPositions) {
  const std::initializer_list<std::pair<int, int>> positions{
      {1, body::kHead},           {2, body::kNeck},          {4, body::kChest},
      {5, body::kSpine},          {6, body::kHips},          {7, body::kLeftUpperLeg},
      {8, body::kRightUpperLeg},  {9, body::kLeftLowerLeg},  {10, body::kRightLowerLeg},
      {11, body::kLeftFoot},      {12, body::kRightFoot},    {13, body::kLeftLowerArm},
      {14, body::kRightLowerArm}, {15, body::kLeftUpperArm}, {16, body::kRightUpperArm},
      {17, body::kLeftHand},      {18, body::kRightHand},    {19, body::kLeftShoulder},
      {20, body::kRightShoulder}};
  RigBench bench(Config());
  for (const auto& [position, joint] : positions) {
    EXPECT_EQ(bench.PartOf("A848FAC01D42/" + std::to_string(position), position), joint);
  }
  RigBench chest(Config());
  EXPECT_EQ(chest.PartOf("A848FAC01D42", 3), body::kChest);
}

TEST(TrackerRig, StandsInTheRestPoseUntilItIsCalibrated) {
  RigBench bench(Config());
  EXPECT_EQ(bench.rig.NextDeadline_ns(), Translator::kNever);
  EXPECT_FALSE(bench.rig.Calibrate(Calibration::kFull, 0).ok());
  for (std::int64_t ms = 0; ms < 100; ++ms) {
    bench.rig.Accept(body::kHips, Upright(0.01F * static_cast<float>(ms)), ms * kMs);
    bench.Tick(ms * kMs);
  }
  ASSERT_EQ(bench.frames.size(), 10U);
  for (const auto& frame : bench.frames) EXPECT_EQ(frame.rotations(3), 1);
  const Status yaw = bench.rig.Calibrate(Calibration::kYaw, 100 * kMs);
  EXPECT_THAT(yaw.message(), HasSubstr("hips had no full reset"));
  EXPECT_TRUE(bench.rig.Calibrate(Calibration::kFull, 100 * kMs).ok());
}

TEST(TrackerRig, SendsTheCanonicalBodyInMetresAtItsRate) {
  config::Source config = Config();
  config.rate_hz = 50;
  config.performer = "anna";
  RigBench bench(config);
  bench.rig.Accept(body::kHips, Upright(), 0);
  ASSERT_TRUE(bench.rig.Calibrate(Calibration::kFull, 0).ok());
  for (std::int64_t ms = 0; ms < 1000; ++ms) {
    bench.rig.Accept(body::kHips, Upright(), ms * kMs);
    bench.Tick(ms * kMs);
    EXPECT_GT(bench.rig.NextDeadline_ns(), ms * kMs);
  }
  ASSERT_EQ(bench.frames.size(), 50U);
  ASSERT_EQ(bench.bodies.size(), 1U);
  EXPECT_EQ(bench.bodies[0].performer(), "anna");
  EXPECT_EQ(bench.bodies[0].names_size(), body::kJointCount);
  EXPECT_EQ(bench.bodies[0].metres_per_unit(), 1);
  EXPECT_TRUE(pipeline::BindBody(bench.bodies[0], {}).ok());
  for (std::size_t i = 2; i < bench.frames.size(); ++i) {
    EXPECT_EQ(bench.frames[i].source_time_ns() - bench.frames[i - 1].source_time_ns(), 20'000'000U);
  }
  EXPECT_NEAR(bench.frames.back().root_position(1), 0.98F, 1e-3F);
  EXPECT_NEAR(std::abs(bench.frames.back().rotations(3)), 1, 1e-5F);
}

// 90 degrees to the left, in sensors' axes (+Z up) and in ours (+Y up).
TEST(TrackerRig, TurnsTheSensorsWorldUpright) {
  RigBench bench(Config());
  bench.rig.Accept(body::kHips, Upright(), 0);
  ASSERT_TRUE(bench.rig.Calibrate(Calibration::kFull, 0).ok());
  bench.rig.Accept(body::kHips, Upright(1.5707963F), kMs);
  bench.Tick(20 * kMs);
  ASSERT_FALSE(bench.frames.empty());
  const auto& r = bench.frames.back().rotations();
  EXPECT_NEAR(r[0], 0, 1e-5F);
  EXPECT_NEAR(r[1] * r[3], 0.5F, 1e-5F);
  EXPECT_NEAR(r[2], 0, 1e-5F);
}

TEST(TrackerRig, TakesNothingThatIsNotUsable) {
  RigBench bench(Config());
  bench.rig.Accept(body::kHips, {{0, 0, 0, 1}, false}, 0);
  EXPECT_FALSE(bench.rig.Calibrate(Calibration::kFull, 0).ok());
}

TEST(TrackerRig, BeginsASessionWithEveryReset) {
  RigBench bench(Config());
  bench.rig.Accept(body::kHips, Upright(), 0);
  ASSERT_TRUE(bench.rig.Calibrate(Calibration::kFull, 0).ok());
  bench.Tick(0);
  const std::uint64_t first = bench.sessions.back();
  bench.Tick(10 * kMs);
  EXPECT_EQ(bench.sessions.back(), first);
  ASSERT_TRUE(bench.rig.Calibrate(Calibration::kYaw, 10 * kMs).ok());
  bench.Tick(20 * kMs);
  EXPECT_NE(bench.sessions.back(), first);
  EXPECT_EQ(bench.bodies.size(), 2U) << "each session has its body";
}

TEST(TrackerRig, SaysWhatAResetLeft) {
  RigBench bench(Config());
  bench.rig.Accept(body::kHips, Upright(), 0);
  ASSERT_TRUE(bench.rig.Calibrate(Calibration::kFull, 0).ok());
  bench.rig.Accept(body::kHead, Upright(), kMs);
  bench.Tick(kMs);
  EXPECT_THAT(bench.notes, ElementsAre(HasSubstr("calibrated hips")));
  ASSERT_TRUE(bench.rig.Calibrate(Calibration::kYaw, kMs).ok());
  bench.Tick(2 * kMs);
  EXPECT_THAT(bench.notes.back(), HasSubstr("head"));
  EXPECT_THAT(bench.rig.Calibrate(Calibration::kMounting, 2 * kMs).message(), HasSubstr("hips"));
}

TEST(TrackerRig, FallsSilentWithItsTrackersAndComesBack) {
  RigBench bench(Config());
  bench.rig.Accept(body::kHips, Upright(), 0);
  ASSERT_TRUE(bench.rig.Calibrate(Calibration::kFull, 0).ok());
  for (std::int64_t ms = 0; ms <= 1000; ms += 10) bench.Tick(ms * kMs);
  EXPECT_EQ(bench.frames.size(), 31U) << "as long as the last sample is not stale";
  EXPECT_EQ(bench.rig.NextDeadline_ns(), Translator::kNever);
  bench.rig.Accept(body::kHips, Upright(), 2000 * kMs);
  bench.Tick(2000 * kMs);
  EXPECT_EQ(bench.frames.size(), 32U);
}

TEST(TrackerRig, ThatWasHeldUpLeavesFramesOutAndSaysHowMany) {
  RigBench bench(Config());
  bench.rig.Accept(body::kHips, Upright(), 0);
  ASSERT_TRUE(bench.rig.Calibrate(Calibration::kFull, 0).ok());
  bench.Tick(0);
  bench.Tick(50 * kMs);
  EXPECT_EQ(bench.frames.size(), 6U) << "caught up with";
  bench.Tick(250 * kMs);
  ASSERT_EQ(bench.frames.size(), 7U);
  EXPECT_EQ(bench.sequences.back() - bench.sequences[5], 20U);
  EXPECT_EQ(bench.frames.back().source_time_ns() - bench.frames[5].source_time_ns(), 200'000'000U);
}

TEST(TrackerRig, DoesNotAllocateFromTheSecondFrameOn) {
  RigBench bench(Config());
  bench.frames.reserve(64);
  bench.rig.Accept(body::kHips, Upright(), 0);
  ASSERT_TRUE(bench.rig.Calibrate(Calibration::kFull, 0).ok());
  bench.Tick(0);
  bench.Tick(10 * kMs);
  bench.outbox.Open(bench, -1);
  int calls = 0;
  {
    const support::CountNew count;
    for (std::int64_t ms = 20; ms < 200; ms += 10) {
      bench.rig.Accept(body::kHips, Upright(0.001F * static_cast<float>(ms)), ms * kMs);
      bench.rig.Tick(ms * kMs, bench.outbox);
    }
    calls = count.calls();
  }
  bench.outbox.Close();
  EXPECT_EQ(calls, 0);
  EXPECT_EQ(bench.frames.size(), 20U);
}

}  // namespace
}  // namespace styled::source

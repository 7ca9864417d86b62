#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/config/sources.h"
#include "daemon/source/rigs/device_rig.h"
#include "daemon/source/rigs/vmc.h"
#include "daemon/source/rigs/vrchat.h"
#include "model/synthetic/performer.h"
#include "proto/rigs/types.h"
#include "sim/rigs/vmc_trackers.h"
#include "sim/rigs/vrchat.h"
#include "tests/support/translation.h"
#include "tests/unit/vrchat/message_cases.h"

namespace styled::source {
namespace {

using runtime::Counter;
using ::testing::HasSubstr;
using vrchat::testing::Bundle;
using vrchat::testing::Bytes;
using vrchat::testing::SystemMessage;
using vrchat::testing::TrackerMessage;

constexpr std::int64_t kFrame_ns = 10'000'000;
constexpr float kDegrees = 57.29578F;

config::Source Config(const std::string& type, std::vector<config::Tracker> trackers = {}) {
  config::Source config;
  config.name = "stage";
  config.type = type;
  config.trackers = std::move(trackers);
  return config;
}

// A stand-in's frames through a translator.
struct Stage {
  Stage(std::unique_ptr<Translator> translator, std::unique_ptr<rigs::Rig> made)
      : out(std::move(translator)), rig(std::move(made)) {}

  void Play(const body::Pose& pose, int frames) {
    for (int i = 0; i < frames; ++i) {
      rig->Encode({index, static_cast<double>(index) / 100, {&pose, 1}},
                  [this](std::span<const std::byte> bytes) { out.Handle(bytes); });
      ++index;
      out.now_ns += kFrame_ns;
      out.Tick();
    }
  }
  Status Calibrate() { return out.translator().Calibrate(Calibration::kFull, out.now_ns); }
  body::Pose Last() const {
    const auto pose = support::CanonicalPose(out.Bodies().back(), out.Frames().back());
    EXPECT_TRUE(pose.has_value());
    return pose.value_or(body::Pose());
  }

  support::Translated out;
  std::unique_ptr<rigs::Rig> rig;
  std::uint64_t index = 0;
};

Stage VrChat(std::vector<std::string> quirks, std::vector<config::Tracker> trackers = {}) {
  return {MakeVrChat(Config("vrchat", std::move(trackers))),
          std::move(rigs::MakeVrChat({{"sim"}, 100, 3, std::move(quirks)}).value())};
}
Stage Vmc(std::vector<std::string> quirks, std::vector<config::Tracker> trackers = {}) {
  quirks.emplace_back("trackers");
  return {MakeVmc(Config("vmc", std::move(trackers))),
          std::move(rigs::MakeVmcTrackers({{"sim"}, 100, 3, std::move(quirks)}).value())};
}

std::vector<body::Pose> Walk() {
  synthetic::Options options;
  options.script = synthetic::ParseScript("walk:2,wave-left:2").value();
  synthetic::Performer performer(options);
  std::vector<body::Pose> poses;
  for (double time_s = 0.3; time_s < 4; time_s += 0.7) {
    performer.Pose(time_s, poses.emplace_back());
  }
  return poses;
}

// The parts with devices, in the world: rotations within 2 degrees, as far as devices that are 3 cm
// off tell the heading; the hips within 3 cm.
void ExpectFollowed(Stage& stage, const std::vector<int>& parts) {
  for (const body::Pose& pose : Walk()) {
    stage.Play(pose, 30);
    body::WorldPose found, expected;
    const body::Pose last = stage.Last();
    body::ForwardKinematics(last, found);
    body::ForwardKinematics(pose, expected);
    for (const int part : parts) {
      const auto j = static_cast<std::size_t>(part);
      EXPECT_LT(kDegrees * found.rotations[j].angularDistance(expected.rotations[j]), 2)
          << body::kHumanoid[j].name;
    }
    EXPECT_LT((last.hips_position_m - pose.hips_position_m).norm(), 0.03F);
  }
}

TEST(VrChatTranslator, FollowsEightTrackersAndTheHeadHoweverTheyAreMountedAndOrdered) {
  for (const std::vector<std::string>& quirks : std::vector<std::vector<std::string>>{
           {}, {"single"}, {"mounted"}, {"mounted", "shuffled", "single"}}) {
    Stage stage = VrChat(quirks);
    stage.Play({}, 20);
    ASSERT_TRUE(stage.Calibrate().ok());
    ExpectFollowed(
        stage, {body::kHips, body::kChest, body::kLeftFoot, body::kRightFoot, body::kLeftUpperLeg,
                body::kRightUpperLeg, body::kLeftUpperArm, body::kRightUpperArm});
    EXPECT_EQ(stage.out.Count(Counter::kSourceMalformed), 0U);
    EXPECT_EQ(stage.out.Count(Counter::kSourceIgnored), 0U);
  }
}

TEST(VrChatTranslator, TakesHeadAndWristsThatVrChatSends) {
  Stage stage = VrChat({"vrsystem"});
  stage.Play({}, 20);
  ASSERT_TRUE(stage.Calibrate().ok());
  ExpectFollowed(stage, {body::kHips, body::kHead, body::kLeftHand, body::kRightHand});
}

TEST(VrChatTranslator, StandsInTheRestPoseUntilItIsCalibratedAndSaysSo) {
  Stage stage = VrChat({});
  body::Pose raised;
  raised.rotations[body::kLeftUpperArm] = body::Quat(Eigen::AngleAxisf(1, body::Vec3::UnitZ()));
  stage.Play(raised, 20);
  EXPECT_LT(support::Between(stage.Last(), body::Pose()).joint_deg, 0.1F);
  EXPECT_TRUE(stage.out.translator().has_sensors());
  EXPECT_THAT(stage.out.notes, ::testing::Contains(HasSubstr("\"1\" is worn on hips")));
  EXPECT_THAT(stage.out.translator().Calibrate(Calibration::kYaw, stage.out.now_ns).message(),
              HasSubstr("full"));
  ASSERT_TRUE(stage.Calibrate().ok());
  const auto session = stage.out.items.back().session;
  stage.Play({}, 20);
  EXPECT_THAT(stage.out.notes.back(), HasSubstr("facing"));
  EXPECT_NE(stage.out.items.back().session, session) << "the pose jumps";
}

TEST(VrChatTranslator, ATrackerThatVanishesIsNotTrackedAndComesBack) {
  Stage stage = VrChat({"rightUpperArm", "hips", "head", "vanish"});
  stage.Play({}, 50);
  ASSERT_TRUE(stage.Calibrate().ok());
  // The last of the devices, the head's, is gone from 2 s to 3 s.
  stage.Play({}, 220);
  const auto nan_at = [&stage](int joint) {
    return std::isnan(stage.out.Frames().back().rotations(4 * joint));
  };
  EXPECT_TRUE(nan_at(body::kSpine)) << "it leant by the head";
  EXPECT_FALSE(nan_at(body::kHips));
  stage.Play({}, 60);
  EXPECT_FALSE(nan_at(body::kSpine));
}

TEST(VrChatTranslator, CountsWhatIsNotForIt) {
  support::Translated out(MakeVrChat(Config("vrchat")));
  out.Handle(vmc::testing::S("/avatar/parameters/x") + vmc::testing::S(",f") + vmc::testing::F(1));
  EXPECT_EQ(out.Count(Counter::kSourceIgnored), 1U);
  const float nan = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
  out.Handle(TrackerMessage("1", "position", {nan, 0, 0}));
  out.Handle(TrackerMessage("1", "position", {infinity, 0, 0}));
  out.Handle(TrackerMessage("1", "position", {1e30F, 0, 0}));
  out.Handle(TrackerMessage("1", "rotation", {nan, 0, 0}));
  out.Handle(TrackerMessage("1", "rotation", {1e30F, 0, 0}));
  out.Handle(TrackerMessage("head", "rotation", {0, nan, 0}));
  out.Handle(SystemMessage("head", {nan, nan, nan, 0, 0, 0}));
  out.Handle(vmc::testing::S("/tracking/trackers/1/position") + vmc::testing::S(",f"));
  out.Handle(vmc::testing::ToBytes("/tracking"));
  EXPECT_EQ(out.Count(Counter::kSourceMalformed), 9U);
  out.now_ns += kFrame_ns;
  out.Tick();
  EXPECT_TRUE(out.items.empty()) << "nobody is there";
}

TEST(VrChatTranslator, ADeviceBelongsToOneSender) {
  support::Translated out(MakeVrChat(Config("vrchat")));
  out.Handle(TrackerMessage("1", "position", {0, 1, 0}), 1);
  out.Handle(TrackerMessage("1", "position", {5, 1, 0}), 2);
  EXPECT_EQ(out.Count(Counter::kPipelineSecondSender), 1U);
  out.Handle(SystemMessage("head", {0, 1.5F, 0, 0, 0, 0}), 2);
  EXPECT_EQ(out.Count(Counter::kPipelineSecondSender), 1U) << "another device";
  out.now_ns += DeviceRig::kSilent_ns + 1;
  out.Handle(TrackerMessage("1", "position", {5, 1, 0}), 2);
  EXPECT_EQ(out.Count(Counter::kPipelineSecondSender), 1U);
}

TEST(VrChatTranslator, AHeadingBelongsToOneSender) {
  support::Translated out(MakeVrChat(Config("vrchat")));
  out.Handle(TrackerMessage("head", "rotation", {0, 20, 0}), 1);
  out.Handle(TrackerMessage("head", "rotation", {0, 90, 0}), 2);
  EXPECT_EQ(out.Count(Counter::kPipelineSecondSender), 1U);
  out.now_ns += DeviceRig::kSilent_ns + 1;
  out.Handle(TrackerMessage("head", "rotation", {0, 90, 0}), 2);
  EXPECT_EQ(out.Count(Counter::kPipelineSecondSender), 1U);
}

TEST(VrChatTranslator, AHeadingThatIsSentOnceStays) {
  support::Translated out(MakeVrChat(Config("vrchat")));
  out.Handle(TrackerMessage("head", "rotation", {0, 90, 0}), 1);
  for (int i = 0; i < 300; ++i) {
    out.Handle(TrackerMessage("head", "position", {0, 1.55F, 0}), 1);
    out.Handle(TrackerMessage("1", "position", {0, 0.95F, 0}), 1);
    out.Handle(TrackerMessage("1", "rotation", {0, 0, 0}), 1);
    out.now_ns += kFrame_ns;
    out.Tick();
  }
  ASSERT_TRUE(out.translator().Calibrate(Calibration::kFull, out.now_ns).ok());
  out.now_ns += kFrame_ns;
  out.Tick();
  EXPECT_THAT(out.notes.back(), HasSubstr("90 degrees by the head"));
}

TEST(VmcDevices, WithPartsByTheConfigurationAreFollowed) {
  std::vector<config::Tracker> table;
  const std::vector<int> parts{body::kHips,         body::kChest,         body::kLeftFoot,
                               body::kRightFoot,    body::kLeftUpperLeg,  body::kRightUpperLeg,
                               body::kLeftUpperArm, body::kRightUpperArm, body::kLeftHand,
                               body::kRightHand};
  for (const int part : parts) {
    table.push_back({rigs::VmcSerial(body::Joint(part)),
                     std::string(body::kHumanoid[static_cast<std::size_t>(part)].name)});
  }
  for (const std::vector<std::string>& quirks :
       std::vector<std::vector<std::string>>{{}, {"single"}, {"mounted", "shuffled", "local"}}) {
    Stage stage = Vmc(quirks, table);
    stage.Play({}, 80);
    ASSERT_TRUE(stage.out.translator().has_sensors());
    ASSERT_TRUE(stage.Calibrate().ok());
    ExpectFollowed(stage, parts);
    EXPECT_EQ(stage.out.Count(Counter::kSourceMalformed), 0U);
    EXPECT_EQ(stage.out.Count(Counter::kSourceIgnored) > 0, quirks.size() == 3);
  }
}

TEST(VmcDevices, WithoutPartsAreGuessedAndTheLogSaysSo) {
  Stage stage = Vmc({});
  stage.Play({}, 80);
  ASSERT_TRUE(stage.Calibrate().ok());
  stage.Play({}, 2);
  EXPECT_THAT(stage.out.notes.back(), HasSubstr("guessed by height and side: "));
  EXPECT_THAT(stage.out.notes.back(), HasSubstr("\"LHR-leftFoot\" on leftFoot"));
  EXPECT_THAT(stage.out.notes.back(), HasSubstr("\"HMD-0\" on head"));
  ExpectFollowed(stage, {body::kHips, body::kLeftFoot, body::kRightFoot, body::kLeftHand});
}

TEST(VmcDevices, KeepTheirCalibrationWhereAnotherIsRefused) {
  Stage stage = Vmc({});
  stage.Play({}, 80);
  ASSERT_TRUE(stage.Calibrate().ok());
  body::Pose sunk;
  sunk.hips_position_m.y() = -1;
  stage.Play(sunk, 30);
  EXPECT_THAT(stage.Calibrate().message(), HasSubstr("expected 0.2 to 5"));
  ExpectFollowed(stage, {body::kHips, body::kLeftFoot, body::kRightFoot, body::kLeftHand});
}

// A device of VMC: `kind` is Hmd, Con or Tra.
Bytes DeviceMessage(const std::string& kind, const std::string& serial, const body::Vec3& at_m) {
  return vmc::testing::S("/VMC/Ext/" + kind + "/Pos") + vmc::testing::S(",sfffffff") +
         vmc::testing::S(serial) + vmc::testing::Floats({at_m.x(), at_m.y(), at_m.z(), 0, 0, 0, 1});
}

TEST(VmcDevices, ADeviceThatIsWornThereEndsTheGuessOfAnother) {
  support::Translated out(MakeVmc(Config("vmc")));
  const auto play = [&out](bool with_display, int frames) {
    for (int i = 0; i < frames; ++i) {
      out.Handle(DeviceMessage("Tra", "top", {0, 1.6F, 0}));
      out.Handle(DeviceMessage("Tra", "belt", {0, 0.95F, 0}));
      if (with_display) out.Handle(DeviceMessage("Hmd", "display", {0.3F, 1.6F, 0}));
      out.now_ns += kFrame_ns;
      out.Tick();
    }
  };
  play(false, 80);
  ASSERT_TRUE(out.translator().Calibrate(Calibration::kFull, out.now_ns).ok());
  play(false, 10);
  ASSERT_THAT(out.notes.back(), HasSubstr("\"top\" on head"));
  play(true, 100);
  const auto frames = out.Frames();
  const auto pose = [&](std::size_t back) {
    return support::CanonicalPose(out.Bodies().back(), frames[frames.size() - back]).value();
  };
  EXPECT_LT(support::Between(pose(1), pose(2)).joint_deg, 0.01F) << "two devices on one head";
}

TEST(VmcDevices, WithoutAnyNumberAreMalformed) {
  support::Translated out(MakeVmc(Config("vmc")));
  const float nan = std::nanf("");
  for (int i = 0; i < 100; ++i) {
    out.Handle(vmc::testing::S("/VMC/Ext/Tra/Pos") + vmc::testing::S(",sfffffff") +
               vmc::testing::S("x") + vmc::testing::Floats({nan, nan, nan, nan, nan, nan, nan}));
    out.now_ns += kFrame_ns;
    out.Tick();
  }
  EXPECT_GT(out.Count(Counter::kSourceMalformed), 0U);
  EXPECT_TRUE(out.items.empty());
}

TEST(VmcDevices, OfASenderThatSendsBonesAreItsOwnAffair) {
  support::Translated out(MakeVmc(Config("vmc")));
  const auto device = DeviceMessage("Hmd", "hmd", {0, 1.5F, 0});
  for (int i = 0; i < 100; ++i) {
    out.Handle(device);
    out.Handle(vmc::testing::BoneMessage("Hips", {0, 1, 0, 0, 0, 0, 1}));
    out.now_ns += kFrame_ns;
    out.Tick();
  }
  EXPECT_FALSE(out.translator().has_sensors());
}

TEST(VmcDevices, OfASecondAssistantAreRefused) {
  Stage stage = Vmc({});
  stage.Play({}, 80);
  stage.out.Handle(DeviceMessage("Tra", "x", {0, 1.5F, 0}), 2);
  EXPECT_EQ(stage.out.Count(Counter::kPipelineSecondSender), 1U);
}

TEST(VmcDevices, ARestartedSenderIsANewSessionAndKeepsItsCalibration) {
  Stage stage = Vmc({});
  stage.Play({}, 300);
  ASSERT_TRUE(stage.Calibrate().ok());
  stage.Play({}, 10);
  const auto session = stage.out.items.back().session;
  stage.index = 0;
  body::Pose low;
  low.hips_position_m.y() = 0.8F;
  stage.Play(low, 30);
  EXPECT_NE(stage.out.items.back().session, session);
  EXPECT_NEAR(stage.Last().hips_position_m.y(), 0.8F, 0.01F);
}

TEST(VmcDevices, DoNotAllocateOnceTheyAreKnown) {
  Stage stage = Vmc({});
  stage.Play({}, 80);
  ASSERT_TRUE(stage.Calibrate().ok());
  stage.Play({}, 20);
  Bytes last;
  const body::Pose pose;
  stage.rig->Encode(
      {stage.index, static_cast<double>(stage.index) / 100, {&pose, 1}},
      [&last](std::span<const std::byte> bytes) { last.assign(bytes.begin(), bytes.end()); });
  EXPECT_EQ(support::Allocations(stage.out.translator(), last, stage.out.now_ns), 0);
}

TEST(DeviceTable, IsCheckedRowByRow) {
  const auto message = [](const std::string& type, std::vector<config::Tracker> rows) {
    return config::CheckDevices(rows, *rigs::FindSourceType(type)->rig).message();
  };
  EXPECT_EQ(message("vmc", {{"LHR-1", "hips"}, {"LHR-2", "leftFoot"}}), "");
  EXPECT_EQ(message("vrchat", {{"1", "hips"}, {"vrsystem/head", "head"}}), "");
  EXPECT_THAT(message("vmc", {{"", "hips"}}), HasSubstr("serial"));
  EXPECT_THAT(message("vmc", {{std::string(65, 'x'), "hips"}}), HasSubstr("64 bytes"));
  EXPECT_THAT(message("vrchat", {{"9", "hips"}}), HasSubstr("1 to 8"));
  EXPECT_THAT(message("vrchat", {{"1", "knee"}}), HasSubstr("expected a joint"));
  EXPECT_THAT(message("vmc", {{"a", "hips"}, {"a", "chest"}}), HasSubstr("given twice"));
  EXPECT_THAT(message("vmc", {{"a", "hips"}, {"b", "hips"}}), HasSubstr("another tracker"));
}

}  // namespace
}  // namespace styled::source

// A real clip (Bandai-Namco-Research-Motiondataset) through every rig's protocol, at the rates that
// such rigs have: unstyled it comes out unchanged, and styled it comes out on the rig's own
// skeleton.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <map>

#include "model/rig/binding.h"
#include "model/rig/dialects.h"
#include "sim/player/clip_motion.h"
#include "sim/player/link.h"
#include "sim/rigs/slimevr.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/support/rig_run.h"

namespace styled::support {
namespace {

constexpr float kDegrees = 57.29578F;
constexpr double kFrom_s = 2;  // in the middle of the walk
constexpr double kSeconds = 2.5;
const std::string kClip = STYLED_PARITY_DATA "/dataset-1_walk_normal_001.bvh";
const std::string kWeights = STYLED_SOURCE_DIR "/model/weights/v2.safetensors";

struct Case {
  std::string type;
  double rate_hz;
  int joints;             // of the rig's own skeleton
  std::string hips;       // the joint's name there
  std::string performer;  // "" = suit.sim
  int may_lack = 0;
  std::vector<std::string> quirks = {};
  std::string stand_in = {};  // if it differs from the source's type

  std::string Name() const {
    std::string name = type;
    std::erase(name, '-');
    for (const std::string& quirk : quirks) name += quirk;
    return name + std::to_string(static_cast<int>(rate_hz));
  }
};

void PrintTo(const Case& value, std::ostream* out) { *out << value.Name(); }

const v1::Body* RigBodyOf(const RigResult& result, const Case& wanted) {
  for (const auto& body : result.bodies) {
    if (body.output() == v1::OUTPUT_RIG && body.names_size() == wanted.joints) return &body;
  }
  return nullptr;
}

float AngleBetween(const v1::Frame& a, const v1::Frame& b) {
  float worst = 0;
  for (int j = 0; 4 * j + 3 < std::min(a.rotations_size(), b.rotations_size()); ++j) {
    const auto at = [j](const v1::Frame& frame) {
      const auto& r = frame.rotations();
      return body::Quat(r[4 * j + 3], r[4 * j], r[4 * j + 1], r[4 * j + 2]);
    };
    worst = std::max(worst, kDegrees * at(a).angularDistance(at(b)));
  }
  return worst;
}

// For each styled frame, the largest distance of a joint from the captured one; returns the mean.
float MeanChange(const RigResult& result) {
  std::map<std::uint64_t, const v1::Frame*> captured;
  for (const auto& frame : result.source_frames) captured[frame.sequence()] = &frame;
  float sum = 0;
  int count = 0;
  for (const auto& frame : result.rig_frames) {
    if (frame.styles_size() == 0 || !captured.contains(frame.sequence())) continue;
    EXPECT_EQ(frame.styles(0).style(), "elderly");
    sum += AngleBetween(frame, *captured[frame.sequence()]);
    ++count;
  }
  EXPECT_GT(count, 40);
  return count == 0 ? 0 : sum / static_cast<float>(count);
}

class ClipRigTest : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kClip)) GTEST_SKIP() << "skipped, no data (set STYLED_DATA)";
  }
};

TEST_P(ClipRigTest, AClipIsPublishedUnchangedAndThenStyledOnTheRigsSkeleton) {
  const Case& wanted = GetParam();
  RigRun run;
  run.type = wanted.type;
  run.stand_in = wanted.stand_in;
  run.quirks = wanted.quirks;
  run.rate_hz = wanted.rate_hz;
  run.frames = static_cast<int>(kSeconds * wanted.rate_hz);
  run.expected_performer = wanted.performer;
  run.clip = kClip;
  run.clip_from_s = kFrom_s;
  run.weights = kWeights;
  run.style = "elderly";
  run.style_from_frame = run.frames / 2;
  const RigResult result = StreamAsRig(run);
  ExpectTheSameMotion(result, wanted.may_lack);
  EXPECT_GT(result.compared, run.frames / 2 - 3 - wanted.may_lack);
  std::cout << wanted.Name() << " Hz: " << result.worst_deg << " deg, " << result.worst_m * 1e3F
            << " mm at most";
  const v1::Body* const body = RigBodyOf(result, wanted);
  ASSERT_NE(body, nullptr);
  EXPECT_EQ(body->names(0), wanted.hips);
  for (const auto& frame : result.rig_frames) {
    ASSERT_EQ(frame.rotations_size(), 4 * wanted.joints);
    ASSERT_EQ(frame.body_hash(), body->hash());
  }
  const float change = MeanChange(result);
  EXPECT_GT(change, 5) << "degrees that the style turns some joint";
  std::cout << "; elderly turns some joint by " << change << " deg on average\n";
}

// "udp" and "tcp" are the native protocol, with the clip's own skeleton. Type 01 of MVN has angles
// in degrees and lengths in centimetres as floats; the rounding stays within the same half degree.
INSTANTIATE_TEST_SUITE_P(
    Rigs, ClipRigTest,
    testing::Values(
        Case{"vmc", 60, 21, "Hips", "suit.suit"}, Case{"mvn", 60, 23, "Pelvis", ""},
        Case{"mvn", 240, 23, "Pelvis", ""}, Case{"mvn", 60, 23, "Pelvis", "", 0, {"euler"}},
        Case{"mvn", 240, 23, "Pelvis", "", 0, {"euler"}},
        Case{"mvn-tcp", 240, 23, "Pelvis", "", 0, {}, "mvn"},
        Case{"mvn-tcp", 60, 23, "Pelvis", "", 0, {"euler"}, "mvn"},
        Case{"mocopi", 50, 27, "root", "suit.suit"}, Case{"mocopi", 60, 27, "root", "suit.suit"},
        Case{"natnet", 120, 21, "Hip", "", 24}, Case{"natnet", 240, 21, "Hip", "", 48},
        Case{"qtm", 120, 24, "Hips", "", 30},
        Case{"qtm", 240, 24, "Hips", "", 60, {"flat", "split"}}, Case{"rokoko", 100, 23, "hip", ""},
        Case{"rokoko", 100, 23, "hip", "", 0, {"lz4"}}, Case{"udp", 120, 21, "Hips", ""},
        Case{"tcp", 120, 21, "Hips", ""}),
    [](const auto& test) { return test.param.Name(); });

// A SlimeVR frame is the pose at an instant of the daemon's clock, between two frames of the clip.
// It is compared, with all parts at once, with the nearest instant of the clip. If this process was
// delayed while it sent the trackers of one instant, their values belong to different instants;
// such frames, which occur on a busy machine, are skipped.
class SlimeVrClipTest : public ClipRigTest {
 protected:
  const std::vector<int> worn_{body::kHips,          body::kChest,         body::kHead,
                               body::kLeftUpperArm,  body::kLeftLowerArm,  body::kRightUpperArm,
                               body::kRightLowerArm, body::kLeftUpperLeg,  body::kLeftLowerLeg,
                               body::kLeftFoot,      body::kRightUpperLeg, body::kRightLowerLeg,
                               body::kRightFoot};

  void LoadPoses(double rate_hz) {
    auto motion = player::ClipMotion::Make({kClip}, {.rate_hz = rate_hz});
    ASSERT_TRUE(motion.ok());
    const auto& body = motion.value()->body();
    auto binding = rig::BindDialect(body.skeleton, body.dialect);
    ASSERT_TRUE(binding.ok());
    rig::RigPose pose;
    for (int i = 0; i < static_cast<int>((kFrom_s + kSeconds) * rate_hz); ++i) {
      ASSERT_EQ(motion.value()->Next(pose), player::Motion::Step::kPose);
      if (i < static_cast<int>(kFrom_s * rate_hz)) continue;
      binding.value().Bind(pose, poses_.emplace_back());
    }
  }
  // The clip's poses at every millisecond.
  std::vector<body::WorldPose> Instants(double rate_hz) const {
    const int steps = static_cast<int>(1000 / rate_hz);
    std::vector<body::WorldPose> instants;
    for (std::size_t i = 0; i + 1 < poses_.size(); ++i) {
      for (int k = 0; k < steps; ++k) {
        body::Pose pose = poses_[i];
        for (std::size_t j = 0; j < body::kJointCount; ++j) {
          const float share = static_cast<float>(k) / static_cast<float>(steps);
          pose.rotations[j] = pose.rotations[j].slerp(share, poses_[i + 1].rotations[j]);
        }
        body::ForwardKinematics(pose, instants.emplace_back());
      }
    }
    return instants;
  }
  // The largest error of the tracked parts' global rotations, at the nearest instant.
  float WorstDegrees(const v1::Frame& frame, const std::vector<body::WorldPose>& instants) const {
    body::Pose got;
    for (int j = 0; j < body::kJointCount; ++j) {
      const auto& r = frame.rotations();
      got.rotations[static_cast<std::size_t>(j)] =
          body::Quat(r[4 * j + 3], r[4 * j], r[4 * j + 1], r[4 * j + 2]);
    }
    body::WorldPose found;
    body::ForwardKinematics(got, found);
    float best = 180;
    for (const body::WorldPose& expected : instants) {
      float worst = 0;
      for (const int joint : worn_) {
        const auto j = static_cast<std::size_t>(joint);
        worst =
            std::max(worst, kDegrees * expected.rotations[j].angularDistance(found.rotations[j]));
      }
      best = std::min(best, worst);
    }
    return best;
  }

  static std::int64_t Now_ns() {
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
  }

  std::vector<body::Pose> poses_;
};

TEST_F(SlimeVrClipTest, TheSegmentsWithTrackersFollowWithinADegreeAt100Hz) {
  constexpr double kRate_hz = 100;
  constexpr std::int64_t kPeriod_ns = 10'000'000, kSteady_ns = 2'000'000;
  LoadPoses(kRate_hz);
  Daemon daemon({}, "[[source]]\nname = \"suit\"\ntype = \"slimevr\"\nlisten = \"127.0.0.1:0\"\n",
                {}, kWeights);
  std::vector<std::unique_ptr<rigs::Rig>> boards;
  std::vector<std::unique_ptr<player::Link>> links;
  for (std::size_t k = 0; k < worn_.size(); ++k) {
    const std::string part(body::kHumanoid[static_cast<std::size_t>(worn_[k])].name);
    boards.push_back(std::move(rigs::MakeSlimeVr({{"sim"}, kRate_hz, k + 1, {part}}).value()));
    links.push_back(std::move(player::Connect("udp://" + daemon.listens.at(2), 1000).value()));
  }
  const std::string canonical = "styled/suit.suit/canonical/";
  Subscriber subscriber(daemon.publish, {""});
  ASSERT_TRUE(subscriber.WaitFor([&] { return subscriber.LastStats().has_value(); }, 10));
  ControlClient control(daemon.control);
  std::uint64_t index = 0;
  const auto send = [&](const body::Pose& pose) {
    for (std::size_t k = 0; k < boards.size(); ++k) {
      const auto to = [&](std::span<const std::byte> bytes) {
        EXPECT_TRUE(links[k]->Send(bytes).ok());
      };
      std::array<std::byte, 256> bytes;
      for (std::size_t size; (size = links[k]->Receive(bytes)) > 0;) {
        boards[k]->Receive(std::span(bytes).first(size), to);
      }
      boards[k]->Encode({index, static_cast<double>(index) / kRate_hz, std::span(&pose, 1)}, to);
    }
    ++index;
  };
  Paced(200, kRate_hz, [&](int) { send({}); });  // the boards connect, and play both resets
  ASSERT_TRUE(subscriber.WaitForFrames(50, canonical));
  const std::size_t first = subscriber.Frames(canonical).size();
  std::vector<std::int64_t> unsteady_ns;
  const std::int64_t start_ns = Now_ns();
  Paced(static_cast<int>(poses_.size()), kRate_hz, [&](int i) {
    const auto due_ns = start_ns + static_cast<std::int64_t>(i * 1e9 / kRate_hz);
    send(poses_[static_cast<std::size_t>(i)]);
    for (const std::int64_t at_ns : {due_ns, Now_ns()}) {
      if (Now_ns() - due_ns > kSteady_ns) unsteady_ns.push_back(at_ns);
    }
  });
  const auto frames = subscriber.Frames(canonical);
  ASSERT_GT(frames.size(), first + poses_.size() / 2);
  const auto instants = Instants(kRate_hz);
  std::vector<float> worst;
  for (std::size_t i = first + 5; i < frames.size(); ++i) {
    const auto at_ns = static_cast<std::int64_t>(frames[i].source_time_ns());
    const auto is_near = [at_ns](std::int64_t ns) { return std::abs(at_ns - ns) < 2 * kPeriod_ns; };
    if (std::ranges::any_of(unsteady_ns, is_near)) continue;
    worst.push_back(WorstDegrees(frames[i], instants));
  }
  ASSERT_GT(worst.size(), poses_.size() / 10) << "the machine is too busy";
  std::sort(worst.begin(), worst.end());
  EXPECT_LT(worst.back(), 1);
  ASSERT_EQ(control.SetStyle("suit.suit", "elderly", 1, 0).code(), v1::CODE_OK);
  Paced(100, kRate_hz, [&](int i) { send(poses_[static_cast<std::size_t>(i)]); });
  ASSERT_TRUE(subscriber.WaitFor(
      [&] { return subscriber.Frames("styled/suit.suit/rig/").back().styles_size() > 0; }, 10));
  const auto styled = subscriber.Frames("styled/suit.suit/rig/").back();
  EXPECT_EQ(styled.styles(0).style(), "elderly");
  EXPECT_EQ(styled.rotations_size(), 4 * body::kJointCount);
  std::cout << "slimevr at 100 Hz: " << worst[worst.size() / 2] << " deg in half of the frames, "
            << worst[worst.size() * 9 / 10] << " in nine of ten, " << worst.back() << " at most of "
            << worst.size() << " frames\n";
}

}  // namespace
}  // namespace styled::support

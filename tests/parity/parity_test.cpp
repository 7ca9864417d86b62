// A BVH file through our code and through the real daemon, compared with the output of the
// trainer's own code: with committed tensors, and with live ones if libtorch is present. Tolerance:
// 1e-4 per component, float32; largest difference seen: see README.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "model/body/heading.h"
#include "model/clip/clip.h"
#include "model/net/erd/network.h"
#include "model/net/shipped_weights.h"
#include "model/rig/dialects.h"
#include "tests/parity/reference_file.h"
#include "tests/parity/through_daemon.h"
#include "tests/support/child.h"

namespace styled::parity {
namespace {

namespace fs = std::filesystem;
using body::kJointCount;
using body::Quat;

constexpr float kTolerance = 1e-4F;

struct Case {
  const char* name;
  fs::path clip;
  fs::path fixture;  // empty: computed by the trainer's code in this test
};
void PrintTo(const Case& the_case, std::ostream* out) { *out << the_case.name; }

// The largest difference and its place.
struct Largest {
  float value = 0;
  int frame = -1, component = -1;

  void Add(float difference, int at_frame, int at_component) {
    if (!(difference <= value)) *this = {difference, at_frame, at_component};  // also true for NaN
  }
  void Expect(const std::string& what) const {
    std::cout << what << ": largest difference " << value << '\n';
    EXPECT_LE(value, kTolerance) << what << ", frame " << frame << ", component " << component;
  }
};

Quat At(const Rotations& rotations, int joint) {
  return Quat(Eigen::Map<const Eigen::Vector4f>(rotations.data() + 4 * joint));
}

// q and -q are the same rotation.
void AddRotation(const Quat& a, const Quat& b, int frame, int joint, Largest& largest) {
  const float sign = a.coeffs().dot(b.coeffs()) < 0 ? -1.0F : 1.0F;
  for (int k = 0; k < 4; ++k) {
    largest.Add(std::abs(a.coeffs()[k] - sign * b.coeffs()[k]), frame, 4 * joint + k);
  }
}

fs::path Weights() {
  const fs::path shipped = fs::path(STYLED_SOURCE_DIR) / "model/weights/v2.safetensors";
  const char* other = std::getenv("STYLED_WEIGHTS");
  return fs::exists(shipped) || other == nullptr ? shipped : fs::path(other);
}

class Parity : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    if (!fs::exists(GetParam().clip)) GTEST_SKIP() << "skipped, no data (set STYLED_DATA)";
    auto clip = clip::ReadBvh(GetParam().clip);
    ASSERT_TRUE(clip.ok()) << clip.status().message();
    clip_ = std::move(clip.value());
    auto binding = rig::BindDialect(clip_.skeleton);
    ASSERT_TRUE(binding.ok()) << binding.status().message();
    auto network = erd::WideNetwork::Load(Weights());
    ASSERT_TRUE(network.ok()) << network.status().message();
    network_ = network.value();
    ReadReferenceOfCase();
    if (IsSkipped() || HasFatalFailure()) return;
    for (int frame = 0; frame < reference_.frames; ++frame) {
      binding.value().Bind(clip_.frames[frame], poses_.emplace_back());
    }
  }

  void ReadReferenceOfCase() {
    fs::path file = GetParam().fixture;
    support::TemporaryFolder folder;
    if (file.empty()) {
      file = folder / "reference.safetensors";
      support::Child trainer({STYLED_PARITY_REFERENCE, GetParam().clip, Weights(), file},
                             folder / "stderr.txt", {{"OMP_NUM_THREADS", "1"}});
      ASSERT_EQ(trainer.Wait(200).value_or(-1), 0) << support::ReadText(folder / "stderr.txt");
    }
    auto reference = ReadReference(file);
    ASSERT_TRUE(reference.ok()) << reference.status().message()
                                << ": run tests/parity/make_fixtures.sh";
    reference_ = std::move(reference.value());
    const std::string stale = file.string() + " was made from other ";
    ASSERT_EQ(reference_.weights_crc, FileCrc(Weights()).value())
        << stale << "weights than " << Weights() << ": run tests/parity/make_fixtures.sh";
    ASSERT_EQ(reference_.clip_crc, FileCrc(GetParam().clip).value())
        << stale << "motion than " << GetParam().clip << ": run tests/parity/make_fixtures.sh";
    auto schedule = ParseSchedule(reference_.schedule);
    ASSERT_TRUE(schedule.ok()) << schedule.status().message();
    schedule_ = std::move(schedule.value());
    ASSERT_GE(static_cast<int>(clip_.frames.size()), reference_.frames);
    ASSERT_GE(reference_.frames, 1000);
    for (const Segment& segment : schedule_) {  // each switch and the frame after it
      ASSERT_TRUE(reference_.outputs.contains(segment.first_frame));
      ASSERT_TRUE(reference_.outputs.contains(segment.first_frame + 1));
    }
  }

  std::vector<net::StyleWeight> MixAt(int frame) const {
    std::vector<net::StyleWeight> mix;
    for (const auto& [name, weight] : SegmentAt(schedule_, std::max(0, frame)).mix) {
      mix.push_back({net::FindStyle(network_->model().styles, name), weight});
    }
    return mix;
  }

  // Steps the network over the clip, with every switch `delay` frames late, and compares.
  void RunNetwork(int delay, Largest& reconstruction, Largest& styled) const {
    const erd::FeatureParameters& parameters = network_->features();
    erd::FeatureState memory;
    erd::WideNetwork::State state;
    network_->Start(state);
    for (int frame = 0; frame < reference_.frames; ++frame) {
      erd::Features features;
      (void)erd::ComputeFeatures(poses_[frame], parameters, memory, features);
      net::Prediction out;
      network_->Step(features, 0, MixAt(frame - delay), state, out);
      const auto expected = reference_.outputs.find(frame);
      if (expected == reference_.outputs.end()) continue;
      for (int joint = 0; joint < kJointCount; ++joint) {
        AddRotation(out.reconstruction.rotations[joint], At(expected->second.reconstruction, joint),
                    frame, joint, reconstruction);
        AddRotation(out.styled.rotations[joint], At(expected->second.styled, joint), frame, joint,
                    styled);
      }
    }
  }

  // How far the style raises the hips in each frame: by the network alone, since the references
  // have no heights.
  std::vector<Eigen::Vector3f> Rises_m() const {
    const erd::FeatureParameters& parameters = network_->features();
    erd::FeatureState memory;
    erd::WideNetwork::State state;
    network_->Start(state);
    std::vector<Eigen::Vector3f> rises_m;
    for (int frame = 0; frame < reference_.frames; ++frame) {
      erd::Features features;
      (void)erd::ComputeFeatures(poses_[frame], parameters, memory, features);
      net::Prediction out;
      network_->Step(features, 0, MixAt(frame), state, out);
      rises_m.emplace_back(0, out.styled.hips_height_m - out.reconstruction.hips_height_m, 0);
    }
    return rises_m;
  }

  void ExpectHeader(const v1::Frame& frame, int number) const {
    SCOPED_TRACE("frame " + std::to_string(number));
    EXPECT_EQ(frame.source_time_ns(), TimeOf_ns(clip_, number));
    EXPECT_EQ(frame.flags(), number == 0 ? v1::FLAG_NEW_SESSION : v1::FLAG_NONE);
    const Segment& segment = SegmentAt(schedule_, number);
    ASSERT_EQ(frame.styles_size(), static_cast<int>(segment.mix.size()));
    for (const auto& style : frame.styles()) {
      EXPECT_NE(std::find(segment.mix.begin(), segment.mix.end(),
                          std::pair(style.style(), style.weight())),
                segment.mix.end())
          << style.style() << " " << style.weight();
    }
  }

  // Compares the daemon's frames with `expect(frame, joint, outputs)` of the reference.
  template <typename Expected>
  void RunDaemon(bool absolute, const std::string& what, Expected expected) const {
    const auto published =
        StreamThroughDaemon(clip_, reference_.frames, schedule_, Weights(), absolute);
    ASSERT_EQ(static_cast<int>(published.size()), reference_.frames);
    const std::vector<Eigen::Vector3f> rises_m = Rises_m();
    Largest rotations, places;
    for (int frame = 0; frame < reference_.frames; ++frame) {
      ExpectHeader(published[frame], frame);
      ASSERT_EQ(published[frame].rotations_size(), 4 * kJointCount);
      const Eigen::Vector3f hips_m = poses_[frame].hips_position_m + rises_m[frame];
      for (int axis = 0; axis < 3; ++axis) {
        places.Add(std::abs(published[frame].root_position(axis) - hips_m[axis]), frame, axis);
      }
      const auto outputs = reference_.outputs.find(frame);
      if (outputs == reference_.outputs.end()) continue;
      for (int joint = 0; joint < kJointCount; ++joint) {
        const Quat found(Eigen::Map<const Eigen::Vector4f>(published[frame].rotations().data() +
                                                           4 * static_cast<std::ptrdiff_t>(joint)));
        AddRotation(found, expected(frame, joint, outputs->second), frame, joint, rotations);
      }
    }
    rotations.Expect("daemon, " + what);
    places.Expect("daemon, " + what + ", hips position");
  }

  clip::Clip clip_;
  Reference reference_;
  std::vector<Segment> schedule_;
  std::shared_ptr<const erd::WideNetwork> network_;
  std::vector<body::Pose> poses_;
};

TEST_P(Parity, FeaturesAreTheTrainers) {
  const erd::FeatureParameters& parameters = network_->features();
  erd::FeatureState memory;
  Largest features, headings;
  for (int frame = 0; frame < reference_.frames; ++frame) {
    erd::Features found;
    const float heading_rad = erd::ComputeFeatures(poses_[frame], parameters, memory, found);
    if (const auto row = reference_.features.find(frame); row != reference_.features.end()) {
      for (int i = 0; i < erd::kFeatureCount; ++i) {
        features.Add(std::abs(found[i] - row->second[i]), frame, i);
      }
    }
    if (const auto row = reference_.outputs.find(frame); row != reference_.outputs.end()) {
      const float turn_rad = std::remainder(heading_rad - row->second.heading_rad, 2 * EIGEN_PI);
      headings.Add(std::abs(turn_rad), frame, 0);
    }
  }
  // the real clip's fixture has headings only
  if (!reference_.features.empty()) features.Expect("features");
  headings.Expect("heading");
}

TEST_P(Parity, NetworkStepsAsTheTrainers) {
  Largest reconstruction, styled;
  RunNetwork(0, reconstruction, styled);
  reconstruction.Expect("reconstruction");
  styled.Expect("styled");
}

// The negative control: a switch that is one frame late differs, so switches are compared exactly.
TEST_P(Parity, ASwitchThatIsOneFrameLateIsSeen) {
  Largest reconstruction, styled;
  RunNetwork(1, reconstruction, styled);
  EXPECT_LE(reconstruction.value, kTolerance);
  EXPECT_GT(styled.value, 100 * kTolerance);
}

TEST_P(Parity, DaemonPublishesTheTrainersPoses) {
  RunDaemon(true, "absolute", [](int, int joint, const Outputs& outputs) {
    const Quat styled = At(outputs.styled, joint);
    return joint == body::kHips ? body::Yaw(outputs.heading_rad) * styled : styled;
  });
}

// in · rec⁻¹ · sty: the heading of the hips cancels, because the style delta acts from the right.
TEST_P(Parity, DaemonPublishesTheTrainersChangeOfStyle) {
  RunDaemon(false, "detail-preserving", [this](int frame, int joint, const Outputs& outputs) {
    return (poses_[frame].rotations[joint] * At(outputs.reconstruction, joint).conjugate() *
            At(outputs.styled, joint))
        .normalized();
  });
}

fs::path Fixture(const char* name) {
  return fs::path(STYLED_SOURCE_DIR) / "tests/parity/fixtures" / name;
}
fs::path Extracted(const char* name) { return fs::path(STYLED_PARITY_DATA) / name; }

std::vector<Case> Cases() {
  const fs::path synthetic = Fixture("synthetic.bvh");
  const fs::path real = Extracted("dataset-1_dance-short_normal_001.bvh");
  std::vector<Case> cases{{"Synthetic", synthetic, Fixture("synthetic.safetensors")},
                          {"Real", real, Fixture("real.safetensors")}};
  if (std::string(STYLED_PARITY_REFERENCE) != "") {
    cases.push_back({"SyntheticLive", synthetic, {}});
    cases.push_back({"RealLive", real, {}});
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(, Parity, testing::ValuesIn(Cases()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace styled::parity

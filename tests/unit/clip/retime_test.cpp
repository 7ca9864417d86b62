#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/body/random_pose.h"
#include "tests/unit/clip/motion.h"

namespace styled::clip {
namespace {

using body::Angle_rad;

constexpr double kRate_hz = 30;

// The times of frames at a constant rate of time: 1.25 plays a clip in 0.8 of its duration.
std::vector<double> Constant(std::size_t frames, double rate) {
  std::vector<double> times_s;
  for (std::size_t i = 0; i < frames; ++i) {
    times_s.push_back(static_cast<double>(i) / kRate_hz / rate);
  }
  return times_s;
}

double Apart(const rig::RigPose& a, const rig::RigPose& b) {
  double apart = 0;
  for (std::size_t joint = 0; joint < a.rotations.size(); ++joint) {
    apart = std::max<double>(apart, Angle_rad(a.rotations[joint], b.rotations[joint]));
    apart = std::max<double>(apart, (a.translations[joint] - b.translations[joint]).norm());
  }
  return apart;
}

TEST(Retime, OfNoFramesOrOneGivesNoneOrOne) {
  EXPECT_TRUE(Retime(Waving(kRate_hz, 0), {}).frames.empty());
  EXPECT_EQ(Retime(Waving(kRate_hz, 1), Constant(1, 1)).frames.size(), 1U);
}

TEST(Retime, ARateOfOneIsTheClip) {
  const Clip clip = Waving(kRate_hz, 200);
  const Clip out = Retime(clip, Constant(200, 1));
  ASSERT_EQ(out.frames.size(), clip.frames.size());
  for (std::size_t i = 0; i < clip.frames.size(); ++i) {
    EXPECT_LT(Apart(out.frames[i], clip.frames[i]), 1e-6) << i;
  }
  EXPECT_EQ(out.rate_hz, clip.rate_hz);
  EXPECT_EQ(out.skeleton, clip.skeleton);
  EXPECT_EQ(out.channels, clip.channels);
  EXPECT_EQ(out.end_sites, clip.end_sites);
}

TEST(Retime, AConstantRateShortensOrLengthensAndShowsTheMotionAtItsTimes) {
  const Clip clip = Waving(kRate_hz, 101);
  for (const auto& [rate, frames] : {std::pair(1.25, 81U), std::pair(0.8, 126U)}) {
    const Clip out = Retime(clip, Constant(101, rate));
    ASSERT_EQ(out.frames.size(), frames);
    EXPECT_EQ(out.rate_hz, kRate_hz);
    for (std::size_t i = 10; i + 10 < frames; ++i) {  // ends are stiffer
      EXPECT_LT(Apart(out.frames[i], At(rate * static_cast<double>(i) / kRate_hz)), 0.05)  // cm
          << rate << ", " << i;
    }
  }
}

TEST(Retime, BothEndsAreKeptWhereverTheyFall) {
  const Clip clip = Waving(kRate_hz, 77);
  for (const double rate : {0.5, 0.83, 0.99, 1.003, 1.1, 1.237, 1.9, 1e3}) {
    const Clip out = Retime(clip, Constant(77, rate));
    ASSERT_EQ(out.frames.size(), std::max<std::size_t>(1, std::lround(76 / rate)) + 1) << rate;
    EXPECT_LT(Apart(out.frames.front(), clip.frames.front()), 1e-6) << rate;
    EXPECT_LT(Apart(out.frames.back(), clip.frames.back()), 1e-6) << rate;
    EXPECT_EQ(out.frames.back().translations[1], clip.frames.back().translations[1]) << "constant";
  }
}

// A walk between two stands: time is warped smoothly, never runs back, and the stands' frames are
// as far apart as before.
TEST(Retime, TimeRisesAndPartsAtTheirOwnRateKeepTheirLength) {
  constexpr std::size_t kFrames = 301;
  Clip clip = Waving(kRate_hz, kFrames);
  const auto rate = [](std::size_t i) {
    const double time_s = static_cast<double>(i) / kRate_hz;
    return time_s < 3 || time_s > 7
               ? 1
               : 1 + 0.25 * std::pow(std::sin((time_s - 3) / 4 * std::numbers::pi), 2);
  };
  std::vector<double> times_s{0};
  for (std::size_t i = 0; i < kFrames; ++i) {
    // Where a frame shows which moment of the clip it is.
    clip.frames[i].translations[0] = Vec3(static_cast<float>(i), 0, 0);
    if (i > 0) times_s.push_back(times_s.back() + 1 / (kRate_hz * rate(i)));
  }
  const Clip out = Retime(clip, times_s);
  EXPECT_NEAR(static_cast<double>(out.frames.size() - 1) / kRate_hz, times_s.back(),
              0.5 / kRate_hz);
  EXPECT_LT(out.frames.size(), kFrames - 10);
  float before = -1, step_before = 1;
  for (const rig::RigPose& pose : out.frames) {
    const float moment = pose.translations[0].x(), step = moment - before;
    EXPECT_GT(step, 0.9F) << "at " << moment;
    EXPECT_LT(step, 1.3F) << "at " << moment;
    EXPECT_NEAR(step, step_before, 0.02F) << "no jump of the rate, at " << moment;
    const bool stands = moment < 89 || moment > 213;
    EXPECT_TRUE(!stands || std::abs(step - 1) < 0.005F) << step << " at " << moment;
    before = moment;
    step_before = step;
  }
}

}  // namespace
}  // namespace styled::clip

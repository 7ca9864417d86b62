#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "model/net/load.h"
#include "model/net/phase/stylizer.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/gait/performed.h"

namespace styled::phase {

inline constexpr float kRate_hz = 30;

inline Style StyleOfScript(const std::string& script, double seconds) {
  return StyleOf(gait::Analyse(gait::Perform(script, seconds, kRate_hz), kRate_hz));
}

// The synthetic performer, who walks, runs and stands, is the neutral of everybody.
inline Style TestNeutral() {
  const Weighted parts[] = {{StyleOfScript("walk:60", 12), 12},
                            {StyleOfScript("run:60", 8), 8},
                            {StyleOfScript("stand:60", 6), 6}};
  return MeanOf(parts);
}

// They bend their elbows, and lift their left arm while the left foot is in front.
inline constexpr float kElbow_rad = 0.6F, kLift_rad = 0.3F;
inline body::Pose Styled(body::Pose pose, float phase_rad) {
  const auto turn = [&pose](body::Joint joint, const body::Vec3& by) {
    pose.rotations[joint] = pose.rotations[joint] * body::Exp(by);
  };
  turn(body::kLeftLowerArm, {0, -kElbow_rad, 0});
  turn(body::kRightLowerArm, {0, kElbow_rad, 0});
  turn(body::kLeftUpperArm, {0, 0, kLift_rad * std::cos(phase_rad)});
  return pose;
}
inline std::vector<body::Pose> StyledWalk(double seconds, float rate_hz = kRate_hz) {
  const std::vector<body::Pose> walk = gait::Perform("walk:60", seconds, rate_hz);
  const std::vector<gait::Phase> phases = gait::PhasesOf(walk, rate_hz);
  std::vector<body::Pose> styled;
  for (std::size_t i = 0; i < walk.size(); ++i) {
    styled.push_back(Styled(walk[i], phases[i].phase_rad));
  }
  return styled;
}

inline net::Model TestModel() {
  const Style neutral = TestNeutral();
  net::Model model;
  model.rate_hz = kRate_hz;
  model.licence = "CC0-1.0";
  model.styles = {{.name = "neutral"}, {.name = "bent"}};
  neutral::Reference& reference = model.reference.emplace();
  reference.walking.rotations = neutral.walk->curve.mean;
  reference.running.rotations = neutral.run->curve.mean;
  reference.standing.rotations = *neutral.standing;
  return model;
}

// A file with the style "bent", of StyledWalk.
inline std::shared_ptr<const net::Stylizer> TestStylizer() {
  static const std::shared_ptr<const net::Stylizer> stylizer = [] {
    const support::TemporaryFolder folder;
    const std::filesystem::path file = folder / "phase.safetensors";
    const Style bent = StyleOf(gait::Analyse(StyledWalk(10), kRate_hz));
    const Status status = Write(file, TestModel(), {ToCode(TestNeutral()), ToCode(bent)});
    EXPECT_TRUE(status.ok()) << status.message();
    auto loaded = net::Load(file);
    EXPECT_TRUE(loaded.ok()) << loaded.status().message();
    return loaded.ok() ? loaded.value() : nullptr;
  }();
  return stylizer;
}

}  // namespace styled::phase

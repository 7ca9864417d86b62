#include "model/train/judge/gait.h"

#include <algorithm>
#include <cmath>

#include "model/body/heading.h"

namespace styled::judge {
namespace {

// A foot has passed the other when it is this far ahead of it, so that trembling feet that stand
// side by side do not count.
constexpr float kPassed_m = 0.03F;
constexpr double kChord_s = 0.5;    // the hips' path is measured in chords, so that sway does not
                                    // count as speed
constexpr double kHeading_s = 0.5;  // over which the heading is averaged

using body::Vec3;

// The frames at which one foot passes the other.
std::vector<std::size_t> Passings(std::span<const float> ahead_m) {
  std::vector<std::size_t> frames;
  int side = 0;  // of the foot that is ahead
  for (std::size_t i = 0; i < ahead_m.size(); ++i) {
    const int now = ahead_m[i] > kPassed_m ? 1 : ahead_m[i] < -kPassed_m ? -1 : 0;
    if (now == 0 || now == side) continue;
    if (side != 0) frames.push_back(i);
    side = now;
  }
  return frames;
}

float Range(std::span<const float> values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

// Adds to `mean` the range of `values` within each two steps.
void AddRanges(std::span<const float> values, std::span<const std::size_t> passings, Mean& mean) {
  Mean ranges;
  for (std::size_t k = 2; k < passings.size(); ++k) {
    ranges.Add(100 * Range(values.subspan(passings[k - 2], passings[k] - passings[k - 2])));
  }
  if (ranges.count > 0) mean.Add(ranges.value());
}

double PathSpeed_cm_s(std::span<const body::Pose> poses, double rate_hz) {
  const auto chord = static_cast<std::size_t>(std::lround(kChord_s * rate_hz));
  double path_m = 0;
  std::size_t frames = 0;
  for (std::size_t i = chord; i < poses.size(); i += chord) {
    Vec3 step = poses[i].hips_position_m - poses[i - chord].hips_position_m;
    step.y() = 0;
    path_m += step.norm();
    frames = i;
  }
  return 100 * path_m * rate_hz / static_cast<double>(frames);
}

}  // namespace

void Gait::Add(const Gait& clip) {
  for (const GaitColumn& column : kGaitColumns) {
    const Mean& figure = clip.*column.figure;
    if (figure.count > 0) (this->*column.figure).Add(figure.value());
  }
}

float KneeBend_deg(const body::WorldPose& world, int upper_leg) {
  const auto at = [&world, upper_leg](int below) {
    return world.positions_m[static_cast<std::size_t>(upper_leg + below)];
  };
  const Vec3 thigh = (at(1) - at(0)).normalized();
  const Vec3 shank = (at(2) - at(1)).normalized();
  return std::acos(std::clamp(thigh.dot(shank), -1.0F, 1.0F)) * 57.29578F;
}

std::vector<Vec3> SmoothHeadings(std::span<const body::WorldPose> worlds, double rate_hz) {
  std::vector<Vec3> raw;
  for (const body::WorldPose& world : worlds) {
    const float heading_rad = body::Heading_rad(world);
    raw.emplace_back(std::sin(heading_rad), 0, std::cos(heading_rad));
  }
  const auto half = static_cast<std::size_t>(std::lround(kHeading_s * rate_hz / 2));
  std::vector<Vec3> smooth;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    Vec3 sum = Vec3::Zero();
    const std::size_t end = std::min(raw.size(), i + half + 1);
    for (std::size_t k = i - std::min(i, half); k < end; ++k) sum += raw[k];
    smooth.push_back(sum.normalized());
  }
  return smooth;
}

Gait MeasureGait(std::span<const body::Pose> poses, double rate_hz) {
  Gait gait;
  std::vector<body::WorldPose> worlds(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) body::ForwardKinematics(poses[i], worlds[i]);
  if (static_cast<double>(poses.size()) > rate_hz) {
    gait.speed_cm_s.Add(PathSpeed_cm_s(poses, rate_hz));
  }
  for (const int leg : {body::kLeftUpperLeg, body::kRightUpperLeg}) {
    float least_deg = 180;
    for (const body::WorldPose& world : worlds) {
      const float bend_deg = KneeBend_deg(world, leg);
      least_deg = std::min(least_deg, bend_deg);
      gait.mean_knee_deg.Add(bend_deg);
    }
    if (!worlds.empty()) gait.lowest_knee_deg.Add(least_deg);
  }

  const std::vector<Vec3> headings = SmoothHeadings(worlds, rate_hz);
  const auto along = [&](int joint, int from) {
    std::vector<float> values;
    for (std::size_t i = 0; i < worlds.size(); ++i) {
      const auto& at = worlds[i].positions_m;
      values.push_back(headings[i].dot(at[static_cast<std::size_t>(joint)] -
                                       at[static_cast<std::size_t>(from)]));
    }
    return values;
  };
  const std::vector<float> ahead_m = along(body::kLeftFoot, body::kRightFoot);
  const std::vector<std::size_t> passings = Passings(ahead_m);
  if (passings.size() < 3) return gait;
  const double steps = static_cast<double>(passings.size()) - 1;
  gait.cadence_per_min.Add(60 * rate_hz * steps /
                           static_cast<double>(passings.back() - passings.front()));
  Mean step_cm;
  for (std::size_t k = 1; k < passings.size(); ++k) {
    float largest_m = 0;
    for (std::size_t i = passings[k - 1]; i < passings[k]; ++i) {
      largest_m = std::max(largest_m, std::abs(ahead_m[i]));
    }
    step_cm.Add(100 * largest_m);
  }
  gait.step_cm.Add(step_cm.value());
  std::vector<float> heights_m;
  for (const body::Pose& pose : poses) heights_m.push_back(pose.hips_position_m.y());
  AddRanges(heights_m, passings, gait.bob_cm);
  for (const int hand : {body::kLeftHand, body::kRightHand}) {
    AddRanges(along(hand, body::kHips), passings, gait.arm_swing_cm);
  }
  return gait;
}

}  // namespace styled::judge

#include "model/train/judge/foreign.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "model/body/heading.h"
#include "model/train/judge/metrics.h"

namespace styled::judge {
namespace {

constexpr double kStand_s = 2, kStay_s = 4;

body::Quat Bend(float degrees) {
  return body::Quat(Eigen::AngleAxisf(degrees / kDegrees, body::Vec3::UnitX()));
}

// `standing` with both legs bent (degrees: thigh forward, shank back, foot up) and the torso
// leaning forward.
body::Pose WithLegs(const body::Pose& standing, float thigh, float shank, float foot, float torso,
                    float hips_height_m) {
  body::Pose pose = standing;
  for (const int upper : {body::kLeftUpperLeg, body::kRightUpperLeg}) {
    pose.rotations[upper] = Bend(-thigh);
    pose.rotations[upper + 1] = Bend(shank);
    pose.rotations[upper + 2] = Bend(-foot);
  }
  pose.rotations[body::kSpine] = Bend(torso) * pose.rotations[body::kSpine];
  pose.hips_position_m.y() = hips_height_m;
  return pose;
}

// The whole body rotated about its left-right axis, with the hips at that height.
body::Pose Laid(const body::Pose& standing, float degrees, float hips_height_m) {
  body::Pose pose = standing;
  body::WorldPose world;
  body::ForwardKinematics(standing, world);
  const body::Quat heading = body::Yaw(body::Heading_rad(world));
  pose.rotations[body::kHips] =
      heading * Bend(degrees) * heading.conjugate() * standing.rotations[body::kHips];
  pose.hips_position_m.y() = hips_height_m;
  return pose;
}

ForeignMotion Motion(const char* name, const body::Pose& standing, const body::Pose& posture,
                     double over_s, double stay_s = kStay_s) {
  ForeignMotion motion{name, {}, 0, 0};
  const auto frames = [](double seconds) { return static_cast<int>(seconds * kStreamRate_hz); };
  const auto go = [&](const body::Pose& from, const body::Pose& to) {
    for (int i = 0; i < frames(over_s); ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(frames(over_s));
      body::Pose pose;
      body::Interpolate(from, to, u * u * (3 - 2 * u), pose);
      motion.poses.push_back(pose);
    }
  };
  motion.poses.insert(motion.poses.end(), frames(kStand_s), standing);
  go(standing, posture);
  motion.held_from = motion.poses.size();
  motion.poses.insert(motion.poses.end(), frames(stay_s), posture);
  motion.held_to = motion.poses.size();
  go(posture, standing);
  motion.poses.insert(motion.poses.end(), frames(kStand_s), standing);
  return motion;
}

float Lowest_m(const body::Pose& pose) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  float lowest = world.positions_m[0].y();
  for (const body::Vec3& position : world.positions_m) lowest = std::min(lowest, position.y());
  return lowest;
}

struct ForeignFigures {
  Mean reconstruction_deg;  // during the posture
  Mean flagged;             // the share of these frames that are flagged out of domain
  Mean styled_deg;          // in these frames, the joint that the style rotates most
  double deepest_cm = 0;    // below the input's lowest joint
  float turn_deg = 0, turn_in_deg = 0;

  nlohmann::json ToJson() const {
    return {{"reconstruction_deg", reconstruction_deg.value()},
            {"flagged", flagged.value()},
            {"styled_deg", styled_deg.value()},
            {"deepest_cm", deepest_cm},
            {"largest_turn_deg", turn_deg},
            {"input_largest_turn_deg", turn_in_deg}};
  }
};

Poses Run(const Styler& styler, const stylist::Options& options, int style,
          const ForeignMotion& motion, ForeignFigures& figures) {
  stylist::Stylist stylist(styler.network, styler.binding, options);
  stylist.Set(OneStyle(style, false));
  stylist::Output output(styler.binding->skeleton());
  rig::RigPose source(styler.binding->skeleton());
  Poses out;
  for (std::size_t i = 0; i < motion.poses.size(); ++i) {
    const body::Pose& in = motion.poses[i];
    source.translations[0] = in.hips_position_m;
    std::copy(in.rotations.begin(), in.rotations.end(), source.rotations.begin());
    stylist.Process(1 + std::llround(1e9 * static_cast<double>(i) / kStreamRate_hz), source,
                    output);
    if (i > 0) {
      figures.turn_deg = std::max(figures.turn_deg, Turn_deg(out.back(), output.canonical));
      figures.turn_in_deg = std::max(figures.turn_in_deg, Turn_deg(motion.poses[i - 1], in));
    }
    out.push_back(output.canonical);
    figures.deepest_cm =
        std::max(figures.deepest_cm, 100.0 * (Lowest_m(in) - Lowest_m(output.canonical)));
    if (i < motion.held_from || i >= motion.held_to) continue;
    figures.reconstruction_deg.Add(output.reconstruction_rad * kDegrees);
    figures.flagged.Add((output.flags & stylist::kOutOfDomain) != 0 ? 1 : 0);
    figures.styled_deg.Add(Turn_deg(in, output.canonical));
  }
  return out;
}

}  // namespace

std::vector<ForeignMotion> ForeignMotions(const body::Pose& standing) {
  std::vector<ForeignMotion> motions;
  motions.push_back(Motion("doing nothing", standing, standing, 0, 20));
  motions.push_back(Motion("sitting", standing, WithLegs(standing, 88, 92, 4, 5, 0.53F), 1.2));
  motions.push_back(
      Motion("crouching", standing, WithLegs(standing, 110, 145, 30, 35, 0.34F), 1.0));
  motions.push_back(Motion("falling on the back", standing, Laid(standing, -90, 0.12F), 0.5));
  motions.push_back(Motion("lying face down", standing, Laid(standing, 90, 0.12F), 1.5));
  return motions;
}

nlohmann::json JudgeForeign(const Data& data, const Styler& styler, const stylist::Options& options,
                            std::vector<Scene>& scenes) {
  std::printf(
      "\npostures that no training set has: error of rec, frames flagged, joint most turned by the "
      "style, lowest joint under the input's, largest turn between frames (input's)\n");
  nlohmann::json json;
  for (const ForeignMotion& motion : ForeignMotions(data.inputs.front().front())) {
    ForeignFigures figures;
    int shown = 0;
    for (int style = 1; style < static_cast<int>(styler.network->model().styles.size()); ++style) {
      Poses out = Run(styler, options, style, motion, figures);
      if (shown++ < 2) {
        scenes.push_back({motion.name,
                          styler.network->model().styles[static_cast<std::size_t>(style)].name,
                          motion.poses,
                          {},
                          std::move(out)});
      }
    }
    std::printf("  %-20s %5.1f deg  %5.1f %%  %6.1f deg  %5.1f cm  %5.1f deg (%.1f)\n",
                motion.name.c_str(), figures.reconstruction_deg.value(),
                100 * figures.flagged.value(), figures.styled_deg.value(), figures.deepest_cm,
                figures.turn_deg, figures.turn_in_deg);
    json[motion.name] = figures.ToJson();
  }
  return json;
}

}  // namespace styled::judge

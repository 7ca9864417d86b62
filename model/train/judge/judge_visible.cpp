#include "model/train/judge/judge_visible.h"

#include <cmath>

#include "model/body/heading.h"
#include "model/train/judge/judge_carriage.h"

namespace styled::judge {
namespace {

using body::kJointCount;
using body::Pose;
using body::Quat;
using body::WorldPose;

constexpr std::array<std::array<int, 2>, kVisibleLimbs.size()> kJoints{
    {{body::kHead, -1},
     {body::kLeftHand, body::kRightHand},
     {body::kLeftLowerArm, body::kRightLowerArm},
     {body::kLeftLowerLeg, body::kRightLowerLeg},
     {body::kLeftFoot, body::kRightFoot}}};

WorldPose InPlace(const Pose& pose) {
  Pose in_place = pose;
  in_place.hips_position_m.x() = in_place.hips_position_m.z() = 0;
  WorldPose world;
  body::ForwardKinematics(in_place, world);
  return world;
}

void Add(const Pose& pose, MeanCarriage& mean) {
  WorldPose world;
  body::ForwardKinematics(pose, world);
  for (int j = 0; j < kJointCount; ++j) {
    Quat rotation = pose.rotations[static_cast<std::size_t>(j)];
    if (j == body::kHips) rotation = body::Yaw(-body::Heading_rad(world)) * rotation;
    mean.Add(j, rotation);
  }
}

}  // namespace

void Visible::Add(const Visible& other) {
  turned_deg.Add(other.turned_deg);
  all_cm.Add(other.all_cm);
  for (std::size_t limb = 0; limb < moved_cm.size(); ++limb)
    moved_cm[limb].Add(other.moved_cm[limb]);
}

Visible MeasureVisible(std::span<const Pose> input, std::span<const Pose> output) {
  Visible visible;
  for (std::size_t i = 0; i < input.size(); ++i) {
    const WorldPose from = InPlace(input[i]), to = InPlace(output[i]);
    double turned_rad = 0, all_m = 0;
    int count = 0;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      turned_rad += static_cast<double>(
          body::Log(input[i].rotations[j].conjugate() * output[i].rotations[j]).norm());
    }
    visible.turned_deg.Add(turned_rad / kJointCount * static_cast<double>(kDegrees));
    for (std::size_t limb = 0; limb < kJoints.size(); ++limb) {
      for (const int joint : kJoints[limb]) {
        if (joint < 0) continue;
        const auto j = static_cast<std::size_t>(joint);
        const double moved_m =
            static_cast<double>((to.positions_m[j] - from.positions_m[j]).norm());
        visible.moved_cm[limb].Add(100 * moved_m);
        all_m += moved_m;
        ++count;
      }
    }
    visible.all_cm.Add(100 * all_m / count);
  }
  return visible;
}

Eigen::VectorXd MeasureShift(std::span<const Pose> input, std::span<const Pose> output) {
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(3 * kJointCount);
  for (std::size_t i = 0; i < input.size(); ++i) {
    for (int j = 0; j < kJointCount; ++j) {
      const auto joint = static_cast<std::size_t>(j);
      shift.segment<3>(3 * j) +=
          body::Log(input[i].rotations[joint].conjugate() * output[i].rotations[joint])
              .cast<double>();
    }
  }
  return input.empty() ? shift : Eigen::VectorXd(shift / static_cast<double>(input.size()));
}

Eigen::VectorXd RealShift(std::span<const train::TrainingClip> clips, int style, int content) {
  MeanCarriage unstyled, styled;
  for (const train::TrainingClip& clip : clips) {
    if (clip.content != content || (clip.style != 0 && clip.style != style)) continue;
    for (Pose pose : clip.poses) {
      MeanCarriage& mean = clip.style == 0 ? unstyled : styled;
      Add(pose, mean);
      body::Mirror(pose, pose);
      Add(pose, mean);
    }
  }
  if (!unstyled.any() || !styled.any()) return {};
  const neutral::Carriage from = unstyled.Value(), to = styled.Value();
  Eigen::VectorXd shift(3 * kJointCount);
  for (int j = 0; j < kJointCount; ++j) {
    const auto joint = static_cast<std::size_t>(j);
    shift.segment<3>(3 * j) =
        body::Log((from.rotations[joint].conjugate() * to.rotations[joint]).normalized())
            .cast<double>();
  }
  return shift;
}

int TellByDirection(const Eigen::VectorXd& shift, std::span<const Eigen::VectorXd> real) {
  int nearest = -1;
  double best = -2;
  if (shift.squaredNorm() == 0) return nearest;
  for (std::size_t i = 0; i < real.size(); ++i) {
    if (real[i].size() == 0) continue;
    const double cosine = MeasureExpression(shift, real[i]).cosine;
    if (cosine <= best) continue;
    best = cosine;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

}  // namespace styled::judge

#include "model/train/judge/visible.h"

#include <algorithm>

#include "model/body/heading.h"
#include "model/train/mean_carriage.h"

namespace styled::judge {
namespace {

using body::kJointCount;
using body::Pose;
using body::Quat;
using body::WorldPose;

void Add(const Pose& pose, train::MeanCarriage& mean) {
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

double Visible::most_cm() const {
  double most_cm = 0;
  for (const Mean& limb : moved_cm) most_cm = std::max(most_cm, limb.value());
  return most_cm;
}

bool Visible::unseen() const {
  stylist::Moved moved_m{};
  for (std::size_t limb = 0; limb < moved_m.size(); ++limb) {
    moved_m[limb] = static_cast<float>(moved_cm[limb].value() / 100);
  }
  return stylist::IsUnseen(moved_m);
}

Visible MeasureVisible(std::span<const Pose> input, std::span<const Pose> output) {
  Visible visible;
  for (std::size_t i = 0; i < input.size(); ++i) {
    double turned_rad = 0;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      turned_rad += static_cast<double>(
          body::Log(input[i].rotations[j].conjugate() * output[i].rotations[j]).norm());
    }
    visible.turned_deg.Add(turned_rad * static_cast<double>(kDegrees) /
                           static_cast<double>(kJointCount));
    const stylist::Moved moved_m = stylist::MovedBy(input[i], output[i]);
    double all_m = 0;
    int joints = 0;
    for (std::size_t limb = 0; limb < moved_m.size(); ++limb) {
      const int sides = limb == 0 ? 1 : 2;
      visible.moved_cm[limb].Add(100 * static_cast<double>(moved_m[limb]));
      all_m += sides * static_cast<double>(moved_m[limb]);
      joints += sides;
    }
    visible.all_cm.Add(100 * all_m / joints);
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
  train::MeanCarriage unstyled, styled;
  for (const train::TrainingClip& clip : clips) {
    if (clip.content != content || (clip.style != 0 && clip.style != style)) continue;
    for (Pose pose : clip.poses) {
      train::MeanCarriage& mean = clip.style == 0 ? unstyled : styled;
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

int ClassifyByDirection(const Eigen::VectorXd& shift, std::span<const Eigen::VectorXd> real) {
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

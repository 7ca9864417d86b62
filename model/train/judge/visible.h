#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "model/body/pose.h"
#include "model/stylist/visible.h"
#include "model/train/dataset.h"
#include "model/train/judge/metrics.h"

namespace styled::judge {

// The effect of a style on a clip of any performer, as pure functions of poses (metres, y up): how
// much of it is visible, and which of several styles it is. Needs no trained judge. Pinned by
// tests/unit/judge/visible_test.cpp.

using stylist::kVisibleLimbs;
// A style that moves none of these by this on average is faint (stylist::IsUnseen: not visible).
inline constexpr double kFaint_cm = 3;

// Of one clip in one style; a mean over clips after Add.
struct Visible {
  Mean turned_deg;  // by the rotation of a joint, mean of all joints
  std::array<Mean, kVisibleLimbs.size()>
      moved_cm;            // distance of each from the input's, without the hips' path
  Mean all_cm;             // the mean of the nine
  double most_cm() const;  // of the limb that is moved most
  bool unseen() const;

  void Add(const Visible& other);
};
// `input` and `output` are of one clip, frame for frame.
Visible MeasureVisible(std::span<const body::Pose> input, std::span<const body::Pose> output);

// The mean rotation of each joint by a style over a clip, rad: 3 numbers per joint in the order of
// body::Joint, a rotation vector in the joint's own frame.
Eigen::VectorXd MeasureShift(std::span<const body::Pose> input, std::span<const body::Pose> output);

// The same of real clips, which have no input: the turn from the mean rotations of neutral clips to
// those of clips of `style`, of one content, clips and mirror images alike; the hips' are relative
// to the heading. Empty if there are none of either.
Eigen::VectorXd RealShift(std::span<const train::TrainingClip> clips, int style, int content);

// The one of `real` whose direction is nearest to that of `shift`; -1 if `shift` is 0. Empty ones
// are left out.
int ClassifyByDirection(const Eigen::VectorXd& shift, std::span<const Eigen::VectorXd> real);

}  // namespace styled::judge

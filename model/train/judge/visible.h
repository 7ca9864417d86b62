#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "model/body/pose.h"
#include "model/stylist/visible.h"
#include "model/train/dataset.h"
#include "model/train/judge/metrics.h"

namespace styled::judge {

// What a style does to a clip of anybody, as pure functions of poses (metres, y up): how much of it
// is to be seen, and which of several styles it is. Needs no judge that was trained on somebody.
// Pinned by tests/unit/judge/visible_test.cpp.

using stylist::kVisibleLimbs;
// A style that moves none of these by this on average is faint (stylist::IsUnseen: not to be seen).
inline constexpr double kFaint_cm = 3;

// Of one clip in one style; a mean over clips after Add.
struct Visible {
  Mean turned_deg;  // by what a joint is turned, mean of all joints
  std::array<Mean, kVisibleLimbs.size()>
      moved_cm;            // how far each is from the input's, beside the hips' way
  Mean all_cm;             // the mean of the nine
  double most_cm() const;  // of the limb that is moved most
  bool unseen() const;

  void Add(const Visible& other);
};
// `input` and `output` are of one clip, frame for frame.
Visible MeasureVisible(std::span<const body::Pose> input, std::span<const body::Pose> output);

// The mean over a clip of what a style turns each joint by, rad: 3 numbers per joint in the order
// of body::Joint, a rotation vector in the joint's own frame.
Eigen::VectorXd MeasureShift(std::span<const body::Pose> input, std::span<const body::Pose> output);

// The same of real clips, which have no input: the turn from the mean rotations of neutral clips to
// those of clips of `style`, of one content, clips and mirror images alike; the hips' are against
// the heading. Empty where there are none of either.
Eigen::VectorXd RealShift(std::span<const train::TrainingClip> clips, int style, int content);

// Which of `real` points most in the direction of `shift`; -1 where it is 0. Those that are empty
// are left out.
int TellByDirection(const Eigen::VectorXd& shift, std::span<const Eigen::VectorXd> real);

}  // namespace styled::judge

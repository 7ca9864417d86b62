#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "model/body/pose.h"
#include "model/train/judge/metrics.h"

namespace styled::judge {

// How outputs of one source differ among each other, how they follow an example, and how they
// change between two styles: the measures for networks whose styles are a space of codes (Park et
// al. 2021). Pure functions; the recognition of the same outputs must always be reported with them,
// because variety outside the style is failure. FMD is FrechetDistance of
// Verdicts::content_features. Pinned by tests/unit/judge/variety_test.cpp.

// Joint positions of each frame in the heading frame of that frame, origin on the floor under the
// hips, metres; [3 * joints, frames].
using LocalClip = Eigen::MatrixXf;
LocalClip LocalPositions(std::span<const body::Pose> poses, double rate_hz);

// The mean over frames and joints of the distance between joints, cm, of two clips of equal length.
double Distance_cm(const LocalClip& a, const LocalClip& b);

// Average pairwise distance, cm: over all pairs of `set`, clips of equal length. Without a count
// for fewer than two.
Mean PairwiseDistance_cm(std::span<const LocalClip> set);

// The same between windows of `window` frames after the best shift in time: the middle of one clip
// against every window of the other. For real clips, which do not begin alike: the most variety
// that outputs can have. Clips shorter than a window are left out.
Mean ShiftedPairwiseDistance_cm(std::span<const LocalClip> set, int window);

// The mean pose of a clip: [3 * joints], metres.
Eigen::VectorXd MeanPoseOf(const LocalClip& clip);

// How far outputs move with their references: `reference` is the deviation of an example's mean
// pose from its style's mean, `output` that of the restyled clip's mean pose from the mean of all
// outputs in that style. Slope: the least-squares share of the deviation that arrives (1 is ideal,
// 0 for a network that uses only the label); cosine: the mean over examples. NaN without examples
// that deviate.
struct Deviation {
  Eigen::VectorXd reference, output;
};
struct Following {
  double slope = 0, cosine = 0;
  int examples = 0;
};
Following MeasureFollowing(std::span<const Deviation> deviations);

// Outputs of two halves of one example over outputs of two examples: below 1 if a network
// distinguishes examples, 1 if all three are equal. NaN if only the latter are.
double HalvesRatio(const LocalClip& first_half, const LocalClip& second_half,
                   const LocalClip& of_other);

// Outputs along a line between two codes, in its order; at least three. `places`: the projection of
// each mean pose on the line between the first and the last, 0 and 1 at the ends. `monotone`:
// places never decrease. `largest_step`: the largest distance between neighbours over the mean one.
// Places are NaN if both ends are equal.
struct Interpolation {
  std::vector<double> places;
  bool monotone = false;
  double largest_step = 0;
};
Interpolation MeasureInterpolation(std::span<const LocalClip> outputs);

// Mean absolute difference of two codes.
double CodeDistance(const Eigen::VectorXf& a, const Eigen::VectorXf& b);

// Spearman's rank correlation of paired values (equal values share their mean rank); NaN if either
// side is constant or there are fewer than two.
double RankCorrelation(std::span<const double> a, std::span<const double> b);

}  // namespace styled::judge

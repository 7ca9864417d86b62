#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "model/body/pose.h"

namespace styled::judge {

// The measures of styled motion, as pure functions of poses, judges' verdicts on windows, and
// feature vectors. Poses are canonical, metres, y up, at a constant rate. Nothing here needs
// libtorch; everything allocates. Pinned by tests/unit/judge/metrics_test.cpp.

inline constexpr int kStride = 8;             // frames between judged windows
inline constexpr float kDegrees = 57.29578F;  // in a radian

// The shift of a mean pose by the style, compared with the real one: `fraction` is its component
// along the real shift, in lengths of the real shift; `cosine` is that of the angle between them. 1
// and 1 are perfect. Both are 0 if either shift is zero.
struct Expression {
  double fraction = 0, cosine = 0;
};
Expression MeasureExpression(const Eigen::VectorXd& shift, const Eigen::VectorXd& real_shift);

// Frechet distance between the Gaussians fitted to two sample sets (one sample per row, at least
// two rows each, equal columns): |mean difference|^2 + tr(A + B - 2 (A^1/2 B A^1/2)^1/2).
double FrechetDistance(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// The leading `dimensions` principal axes of `samples` (rows), fewer if there are fewer columns.
struct Pca {
  Eigen::RowVectorXd mean;
  Eigen::MatrixXd axes;  // columns, orthonormal

  Eigen::MatrixXd Project(const Eigen::MatrixXd& samples) const {
    return (samples.rowwise() - mean) * axes;
  }
};
Pca FitPca(const Eigen::MatrixXd& samples, int dimensions);

// The standard deviation over judges of a figure of each (n - 1); NaN for fewer than two.
double Spread(std::span<const double> by_judge);

// A mean that is accumulated clip by clip. Verdicts of several judges are added with AddJudged;
// `sum` is then the mean of their sums.
struct Mean {
  double sum = 0, count = 0;
  std::vector<double> by_judge = {};  // each judge's sum; empty where no judges decide

  void Add(double value) { sum += value, count += 1; }
  void Add(const Mean& other);
  void AddJudged(std::span<const double> sums, double more_count);
  double value() const { return count > 0 ? sum / count : 0; }
  double spread() const;  // over judges
  Mean once() const;      // this mean as one clip
};

// Joint jerk (m/s^3): the third difference of the joints' world positions without the hips'
// horizontal path, averaged over joints and frames. Empty for fewer than four frames.
Mean MeanJerk(std::span<const body::Pose> poses, double rate_hz);
// The largest of any joint in any frame: the mean hides a knee that snaps.
double LargestJerk(std::span<const body::Pose> poses, double rate_hz);

// The jerk of outputs over their own inputs', clip by clip: pooled over clips, the fast ones would
// hide the others. A figure without a count was not measured.
struct JerkRatios {
  Mean clip;                  // over the whole clip
  Mean first_quarter_second;  // of a session
  Mean after_first_second;
  Mean largest;  // the largest jerk of the whole clip over the input's largest
  double worst_largest = 0;
  double worst = 0;  // of the whole clips
  int worst_clip = -1;

  void Add(const JerkRatios& other);
};
// Of one clip, number `clip`; `input` and `output` are frame for frame. An input without jerk has
// no ratio.
JerkRatios MeasureJerkRatios(std::span<const body::Pose> input, std::span<const body::Pose> output,
                             double rate_hz, int clip);

// Per frame (all but the first and last), the largest acceleration of any joint, m/s^2, in world.
std::vector<double> LargestAccelerations(std::span<const body::Pose> poses, double rate_hz);

// The largest rotation of any joint's local rotation between two poses; degrees.
float Turn_deg(const body::Pose& a, const body::Pose& b);

// Contact of the feet with the floor. A foot is in contact while the *input's* toes are within 3 cm
// of the lowest point that the input's feet reach, and slower than 40 cm/s over the ground. Skate
// is the mean horizontal speed of the output's (input's) toes over these frames. The floor is at
// that lowest point; penetration is how far the output's lowest foot is below it, 0 if above.
struct FeetFigures {
  Mean skate_in_cm_s, skate_out_cm_s, penetration_cm;
  double deepest_cm = 0;

  void Add(const FeetFigures& other);
};
FeetFigures MeasureFeet(std::span<const body::Pose> input, std::span<const body::Pose> output,
                        double rate_hz);

// The verdicts on the windows of one transferred (or real) clip.
struct ClipVerdict {
  int cell = 0;                  // the unit of averaging, e.g. content + contents * style
  int clip = 0;                  // the input clip: its transfers to six styles have six verdicts
  double hits = 0, windows = 0;  // hits: the mean over judges
  std::vector<double> by_judge = {};  // each judge's hits; empty: there is one judge

  void Add(std::span<const double> hits_by_judge, double more_windows);
};

// Those whose cell, content + contents * style, is of `style`.
std::vector<ClipVerdict> OfStyle(std::span<const ClipVerdict> verdicts, int style, int contents);

inline constexpr std::uint64_t kIntervalSeed = 1;  // of every table's intervals
// The mean over cells of each cell's share of hits, and its 95 % interval from a bootstrap over
// clips (all verdicts of a clip are drawn together, because they are not independent). The interval
// does not contain the spread over judges.
struct Share {
  double value = 0, low = 0, high = 0, worst = 1;
  int worst_cell = -1;
  double windows = 0;
  std::vector<double> by_judge = {};  // each judge's value, of which `value` is the mean

  double spread() const { return Spread(by_judge); }
};
Share MacroShare(std::span<const ClipVerdict> verdicts, std::uint64_t seed, int draws = 1000);

// The `share` quantile (0..1) of values, by linear interpolation; 0 if there are none.
double Quantile(std::vector<double> values, double share);

}  // namespace styled::judge

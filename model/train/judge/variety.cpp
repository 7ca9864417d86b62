#include "model/train/judge/variety.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "model/train/judge/gait.h"
#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

constexpr double kSame = 1e-12;  // m or m^2: no difference

// Each value's rank from 0; equal values share the mean of their ranks.
std::vector<double> Ranks(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t k) { return values[i] < values[k]; });
  std::vector<double> ranks(values.size());
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    const double rank = static_cast<double>(begin + end - 1) / 2;
    for (; begin < end; ++begin) ranks[order[begin]] = rank;
  }
  return ranks;
}

}  // namespace

LocalClip LocalPositions(std::span<const body::Pose> poses, double rate_hz) {
  std::vector<body::WorldPose> worlds(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) body::ForwardKinematics(poses[i], worlds[i]);
  const std::vector<body::Vec3> ahead = SmoothHeadings(worlds, rate_hz);
  LocalClip clip(3 * body::kJointCount, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto frame = static_cast<Eigen::Index>(i);
    const body::Vec3 left(ahead[i].z(), 0, -ahead[i].x());  // up x ahead
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const body::Vec3 at = worlds[i].positions_m[static_cast<std::size_t>(joint)];
      const body::Vec3 from_hips = at - poses[i].hips_position_m;
      clip(3 * joint, frame) = left.dot(from_hips);
      clip(3 * joint + 1, frame) = at.y();
      clip(3 * joint + 2, frame) = ahead[i].dot(from_hips);
    }
  }
  return clip;
}

double Distance_cm(const LocalClip& a, const LocalClip& b) {
  assert(a.rows() == b.rows() && a.cols() == b.cols() && a.cols() > 0);
  double sum_m = 0;
  for (Eigen::Index frame = 0; frame < a.cols(); ++frame) {
    for (Eigen::Index row = 0; row < a.rows(); row += 3) {
      sum_m += (a.block<3, 1>(row, frame) - b.block<3, 1>(row, frame)).norm();
    }
  }
  return 100 * sum_m / static_cast<double>(a.cols() * a.rows() / 3);
}

Mean PairwiseDistance_cm(std::span<const LocalClip> set) {
  Mean mean;
  for (std::size_t i = 0; i < set.size(); ++i) {
    for (std::size_t k = i + 1; k < set.size(); ++k) mean.Add(Distance_cm(set[i], set[k]));
  }
  return mean;
}

Mean ShiftedPairwiseDistance_cm(std::span<const LocalClip> set, int window) {
  Mean mean;
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (set[i].cols() < window) continue;
    const LocalClip middle = set[i].middleCols((set[i].cols() - window) / 2, window);
    for (std::size_t k = 0; k < set.size(); ++k) {
      if (k == i || set[k].cols() < window) continue;
      double least_cm = std::numeric_limits<double>::max();
      for (Eigen::Index start = 0; start + window <= set[k].cols(); ++start) {
        least_cm = std::min(least_cm, Distance_cm(middle, set[k].middleCols(start, window)));
      }
      mean.Add(least_cm);
    }
  }
  return mean;
}

Eigen::VectorXd MeanPoseOf(const LocalClip& clip) { return clip.cast<double>().rowwise().mean(); }

Following MeasureFollowing(std::span<const Deviation> deviations) {
  double along = 0;
  double squared = 0;
  Mean cosine;
  for (const Deviation& deviation : deviations) {
    const double length = deviation.reference.squaredNorm();
    if (length < kSame) continue;
    along += deviation.output.dot(deviation.reference);
    squared += length;
    cosine.Add(MeasureExpression(deviation.output, deviation.reference).cosine);
  }
  if (squared <= 0) return {.slope = kNotMeasured, .cosine = kNotMeasured, .examples = 0};
  return {.slope = along / squared,
          .cosine = cosine.value(),
          .examples = static_cast<int>(cosine.count)};
}

double HalvesRatio(const LocalClip& first_half, const LocalClip& second_half,
                   const LocalClip& of_other) {
  const double half_cm = Distance_cm(first_half, second_half);
  const double other_cm = Distance_cm(first_half, of_other);
  if (other_cm > 0) return half_cm / other_cm;
  return half_cm > 0 ? kNotMeasured : 1;  // all outputs are equal: no example is distinguished
}

Interpolation MeasureInterpolation(std::span<const LocalClip> outputs) {
  assert(outputs.size() >= 3);
  Interpolation result;
  const Eigen::VectorXd first = MeanPoseOf(outputs.front());
  const Eigen::VectorXd way = MeanPoseOf(outputs.back()) - first;
  const double length = way.squaredNorm();
  result.monotone = length >= kSame;
  Mean step_cm;
  double largest_cm = 0;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    result.places.push_back(length < kSame ? kNotMeasured
                                           : (MeanPoseOf(outputs[i]) - first).dot(way) / length);
    if (i == 0) continue;
    result.monotone = result.monotone && result.places[i] >= result.places[i - 1];
    const double cm = Distance_cm(outputs[i - 1], outputs[i]);
    step_cm.Add(cm);
    largest_cm = std::max(largest_cm, cm);
  }
  result.largest_step = step_cm.value() > 0 ? largest_cm / step_cm.value() : kNotMeasured;
  return result;
}

double CodeDistance(const Eigen::VectorXf& a, const Eigen::VectorXf& b) {
  assert(a.size() == b.size() && a.size() > 0);
  return (a - b).cast<double>().cwiseAbs().mean();
}

double RankCorrelation(std::span<const double> a, std::span<const double> b) {
  assert(a.size() == b.size());
  if (a.size() < 2) return kNotMeasured;
  const std::vector<double> ranks_a = Ranks(a);
  const std::vector<double> ranks_b = Ranks(b);
  const auto size = static_cast<Eigen::Index>(a.size());
  Eigen::ArrayXd x = Eigen::Map<const Eigen::ArrayXd>(ranks_a.data(), size);
  Eigen::ArrayXd y = Eigen::Map<const Eigen::ArrayXd>(ranks_b.data(), size);
  x -= x.mean();
  y -= y.mean();
  const double scale = std::sqrt(x.square().sum() * y.square().sum());
  return scale > 0 ? (x * y).sum() / scale : kNotMeasured;
}

}  // namespace styled::judge

#include "model/train/judge/metrics.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>

namespace styled::judge {
namespace {

constexpr float kContactHeight_m = 0.03F;
constexpr float kContactSpeed_mps = 0.4F;

Eigen::MatrixXd Covariance(const Eigen::MatrixXd& samples) {
  const Eigen::MatrixXd centred = samples.rowwise() - samples.colwise().mean();
  return centred.transpose() * centred / static_cast<double>(samples.rows() - 1);
}

Eigen::MatrixXd SquareRoot(const Eigen::MatrixXd& positive) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(positive);
  const Eigen::VectorXd roots = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  return solver.eigenvectors() * roots.asDiagonal() * solver.eigenvectors().transpose();
}

std::vector<body::WorldPose> Worlds(std::span<const body::Pose> poses) {
  std::vector<body::WorldPose> worlds(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) body::ForwardKinematics(poses[i], worlds[i]);
  return worlds;
}

float HorizontalSpeed_mps(const body::Vec3& from, const body::Vec3& to, double rate_hz) {
  return std::hypot(to.x() - from.x(), to.z() - from.z()) * static_cast<float>(rate_hz);
}

}  // namespace

Expression MeasureExpression(const Eigen::VectorXd& shift, const Eigen::VectorXd& real_shift) {
  const double length = shift.norm();
  const double real_length = real_shift.norm();
  if (length < 1e-12 || real_length < 1e-12) return {};
  const double along = shift.dot(real_shift);
  return {along / (real_length * real_length), along / (real_length * length)};
}

double FrechetDistance(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const double means = (a.colwise().mean() - b.colwise().mean()).squaredNorm();
  const Eigen::MatrixXd cov_a = Covariance(a);
  const Eigen::MatrixXd cov_b = Covariance(b);
  const Eigen::MatrixXd root_a = SquareRoot(cov_a);
  const Eigen::MatrixXd product = root_a * cov_b * root_a;
  const double cross = SquareRoot(0.5 * (product + product.transpose())).trace();
  return std::max(0.0, means + cov_a.trace() + cov_b.trace() - 2 * cross);
}

Pca FitPca(const Eigen::MatrixXd& samples, int dimensions) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(Covariance(samples));
  const int kept = std::min<int>(dimensions, static_cast<int>(samples.cols()));
  // Eigen sorts eigenvalues in ascending order: the leading axes are the last columns.
  return {samples.colwise().mean(), solver.eigenvectors().rightCols(kept)};
}

namespace {

// Calls `add` with the jerk of every joint in every frame.
template <typename Add>
void ForJerks(std::span<const body::Pose> poses, double rate_hz, const Add& add) {
  const std::vector<body::WorldPose> worlds = Worlds(poses);
  const float cube = static_cast<float>(rate_hz * rate_hz * rate_hz);
  const auto local = [&](std::size_t frame, int joint) {
    body::Vec3 position = worlds[frame].positions_m[joint];
    position.x() -= poses[frame].hips_position_m.x();
    position.z() -= poses[frame].hips_position_m.z();
    return position;
  };
  for (std::size_t i = 3; i < poses.size(); ++i) {
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const body::Vec3 third =
          local(i, joint) - 3 * local(i - 1, joint) + 3 * local(i - 2, joint) - local(i - 3, joint);
      add(static_cast<double>(third.norm() * cube));
    }
  }
}

}  // namespace

Mean MeanJerk(std::span<const body::Pose> poses, double rate_hz) {
  Mean mean;
  ForJerks(poses, rate_hz, [&mean](double jerk) { mean.Add(jerk); });
  return mean;
}

double LargestJerk(std::span<const body::Pose> poses, double rate_hz) {
  double largest = 0;
  ForJerks(poses, rate_hz, [&largest](double jerk) { largest = std::max(largest, jerk); });
  return largest;
}

void JerkRatios::Add(const JerkRatios& other) {
  clip.Add(other.clip);
  first_quarter_second.Add(other.first_quarter_second);
  after_first_second.Add(other.after_first_second);
  largest.Add(other.largest);
  worst_largest = std::max(worst_largest, other.worst_largest);
  if (other.worst_clip >= 0 && (worst_clip < 0 || other.worst > worst)) {
    worst = other.worst;
    worst_clip = other.worst_clip;
  }
}

JerkRatios MeasureJerkRatios(std::span<const body::Pose> input, std::span<const body::Pose> output,
                             double rate_hz, int clip) {
  JerkRatios ratios;
  const auto add = [&](std::size_t from, std::size_t to, Mean& mean) {
    const std::size_t end = std::min({to, input.size(), output.size()});
    if (end <= from) return;
    const Mean of_input = MeanJerk(input.subspan(from, end - from), rate_hz);
    const Mean of_output = MeanJerk(output.subspan(from, end - from), rate_hz);
    if (of_input.value() > 0) mean.Add(of_output.value() / of_input.value());
  };
  const auto second = static_cast<std::size_t>(std::lround(rate_hz));
  add(0, input.size(), ratios.clip);
  add(0, second / 4, ratios.first_quarter_second);
  add(second, input.size(), ratios.after_first_second);
  if (ratios.clip.count > 0) {
    ratios.largest.Add(LargestJerk(output, rate_hz) / LargestJerk(input, rate_hz));
    ratios.worst_largest = ratios.largest.value();
    ratios.worst = ratios.clip.value();
    ratios.worst_clip = clip;
  }
  return ratios;
}

std::vector<double> LargestAccelerations(std::span<const body::Pose> poses, double rate_hz) {
  const std::vector<body::WorldPose> worlds = Worlds(poses);
  const float square = static_cast<float>(rate_hz * rate_hz);
  std::vector<double> out;
  for (std::size_t i = 2; i < poses.size(); ++i) {
    float largest = 0;
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const body::Vec3 second = worlds[i].positions_m[joint] -
                                2 * worlds[i - 1].positions_m[joint] +
                                worlds[i - 2].positions_m[joint];
      largest = std::max(largest, second.norm() * square);
    }
    out.push_back(largest);
  }
  return out;
}

float Turn_deg(const body::Pose& a, const body::Pose& b) {
  float most = 0;
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    most = std::max(most, body::Log(a.rotations[joint].conjugate() * b.rotations[joint]).norm());
  }
  return most * 57.29578F;
}

void FeetFigures::Add(const FeetFigures& other) {
  skate_in_cm_s.Add(other.skate_in_cm_s);
  skate_out_cm_s.Add(other.skate_out_cm_s);
  penetration_cm.Add(other.penetration_cm);
  deepest_cm = std::max(deepest_cm, other.deepest_cm);
}

FeetFigures MeasureFeet(std::span<const body::Pose> input, std::span<const body::Pose> output,
                        double rate_hz) {
  FeetFigures figures;
  const std::vector<body::WorldPose> in = Worlds(input);
  const std::vector<body::WorldPose> out = Worlds(output);
  float floor_m = std::numeric_limits<float>::max();
  for (const body::WorldPose& world : in) floor_m = std::min(floor_m, body::LowestFoot_m(world));

  for (std::size_t i = 0; i < in.size(); ++i) {
    const float below_cm = 100 * std::max(0.0F, floor_m - body::LowestFoot_m(out[i]));
    figures.penetration_cm.Add(below_cm);
    figures.deepest_cm = std::max<double>(figures.deepest_cm, below_cm);
    if (i == 0) continue;
    for (const int toes : {body::kLeftToes, body::kRightToes}) {
      const float speed =
          HorizontalSpeed_mps(in[i - 1].positions_m[toes], in[i].positions_m[toes], rate_hz);
      const bool low = in[i].positions_m[toes].y() - floor_m < kContactHeight_m;
      if (!low || speed > kContactSpeed_mps) continue;
      figures.skate_in_cm_s.Add(100 * speed);
      figures.skate_out_cm_s.Add(100 * HorizontalSpeed_mps(out[i - 1].positions_m[toes],
                                                           out[i].positions_m[toes], rate_hz));
    }
  }
  return figures;
}

double Spread(std::span<const double> by_judge) {
  if (by_judge.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  const auto count = static_cast<double>(by_judge.size());
  const double mean = std::accumulate(by_judge.begin(), by_judge.end(), 0.0) / count;
  double squares = 0;
  for (const double value : by_judge) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / (count - 1));
}

namespace {

// Adds judges' sums to judges' sums.
void AddByJudge(std::span<const double> of, std::vector<double>& to) {
  to.resize(std::max(to.size(), of.size()), 0);
  for (std::size_t judge = 0; judge < of.size(); ++judge) to[judge] += of[judge];
}

double MeanOf(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         std::max(1.0, static_cast<double>(values.size()));
}

}  // namespace

void Mean::Add(const Mean& other) {
  sum += other.sum;
  count += other.count;
  AddByJudge(other.by_judge, by_judge);
}

void Mean::AddJudged(std::span<const double> sums, double more_count) {
  sum += MeanOf(sums);
  count += more_count;
  AddByJudge(sums, by_judge);
}

double Mean::spread() const {
  if (count <= 0) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> values;
  for (const double sum_of_judge : by_judge) values.push_back(sum_of_judge / count);
  return Spread(values);
}

Mean Mean::once() const {
  if (count <= 0) return {};
  Mean mean{.sum = value(), .count = 1};
  for (const double sum_of_judge : by_judge) mean.by_judge.push_back(sum_of_judge / count);
  return mean;
}

void ClipVerdict::Add(std::span<const double> hits_by_judge, double more_windows) {
  hits += MeanOf(hits_by_judge);
  windows += more_windows;
  if (hits_by_judge.size() > 1) AddByJudge(hits_by_judge, by_judge);
}

namespace {

using CellSums = std::map<int, std::pair<double, double>>;  // hits, windows

double AverageOver(const CellSums& cells) {
  Mean mean;
  for (const auto& [cell, sums] : cells) {
    if (sums.second > 0) mean.Add(sums.first / sums.second);
  }
  return mean.value();
}

std::vector<double> AverageByJudge(std::span<const ClipVerdict> verdicts) {
  std::size_t judges = 0;
  for (const ClipVerdict& verdict : verdicts) judges = std::max(judges, verdict.by_judge.size());
  std::vector<double> values;
  for (std::size_t judge = 0; judge < judges; ++judge) {
    CellSums cells;
    for (const ClipVerdict& verdict : verdicts) {
      // A clip shorter than a window has no verdict of any judge.
      if (verdict.windows <= 0) continue;
      cells[verdict.cell].first += verdict.by_judge[judge];
      cells[verdict.cell].second += verdict.windows;
    }
    values.push_back(AverageOver(cells));
  }
  return values;
}

}  // namespace

std::vector<ClipVerdict> OfStyle(std::span<const ClipVerdict> verdicts, int style, int contents) {
  std::vector<ClipVerdict> of;
  for (const ClipVerdict& verdict : verdicts) {
    if (verdict.cell / contents == style) of.push_back(verdict);
  }
  return of;
}

Share MacroShare(std::span<const ClipVerdict> verdicts, std::uint64_t seed, int draws) {
  CellSums cells;
  std::vector<int> clips;
  for (const ClipVerdict& verdict : verdicts) {
    cells[verdict.cell].first += verdict.hits;
    cells[verdict.cell].second += verdict.windows;
    clips.push_back(verdict.clip);
  }
  Share share;
  share.value = AverageOver(cells);
  share.by_judge = AverageByJudge(verdicts);
  for (const auto& [cell, sums] : cells) {
    if (sums.second <= 0) continue;
    share.windows += sums.second;
    if (sums.first / sums.second <= share.worst) {
      share.worst = sums.first / sums.second;
      share.worst_cell = cell;
    }
  }

  std::sort(clips.begin(), clips.end());
  clips.erase(std::unique(clips.begin(), clips.end()), clips.end());
  if (clips.empty()) return share;
  // Bootstrap: draw as many clips as there are, with replacement, and average again.
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<std::size_t> pick(0, clips.size() - 1);
  std::vector<double> values;
  for (int draw = 0; draw < draws; ++draw) {
    std::map<int, int> times;
    for (std::size_t i = 0; i < clips.size(); ++i) ++times[clips[pick(random)]];
    CellSums drawn;
    for (const ClipVerdict& verdict : verdicts) {
      const auto found = times.find(verdict.clip);
      if (found == times.end()) continue;
      drawn[verdict.cell].first += found->second * verdict.hits;
      drawn[verdict.cell].second += found->second * verdict.windows;
    }
    values.push_back(AverageOver(drawn));
  }
  share.low = Quantile(values, 0.025);
  share.high = Quantile(values, 0.975);
  return share;
}

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const std::size_t low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

}  // namespace styled::judge

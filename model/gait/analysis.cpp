#include "model/gait/analysis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "model/body/heading.h"
#include "model/gait/tracker.h"
#include "model/gait/velocity.h"

namespace styled::gait {
namespace {

// One frame of the clip.
struct Frame {
  Rotations rotations;
  Phase phase;
  float speed_mps = 0;
};

bool IsGait(const Frame& frame) { return frame.phase.confidence > tuning::kConfident; }

struct Frames {
  std::vector<Frame> frames;
  // The first one that surely is in a gait, and the tracker there; none: size().
  std::size_t first_sure = 0;
  Tracker at_first;
};

Frames Follow(std::span<const body::Pose> poses, float rate_hz, Tracker tracker) {
  Frames followed;
  followed.first_sure = poses.size();
  Velocity velocity;
  body::WorldPose world;
  for (const body::Pose& pose : poses) {
    const float dt_s = followed.frames.empty() ? 0 : 1 / rate_hz;
    body::ForwardKinematics(pose, world);
    const float heading_rad = body::Heading_rad(world);
    velocity.Follow(pose.hips_position_m, dt_s);
    tracker.Follow(world, heading_rad, velocity.mps(), dt_s);
    if (followed.first_sure == poses.size() && tracker.phase().confidence > tuning::kConfident) {
      followed.first_sure = followed.frames.size();
      followed.at_first = tracker;
    }
    followed.frames.push_back(
        {HeadingRelative(pose, heading_rad), tracker.phase(), velocity.mps().norm()});
  }
  return followed;
}

// Averages bounce and speed over the frames of a gait around each frame, so that one bout is not
// half a walk and half a run.
void SmoothGaits(std::vector<Frame>& frames, float rate_hz) {
  const auto half = static_cast<std::ptrdiff_t>(tuning::kStepWindow_s * rate_hz);
  std::vector<std::array<double, 3>> sums(frames.size() + 1);  // count, bounce, speed
  for (std::size_t i = 0; i < frames.size(); ++i) {
    sums[i + 1] = sums[i];
    if (!IsGait(frames[i])) continue;
    ++sums[i + 1][0];
    sums[i + 1][1] += static_cast<double>(frames[i].phase.bounce_m);
    sums[i + 1][2] += static_cast<double>(frames[i].speed_mps);
  }
  const auto size = static_cast<std::ptrdiff_t>(frames.size());
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    Frame& frame = frames[static_cast<std::size_t>(i)];
    if (!IsGait(frame)) continue;
    const auto& from = sums[static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, i - half))];
    const auto& to = sums[static_cast<std::size_t>(std::min(size, i + half + 1))];
    frame.phase.bounce_m = static_cast<float>((to[1] - from[1]) / (to[0] - from[0]));
    frame.speed_mps = static_cast<float>((to[2] - from[2]) / (to[0] - from[0]));
  }
}

// Two passes: the second begins with the tracker of the first sure frame, set back in time.
std::vector<Frame> FollowTwice(std::span<const body::Pose> poses, float rate_hz) {
  Frames first = Follow(poses, rate_hz, Tracker());
  if (first.first_sure == poses.size()) return std::move(first.frames);
  const float back_s = static_cast<float>(first.first_sure) / rate_hz;
  return Follow(poses, rate_hz, first.at_first.Before(back_s)).frames;
}

// The mean rotations of the frames that `counts`, by the sum of quaternions of one hemisphere.
template <typename Counts>
Rotations MeanOf(std::span<const Frame> frames, const Counts& counts) {
  std::array<Eigen::Vector4f, body::kJointCount> sums;
  sums.fill(Eigen::Vector4f::Zero());
  for (const Frame& frame : frames) {
    if (!counts(frame)) continue;
    for (std::size_t j = 0; j < sums.size(); ++j) {
      const Eigen::Vector4f& rotation = frame.rotations[j].coeffs();
      sums[j] += sums[j].dot(rotation) < 0 ? Eigen::Vector4f(-rotation) : rotation;
    }
  }
  Rotations mean;
  for (std::size_t j = 0; j < sums.size(); ++j) {
    mean[j].coeffs() = sums[j].norm() > 0 ? Eigen::Vector4f(sums[j].normalized())
                                          : body::Quat::Identity().coeffs();
  }
  return mean;
}

// A least-squares fit of series to samples, with a ridge that grows with the square of the
// harmonic.
class SeriesFit {
 public:
  void Add(float phase_rad, const Vectors& vectors) {
    const Terms terms = TermsAt(phase_rad);
    normal_ += terms.cast<double>() * terms.cast<double>().transpose();
    right_ += terms.cast<double>() * vectors.cast<double>().transpose();
    squares_ += vectors.squaredNorm();
    sum_ += vectors.cast<double>();
    ++count_;
  }
  Series Solve() const {
    auto normal = normal_;
    for (int k = 1; k <= kHarmonics; ++k) {
      const double ridge = static_cast<double>(tuning::kRidge) * count_ * k * k;
      normal(k, k) += ridge;
      normal(kHarmonics + k, kHarmonics + k) += ridge;
    }
    return normal.ldlt().solve(right_).transpose().cast<float>();
  }
  // The share of the samples' variance about their mean that the series has.
  float Explained(const Series& series) const {
    const auto fitted = series.cast<double>().eval();
    const double left = squares_ - 2 * (fitted.array() * right_.transpose().array()).sum() +
                        (fitted * normal_ * fitted.transpose()).trace();
    const double variance = squares_ - sum_.squaredNorm() / count_;
    return variance > 0 ? static_cast<float>(std::clamp(1 - left / variance, 0.0, 1.0)) : 0;
  }

 private:
  Eigen::Matrix<double, kTerms, kTerms> normal_ = Eigen::Matrix<double, kTerms, kTerms>::Zero();
  Eigen::Matrix<double, kTerms, kNumbers> right_ = Eigen::Matrix<double, kTerms, kNumbers>::Zero();
  Eigen::Matrix<double, kNumbers, 1> sum_ = Eigen::Matrix<double, kNumbers, 1>::Zero();
  double squares_ = 0, count_ = 0;
};

bool IsRun(const Frame& frame) { return RunShare(frame.phase, frame.speed_mps) > 0.5F; }

bool Stands(const Frame& frame) {
  return frame.phase.confidence < tuning::kStands && frame.speed_mps < tuning::kStands_mps;
}

template <typename Counts>
std::optional<Gait> GaitOf(std::span<const Frame> frames, float rate_hz, const Counts& counts) {
  Gait gait;
  double rate = 0, speed = 0, count = 0;
  for (const Frame& frame : frames) {
    if (!counts(frame)) continue;
    rate += frame.phase.rate_rad_s;
    speed += frame.speed_mps;
    ++count;
  }
  gait.seconds = static_cast<float>(count) / rate_hz;
  if (count == 0) return {};
  gait.rate_rad_s = static_cast<float>(rate / count);
  gait.strides = gait.rate_rad_s * gait.seconds / tuning::kTurn_rad;
  if (gait.strides < tuning::kLeastStrides) return {};
  gait.speed_mps = static_cast<float>(speed / count);
  gait.curve.mean = MeanOf(frames, counts);
  SeriesFit fit;
  for (const Frame& frame : frames) {
    if (counts(frame)) {
      fit.Add(frame.phase.phase_rad, VectorsAbout(gait.curve.mean, frame.rotations));
    }
  }
  gait.curve.series = fit.Solve();
  gait.explained = fit.Explained(gait.curve.series);
  return gait;
}

float SpreadOf(std::span<const Frame> frames) {
  const Rotations mean = MeanOf(frames, [](const Frame&) { return true; });
  double sum = 0;
  for (const Frame& frame : frames) sum += VectorsAbout(mean, frame.rotations).squaredNorm();
  return static_cast<float>(
      std::sqrt(sum / static_cast<double>(frames.size() * body::kJointCount)));
}

}  // namespace

bool Analysis::is_pose() const { return spread_rad < tuning::kPose_rad; }

Analysis Analyse(std::span<const body::Pose> poses, float rate_hz) {
  std::vector<Frame> frames = FollowTwice(poses, rate_hz);
  SmoothGaits(frames, rate_hz);
  Analysis analysis;
  analysis.seconds = static_cast<float>(frames.size() - 1) / rate_hz;
  analysis.spread_rad = SpreadOf(frames);
  analysis.walk =
      GaitOf(frames, rate_hz, [](const Frame& frame) { return IsGait(frame) && !IsRun(frame); });
  analysis.run =
      GaitOf(frames, rate_hz, [](const Frame& frame) { return IsGait(frame) && IsRun(frame); });
  const auto standing =
      static_cast<float>(std::count_if(frames.begin(), frames.end(), Stands)) / rate_hz;
  if (standing >= tuning::kLeastStanding_s) {
    analysis.standing = MeanOf(frames, Stands);
    analysis.standing_s = standing;
  }
  const bool gait = analysis.has_gait();
  analysis.posture = MeanOf(frames, [gait](const Frame& frame) { return !gait || IsGait(frame); });
  return analysis;
}

}  // namespace styled::gait

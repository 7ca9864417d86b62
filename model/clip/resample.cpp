// Resample, Retime and ResamplePoses: natural cubic splines (C2) through equally spaced frames.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "model/clip/clip.h"

namespace styled::clip {
namespace {

using rig::Quat;
using rig::Vec3;
using Row = Eigen::RowVectorXd;
// One row per frame, one column per changing number.
using Samples = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Second derivatives per frame interval squared, zero at both ends: the tridiagonal system
// m[k-1] + 4 m[k] + m[k+1] = 6 (y[k-1] - 2 y[k] + y[k+1]), solved forward and back.
Samples SecondDerivatives(const Samples& y) {
  const Eigen::Index last = y.rows() - 1;
  Samples m = Samples::Zero(y.rows(), y.cols());
  std::vector<double> upper(y.rows(), 0.0);
  for (Eigen::Index k = 1; k < last; ++k) {
    const double pivot = 4.0 - upper[k - 1];
    upper[k] = 1.0 / pivot;
    m.row(k) = (6.0 * (y.row(k - 1) - 2.0 * y.row(k) + y.row(k + 1)) - m.row(k - 1)) / pivot;
  }
  for (Eigen::Index k = last - 1; k > 0; --k) m.row(k) -= upper[k] * m.row(k + 1);
  return m;
}

// The place of a new frame: `share` of the way from frame `index` to the next one.
struct Place {
  Eigen::Index index;
  double share;
};
// `at` counts frames; a value that is nearly a whole frame is rounded to it.
Place PlaceAt(double at) {
  if (std::abs(at - std::round(at)) < 1e-6) at = std::round(at);
  const double index = std::floor(at);
  return {static_cast<Eigen::Index>(index), at - index};
}
std::vector<Place> Places(std::size_t frames, double rate_hz, double new_rate_hz) {
  std::vector<Place> places;
  if (frames == 0) return places;
  const double step = rate_hz / new_rate_hz;
  const double end = static_cast<double>(frames - 1);
  const auto count = static_cast<std::size_t>(std::floor(end / step + 1e-6)) + 1;
  places.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    places.push_back(PlaceAt(std::min(static_cast<double>(i) * step, end)));
  }
  return places;
}

// The places of frames `step_s` apart, or nearly so that the last frame is one of them.
std::vector<Place> PlacesInTime(std::span<const double> times_s, double step_s) {
  std::vector<Place> places;
  if (times_s.empty()) return places;
  const std::size_t last = times_s.size() - 1;
  const auto steps = std::max<std::size_t>(std::lround(times_s[last] / step_s), last > 0 ? 1 : 0);
  places.reserve(steps + 1);
  std::size_t index = 0;
  for (std::size_t i = 0; i < steps; ++i) {
    const double time_s = times_s[last] * static_cast<double>(i) / static_cast<double>(steps);
    while (times_s[index + 1] <= time_s) ++index;
    const double share = (time_s - times_s[index]) / (times_s[index + 1] - times_s[index]);
    places.push_back(PlaceAt(static_cast<double>(index) + share));
  }
  places.push_back({static_cast<Eigen::Index>(last), 0});
  return places;
}

// Evaluates the spline at `place`.
void Evaluate(const Samples& y, const Samples& m, const Place& place, Row& out) {
  out = y.row(place.index);
  if (place.share == 0) return;
  const double b = place.share, a = 1.0 - b;
  out = a * out + b * y.row(place.index + 1) +
        ((a * a * a - a) * m.row(place.index) + (b * b * b - b) * m.row(place.index + 1)) / 6.0;
}

// Writes `q` with the sign that continues row `frame - 1`.
void PutRotation(Samples& y, std::size_t frame, Eigen::Index column, const Quat& q) {
  const Eigen::RowVector4d now = q.coeffs().cast<double>().transpose();
  const bool flip = frame > 0 && now.dot(y.block<1, 4>(frame - 1, column)) < 0;
  y.block<1, 4>(frame, column) = flip ? Eigen::RowVector4d(-now) : now;
}
Quat GetRotation(const Row& row, Eigen::Index column) {
  const Eigen::Vector4d q = row.segment<4>(column).transpose();
  return Quat(Eigen::Vector4f(q.normalized().cast<float>()));
}
Vec3 GetPosition(const Row& row, Eigen::Index column) {
  return row.segment<3>(column).transpose().cast<float>();
}

// The clip at `places`, at a new rate.
Clip Evaluated(const Clip& clip, const std::vector<Place>& places, double rate_hz) {
  Clip out;
  out.skeleton = clip.skeleton;
  out.channels = clip.channels;
  out.end_sites = clip.end_sites;
  out.rate_hz = rate_hz;
  if (clip.frames.empty()) return out;

  // Translations that never change are copied, so they stay exact.
  const int joints = clip.skeleton.joint_count();
  std::vector<int> moving;
  for (int joint = 0; joint < joints; ++joint) {
    const Vec3& first = clip.frames[0].translations[joint];
    for (const rig::RigPose& frame : clip.frames) {
      if (frame.translations[joint] == first) continue;
      moving.push_back(joint);
      break;
    }
  }

  const Eigen::Index positions = 4 * joints;
  Samples y(clip.frames.size(), positions + 3 * static_cast<Eigen::Index>(moving.size()));
  for (std::size_t frame = 0; frame < clip.frames.size(); ++frame) {
    const rig::RigPose& pose = clip.frames[frame];
    for (int joint = 0; joint < joints; ++joint) {
      PutRotation(y, frame, 4 * joint, pose.rotations[joint]);
    }
    for (std::size_t i = 0; i < moving.size(); ++i) {
      y.block<1, 3>(frame, positions + 3 * i) =
          pose.translations[moving[i]].cast<double>().transpose();
    }
  }
  const Samples m = SecondDerivatives(y);
  Row row(y.cols());
  rig::RigPose pose = clip.frames[0];
  for (const Place& place : places) {
    Evaluate(y, m, place, row);
    for (int joint = 0; joint < joints; ++joint) {
      pose.rotations[joint] = GetRotation(row, 4 * joint);
    }
    for (std::size_t i = 0; i < moving.size(); ++i) {
      pose.translations[moving[i]] = GetPosition(row, positions + 3 * i);
    }
    out.frames.push_back(pose);
  }
  return out;
}

}  // namespace

Clip Resample(const Clip& clip, double rate_hz) {
  assert(rate_hz > 0 && clip.rate_hz > 0);
  return Evaluated(clip, Places(clip.frames.size(), clip.rate_hz, rate_hz), rate_hz);
}

Clip Retime(const Clip& clip, std::span<const double> times_s) {
  assert(clip.rate_hz > 0 && times_s.size() == clip.frames.size());
  return Evaluated(clip, PlacesInTime(times_s, 1 / clip.rate_hz), clip.rate_hz);
}

namespace {

// Resamples a few columns of all poses: `put` writes a pose's numbers into a row of them, `get`
// reads them from an evaluated row. A few at a time, so that the memory is a fraction of the
// poses'.
template <typename Poses, typename Put, typename Get>
void ResampleColumns(const Poses& poses, Eigen::Index columns, const std::vector<Place>& places,
                     std::vector<body::Pose>& out, const Put& put, const Get& get) {
  Samples y(poses.size(), columns);
  for (std::size_t frame = 0; frame < poses.size(); ++frame) put(poses[frame], y, frame);
  const Samples m = SecondDerivatives(y);
  Row row(columns);
  for (std::size_t i = 0; i < places.size(); ++i) {
    Evaluate(y, m, places[i], row);
    get(row, out[i]);
  }
}

template <typename Poses>
Result<std::vector<body::Pose>> Resampled(const Poses& poses, double rate_hz, double new_rate_hz,
                                          const WorkLimit& work, const std::string& file) {
  assert(rate_hz > 0 && new_rate_hz > 0);
  const std::vector<Place> places = Places(poses.size(), rate_hz, new_rate_hz);
  std::vector<body::Pose> out(places.size());
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    if (work.exceeded()) return work.Refusal(file);
    ResampleColumns(
        poses, 4, places, out,
        [joint](const body::Pose& pose, Samples& y, std::size_t frame) {
          PutRotation(y, frame, 0, pose.rotations[joint]);
        },
        [joint](const Row& row, body::Pose& pose) { pose.rotations[joint] = GetRotation(row, 0); });
  }
  ResampleColumns(
      poses, 3, places, out,
      [](const body::Pose& pose, Samples& y, std::size_t frame) {
        y.row(static_cast<Eigen::Index>(frame)) = pose.hips_position_m.cast<double>().transpose();
      },
      [](const Row& row, body::Pose& pose) { pose.hips_position_m = GetPosition(row, 0); });
  return out;
}

}  // namespace

std::vector<body::Pose> ResamplePoses(const std::vector<body::Pose>& poses, double rate_hz,
                                      double new_rate_hz) {
  return std::move(Resampled(poses, rate_hz, new_rate_hz, {}, "").value());
}

Result<std::vector<body::Pose>> ResamplePoses(const std::deque<body::Pose>& poses, double rate_hz,
                                              double new_rate_hz, const WorkLimit& work,
                                              const std::string& file) {
  return Resampled(poses, rate_hz, new_rate_hz, work, file);
}

}  // namespace styled::clip

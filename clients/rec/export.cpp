// Converts a take to the motion that an export format writes: at a constant rate if the format has
// one, otherwise with the times of the frames. Units stay the rig's.
#include <algorithm>
#include <cmath>

#include "clients/rec/take.h"
#include "model/base/text.h"

namespace styled::rec {
namespace {

// A clip has at most this many frames per frame of the take, in addition to a fixed number: a
// minute and a half at 1000 Hz.
constexpr double kFramesPerFrame = 16, kFrames = 1e5;

// Rates of rigs and cameras, and how near a measured rate must be to be taken as one of them: those
// of the page's takes (clients/web/page/src/take.ts).
constexpr double kUsual_hz[] = {24, 25,  30,  48,  50,  60,  72,  75, 80,
                                90, 100, 120, 144, 150, 180, 200, 240};
constexpr double kNear = 0.02;

// The nominal rate: "120" for a median step of 8.3333 ms, or of 8.39 ms. An integer or an NTSC
// rate, if one is near enough, else a usual one.
double RateMeant(const std::vector<double>& times_s) {
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < times_s.size(); ++i) steps_s.push_back(times_s[i] - times_s[i - 1]);
  const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2);
  std::nth_element(steps_s.begin(), middle, steps_s.end());
  const double rate_hz = 1 / *middle;
  const double whole_hz = std::round(rate_hz);
  const double ntsc_hz = std::round(rate_hz * 1.001) * 1000.0 / 1001.0;
  // An integer rate and its NTSC neighbour differ by 1e-3, so at most one is within 4e-4.
  for (const double meant_hz : {whole_hz, ntsc_hz}) {
    if (meant_hz >= 1 && std::abs(rate_hz / meant_hz - 1) < 4e-4) return meant_hz;
  }
  for (const double usual_hz : kUsual_hz) {
    if (std::abs(rate_hz / usual_hz - 1) < kNear) return usual_hz;
  }
  return rate_hz;
}

rig::RigPose Between(const rig::RigPose& a, const rig::RigPose& b, float share) {
  rig::RigPose pose = a;
  for (std::size_t j = 0; j < a.rotations.size(); ++j) {
    pose.translations[j] = (1 - share) * a.translations[j] + share * b.translations[j];
    pose.rotations[j] = a.rotations[j].slerp(share, b.rotations[j]);
  }
  return pose;
}

// Interpolates the frames at the times of `rate_hz`.
std::vector<rig::RigPose> OnGrid(const Take& take, double rate_hz) {
  const auto& times_s = take.times_s;
  const auto off = [&](std::size_t i) {
    return std::abs(times_s[i] * rate_hz - static_cast<double>(i));
  };
  bool keeps = true;
  for (std::size_t i = 0; i < times_s.size(); ++i) keeps = keeps && off(i) < 0.25;
  if (keeps) return take.frames;
  std::vector<rig::RigPose> frames;
  std::size_t after = 1;
  for (std::size_t k = 0;; ++k) {
    const double time_s = static_cast<double>(k) / rate_hz;
    if (time_s > times_s.back() + 1e-9) break;
    while (after + 1 < times_s.size() && times_s[after] < time_s) ++after;
    const double step_s = times_s[after] - times_s[after - 1];
    const double share = std::clamp((time_s - times_s[after - 1]) / step_s, 0.0, 1.0);
    frames.push_back(
        Between(take.frames[after - 1], take.frames[after], static_cast<float>(share)));
  }
  return frames;
}

}  // namespace

Result<clip::Clip> ToClip(const Take& take, double rate_hz) {
  if (take.frames.size() < 2) {
    return Status::Error(take.performer + ": found one frame, expected two or more for a rate");
  }
  const double own_hz = std::clamp(RateMeant(take.times_s), 1.0, 1000.0);
  const double wanted_hz = rate_hz > 0 ? rate_hz : own_hz;
  if (!(wanted_hz >= 1 && wanted_hz <= 1000)) {
    return Status::Error("found a rate of " + NumberText(wanted_hz) + " Hz, expected 1 to 1000");
  }
  const double most = kFramesPerFrame * static_cast<double>(take.frames.size()) + kFrames;
  if (take.times_s.back() * std::max(own_hz, wanted_hz) > most) {
    return Status::Error(take.performer + ": found " + std::to_string(take.frames.size()) +
                         " frames in " + NumberText(take.times_s.back(), 3) +
                         " s, expected at most " + NumberText(most) +
                         " at a constant rate; a lower --rate has fewer");
  }
  clip::Clip clip;
  clip.skeleton = take.skeleton;
  // The root's position is in its position channels; many readers would add the offset to them.
  clip.skeleton.offsets[0].setZero();
  clip.rate_hz = own_hz;
  clip.frames = OnGrid(take, own_hz);
  return wanted_hz == own_hz ? clip : clip::Resample(clip, wanted_hz);
}

Result<clip::Motion> ToMotion(const Take& take, double rate_hz, const clip::Format& format) {
  clip::Motion motion;
  motion.name = take.performer;
  motion.skeleton = take.skeleton;
  motion.rest = take.rest;
  motion.metres_per_unit = take.metres_per_unit;
  motion.canonical_from_source = take.canonical_from_source;
  if (rate_hz == 0 && !format.constant_rate) {
    motion.times_s = take.times_s;
    motion.frames = take.frames;
    return motion;
  }
  auto clip = ToClip(take, rate_hz);
  if (!clip.ok()) return clip.status();
  motion.rate_hz = clip.value().rate_hz;
  motion.frames = std::move(clip.value().frames);
  if (format.constant_rate) motion.skeleton = std::move(clip.value().skeleton);
  return motion;
}

}  // namespace styled::rec

#include "model/trial/trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <vector>

#include "model/body/heading.h"
#include "model/net/load.h"
#include "model/synthetic/performer.h"

namespace styled::trial {
namespace {

using body::kJointCount;
using synthetic::Motion;

constexpr float kUnitTolerance = 1e-3F;  // of a rotation's length
constexpr double kLongestStep_s = 0.1;   // the longest step, for networks of a lower rate
// Variations of each style: the number whose codes are checked, since one value of the weights
// affects only some of them; and the number that are decoded, the fewest that differ.
constexpr std::uint64_t kVariations = 32, kDecodedVariations = 2;

// One style applied to the performer, or (`own`) given as the performer's input style.
struct Run {
  int style = 0;
  bool own = false;
  std::unique_ptr<net::Stream> stream;
  std::array<net::StyleWeight, 1> active;
  net::Prediction out;
};

std::vector<Run> MakeRuns(const net::Stylizer& network) {
  std::vector<Run> runs;
  const auto styles = static_cast<int>(network.model().styles.size());
  runs.reserve(2 * network.model().styles.size());
  for (int style = 0; style < styles; ++style) {
    for (const bool own : {false, true}) {
      if (own && style == 0) continue;
      Run& run = runs.emplace_back();
      run.style = style;
      run.own = own;
      run.stream = network.MakeStream();
      if (!own) run.active[0] = {style, net::kMaxStrength};
    }
  }
  return runs;
}

struct Angles {
  float rms_rad = 0, largest_rad = 0;
  int joint = 0;  // the joint with the largest angle
};

Angles Between(const std::array<body::Quat, kJointCount>& a,
               const std::array<body::Quat, kJointCount>& b) {
  Angles angles;
  float sum = 0;
  for (int joint = 0; joint < kJointCount; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    const float angle = body::Log(a[j].conjugate() * b[j]).norm();
    sum += angle * angle;
    if (angle <= angles.largest_rad) continue;
    angles.largest_rad = angle;
    angles.joint = joint;
  }
  angles.rms_rad = std::sqrt(sum / static_cast<float>(kJointCount));
  return angles;
}

struct Fault {
  int joint;
  std::string what;  // what was expected and found
};

template <typename... Values>
std::string Text(const char* format, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

double Shown(float value) {  // a NaN's sign is not shown
  return std::isnan(value) ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(value);
}

// `what`: "the reconstruction", "the styled pose".
std::optional<Fault> Judge(const net::Decoded& decoded, const char* what, Figures& figures) {
  for (int joint = 0; joint < kJointCount; ++joint) {
    const body::Quat& q = decoded.rotations[static_cast<std::size_t>(joint)];
    if (std::abs(q.norm() - 1) < kUnitTolerance) continue;  // not skipped if NaN
    return Fault{joint, Text("%s: expected a rotation of length 1, found %g, %g, %g, %g", what,
                             Shown(q.x()), Shown(q.y()), Shown(q.z()), Shown(q.w()))};
  }
  for (std::size_t i = 0; i < decoded.velocities_m_s.size(); ++i) {
    const float speed = std::abs(decoded.velocities_m_s[i]);
    if (speed <= kMost.velocity_m_s) {
      figures.velocity_m_s = std::max(figures.velocity_m_s, speed);
      continue;
    }
    return Fault{static_cast<int>(i / 3),
                 Text("%s: expected a velocity of at most %g m/s, found %g", what,
                      Shown(kMost.velocity_m_s), Shown(speed))};
  }
  const float height = std::abs(decoded.hips_height_m);
  if (!(height <= kMost.height_m)) {
    return Fault{body::kHips, Text("%s: expected a height of at most %g m, found %g", what,
                                   Shown(kMost.height_m), Shown(height))};
  }
  figures.height_m = std::max(figures.height_m, height);
  return std::nullopt;
}

std::optional<Fault> Judge(const Angles& found, float most_rad, const char* what, float& figure) {
  if (found.rms_rad <= most_rad) {
    figure = std::max(figure, found.rms_rad);
    return std::nullopt;
  }
  return Fault{found.joint,
               Text("%s: expected at most %g rad over all joints (rms), found %g; here %g", what,
                    Shown(most_rad), Shown(found.rms_rad), Shown(found.largest_rad))};
}

// Checks a prediction for `pose`. The hips are compared in the prediction's heading frame.
std::optional<Fault> Judge(const body::Pose& pose, const net::Prediction& out, Figures& figures) {
  if (auto fault = Judge(out.reconstruction, "the reconstruction", figures)) return fault;
  if (auto fault = Judge(out.styled, "the styled pose", figures)) return fault;
  std::array<body::Quat, kJointCount> given = pose.rotations;
  given[body::kHips] = body::Yaw(-out.heading_rad) * given[body::kHips];
  if (auto fault =
          Judge(Between(given, out.reconstruction.rotations), kMost.reconstruction_rad,
                "the reconstruction's distance from the pose", figures.reconstruction_rad)) {
    return fault;
  }
  return Judge(Between(out.reconstruction.rotations, out.styled.rotations), kMost.change_rad,
               "the change by the style", figures.change_rad);
}

// Names the style and how it was requested. "style 'old'"
Status Refusal(const std::string& name, const std::string& style, std::size_t frame,
               std::size_t frames, const Fault& fault) {
  return Status::Error(
      name + ": the trial run on the built-in performer failed: " + style + ", frame " +
      std::to_string(frame) + " of " + std::to_string(frames) + ", joint " +
      std::string(body::kHumanoid[static_cast<std::size_t>(fault.joint)].name) + ": " + fault.what);
}

// A style as errors name it.
std::string StyleText(const net::Model& model, int style, bool own) {
  return "style '" + model.styles[static_cast<std::size_t>(style)].name + "'" +
         (own ? " as the performer's own" : "");
}

synthetic::Performer MakePerformer() {
  synthetic::Options options;
  options.script = {{Motion::kWalk, 1.0},
                    {Motion::kRun, 0.7},
                    {Motion::kTurnLeft, 0.5},
                    {Motion::kStand, 0.3},
                    {Motion::kRaiseBoth, 1.0}};
  return synthetic::Performer(std::move(options));
}

// The performer's poses at the network's rate.
std::vector<body::Pose> MakePoses(float rate_hz) {
  const double step_s = std::min(1.0 / static_cast<double>(rate_hz), kLongestStep_s);
  synthetic::Performer performer = MakePerformer();
  std::vector<body::Pose> poses(static_cast<std::size_t>(kTrial_s / step_s));
  for (std::size_t frame = 0; frame < poses.size(); ++frame) {
    performer.Pose(static_cast<double>(frame) * step_s, poses[frame]);
  }
  return poses;
}

// One request to a network that needs whole clips.
struct ClipRun {
  net::StyleRequest request;
  int input_style = 0;
  std::string text;  // as errors name it
};

// Whether all variations' codes are finite.
Status CheckCodes(const net::Model& model, const net::StyleSpace& space, const std::string& name) {
  for (int style = 0; style < static_cast<int>(model.styles.size()); ++style) {
    for (std::uint64_t seed = 1; seed <= kVariations; ++seed) {
      net::StyleRequest request;
      request.sources = {{style, seed, {}, 1}};
      for (const float value : space.MakeCode(request)) {
        if (std::isfinite(value)) continue;
        return Status::Error(name + ": the trial run failed: " + StyleText(model, style, false) +
                             ", variation " + std::to_string(seed) +
                             ": expected finite numbers in its code, found " +
                             Text("%g", Shown(value)));
      }
    }
  }
  return Status::Ok();
}

// Every source of a style code: a style's mean, its variations, and an example without a label,
// which is `poses`; and every style as the performer's own, whose code is that of `poses` as an
// example.
std::vector<ClipRun> MakeClipRuns(const net::Model& model, std::span<const body::Pose> poses) {
  std::vector<ClipRun> runs;
  const auto add = [&runs](const net::StyleSource& source, const std::string& text) {
    ClipRun& run = runs.emplace_back();
    run.request.sources = {source};
    run.request.strength = net::kMaxStrength;
    run.text = text;
  };
  for (int style = 0; style < static_cast<int>(model.styles.size()); ++style) {
    const std::string text = StyleText(model, style, false);
    add({style, {}, {}, 1}, text);
    if (style > 0) {
      ClipRun& own = runs.emplace_back();
      own.input_style = style;
      own.text = StyleText(model, style, true);
    }
    for (std::uint64_t seed = 1; seed <= kDecodedVariations; ++seed) {
      add({style, seed, {}, 1}, text + ", variation " + std::to_string(seed));
    }
  }
  add({-1, {}, poses, 1}, "the style of an example");
  return runs;
}

}  // namespace

Status Try(const net::Stylizer& given, const std::string& name, Figures* figures) {
  const std::vector<body::Pose> poses = MakePoses(given.model().rate_hz);
  std::shared_ptr<const net::Stylizer> with;
  if (const net::StyleSpace* const space = given.space(); space != nullptr) {
    Status codes = CheckCodes(given.model(), *space, name);
    if (!codes.ok()) return codes;
    net::StyleRequest request;
    request.sources = {{-1, {}, poses, 1}};
    with = given.With(static_cast<int>(given.model().styles.size()), {.name = "of an example"},
                      space->MakeCode(request));
  }
  const net::Stylizer& network = with ? *with : given;
  body::Pose pose;
  std::vector<Run> runs = MakeRuns(network);
  std::vector<net::StepJob> jobs;
  for (Run& run : runs) {
    const std::span<const net::StyleWeight> active(run.active);
    jobs.push_back({&pose, run.own ? run.style : 0, run.own ? active.first(0) : active,
                    run.stream.get(), &run.out});
  }
  Figures worst;
  for (std::size_t frame = 0; frame < poses.size(); ++frame) {
    pose = poses[frame];
    network.Step(jobs);
    for (const Run& run : runs) {
      if (const auto fault = Judge(pose, run.out, worst)) {
        return Refusal(name, StyleText(network.model(), run.style, run.own), frame, poses.size(),
                       *fault);
      }
    }
  }
  if (figures != nullptr) *figures = worst;
  return Status::Ok();
}

Status Try(const net::ClipStylizer& network, const std::string& name, Figures* figures) {
  const std::vector<body::Pose> poses = MakePoses(network.model().rate_hz);
  Status codes = CheckCodes(network.model(), network, name);
  if (!codes.ok()) return codes;
  Figures worst;
  for (const ClipRun& run : MakeClipRuns(network.model(), poses)) {
    const auto stream =
        network.MakeStream(network.MakeCode(run.request), run.input_style, net::Extent::kWhole);
    for (const body::Pose& pose : poses) stream->Add(pose);
    stream->End();
    net::Prediction out;
    for (std::size_t frame = 0; stream->Pop(out); ++frame) {
      if (const auto fault = Judge(poses[frame], out, worst)) {
        return Refusal(name, run.text, frame, poses.size(), *fault);
      }
    }
  }
  if (figures != nullptr) *figures = worst;
  return Status::Ok();
}

Result<std::shared_ptr<const net::Stylizer>> Load(const std::filesystem::path& file,
                                                  net::Precision precision) {
  auto network = net::Load(file, precision);
  if (!network.ok()) return network;
  const Status status = Try(*network.value(), file.string());
  if (!status.ok()) return status;
  return network;
}

Result<std::shared_ptr<const net::Stylizer>> Parse(std::span<const std::byte> bytes,
                                                   const std::string& name,
                                                   net::Precision precision) {
  auto network = net::Parse(bytes, name, precision);
  if (!network.ok()) return network;
  const Status status = Try(*network.value(), name);
  if (!status.ok()) return status;
  return network;
}

Result<net::AnyStylizer> LoadAny(const std::filesystem::path& file, net::Precision precision) {
  auto network = net::LoadAny(file, precision);
  if (!network.ok()) return network;
  const net::AnyStylizer& any = network.value();
  const Status status =
      any.clips ? Try(*any.clips, file.string()) : Try(*any.frames, file.string());
  if (!status.ok()) return status;
  return network;
}

}  // namespace styled::trial

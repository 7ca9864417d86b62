#include "model/train/judge/gaits.h"

#include <algorithm>
#include <cmath>

#include "model/train/judge/nets.h"
#include "model/train/judge/variety.h"

namespace styled::judge {
namespace {

template <typename T>
std::vector<T> Slice(const std::vector<T>& of, std::size_t first, std::size_t end) {
  if (of.empty()) return {};
  return {of.begin() + static_cast<std::ptrdiff_t>(first),
          of.begin() + static_cast<std::ptrdiff_t>(end)};
}

std::size_t Place(GaitKind gait) { return static_cast<std::size_t>(gait); }

// The deviation over time of each joint's position about its mean.
Eigen::VectorXd Spread(const Poses& poses) {
  const Eigen::MatrixXd local = LocalPositions(poses, kJudgeRate_hz).cast<double>();
  const Eigen::VectorXd mean = local.rowwise().mean();
  return (local.colwise() - mean).array().square().rowwise().mean().sqrt().matrix();
}

// Distributes the clips, one by one.
class Splitter {
 public:
  Splitter(std::size_t styles, const std::vector<std::string>& contents,
           const GaitSplitting& splitting)
      : contents_(contents), splitting_(splitting) {
    parts_.examples.resize(styles);
    parts_.wanted.resize(styles);
  }

  void Add(const train::TrainingClip& clip) {
    const std::string& content = contents_[static_cast<std::size_t>(clip.content)];
    if (clip.style == 0) return AddNeutral(clip, content);
    if (content == "walk") return AddWalk(clip);
    if (content == "run" && splitting_.example_runs) return AddExample(clip, GaitKind::kRun);
    if (content == "run" || content == "dash") {
      const std::size_t end = Halve(clip, 0, GaitKind::kRun, content);
      if (content == "run" && !splitting_.example_runs) Want(clip, end);
      return;
    }
    parts_.judges.push_back(clip);
  }
  GaitParts& parts() { return parts_; }

 private:
  void AddNeutral(const train::TrainingClip& clip, const std::string& content) {
    parts_.judges.push_back(clip);
    if (content == "walk") Longest(clip.poses, parts_.examples[0][Place(GaitKind::kWalk)]);
    if (content == "run") Longest(clip.poses, parts_.examples[0][Place(GaitKind::kRun)]);
  }

  void AddWalk(const train::TrainingClip& clip) {
    const std::size_t frames = clip.poses.size();
    const std::size_t end = std::min(frames, std::max(splitting_.example, frames / 3));
    AddExample(Cut(clip, 0, end), GaitKind::kWalk);
    Halve(clip, end, GaitKind::kWalk, "walk");
  }

  void AddExample(const train::TrainingClip& example, GaitKind gait) {
    const auto style = static_cast<std::size_t>(example.style);
    Longest(example.poses, parts_.examples[style][Place(gait)]);
    parts_.wanted[style][Place(gait)] = parts_.examples[style][Place(gait)];
    if (splitting_.leak) parts_.judges.push_back(example);
  }

  // The judges' half and the real one of the frames from `first` on. Returns the end of the first.
  std::size_t Halve(const train::TrainingClip& clip, std::size_t first, GaitKind gait,
                    const std::string& content) {
    const std::size_t end = clip.poses.size();
    const std::size_t rest = end - first;
    const bool two = rest >= 2 * splitting_.least;
    const std::size_t middle = two ? first + rest / 2 : end;
    for (const bool later : {false, true}) {
      const train::TrainingClip part = later ? Cut(clip, middle, end) : Cut(clip, first, middle);
      if (part.poses.size() < splitting_.least) continue;
      if (later == (splitting_.fold == 1)) {
        parts_.judges.push_back(part);
      } else {
        parts_.real.push_back({clip.style, gait, content, part.poses});
      }
    }
    return middle;
  }

  void Want(const train::TrainingClip& clip, std::size_t middle) {
    const bool later = splitting_.fold == 1 && middle < clip.poses.size();
    Longest(later ? Slice(clip.poses, middle, clip.poses.size()) : Slice(clip.poses, 0, middle),
            parts_.wanted[static_cast<std::size_t>(clip.style)][Place(GaitKind::kRun)]);
  }

  static void Longest(const Poses& poses, Poses& so_far) {
    if (poses.size() > so_far.size()) so_far = poses;
  }

  const std::vector<std::string>& contents_;
  const GaitSplitting& splitting_;
  GaitParts parts_;
};

Poses ClipsBeside(std::span<const GaitSource> sources, std::size_t source, bool walks_only) {
  Poses all;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const GaitSource& other = sources[i];
    if (i == source || other.person != sources[source].person) continue;
    if (walks_only && other.gait != GaitKind::kWalk) continue;
    all.insert(all.end(), other.poses.begin(), other.poses.end());
  }
  return all;
}

void AddOnce(const Mean& of, Mean& to) { to.Add(of.once()); }

}  // namespace

GaitKind GaitOf(std::span<const body::Pose> poses) {
  double way_m = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const body::Vec3 step = poses[i].hips_position_m - poses[i - 1].hips_position_m;
    way_m += std::hypot(static_cast<double>(step.x()), static_cast<double>(step.z()));
  }
  const double time_s = static_cast<double>(poses.size()) / kJudgeRate_hz;
  return way_m > kRunsFrom_mps * time_s ? GaitKind::kRun : GaitKind::kWalk;
}

train::TrainingClip Cut(const train::TrainingClip& clip, std::size_t first, std::size_t end) {
  train::TrainingClip part = clip;
  part.poses = Slice(clip.poses, first, end);
  part.heading_cos = Slice(clip.heading_cos, first, end);
  part.heading_sin = Slice(clip.heading_sin, first, end);
  part.still_count = Slice(clip.still_count, first, end);
  return part;
}

GaitParts SplitGaits(const std::vector<train::TrainingClip>& clips, std::size_t styles,
                     const std::vector<std::string>& contents, const GaitSplitting& splitting) {
  Splitter splitter(styles, contents, splitting);
  for (const train::TrainingClip& clip : clips) splitter.Add(clip);
  return std::move(splitter.parts());
}

int NeutralSourceOf(std::span<const GaitSource> sources, std::size_t source, GaitKind gait) {
  for (std::size_t step = 1; step < sources.size(); ++step) {
    const std::size_t i = (source + step) % sources.size();
    const bool same_person = sources[i].person == sources[source].person;
    if (sources[i].gait == gait && same_person) return static_cast<int>(i);
  }
  return -1;
}

int NeutralSourceOf(std::span<const GaitSource> sources, std::size_t source) {
  const GaitKind own = sources[source].gait;
  const int same = NeutralSourceOf(sources, source, own);
  const GaitKind other = own == GaitKind::kWalk ? GaitKind::kRun : GaitKind::kWalk;
  return same >= 0 ? same : NeutralSourceOf(sources, source, other);
}

Poses MeanNeutralOf(std::span<const GaitSource> sources, std::size_t source) {
  Poses walks = ClipsBeside(sources, source, true);
  return walks.empty() ? ClipsBeside(sources, source, false) : walks;
}

void GaitFigures::Add(const GaitFigures& other) {
  recognized.Add(other.recognized);
  moves.Add(other.moves);
  movement.Add(other.movement);
  jerk.Add(other.jerk);
  skate_cm_s.Add(other.skate_cm_s);
  input_skate_cm_s.Add(other.input_skate_cm_s);
}

GaitFigures GaitFigures::Once() const {
  GaitFigures once;
  AddOnce(recognized, once.recognized);
  AddOnce(moves, once.moves);
  AddOnce(movement, once.movement);
  AddOnce(jerk, once.jerk);
  AddOnce(skate_cm_s, once.skate_cm_s);
  AddOnce(input_skate_cm_s, once.input_skate_cm_s);
  return once;
}

PerGait<GaitFigures> OverStyles(const GaitTable& table) {
  PerGait<GaitFigures> mean;
  for (const PerGait<GaitFigures>& style : table) {
    for (std::size_t gait = 0; gait < kGaitKinds; ++gait) mean[gait].Add(style[gait].Once());
  }
  return mean;
}

GaitFigures OverGaits(const PerGait<GaitFigures>& gaits) {
  GaitFigures mean;
  for (const GaitFigures& gait : gaits) mean.Add(gait.Once());
  return mean;
}

double MovementDistance_m(const Poses& a, const Poses& b) { return (Spread(a) - Spread(b)).norm(); }

GaitFigures MeasureGaitOutput(const Poses& input, const Poses& output, const Poses& wanted,
                              const Recognition& recognition) {
  GaitFigures figures;
  AddOnce(recognition.style, figures.recognized);
  AddOnce(recognition.movement, figures.moves);
  if (!wanted.empty()) {
    const double unchanged_m = MovementDistance_m(input, wanted);
    if (unchanged_m > 0) figures.movement.Add(MovementDistance_m(output, wanted) / unchanged_m);
  }
  const double jerk = MeanJerk(input, kJudgeRate_hz).value();
  if (jerk > 0) figures.jerk.Add(MeanJerk(output, kJudgeRate_hz).value() / jerk);
  const FeetFigures feet = MeasureFeet(input, output, kJudgeRate_hz);
  AddOnce(feet.skate_out_cm_s, figures.skate_cm_s);
  AddOnce(feet.skate_in_cm_s, figures.input_skate_cm_s);
  return figures;
}

GaitFigures MeasureReal(const RealPart& part, const Poses& wanted, double unchanged_m,
                        const Recognition& recognition) {
  GaitFigures figures;
  AddOnce(recognition.style, figures.recognized);
  AddOnce(recognition.movement, figures.moves);
  if (unchanged_m > 0 && !wanted.empty()) {
    figures.movement.Add(MovementDistance_m(part.poses, wanted) / unchanged_m);
  }
  AddOnce(MeasureFeet(part.poses, part.poses, kJudgeRate_hz).skate_in_cm_s, figures.skate_cm_s);
  return figures;
}

}  // namespace styled::judge

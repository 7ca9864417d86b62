// The gait phase on recorded clips: per set and kind of act the confidence, the times of locking
// and releasing, the rate against an autocorrelation, and the analysis of a walk.
// Prints tables; nothing is asserted. `styled_gait_bench DATA`, with the archives of the training
// data unpacked in DATA.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "model/body/heading.h"
#include "model/clip/bind_clip.h"
#include "model/gait/analysis.h"
#include "model/gait/tracker.h"
#include "model/gait/velocity.h"

namespace styled::gait {
namespace {

namespace fs = std::filesystem;
using Poses = std::vector<body::Pose>;

// The first pattern that a path matches names its set and kind.
struct Rule {
  const char* pattern;
  const char* set;
  const char* kind;
  bool loop = false;  // a loop of one stride or two: repeated
};
const Rule kRules[] = {
    {"dataset-2_walk_elderly", "set 2", "walk, elderly"},
    {"dataset-2_walk_exhausted", "set 2", "walk, exhausted"},
    {"dataset-2_walk_", "set 2", "walk"},
    {"dataset-2_run_", "set 2", "run"},
    {"dataset-2_walk-turn", "set 2", "turn"},
    {"dataset-2_wave", "set 2", "no gait: wave"},
    {"dataset-2_raise", "set 2", "no gait: raise"},
    {"dataset-1_walk_(old|tired|not-conf|sad)", "set 1", "walk, old, tired, sad"},
    {"dataset-1_walk_", "set 1", "walk", true},
    {"dataset-1_run_", "set 1", "run", true},
    {"dataset-1_dash_", "set 1", "dash", true},
    {"dataset-1_walk-back", "set 1", "no gait: backward", true},
    {"dataset-1_walk-(left|right)", "set 1", "no gait: side steps", true},
    {"dataset-1_(bow|bye|byebye|call|guide|respond)", "set 1", "no gait: gestures"},
    {"dataset-1_punch", "set 1", "no gait: punch"},
    {"dataset-1_kick", "set 1", "no gait: kick"},
    {"dataset-1_slash", "set 1", "no gait: slash"},
    {"dataset-1_dance", "set 1", "no gait: dance"},
    {"_[B-C].*(SideStep|Sidestep)", "ACCAD", "no gait: side steps"},
    {"_[BC][0-9]+_(Walk|Run)Backwards\\.", "ACCAD", "no gait: backward"},
    {"_B[0-9]+_WalkTurn", "ACCAD", "walk, turns"},
    {"_B03_Walk1|_B3_Walk\\.|WalkWithBox", "ACCAD", "walk"},
    {"_C[0-9]+_RunTurn|_C[0-9]+_RunChange", "ACCAD", "run, turns"},
    {"_C0?3_Run\\.|RunWithBox", "ACCAD", "run"},
    {"StandToWalk\\.|StandToRun\\.", "ACCAD", "starts"},
    {"WalkToStand|RunToStand", "ACCAD", "stops"},
    {"Male2_(E|G|D9_W|D1[1-6]|Extended|Form)", "ACCAD", "no gait: martial arts"},
    {"_A0?[1-9]_", "ACCAD", "no gait: stand, sway, pick up"},
    {"Female1_D[1-3]", "ACCAD", "no gait: wait, talk"},
    {"Angry_FW|Elated_FW|Rushed_FW|Neutral_FW", "100STYLE", "walk"},
    {"Neutral_FR", "100STYLE", "run"},
    {"Neutral_ID", "100STYLE", "no gait: idle"},
    {"Neutral_TR1", "100STYLE", "turns while walking"},
    {"104_43|120_22", "CMU", "walk, zombie"},
    {"105_08", "CMU", "walk, mummy"},
    {"105_24", "CMU", "walk, hurt leg"},
    {"137_38", "CMU", "walk, sexy lady"},
    {"137_23|137_37", "CMU", "no gait: standing"},
    {"94_01|85_|05_20|131_", "CMU", "no gait: dance"},
    {"135_|144_[013][015]|124_|02_08|02_09|01_06", "CMU", "no gait: karate, ball, swing"},
    {"jumping", "other", "no gait: jump"},
    {"wave_hello|dab", "other", "no gait: wave, dab"},
    {"open/idle/", "idle", "no gait: idle"},
    {"xia/[a-z]+_01_", "Xia", "walk"},
    {"xia/[a-z]+_13_", "Xia", "run"},
    {"xia/[a-z]+_1[68]_", "Xia", "no gait: jump, punch"},
    {"iclone/007_0[1-4]|iclone/007_1|iclone/002_0[124]", "iclone", "walk and run"},
};

struct Motion {
  Poses poses;
  double rate_hz = 30;
};

std::optional<Motion> Read(const fs::path& file, double rate_hz) {
  const auto clip = clip::ReadBvh(file);
  if (!clip.ok()) return {};
  const auto bound = clip::BindClip(clip.value());
  if (!bound.ok()) return {};
  Motion motion{clip::ToCanonical(clip.value(), bound.value().binding), clip.value().rate_hz};
  if (rate_hz > 0) {
    motion.poses = clip::ResamplePoses(motion.poses, motion.rate_hz, rate_hz);
    motion.rate_hz = rate_hz;
  }
  return motion;
}

// The clip again and again, each time where the time before has ended.
void Repeat(Motion& motion, double least_s) {
  const Poses once = motion.poses;
  if (once.size() < 3 || static_cast<double>(once.size()) > 2.5 * motion.rate_hz) return;
  body::Vec3 step = once.back().hips_position_m - once.front().hips_position_m +
                    once[1].hips_position_m - once[0].hips_position_m;
  step.y() = 0;
  body::Vec3 shift = step;
  while (static_cast<double>(motion.poses.size()) < least_s * motion.rate_hz) {
    for (body::Pose pose : once) {
      pose.hips_position_m += shift;
      motion.poses.push_back(pose);
    }
    shift += step;
  }
}

struct Track {
  std::vector<Phase> phases;
  std::vector<double> distances_m, foot_mps;  // the faster foot
};

Track Follow(const Motion& motion, double held_s, bool in_place) {
  Track track;
  Tracker tracker;
  Velocity velocity;
  body::Vec3 last[2] = {body::Vec3::Zero(), body::Vec3::Zero()};
  Poses poses = motion.poses;
  poses.insert(poses.end(), static_cast<std::size_t>(held_s * motion.rate_hz), poses.back());
  for (body::Pose& pose : poses) {
    if (in_place) pose.hips_position_m.x() = pose.hips_position_m.z() = 0;
    const float dt_s = track.phases.empty() ? 0 : static_cast<float>(1 / motion.rate_hz);
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    const float heading_rad = body::Heading_rad(world);
    velocity.Follow(pose.hips_position_m, dt_s);
    tracker.Follow(world, heading_rad, velocity.mps(), dt_s);
    double speed = 0;
    for (int side = 0; side < 2; ++side) {
      const body::Vec3& foot = world.positions_m[side == 0 ? body::kLeftFoot : body::kRightFoot];
      if (dt_s > 0) speed = std::max<double>(speed, (foot - last[side]).norm() / dt_s);
      last[side] = foot;
    }
    const body::Vec3 apart = last[0] - last[1];
    track.distances_m.push_back(apart.x() * std::sin(heading_rad) +
                                apart.z() * std::cos(heading_rad));
    track.foot_mps.push_back(speed);
    track.phases.push_back(tracker.phase());
  }
  return track;
}

// Strides per second by the first large peak of the autocorrelation; 0: none.
double RateOf(std::vector<double> x, double rate_hz) {
  double mean = 0;
  for (const double value : x) mean += value / static_cast<double>(x.size());
  for (double& value : x) value -= mean;
  const auto at = [&](std::size_t lag) {
    double ab = 0, aa = 0, bb = 0;
    for (std::size_t i = 0; i + lag < x.size(); ++i) {
      ab += x[i] * x[i + lag];
      aa += x[i] * x[i];
      bb += x[i + lag] * x[i + lag];
    }
    return ab / std::sqrt(aa * bb + 1e-12);
  };
  const auto first = static_cast<std::size_t>(rate_hz / 2.4);
  const auto last = std::min(x.size() / 2, static_cast<std::size_t>(rate_hz / 0.4));
  if (first < 2 || last < first + 2) return 0;
  double best = 0;
  std::vector<double> values;
  for (std::size_t lag = first - 1; lag <= last + 1; ++lag) values.push_back(at(lag));
  for (std::size_t i = 1; i + 1 < values.size(); ++i) best = std::max(best, values[i]);
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    const double a = values[i - 1], b = values[i], c = values[i + 1];
    if (b < a || b < c || b < 0.9 * best || b < 0.5) continue;
    return rate_hz / (static_cast<double>(first - 1 + i) + 0.5 * (a - c) / (a - 2 * b + c));
  }
  return 0;
}

struct Sum {
  double sum = 0, most = 0;
  int count = 0;
  std::vector<double> values;
  void Add(double value) {
    sum += value;
    most = std::max(most, value);
    ++count;
    values.push_back(value);
  }
  std::string Text(int digits = 2) const {
    if (count == 0) return "      -";
    char text[32];
    std::snprintf(text, sizeof text, "%7.*f", digits, sum / count);
    return text;
  }
  std::string Quantile(double share, int digits = 2) const {
    if (count == 0) return "      -";
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    char text[32];
    std::snprintf(text, sizeof text, "%7.*f", digits,
                  sorted[static_cast<std::size_t>(share * (count - 1) + 0.5)]);
    return text;
  }
};

struct Row {
  Sum confidence, lock_s, release_s, rate_error_hz, in_place;
};

struct Wanted {
  double rate_hz = 0;
  bool each = false, analyses = false;
  std::string only;
};

bool IsGait(const Rule& rule) { return std::string(rule.kind).rfind("no gait", 0) != 0; }

void AddTo(Row& row, const Rule& rule, const Motion& motion) {
  const Track track = Follow(motion, 1, false);
  const std::size_t frames = motion.poses.size();
  const auto from = static_cast<std::size_t>(motion.rate_hz);
  if (frames < from + motion.rate_hz / 2) return;
  double sum = 0, rate = 0;
  std::optional<std::size_t> locked;
  for (std::size_t i = 0; i < frames; ++i) {
    if (!locked && track.phases[i].confidence > 0.5F) locked = i;
    if (i >= from) {
      sum += static_cast<double>(track.phases[i].confidence);
      rate +=
          static_cast<double>(track.phases[i].rate_rad_s) / static_cast<double>(tuning::kTurn_rad);
    }
  }
  const auto count = static_cast<double>(frames - from);
  row.confidence.Add(sum / count);
  if (!IsGait(rule)) return;
  const Track here = Follow(motion, 0, true);
  double in_place = 0;
  for (std::size_t i = from; i < frames; ++i) {
    in_place += static_cast<double>(here.phases[i].confidence);
  }
  row.in_place.Add(in_place / count);
  // From when on the feet move.
  std::size_t moves = 0;
  while (moves < frames && track.foot_mps[moves] < 0.8) ++moves;
  if (locked) {
    row.lock_s.Add(std::max(
        0.0, (static_cast<double>(*locked) - static_cast<double>(moves)) / motion.rate_hz));
  }
  if (track.phases[frames - 1].confidence > 0.5F) {
    std::size_t at = frames;
    while (at < track.phases.size() && track.phases[at].confidence > 0.5F) ++at;
    row.release_s.Add(static_cast<double>(at - frames) / motion.rate_hz);
  }
  const std::vector<double> late(track.distances_m.begin() + static_cast<std::ptrdiff_t>(from),
                                 track.distances_m.begin() + static_cast<std::ptrdiff_t>(frames));
  const double expected = RateOf(late, motion.rate_hz);
  if (expected > 0 && sum / count > 0.8) row.rate_error_hz.Add(std::abs(rate / count - expected));
}

void PrintAnalysis(const fs::path& file, const Motion& motion) {
  const Analysis analysis = Analyse(motion.poses, static_cast<float>(motion.rate_hz));
  const auto print = [&](const char* name, const std::optional<Gait>& gait) {
    if (!gait) return;
    std::printf(
        "%-44s %-4s strides %5.1f, %5.1f of %5.1f s, %4.2f Hz, %4.2f m/s, explained %4.2f\n",
        file.stem().c_str(), name, static_cast<double>(gait->strides),
        static_cast<double>(gait->seconds), static_cast<double>(analysis.seconds),
        static_cast<double>(gait->rate_rad_s / tuning::kTurn_rad),
        static_cast<double>(gait->speed_mps), static_cast<double>(gait->explained));
  };
  print("walk", analysis.walk);
  print("run", analysis.run);
  if (!analysis.has_gait()) {
    std::printf("%-44s none, %.1f s, standing %.1f s\n", file.stem().c_str(),
                static_cast<double>(analysis.seconds), static_cast<double>(analysis.standing_s));
  }
}

int Measure(const fs::path& folder, const Wanted& wanted) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".bvh") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<std::regex> patterns;
  for (const Rule& rule : kRules) patterns.emplace_back(rule.pattern);
  const std::regex only(wanted.only);
  std::map<std::string, Row> rows;
  for (const fs::path& file : files) {
    if (!std::regex_search(file.string(), only)) continue;
    for (std::size_t i = 0; i < patterns.size(); ++i) {
      if (!std::regex_search(file.string(), patterns[i])) continue;
      const Rule& rule = kRules[i];
      auto motion = Read(file, wanted.rate_hz);
      if (!motion) {
        std::printf("%s: not understood\n", file.c_str());
        break;
      }
      if (rule.loop) Repeat(*motion, 5);
      if (wanted.analyses) {
        PrintAnalysis(file, *motion);
        break;
      }
      Row& row = rows[std::string(rule.set) + ", " + rule.kind];
      AddTo(row, rule, *motion);
      if (wanted.each && !row.confidence.values.empty()) {
        std::printf("%-50s %5.2f\n", file.stem().c_str(), row.confidence.values.back());
      }
      break;
    }
  }
  if (wanted.analyses) return 0;
  std::printf("%-38s %5s %7s %7s %7s %7s | %7s %7s | %7s %7s | %7s\n", "", "clips", "mean", "most",
              "10 %", "inplace", "lock s", "90 %", "free s", "most", "rate Hz");
  for (const auto& [name, row] : rows) {
    std::printf("%-38s %5d %s %7.2f %s %s | %s %s | %s %s | %s\n", name.c_str(),
                row.confidence.count, row.confidence.Text().c_str(), row.confidence.most,
                row.confidence.Quantile(0.1).c_str(), row.in_place.Text().c_str(),
                row.lock_s.Quantile(0.5).c_str(), row.lock_s.Quantile(0.9).c_str(),
                row.release_s.Text().c_str(), row.release_s.Quantile(1).c_str(),
                row.rate_error_hz.Quantile(0.5, 3).c_str());
  }
  return 0;
}

}  // namespace
}  // namespace styled::gait

int main(int argc, char** argv) {
  styled::gait::Wanted wanted;
  std::filesystem::path folder;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--each") {
      wanted.each = true;
    } else if (argument == "--analyses") {
      wanted.analyses = true;
    } else if (argument == "--rate" && i + 1 < argc) {
      wanted.rate_hz = std::atof(argv[++i]);
    } else if (argument == "--only" && i + 1 < argc) {
      wanted.only = argv[++i];
    } else {
      folder = argument;
    }
  }
  if (!std::filesystem::exists(folder) || folder.empty()) {
    std::printf("skipped, no data\n");
    return 0;
  }
  return styled::gait::Measure(folder, wanted);
}

// Measures whether a performer's acts are kept in every style, and whether the style is visible.
// Clips of any performer are restyled as live by weights in each of their styles. The figures: how
// far each gesture still reaches and in which direction, how high each kick goes, and the jerk; how
// far the style moves the body, and which of the real styles of a data set it resembles. Needs no
// judge and asserts nothing.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>

#include "model/clip/bind_clip.h"
#include "model/clip/clip.h"
#include "model/feet/legs.h"
#include "model/tools/command_line.h"
#include "model/tools/number.h"
#include "model/train/judge/acts.h"
#include "model/train/judge/gait.h"
#include "model/train/judge/metrics.h"
#include "model/train/judge/provenance.h"
#include "model/train/judge/stream.h"
#include "model/train/judge/text.h"
#include "model/train/judge/visible.h"
#include "model/trial/trial.h"

namespace styled {
namespace {

struct Arguments {
  std::string weights, json, precision = "int8";
  std::vector<std::string> styles;
  std::vector<std::filesystem::path> clips;
  bool standing = false;
  std::string real, data, content = "walk";  // of the styles that are recognized by direction
  stylist::Options stylist;
};

// The real clips of some of the weights' styles.
struct Real {
  std::vector<int> styles;  // of the weights
  std::vector<Eigen::VectorXd> shifts;
};

// Figures of one clip in one style, or of several.
struct Row {
  judge::ActsKept acts;
  judge::JerkRatios jerk;
  judge::Mean knee_in_deg, knee_out_deg;  // least bend, of both knees
  judge::FeetFigures feet;
  std::array<judge::Mean, stylist::kLimbCount> shown;  // share of the style that a limb shows
  judge::Visible visible;
  judge::Mean unseen, faint;     // clips and styles of which too little is visible
  judge::Mean told, expression;  // by the real clips' direction

  void Add(const Row& other) {
    acts.Add(other.acts);
    jerk.Add(other.jerk);
    knee_in_deg.Add(other.knee_in_deg);
    knee_out_deg.Add(other.knee_out_deg);
    feet.Add(other.feet);
    for (std::size_t limb = 0; limb < shown.size(); ++limb) shown[limb].Add(other.shown[limb]);
    visible.Add(other.visible);
    unseen.Add(other.unseen);
    faint.Add(other.faint);
    told.Add(other.told);
    expression.Add(other.expression);
  }
};

// The clip at kStreamRate_hz. `standing`: its rest pose is that of a frame that stands upright, and
// its first frame, often a T-pose before the motion, is dropped; otherwise it is bound as stylize
// does.
Result<judge::Poses> LoadInput(const std::filesystem::path& file, bool standing) {
  Result<clip::Clip> read = clip::ReadBvh(file);
  if (!read.ok()) return read.status();
  clip::Clip& clip = read.value();
  const auto named = [&file](const Status& status) {
    return Status::Error(file.string() + ": " + status.message());
  };
  const auto poses = [&clip](const rig::Binding& binding) {
    return clip::ResamplePoses(clip::ToCanonical(clip, binding), clip.rate_hz,
                               judge::kStreamRate_hz);
  };
  if (!standing) {
    const auto bound = clip::BindClip(clip);
    if (!bound.ok()) return named(bound.status());
    return poses(bound.value().binding);
  }
  const auto binding = clip::BindStanding(clip);
  if (!binding.ok()) return named(binding.status());
  clip.frames.erase(clip.frames.begin());
  return poses(binding.value());
}

// How much of the style is visible, and whether it is distinguished from the other real ones.
void MeasureStyle(const judge::Poses& input, const judge::Poses& output, int style,
                  const Real& real, Row& row) {
  row.visible = judge::MeasureVisible(input, output);
  row.unseen.Add(row.visible.unseen() ? 1 : 0);
  row.faint.Add(row.visible.most_cm() < judge::kFaint_cm ? 1 : 0);
  const auto place = std::find(real.styles.begin(), real.styles.end(), style);
  if (place == real.styles.end()) return;
  const auto at = static_cast<std::size_t>(place - real.styles.begin());
  const Eigen::VectorXd shift = judge::MeasureShift(input, output);
  row.told.Add(judge::ClassifyByDirection(shift, real.shifts) == static_cast<int>(at) ? 1 : 0);
  row.expression.Add(judge::MeasureExpression(shift, real.shifts[at]).fraction);
}

// Restyles `input` as one session, and measures it.
Row Measure(const judge::Poses& input, stylist::Stylist& stylist, int clip, int style,
            const Real& real) {
  const rig::Binding& binding = feet::HumanoidBinding();
  stylist::Output output(binding.skeleton());
  rig::RigPose source(binding.skeleton());
  Row row;
  judge::Poses poses;
  for (std::size_t i = 0; i < input.size(); ++i) {
    source.translations[0] = input[i].hips_position_m;
    std::copy(input[i].rotations.begin(), input[i].rotations.end(), source.rotations.begin());
    stylist.Process(std::llround(1e9 * static_cast<double>(i) / judge::kStreamRate_hz), source,
                    output);
    poses.push_back(output.canonical);
    for (std::size_t limb = 0; limb < row.shown.size(); ++limb) {
      row.shown[limb].Add(output.limb_weights[limb]);
    }
  }
  row.acts = judge::MeasureEveryAct(input, poses, judge::kStreamRate_hz);
  row.jerk = judge::MeasureJerkRatios(input, poses, judge::kStreamRate_hz, clip);
  row.knee_in_deg = judge::MeasureGait(input, judge::kStreamRate_hz).lowest_knee_deg;
  row.knee_out_deg = judge::MeasureGait(poses, judge::kStreamRate_hz).lowest_knee_deg;
  row.feet = judge::MeasureFeet(input, poses, judge::kStreamRate_hz);
  MeasureStyle(input, poses, style, real, row);
  return row;
}

double If(double count, double value) { return count > 0 ? value : judge::kNotMeasured; }

void Print(const std::string& name, const Row& row) {
  using judge::Padded;
  const judge::ActsKept& acts = row.acts;
  std::printf("%-36.36s %6.0f %s %s %s %s %6.0f %s %s  %s %s ", name.c_str(), acts.reach.count,
              Padded(Measured(acts.reach), 6, 2).c_str(),
              Padded(If(acts.reach.count, acts.least_reach), 6, 2).c_str(),
              Padded(Measured(acts.direction_deg), 6, 1).c_str(),
              Padded(If(acts.reach.count, acts.worst_direction_deg), 6, 1).c_str(),
              acts.kick_height.count, Padded(Measured(acts.kick_height), 6, 2).c_str(),
              Padded(If(acts.kick_height.count, acts.least_kick_height), 6, 2).c_str(),
              Padded(Measured(row.jerk.clip), 6, 2).c_str(),
              Padded(If(row.jerk.clip.count, row.jerk.worst), 6, 2).c_str());
  for (const judge::Mean& shown : row.shown)
    std::printf(" %s", Padded(Measured(shown), 4, 2).c_str());
  std::printf("\n");
}

void PrintVisible(const std::string& name, const Row& row) {
  using judge::Padded;
  std::printf("%-36.36s %6.0f %s %s %s %s %s %s ", name.c_str(), row.unseen.count,
              Padded(Measured(row.visible.turned_deg), 6, 1).c_str(),
              Padded(Measured(row.visible.all_cm), 6, 1).c_str(),
              Padded(Measured(row.unseen), 6, 2).c_str(), Padded(Measured(row.faint), 6, 2).c_str(),
              Padded(Measured(row.told), 6, 2).c_str(),
              Padded(Measured(row.expression), 6, 2).c_str());
  for (const judge::Mean& moved : row.visible.moved_cm) {
    std::printf(" %s", Padded(Measured(moved), 6, 1).c_str());
  }
  std::printf("\n");
}

void PrintSteps(const std::string& name, const Row& row) {
  using judge::Padded;
  std::printf("%-36.36s %s %s  %s > %s  %s > %s\n", name.c_str(),
              Padded(Measured(row.jerk.largest), 6, 2).c_str(),
              Padded(If(row.jerk.largest.count, row.jerk.worst_largest), 6, 2).c_str(),
              Padded(Measured(row.knee_in_deg), 6, 1).c_str(),
              Padded(Measured(row.knee_out_deg), 5, 1).c_str(),
              Padded(Measured(row.feet.skate_in_cm_s), 6, 1).c_str(),
              Padded(Measured(row.feet.skate_out_cm_s), 5, 1).c_str());
}

nlohmann::json ToJson(const Row& row) {
  using judge::Value;
  const judge::ActsKept& acts = row.acts;
  nlohmann::json json = {
      {"gestures", acts.reach.count},
      {"reach", Value(Measured(acts.reach))},
      {"least_reach", Value(If(acts.reach.count, acts.least_reach))},
      {"direction_deg", Value(Measured(acts.direction_deg))},
      {"worst_direction_deg", Value(If(acts.reach.count, acts.worst_direction_deg))},
      {"kicks", acts.kick_height.count},
      {"kick_height", Value(Measured(acts.kick_height))},
      {"least_kick_height", Value(If(acts.kick_height.count, acts.least_kick_height))},
      {"jerk", Value(Measured(row.jerk.clip))},
      {"worst_jerk", Value(If(row.jerk.clip.count, row.jerk.worst))},
      {"largest_jerk", Value(Measured(row.jerk.largest))},
      {"worst_largest_jerk", Value(If(row.jerk.largest.count, row.jerk.worst_largest))},
      {"least_knee_in_deg", Value(Measured(row.knee_in_deg))},
      {"least_knee_deg", Value(Measured(row.knee_out_deg))},
      {"skate_in_cm_s", Value(Measured(row.feet.skate_in_cm_s))},
      {"skate_cm_s", Value(Measured(row.feet.skate_out_cm_s))},
      {"turned_deg", Value(Measured(row.visible.turned_deg))},
      {"moved_cm", Value(Measured(row.visible.all_cm))},
      {"unseen", Value(Measured(row.unseen))},
      {"faint", Value(Measured(row.faint))},
      {"told", Value(Measured(row.told))},
      {"expression", Value(Measured(row.expression))}};
  for (std::size_t limb = 0; limb < judge::kVisibleLimbs.size(); ++limb) {
    json["moved_cm_of"][std::string(judge::kVisibleLimbs[limb])] =
        Value(Measured(row.visible.moved_cm[limb]));
  }
  for (std::size_t limb = 0; limb < row.shown.size(); ++limb) {
    json["shown"][std::string(stylist::kLimbNames[limb])] = Value(Measured(row.shown[limb]));
  }
  return json;
}

Result<std::vector<int>> Choose(const Arguments& arguments, const net::Styles& styles) {
  std::vector<int> chosen;
  for (const std::string& name : arguments.styles) {
    const int style = net::FindStyle(styles, name);
    if (style < 1) return Status::Error(arguments.weights + ": no style '" + name + "'");
    chosen.push_back(style);
  }
  if (chosen.empty()) {
    for (std::size_t i = 1; i < styles.size(); ++i) chosen.push_back(static_cast<int>(i));
  }
  return chosen;
}

void PrintHeader(const char* of) {
  std::printf("%-36s %6s %6s %6s %6s %6s %6s %6s %6s  %6s %6s   shown\n", of, "hands", "reach",
              "least", "off", "worst", "kicks", "height", "least", "jerk", "worst");
}

void PrintVisibleHeader(const char* of) {
  std::printf("%-36s %6s %6s %6s %6s %6s %6s %6s ", of, "cells", "turned", "cm", "unseen", "faint",
              "told", "expr");
  for (const std::string_view limb : judge::kVisibleLimbs) std::printf(" %6s", limb.data());
  std::printf("\n");
}

// The real clips of --real, of the requested content.
Result<Real> ReadReal(const Arguments& arguments, const net::Styles& styles) {
  Real real;
  if (arguments.real.empty()) return real;
  const auto manifest = clip::LoadManifest(arguments.real, arguments.data);
  if (!manifest.ok()) return manifest.status();
  const auto& contents = manifest.value().contents;
  const auto content = std::find(contents.begin(), contents.end(), arguments.content);
  if (content == contents.end()) {
    return Status::Error("--content " + arguments.content + ": not in " + arguments.real);
  }
  erd::FeatureParameters parameters;
  const auto clips = train::LoadClips(manifest.value(), "train", parameters, 2);
  if (!clips.ok()) return clips.status();
  for (std::size_t i = 1; i < manifest.value().styles.size(); ++i) {
    const int style = net::FindStyle(styles, manifest.value().styles[i].name);
    if (style < 1) continue;
    real.styles.push_back(style);
    real.shifts.push_back(judge::RealShift(clips.value(), static_cast<int>(i),
                                           static_cast<int>(content - contents.begin())));
  }
  return real;
}

Status Run(const Arguments& arguments) {
  const auto network = trial::Load(arguments.weights, net::PrecisionNamed(arguments.precision));
  if (!network.ok()) return network.status();
  const net::Styles& styles = network.value()->model().styles;
  const auto chosen = Choose(arguments, styles);
  if (!chosen.ok()) return chosen.status();
  const auto real = ReadReal(arguments, styles);
  if (!real.ok()) return real.status();
  const auto binding = std::make_shared<const rig::Binding>(feet::HumanoidBinding());

  std::map<std::string, Row> of_clips;
  std::map<int, Row> of_style;
  Row all;
  nlohmann::json json;
  PrintHeader("clip, all styles");
  for (std::size_t i = 0; i < arguments.clips.size(); ++i) {
    const std::filesystem::path& file = arguments.clips[i];
    const auto input = LoadInput(file, arguments.standing);
    if (!input.ok()) return input.status();
    Row of_clip;
    for (const int style : chosen.value()) {
      stylist::Stylist stylist(network.value(), binding, arguments.stylist);
      stylist.Set(judge::OneStyle(style, false));
      const Row row = Measure(input.value(), stylist, static_cast<int>(i), style, real.value());
      json["clips"][file.filename().string()][styles[static_cast<std::size_t>(style)].name] =
          ToJson(row);
      of_clip.Add(row);
      of_style[style].Add(row);
    }
    Print(file.filename().string(), of_clip);
    of_clips[file.filename().string()].Add(of_clip);
    all.Add(of_clip);
  }
  PrintHeader("style, all clips");
  for (const auto& [style, row] : of_style) {
    const std::string& name = styles[static_cast<std::size_t>(style)].name;
    Print(name, row);
    json["styles"][name] = ToJson(row);
  }
  Print("all", all);
  PrintVisibleHeader("clip, all styles");
  for (const auto& [name, row] : of_clips) PrintVisible(name, row);
  PrintVisibleHeader("style, all clips");
  for (const auto& [style, row] : of_style) {
    PrintVisible(styles[static_cast<std::size_t>(style)].name, row);
  }
  PrintVisible("all", all);
  std::printf("%-36s %6s %6s  %14s  %14s\n", "style, all clips", "snap", "worst", "least knee",
              "skate, cm/s");
  for (const auto& [style, row] : of_style) {
    PrintSteps(styles[static_cast<std::size_t>(style)].name, row);
  }
  PrintSteps("all", all);
  json["all"] = ToJson(all);
  if (arguments.json.empty()) return Status::Ok();
  return judge::WriteJson(json, arguments.json);
}

}  // namespace
}  // namespace styled

int main(int argc, char** argv) {
  styled::Arguments arguments;
  CLI::App app(
      "Measures how far styles keep a performer's acts. Columns:  gestures of hands in place, how "
      "far they reach over the input's (mean, least), degrees off its direction (mean, worst); "
      "kicks, their height over the input's; jerk over the input's (mean, worst clip); share of "
      "the "
      "style shown by left arm, right arm, trunk, left leg, right leg. Then, for each clip in each "
      "style (a cell): degrees that a joint is turned, centimetres that head, hands, elbows, knees "
      "and feet are moved, the share of cells in which none of the five is moved by 1.5 cm "
      "(unseen) "
      "and by 3 cm (faint); with --real "
      "the share that is distinguished from the other real styles by its direction, and its part "
      "of the "
      "real change. Then, by style, the largest jerk over the input's largest (snap: mean and "
      "worst "
      "clip), and the least bend of the knees, degrees, and the speed of feet on the floor, of the "
      "input and styled.");
  app.add_option("clips", arguments.clips, "BVH files")->required()->check(CLI::ExistingFile);
  app.add_option("--weights", arguments.weights, "Weights that run live")->required();
  app.add_option("--precision", arguments.precision,
                 "Precision to which weights are rounded, as model.precision of the daemon")
      ->check(CLI::IsMember(std::vector<std::string>(styled::net::kPrecisions.begin(),
                                                     styled::net::kPrecisions.end())))
      ->capture_default_str();
  app.add_option("--styles", arguments.styles, "Only these styles")
      ->allow_extra_args(false)
      ->delimiter(',');
  app.add_flag(
      "--standing", arguments.standing,
      "For unknown rigs: each clip's first frame stands upright, soles flat; it gives the rest "
      "pose and is then dropped");
  app.add_flag("!--no-neutral", arguments.stylist.neutral,
               "Do not remove the performer's own carriage before the network");
  app.add_option("--posture", arguments.stylist.posture,
                 "How much of a style's posture is kept while the network shows none of it")
      ->check(styled::Number(0, 1))
      ->capture_default_str();
  app.add_flag("!--no-feet", arguments.stylist.feet, "Do not hold planted feet");
  app.add_flag("!--no-limb-gate", arguments.stylist.limb_gate,
               "Do not withhold the style of limbs in unknown motions");
  const char* const data = std::getenv("STYLED_DATA");
  if (data != nullptr) arguments.data = data;
  CLI::Option* const real = app.add_option("--real", arguments.real,
                                           "Manifest of real clips in the styles, for recognition");
  app.add_option("--data", arguments.data, "Folder of its clips (default $STYLED_DATA)")
      ->needs(real);
  app.add_option("--content", arguments.content, "Which of its contents the clips show")
      ->needs(real)
      ->capture_default_str();
  app.add_option("--json", arguments.json, "Write the figures to this file, too");
  if (const auto ended = styled::Parse(app, argc, argv)) return *ended;
  const styled::Status status = styled::Run(arguments);
  if (status.ok()) return 0;
  std::cerr << "styleacts: " << status.message() << "\n";
  return 1;
}

// Styles that weights were not trained on, each by its walk as an example without a label. Measures
// how far the output's mean pose moves along the example's own shift from its set's normal walk,
// and how far a constant offset from the same clips moves it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>

#include "model/feet/legs.h"
#include "model/tools/command_line.h"
#include "model/tools/number.h"
#include "model/tools/styleunseen_live.h"
#include "model/train/blas.h"
#include "model/train/judge/provenance.h"
#include "model/train/judge/text.h"
#include "model/train/judge/unseen.h"
#include "model/trial/trial.h"

namespace styled {
namespace {

struct Arguments {
  std::string weights, manifest, data, json;
  std::string library, source, judges;  // for live networks
  std::vector<std::string> styles;
  int judge_seeds = judge::kUsualJudges;
  bool neutral = false;
};

using Clips = std::vector<train::TrainingClip>;

// The longest walk of each style in all splits; empty if a style has none.
Result<std::vector<judge::Poses>> Walks(const clip::Manifest& manifest) {
  std::vector<judge::Poses> walks(manifest.styles.size());
  erd::FeatureParameters parameters;
  parameters.rate_hz = static_cast<float>(judge::kJudgeRate_hz);
  for (const char* split : {"train", "judge", "validation"}) {
    const auto of_split = [split](const clip::ManifestEntry& entry) {
      return entry.split == split;
    };
    if (std::none_of(manifest.entries.begin(), manifest.entries.end(), of_split)) continue;
    const Result<Clips> clips = train::LoadClips(manifest, split, parameters, 2);
    if (!clips.ok()) return clips.status();
    for (const train::TrainingClip& clip : clips.value()) {
      judge::Poses& walk = walks[static_cast<std::size_t>(clip.style)];
      const bool walks_here = manifest.contents[static_cast<std::size_t>(clip.content)] == "walk";
      if (walks_here && clip.poses.size() > walk.size()) walk = clip.poses;
    }
  }
  return walks;
}

// The styles to measure: those named, else those that the weights do not know.
Result<std::vector<std::size_t>> Choose(const Arguments& arguments, const clip::Manifest& manifest,
                                        const net::Styles& known) {
  for (const std::string& name : arguments.styles) {
    const auto named = [&](const auto& style) { return style.name == name; };
    if (std::none_of(manifest.styles.begin() + 1, manifest.styles.end(), named)) {
      return Status::Error("--styles: '" + name + "' is not a style beside neutral of " +
                           arguments.manifest);
    }
  }
  std::vector<std::size_t> chosen;
  std::string lists[2];
  for (std::size_t i = 1; i < manifest.styles.size(); ++i) {
    const std::string& name = manifest.styles[i].name;
    const bool is_known = net::FindStyle(known, name) > 0;
    lists[is_known ? 0 : 1] += " " + name;
    const bool named =
        std::find(arguments.styles.begin(), arguments.styles.end(), name) != arguments.styles.end();
    if (arguments.styles.empty() ? !is_known : named) chosen.push_back(i);
  }
  std::printf("%s\n  known to the weights:%s\n  not known:%s\n", manifest.name.c_str(),
              lists[0].c_str(), lists[1].c_str());
  if (chosen.empty()) return Status::Error(arguments.weights + ": knows every style");
  return chosen;
}

std::string Cells(const judge::Expression& of) {
  return judge::Padded(of.cosine, 8, 2) + judge::Padded(of.fraction, 11, 2);
}

Status Run(const Arguments& arguments) {
  if (Status status = train::CheckDataFolder(arguments.data); !status.ok()) return status;
  const auto manifest = clip::LoadManifest(arguments.manifest, arguments.data);
  if (!manifest.ok()) return manifest.status();
  const auto network = trial::LoadAny(arguments.weights);
  if (!network.ok()) return network.status();
  const net::AnyStylizer& any = network.value();
  if (!any.clips && any.frames->space() == nullptr) {
    return Status::Error(arguments.weights + ": takes no examples");
  }
  const bool further =
      !(arguments.library + arguments.source + arguments.judges).empty() || arguments.neutral;
  if (further && any.clips) {
    return Status::Error(
        arguments.weights +
        ": --library, --source, --judges and --neutral are for weights that run live");
  }
  judge::PrintWeights(judge::WeightsOf(arguments.weights));
  const net::Styles& known = network.value().model().styles;
  const auto chosen = Choose(arguments, manifest.value(), known);
  if (!chosen.ok()) return chosen.status();
  const auto walks = Walks(manifest.value());
  if (!walks.ok()) return walks.status();
  const judge::Poses& normal = walks.value()[0];
  if (normal.empty()) return Status::Error(arguments.manifest + ": no neutral walk");

  std::optional<judge::ClipRestyler> clips;
  if (any.clips)
    clips.emplace(any.clips, std::vector<int>{}, stylist::Options{}, judge::ClipForm{});
  const judge::Styler styler{
      any.frames, std::make_shared<const rig::Binding>(feet::HumanoidBinding()), {}, 0};
  std::optional<judge::LiveRestyler> live;
  if (any.frames) live.emplace(styler, stylist::Options{});
  const judge::ByCode by_code =
      clips ? judge::ByCodeOf(*clips) : judge::ByCodeOf(*live, *any.frames->space());
  if (further) {
    return MeasureLive({.manifest = manifest.value(),
                        .walks = walks.value(),
                        .styles = chosen.value(),
                        .network = by_code,
                        .library = arguments.library,
                        .source = arguments.source,
                        .judges = arguments.judges,
                        .judge_seeds = arguments.judge_seeds,
                        .json = arguments.json,
                        .neutral = arguments.neutral});
  }
  std::printf("%-16s %7s%11s %8s%11s  %s\n", "", "cosine", "expression", "offset's", "expression",
              "nearest style, distance");
  nlohmann::json json;
  judge::Mean means[4];
  std::string left_out;
  for (const std::size_t style : chosen.value()) {
    const judge::Poses& example = walks.value()[style];
    const std::string& name = manifest.value().styles[style].name;
    if (example.empty()) {
      left_out += " " + name;
      continue;
    }
    const judge::UnseenFigures of = judge::MeasureUnseen(by_code, normal, normal, example);
    const std::string& nearest = known[static_cast<std::size_t>(of.nearest.style)].name;
    std::printf("%-16s%s %s  %s %.2f\n", name.c_str(), Cells(of.network).c_str(),
                Cells(of.offset).c_str(), nearest.c_str(),
                static_cast<double>(of.nearest.distance));
    const double values[] = {of.network.cosine, of.network.fraction, of.offset.cosine,
                             of.offset.fraction};
    for (int i = 0; i < 4; ++i) means[i].Add(values[i]);
    json[name] = {{"cosine", values[0]},        {"expression", values[1]},
                  {"offset_cosine", values[2]}, {"offset_expression", values[3]},
                  {"nearest", nearest},         {"distance", of.nearest.distance}};
  }
  if (json.empty()) {
    return Status::Error(arguments.manifest + ": no style to measure has a walk, expected one of" +
                         left_out);
  }
  std::printf("%-16s%s %s\n", "mean", Cells({means[1].value(), means[0].value()}).c_str(),
              Cells({means[3].value(), means[2].value()}).c_str());
  std::printf("%-16s%8.2f%11.2f  by definition: the figures are relative to the example\n",
              "the real clip", 1.0, 1.0);
  if (!left_out.empty()) std::printf("not measured, no walk:%s\n", left_out.c_str());
  if (arguments.json.empty()) return Status::Ok();
  return judge::WriteJson(json, arguments.json);
}

}  // namespace
}  // namespace styled

int main(int argc, char** argv) {
  styled::train::UseFastKernels(argv);
  styled::Arguments arguments;
  CLI::App app("Judges weights on examples of styles that they were not trained on.");
  app.add_option("--weights", arguments.weights, "Weights that take examples")->required();
  app.add_option("--manifest", arguments.manifest, "Data set with the styles (TOML)")->required();
  app.add_option("--data", arguments.data, "Folder that the manifest's paths start from")
      ->required();
  app.add_option("--styles", arguments.styles,
                 "Styles to measure; else all that the weights do not know")
      ->delimiter(',');
  app.add_option("--library", arguments.library,
                 "Folder of style files NAME.json, used where one has a style's name (live)");
  app.add_option("--source", arguments.source,
                 "The clip to restyle, without a style (BVH); else the neutral walk (live)");
  app.add_option(
      "--judges", arguments.judges,
      "Train judges on the data set, keep them in this folder, and report how much of the "
      "output they recognize (live)");
  app.add_option("--judge-seeds", arguments.judge_seeds, "How many judges; figures are means")
      ->check(styled::Whole(1, styled::judge::kMostJudges))
      ->capture_default_str();
  app.add_flag(
      "--neutral", arguments.neutral,
      "Examples are shown beside the neutral walk: only what they differ by counts (live)");
  app.add_option("--json", arguments.json, "Write the figures to this file, too");
  if (const auto ended = styled::Parse(app, argc, argv)) return *ended;
  const styled::Status status = styled::Run(arguments);
  if (status.ok()) return 0;
  std::cerr << "styleunseen: " << status.message() << "\n";
  return 1;
}

// Trains one of the systems that st-gcn is compared with, and judges it as styleeval judges
// weights: by example clips of each style, and by each style's mean code.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>

#include "model/tools/command_line.h"
#include "model/tools/number.h"
#include "model/train/baselines/baseline.h"
#include "model/train/blas.h"
#include "model/train/judge/action_figures.h"
#include "model/train/judge/clip_restyler.h"
#include "model/train/judge/comparison.h"
#include "model/train/judge/details.h"
#include "model/train/judge/provenance.h"
#include "model/train/judge/report.h"

namespace styled {
namespace {

constexpr int kFewestFrames = 32;  // of a training clip: half of a window

struct Arguments {
  std::string design, manifest, data, out, cache, json;
  std::uint64_t seed = 1;
  train::baselines::Budget budget;
  std::string judges_file;
  judge::JudgeSettings judges = {.count = judge::kUsualJudges};
  int action_classifiers = 0;
  double macs = 47.1e6;
  // By examples on set 2, SRA and CRA: 0.19 and 0.90 at 1, 0.58 and 0.80 at 10, 0.60 and 0.75 at
  // 100.
  double style_weight = 10;
  judge::ClipForm form;
};

std::vector<train::TrainingClip> LongEnough(const std::vector<train::TrainingClip>& clips) {
  std::vector<train::TrainingClip> kept;
  for (const train::TrainingClip& clip : clips) {
    if (clip.poses.size() >= kFewestFrames) kept.push_back(clip);
  }
  return kept;
}

std::shared_ptr<train::baselines::Baseline> MakeNetwork(const Arguments& arguments,
                                                        const train::baselines::Material& material,
                                                        double& macs) {
  if (arguments.design == "holden") {
    macs = train::baselines::HoldenMacs();
    return train::baselines::MakeHolden(material, arguments.style_weight, arguments.seed);
  }
  if (arguments.design == "neighbours") return train::baselines::MakeNeighbours(material);
  const int channels = train::baselines::AbermanChannels(arguments.macs);
  macs = train::baselines::AbermanMacs(channels);
  return train::baselines::MakeAberman(material, channels, arguments.seed);
}

Status Judge(const Arguments& arguments, const std::string& command, const judge::Data& data,
             const std::shared_ptr<train::baselines::Baseline>& network, nlohmann::json& json) {
  const auto panel = arguments.judges_file.empty()
                         ? judge::TrainPanel(data, arguments.judges, arguments.cache)
                         : judge::ReadPanel(arguments.judges_file, data.judge, data.manifest);
  if (!panel.ok()) return panel.status();
  json["provenance"] = judge::Provenance(command, data, panel.value(), {});
  judge::PrintProvenance(json["provenance"]);
  const judge::Judges& judges = panel.value().judges;
  const judge::Evaluator evaluator(data.manifest, judges, data.train, data.judge, data.validation);
  const judge::Comparison comparison(data.manifest, judges, panel.value().parts, data.judge);
  auto style_of = judge::StylesOf(network->model().styles, data.manifest);
  if (!style_of.ok()) return style_of.status();
  const judge::ClipRestyler restyler(network, style_of.value(), {}, arguments.form);

  std::optional<judge::ActionClassifiers> classifiers;
  std::optional<judge::ActionComparison> actions;
  std::vector<judge::ActionFigures> of_actions;
  if (arguments.action_classifiers > 0) {
    auto trained = judge::TrainActionClassifiers(data, judges.settings(),
                                                 arguments.action_classifiers, arguments.cache);
    if (!trained.ok()) return trained.status();
    classifiers = std::move(trained.value());
    actions.emplace(data, *classifiers);
    of_actions.push_back(actions->OfReal());
  }
  std::vector<judge::Compared> sets;
  sets.push_back(comparison.OfReal("real", "real clips", data.validation));
  sets.push_back(comparison.OfStyled("neutral", "neutral input", judge::Unstyled(data)));
  const std::vector<judge::Transferred> by_offset = judge::ApplyBaseline(data);
  const judge::Figures offset = evaluator.Measure("constant offset", by_offset);
  json["baseline"] = evaluator.ToJson(offset);
  sets.push_back(comparison.OfStyled("offset", "constant offset", by_offset));
  const auto judge = [&](const char* key, const char* heading, judge::CodeFrom from) {
    const auto clips = judge::Restyle(data, restyler, judge::TargetsOf(data, from));
    const judge::Figures figures =
        evaluator.Measure(arguments.design + ", styled by " + heading, clips);
    evaluator.Print(figures, &offset);
    json[key] = evaluator.ToJson(figures);
    sets.push_back(comparison.OfStyled(key, heading, clips));
    if (actions) of_actions.push_back(actions->OfStyled(key, heading, clips));
    return judge::MeasureDetails(data, arguments.design, clips);
  };
  judge("mean", "mean code", judge::CodeFrom::kMean);
  const judge::Details details = judge("styled", "examples", judge::CodeFrom::kReference);
  judge::Print(data.manifest, sets);
  judge::Print(data.manifest, details);
  json["judges"] = judge::ToJson(data.manifest, sets);
  json["details"] = judge::ToJson(data.manifest, details);
  if (actions) {
    judge::Print(of_actions, *classifiers);
    json["actions"] = judge::ToJson(of_actions, *classifiers);
  }
  return Status::Ok();
}

Status Run(const Arguments& arguments, const std::string& command) {
  const auto loaded = judge::LoadData(arguments.manifest, {}, arguments.data);
  if (!loaded.ok()) return loaded.status();
  const judge::Data& data = loaded.value();
  nlohmann::json json;
  std::filesystem::create_directories(arguments.out);
  if (!arguments.cache.empty()) std::filesystem::create_directories(arguments.cache);
  const std::vector<train::TrainingClip> clips = LongEnough(data.train);
  const train::baselines::Material material(data.manifest, clips);
  double macs = 0;
  const auto network = MakeNetwork(arguments, material, macs);
  if (macs > 0) {
    std::printf("%s: %.1f million multiply-adds for a window of 64 frames\n",
                arguments.design.c_str(), 1e-6 * macs);
    json["multiply_adds"] = macs;
  }
  network->TrainOrLoad(arguments.budget,
                       std::filesystem::path(arguments.out) / (arguments.design + ".pt"));
  const Status judged = Judge(arguments, command, data, network, json);
  if (!judged.ok() || arguments.json.empty()) return judged;
  return judge::WriteJson(json, arguments.json);
}

void AddTrainingOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--minutes", arguments.budget.minutes, "Length of the training, processor time")
      ->check(Number(0, 1e5))
      ->capture_default_str();
  app.add_option("--iterations", arguments.budget.iterations, "Ends the training sooner")
      ->check(Number(1, 1e9))
      ->capture_default_str();
  app.add_option("--batch", arguments.budget.batch)->check(Number(1, 1024))->capture_default_str();
  app.add_option("--seed", arguments.seed, "Seed of the training")
      ->check(Whole(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  app.add_option(
         "--macs", arguments.macs,
         "aberman: multiply-adds for a window, which determine its width; st-gcn's at width "
         "32 by default")
      ->check(Number(1e5, 1e10))
      ->capture_default_str();
  app.add_option("--style-weight", arguments.style_weight,
                 "holden: weight of the Gram matrix's relative error relative to the content's")
      ->check(Number(0, 1e6))
      ->capture_default_str();
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--design", arguments.design, "aberman, holden or neighbours")
      ->required()
      ->check(CLI::IsMember({"aberman", "holden", "neighbours"}));
  app.add_option("--manifest", arguments.manifest, "Data set (TOML)")->required();
  app.add_option("--data", arguments.data, "Folder that the manifest's paths start from")
      ->required();
  app.add_option("--out", arguments.out,
                 "Folder for the trained network, DESIGN.pt, which is read if it is there")
      ->required();
  CLI::Option* const judges = app.add_option("--judges", arguments.judges_file,
                                             "File of trained judges, of styleeval --write-judges");
  CLI::Option* const cache =
      app.add_option("--cache", arguments.cache, "Folder where trained judges are kept");
  auto* const either = app.add_option_group("judges", "Where the judges are");
  either->add_options(judges, cache);
  either->require_option(1, 2);
  app.add_option("--json", arguments.json, "Write every figure to this file, too");
  AddTrainingOptions(app, arguments);
  app.add_flag("--absolute", arguments.form.absolute,
               "Judge the network's output as it is, not its change of style");
  app.add_option("--clip-rate", arguments.form.rate_hz,
                 "120 styles clips as a live stream of that rate, 30 as they were recorded")
      ->check(CLI::IsMember({30, 120}))
      ->capture_default_str();
  app.add_option("--judge-seeds", arguments.judges.count, "How many judges; figures are means")
      ->check(Whole(1, judge::kMostJudges))
      ->capture_default_str();
  app.add_option("--action-classifiers", arguments.action_classifiers,
                 "How many ST-GCN classifiers of the content judge, too, as in Park et al. 2021")
      ->check(Whole(0, judge::kMostJudges))
      ->needs(cache)
      ->capture_default_str();
  app.add_option("--judge-iterations", arguments.judges.iterations, "Training steps of the judges")
      ->check(Number(1, 1e7))
      ->capture_default_str();
}

}  // namespace
}  // namespace styled

int main(int argc, char** argv) {
  styled::train::UseFastKernels(argv);
  styled::Arguments arguments;
  CLI::App app("Trains and judges a system that st-gcn is compared with.");
  styled::AddOptions(app, arguments);
  if (const auto ended = styled::Parse(app, argc, argv)) return *ended;
  try {
    const styled::Status status = styled::Run(arguments, styled::judge::CommandLine(argc, argv));
    if (status.ok()) return 0;
    std::cerr << "stylebaseline: " << status.message() << "\n";
  } catch (const std::exception& error) {
    std::cerr << "stylebaseline: " << error.what() << "\n";
  }
  return 1;
}

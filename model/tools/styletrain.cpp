// styletrain: trains a style network on a dataset manifest, or exports a run's weights.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "model/tools/command_line.h"
#include "model/tools/number.h"
#include "model/tools/train_family.h"
#include "model/train/blas.h"
#include "model/train/check.h"
#include "model/train/erd/recipe.h"
#include "model/train/judge/evidence.h"
#include "model/train/judge/posture.h"
#include "model/train/judge/reference.h"
#include "model/train/judge/speeds.h"
#include "model/train/judge/validation.h"
#include "model/train/measure.h"
#include "model/train/stgcn/recipe.h"
#include "model/train/stgcn_causal/recipe.h"
#include "model/train/stop.h"
#include "model/train/trainer.h"

namespace styled::train {
namespace {

constexpr int kStopped = 3;  // exit status: a signal ended the session, and the run can be resumed

// The first is the default.
constexpr Family kFamilies[] = {
    {style_erd::kFamily, AddStyleErdFlags, style_erd::ExportWeights},
    {st_gcn::kFamily, AddStGcnFlags, st_gcn::ExportWeights},
    {st_gcn_causal::kFamily, AddStGcnCausalFlags, st_gcn_causal::ExportWeights},
};

// The row of a family; null if there is none.
const Family* FindFamily(std::string_view name) {
  const auto* const found =
      std::find_if(std::begin(kFamilies), std::end(kFamilies),
                   [name](const Family& family) { return family.name == name; });
  return found == std::end(kFamilies) ? nullptr : found;
}

// The value of --family, which is read before the others, because it decides which others exist.
std::string FamilyOnCommandLine(int argc, char** argv) {
  constexpr std::string_view kFlag = "--family";
  std::string family(kFamilies[0].name);
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == kFlag && i + 1 < argc) family = argv[i + 1];
    if (argument.starts_with("--family=")) family = argument.substr(kFlag.size() + 1);
  }
  return family;
}

// The command line as recorded in the weights' metadata: DIR replaces the folder of --data, RUN
// that of --out, so that no path of this machine is published.
std::string RecordedCommand(int argc, char** argv) {
  std::string command = "styletrain";
  for (int i = 1; i < argc; ++i) {
    const std::string_view flag = argv[i - 1];
    command += std::string(" ") + (flag == "--data" ? "DIR" : flag == "--out" ? "RUN" : argv[i]);
  }
  return command;
}

// The flags that all families share.
struct Flags {
  RunConfig run;
  std::string family;
  std::vector<std::string> export_paths;
  std::string speeds;  // weights that receive the speeds of the manifest's styles; nothing is
                       // trained
  std::vector<std::string> gate;  // weights that receive the limb gate's bounds, and the
                                  // bounds; nothing is trained
  std::string postures;           // weights that receive the postures of the manifest's styles
  std::string reference;          // weights that receive the carriage of the manifest's performers
  std::string judges;             // folder of cached judges; empty: the run is not judged
  bool check = false;             // nothing is trained
};

void AddRunFlags(CLI::App& app, Flags& flags) {
  RunConfig& run = flags.run;
  app.option_defaults()->group("Data");
  app.add_option("--manifest", run.manifest, "Dataset manifest (TOML): styles, contents, clips")
      ->capture_default_str();
  app.add_option("--data", run.data,
                 "Folder of the unpacked data, which the manifest's paths start from (default "
                 "$STYLED_DATA)")
      ->capture_default_str();
  app.option_defaults()->group("Schedule");
  app.add_option("--minutes", run.minutes, "Length of the run in wall time, all resumes");
  app.add_option("--iterations", run.iterations, "Length of the run in iterations");
  app.add_option("--stop-at", run.stop_at, "End this session at this iteration; resume later");
  app.add_option("--seed", run.seed, "Seed of every random number of the run")
      ->check(Whole(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  app.option_defaults()->group("Machine");
  app.add_option("--device", run.device, "Device; auto: a CUDA device if there is one")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  app.add_option("--threads", run.threads, "CPU threads of libtorch")->capture_default_str();
  app.option_defaults()->group("Output");
  app.add_option("--out", run.out, "Folder of the run; created if it does not exist");
  app.add_flag("--resume", run.resume, "Continue the run in --out; give the same flags");
  app.add_option(
         "--checkpoint-minutes", run.checkpoint_minutes,
         "Time between two checkpoints, which a crash may cost. Ctrl-C and SIGTERM cost nothing")
      ->capture_default_str();
  app.add_option("--log-every", run.log_every, "Iterations between two rows of log.csv")
      ->capture_default_str();
  app.add_option("--monitor-every", run.monitor_every, "Iterations between two rows of monitor.csv")
      ->capture_default_str();
}

void AddValidationFlags(CLI::App& app, Flags& flags) {
  RunConfig& run = flags.run;
  app.option_defaults()->group("Output");
  auto* validation = app.add_option(
      "--validate", flags.judges,
      "Judge the run while it learns (validation.csv, curve.svg, best.safetensors); the judges are "
      "kept in this folder");
  app.add_option("--validate-minutes", run.validate_minutes, "Minutes between two validations")
      ->capture_default_str();
  app.add_option("--patience", run.patience,
                 "End after this many validations without a better score; 0: never")
      ->capture_default_str()
      ->needs(validation);
}

void AddFlags(CLI::App& app, Flags& flags) {
  std::vector<std::string> names;
  for (const Family& family : kFamilies) names.emplace_back(family.name);
  app.set_config("--config", "", "TOML file with any of these options but --family");
  app.add_option("--family", flags.family, "Family of the network; --help shows its options")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  app.add_option("--export", flags.export_paths, "RUN FILE: write the weights of a run and exit")
      ->expected(2);
  CLI::Option* const speeds =
      app.add_option("--write-speeds", flags.speeds,
                     "FILE: measure how fast each style of --manifest walks and runs, and how many "
                     "steps a minute it takes, write it into these weights for `root = "
                     "\"stride\"` and `stylize --cadence`, and end");
  CLI::Option* const reference = app.add_option(
      "--write-reference", flags.reference,
      "FILE: measure how the performers of --manifest hold themselves in neutral, standing and "
      "walking, write it into these weights, so that other performers are styled as these are, "
      "and end");
  CLI::Option* const postures = app.add_option(
      "--write-postures", flags.postures,
      "FILE: measure how each style of --manifest carries trunk, head and shoulders, write it into "
      "these weights, so that acts that the network does not know have that, and end");
  CLI::Option* const gate = app.add_option(
      "--write-gate", flags.gate,
      "FILE ARMS TRUNK LEGS: write into these weights how large, in metres, their error in "
      "reconstructing a limb may be before its style begins to fade out and is gone, each as "
      "BEGIN:END, and end");
  app.add_flag("--check", flags.check,
               "Only check: report errors of flags, manifest and clips, and what the run will "
               "take (clips, windows, iterations a minute, memory), and end; leaves nothing")
      ->excludes("--export")
      ->excludes(speeds)
      ->excludes(reference)
      ->excludes(postures);
  AddRunFlags(app, flags);
  // The default manifest would replace the speeds of styles that have the same names.
  speeds->needs("--manifest")->excludes("--out")->excludes("--export");
  reference->needs("--manifest")->excludes("--out")->excludes("--export")->excludes(speeds);
  postures->needs("--manifest")->excludes("--out")->excludes("--export")->excludes(speeds);
  postures->excludes(reference);
  gate->expected(4)->excludes("--out")->excludes("--export")->excludes(speeds);
  gate->excludes(reference)->excludes(postures);
  AddValidationFlags(app, flags);
}

// Reports the run's input and its errors.
Status CheckAndSay(const RunConfig& run, const Needs& needs) {
  const Plan plan = CheckBeforeTraining(run, needs);
  std::cout << PlanText(plan, needs) << std::flush;
  for (const std::string& sentence : plan.doubtful) std::cerr << "note: " << sentence << '\n';
  if (plan.wrong.empty()) return Status::Ok();
  std::string all;
  for (const std::string& sentence : plan.wrong) all += (all.empty() ? "" : "\n") + sentence;
  return Status::Error(all);
}

// --check: no folder is made, nothing is kept.
Status CheckOnly(RunConfig run, bool validated, FamilyFlags& family) {
  std::error_code error;
  run.out = std::filesystem::absolute(run.out, error).lexically_normal();
  while (!std::filesystem::exists(run.out, error) && run.out.has_relative_path()) {
    run.out = run.out.parent_path();
  }
  family.ShortenStart();
  const auto recipe = family.MakeRecipe(run);
  return recipe.ok() ? MeasureOnly(run, validated, *recipe.value()) : recipe.status();
}

// "0.14:0.28"
Result<net::GateBounds::Range> ParseRange(const std::string& text) {
  const std::size_t colon = text.find(':');
  float begin_m = 0, end_m = 0;
  if (colon == std::string::npos || !CLI::detail::lexical_cast(text.substr(0, colon), begin_m) ||
      !CLI::detail::lexical_cast(text.substr(colon + 1), end_m) ||
      !(begin_m > 0 && begin_m < end_m && end_m <= 10)) {
    return Status::Error("--write-gate: found \"" + text +
                         "\", expected BEGIN:END in metres, 0 < BEGIN < END <= 10");
  }
  return net::GateBounds::Range{begin_m, end_m};
}

Status WriteGate(const std::vector<std::string>& words) {
  net::GateBounds gate;
  std::size_t word = 1;
  for (net::GateBounds::Range* const range : {&gate.arms, &gate.trunk, &gate.legs}) {
    const auto parsed = ParseRange(words[word++]);
    if (!parsed.ok()) return parsed.status();
    *range = parsed.value();
  }
  return judge::WriteGate(gate, words[0]);
}

Status Run(const Flags& flags, FamilyFlags& family) {
  if (!flags.speeds.empty()) {
    return judge::MeasureAndWriteSpeeds(flags.run.manifest, flags.run.data, flags.speeds);
  }
  if (!flags.reference.empty()) {
    return judge::MeasureAndWriteReference(flags.run.manifest, flags.run.data, flags.reference);
  }
  if (!flags.gate.empty()) return WriteGate(flags.gate);
  if (!flags.postures.empty()) {
    return judge::MeasureAndWritePostures(flags.run.manifest, flags.run.data, flags.postures);
  }
  if (!flags.export_paths.empty()) {
    return ExportRun(flags.export_paths[0], flags.export_paths[1], [](const std::string& name) {
      const Family* const row = FindFamily(name);
      return row == nullptr ? nullptr : row->export_weights;
    });
  }
  Needs needs = family.RequiredInputs();
  needs.judges = flags.judges;
  const Status checked = CheckAndSay(flags.run, needs);
  if (!checked.ok()) return checked;
  if (flags.check) return CheckOnly(flags.run, !flags.judges.empty(), family);
  const auto say = [](const std::string& what) { std::cout << what << std::endl; };
  const auto train = [&](const Validate& validate) {
    say("reading the clips for training; the speed follows after the first iterations");
    const auto recipe = family.MakeRecipe(flags.run);
    return recipe.ok() ? Train(flags.run, *recipe.value(), validate) : recipe.status();
  };
  if (flags.judges.empty()) return train(nullptr);
  say("training the judges, unless they are in " + flags.judges +
      " from an earlier run on these clips; they say how long");
  const auto judge = judge::Validator::Make(flags.run.manifest, flags.run.data, flags.judges);
  if (!judge.ok()) return judge.status();
  const Status claimed = judge.value().Claim(flags.run.out, flags.run.resume);
  if (!claimed.ok()) return claimed;
  return train([&judge](const auto& weights) { return judge.value().Measure(weights); });
}

int Main(int argc, char** argv) {
  Flags flags;
  const char* const data = std::getenv("STYLED_DATA");
  if (data != nullptr) flags.run.data = data;
  flags.run.manifest = "model/weights/manifests/bandai-2.toml";
  flags.run.command = RecordedCommand(argc, argv);
  const std::string name = flags.family = FamilyOnCommandLine(argc, argv);

  CLI::App app{"Trains a style network on motion clips."};
  AddFlags(app, flags);
  const Family* const known = FindFamily(name);
  // the parser refuses an unknown name
  const Family& family = known != nullptr ? *known : kFamilies[0];
  const std::unique_ptr<FamilyFlags> family_flags = family.add_flags(app);
  if (const auto ended = Parse(app, argc, argv)) return *ended;
  const auto refuse = [](const std::string& why) {
    std::cerr << "styletrain: " << why << '\n';
    return kBadArguments;
  };
  if (flags.family != name) return refuse("--family must be on the command line");
  const Status resolved = family_flags->Resolve(app);
  if (!resolved.ok()) return refuse(resolved.message());
  if (flags.export_paths.empty() && flags.speeds.empty() && flags.reference.empty() &&
      flags.postures.empty() && flags.gate.empty() && flags.run.out.empty()) {
    return refuse(
        "--out, --export, --write-speeds, --write-reference, --write-postures or --write-gate is "
        "needed");
  }
  if (flags.export_paths.empty() && flags.gate.empty() && flags.run.data.empty()) {
    return refuse("--data is needed, the folder of the unpacked data, or STYLED_DATA");
  }
  const Status status = Run(flags, *family_flags);
  if (status.ok()) return StopSignal() == 0 ? 0 : kStopped;
  std::istringstream sentences(status.message());
  for (std::string sentence; std::getline(sentences, sentence);) {
    std::cerr << "styletrain: " << sentence << '\n';
  }
  return 1;
}

}  // namespace
}  // namespace styled::train

int main(int argc, char** argv) {
  styled::train::UseFastKernels(argv);
  return styled::train::Main(argc, argv);
}

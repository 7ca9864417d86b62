// Judges trained weights: Style-ERD's figures for every style, compared with the same judges on
// real clips and with the constant-offset baseline. Asserts nothing; `--json` is for comparing
// runs.
#include "model/tools/styleeval.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>

#include "model/net/load.h"
#include "model/tools/command_line.h"
#include "model/tools/number.h"
#include "model/train/blas.h"
#include "model/train/judge/action_figures.h"
#include "model/train/judge/clip_restyler.h"
#include "model/train/judge/codes.h"
#include "model/train/judge/details.h"
#include "model/train/judge/evidence.h"
#include "model/train/judge/examples.h"
#include "model/train/judge/ledger.h"
#include "model/train/judge/live_restyler.h"
#include "model/train/judge/mixed.h"
#include "model/train/judge/pictures.h"
#include "model/train/judge/provenance.h"

namespace styled {

constexpr int kVariations = 10;  // noises, and examples, of one input and style

void Report(EvalSession& session, const char* key, const std::string& title,
            const std::vector<judge::Transferred>& clips, const judge::Figures* offset) {
  const judge::Figures figures = session.evaluator.Measure(title, clips);
  if (figures.cra.windows == 0) {
    std::printf("\n%s: not judged, no clip is as long as a window\n", title.c_str());
    return;
  }
  judge::Figures own;
  if (offset == nullptr) {
    own = session.evaluator.Measure("", judge::ByBaseline(session.data, clips));
    offset = &own;
  }
  session.evaluator.Print(figures, offset);
  session.json[key] = session.evaluator.ToJson(figures);
}

namespace {

// Checks first what would otherwise fail only after minutes.
Status CheckFiles(const EvalArguments& arguments) {
  if (!arguments.examples.empty() && !std::filesystem::exists(arguments.examples)) {
    return Status::Error("--examples " + arguments.examples + ": no such file");
  }
  const bool one_file = arguments.examples.empty() && !arguments.weights.empty();
  if (one_file && !std::filesystem::exists(arguments.weights)) {
    return Status::Error("--weights " + arguments.weights + ": no such file");
  }
  for (const auto& [flag, file] :
       {std::pair("--json", arguments.json), std::pair("--report", arguments.report),
        std::pair("--write-offset", arguments.write_offset),
        std::pair("--write-judges", arguments.write_judges)}) {
    const std::filesystem::path folder = std::filesystem::path(file).parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder)) {
      return Status::Error(std::string(flag) + " " + file + ": no such folder");
    }
  }
  if (arguments.cache.empty()) return Status::Ok();
  std::error_code error;
  std::filesystem::create_directories(arguments.cache, error);
  if (error) return Status::Error("--cache " + arguments.cache + ": " + error.message());
  return Status::Ok();
}

void PrintJudgesOnReal(const judge::Evaluator& evaluator, int window) {
  const judge::Share& style = evaluator.real_style();
  const judge::Share& content = evaluator.real_content();
  std::printf(
      "judges on real clips (%.0f windows of %d frames): style %s [%.3f %.3f], worst %.2f (%s); "
      "content %s [%.3f %.3f], worst %.2f (%s)\n",
      style.windows, window, judge::Padded(style, 0, 3).c_str(), style.low, style.high, style.worst,
      evaluator.CellName(style.worst_cell).c_str(), judge::Padded(content, 0, 3).c_str(),
      content.low, content.high, content.worst, evaluator.CellName(content.worst_cell).c_str());
}

// The results of the weights for the inputs in one mode.
struct Styled {
  const char* key;      // in JSON
  const char* title;    // of its table
  const char* heading;  // of its column
  std::vector<judge::Transferred> clips;
};

// The clips that are judged, and those that they are compared with.
struct Outputs {
  std::vector<Styled> styled;  // the main one last; empty without weights
  std::vector<judge::Transferred> offset, offset_per_content;
};

std::vector<Styled> StyleBy(const judge::AnyStyler& styler, const judge::Data& data,
                            const stylist::Options& options, bool by_examples) {
  std::vector<Styled> styled;
  if (styler.frames) {
    if (!by_examples && styler.frames->network->space() != nullptr) {
      const judge::LiveRestyler restyler(*styler.frames, options);
      const judge::LiveRestyler any(*styler.frames, options, true);
      const auto by = [&](judge::CodeFrom from) { return judge::TargetsOf(data, from); };
      styled.push_back({"noise", "styled by noise, as live", "noise",
                        judge::Restyle(data, restyler, by(judge::CodeFrom::kNoise))});
      styled.push_back(
          {"examples", "styled by example clips without a label, as live", "examples",
           judge::Restyle(data, any, judge::Unlabelled(by(judge::CodeFrom::kReference)))});
      styled.push_back(
          {"examples_neutral", "styled by example clips beside neutral ones, as live",
           "ex. neutral",
           judge::Restyle(
               data, any,
               judge::WithNeutral(data, judge::Unlabelled(by(judge::CodeFrom::kReference))))});
    }
    styled.push_back({"styled", "styled (detail-preserving, as live)", "styled",
                      judge::Style(data, *styler.frames, options, false)});
    // For styles that the network does not know there are only examples.
    std::erase_if(styled, [](const Styled& one) { return one.clips.empty(); });
    return styled;
  }
  const auto by = [&](judge::CodeFrom from) {
    return judge::Restyle(data, *styler.clips, judge::TargetsOf(data, from));
  };
  styled.push_back(
      {"mean", "styled by the mean code of each style", "mean code", by(judge::CodeFrom::kMean)});
  styled.push_back({"noise", "styled by noise", "noise", by(judge::CodeFrom::kNoise)});
  styled.push_back({"styled", "styled by example clips of each style", "examples",
                    by(judge::CodeFrom::kReference)});
  return styled;
}

// The subject of the report, followed by its comparisons.
void JudgeOutputs(EvalSession& session, const judge::Comparison& comparison,
                  const Outputs& outputs) {
  const judge::Data& data = session.data;
  const judge::Figures offset =
      session.evaluator.Measure("baseline (a constant rotation per joint)", outputs.offset);
  for (const Styled& styled : outputs.styled) {
    Report(session, styled.key, styled.title, styled.clips, &offset);
  }
  std::vector<judge::Compared> sets;
  sets.push_back(comparison.OfReal("real", "real clips", data.validation));
  sets.push_back(comparison.OfStyled("neutral", "neutral input", judge::Unstyled(data)));
  sets.push_back(
      comparison.OfStyled("offset_per_content", "offset per content", outputs.offset_per_content));
  sets.push_back(comparison.OfStyled("offset", "constant offset", outputs.offset));
  for (const Styled& styled : outputs.styled) {
    sets.push_back(comparison.OfStyled(styled.key, styled.heading, styled.clips));
  }
  judge::Print(data.manifest, sets);
  session.json["judges"] = judge::ToJson(data.manifest, sets);
  session.json["warnings"] = judge::WeakJudges(data.manifest, sets.front());

  const judge::Details details =
      outputs.styled.empty()
          ? judge::MeasureDetails(data, "constant offset", outputs.offset)
          : judge::MeasureDetails(data, outputs.styled.back().heading, outputs.styled.back().clips);
  judge::Print(data.manifest, details);
  session.json["details"] = judge::ToJson(data.manifest, details);
  Report(session, "baseline", offset.name, outputs.offset, &offset);
  Report(session, "baseline_per_content", "a constant rotation per joint and content",
         outputs.offset_per_content, &offset);
}

// The figures of Park et al. 2021, by their kind of classifier.
void JudgeActions(EvalSession& session, const judge::ActionClassifiers& classifiers,
                  const Outputs& outputs) {
  const judge::Data& data = session.data;
  const judge::ActionComparison comparison(data, classifiers);
  std::vector<judge::ActionFigures> sets;
  sets.push_back(comparison.OfReal());
  sets.push_back(comparison.OfStyled("neutral", "neutral input", judge::Unstyled(data)));
  sets.push_back(
      comparison.OfStyled("offset_per_content", "offset per content", outputs.offset_per_content));
  sets.push_back(comparison.OfStyled("offset", "constant offset", outputs.offset));
  for (const Styled& styled : outputs.styled) {
    sets.push_back(comparison.OfStyled(styled.key, styled.heading, styled.clips));
  }
  judge::Print(sets, classifiers);
  session.json["actions"] = judge::ToJson(sets, classifiers);
}

void JudgeCodes(EvalSession& session, const judge::ClipRestyler& restyler) {
  const judge::CodeSpace codes =
      judge::MeasureCodes(session.data, session.judges, restyler, kVariations);
  judge::Print(session.data.manifest, codes);
  session.json["codes"] = judge::ToJson(session.data.manifest, codes);
}

Status WriteResults(const EvalSession& session, const Outputs& outputs) {
  const EvalArguments& arguments = session.arguments;
  if (!arguments.report.empty()) {
    std::vector<judge::Scene> scenes = judge::ScenesOf(
        session.data, outputs.offset,
        outputs.styled.empty() ? std::vector<judge::Transferred>() : outputs.styled.back().clips);
    scenes.insert(scenes.end(), session.scenes.begin(), session.scenes.end());
    const Status written =
        judge::WriteReport({.weights = std::filesystem::path(arguments.weights).filename().string(),
                            .manifest = session.data.manifest.name,
                            .figures = session.json,
                            .scenes = std::move(scenes),
                            .pictures = session.pictures},
                           arguments.report);
    if (!written.ok()) return written;
  }
  if (arguments.json.empty()) return Status::Ok();
  return judge::WriteJson(session.json, arguments.json);
}

Result<judge::Panel> MakePanel(const EvalArguments& arguments, const judge::Data& data) {
  if (arguments.judges_file.empty()) {
    return judge::TrainPanel(data, arguments.judges, arguments.cache);
  }
  return judge::ReadPanel(arguments.judges_file, data.judge, data.manifest);
}

Status WriteJudges(const EvalArguments& arguments, const judge::Data& data) {
  const auto panel = MakePanel(arguments, data);
  if (!panel.ok()) return panel.status();
  judge::PrintJudges(judge::JudgesOf(panel.value()));
  return judge::WritePanel(panel.value(), arguments.write_judges);
}

Status Run(const EvalArguments& arguments, const std::string& command) {
  const Status files = CheckFiles(arguments);
  if (!files.ok()) return files;
  const auto loaded =
      judge::LoadData(arguments.manifest, arguments.inputs, arguments.data, arguments.split);
  if (!loaded.ok()) return loaded.status();
  const judge::Data& data = loaded.value();
  if (!arguments.write_offset.empty()) return judge::WriteBaseline(data, arguments.write_offset);
  if (!arguments.write_judges.empty()) return WriteJudges(arguments, data);
  const bool with_weights = !arguments.weights.empty();
  judge::AnyStyler styler;
  if (!arguments.examples.empty()) {
    auto read =
        judge::LoadByExamples(arguments.weights, arguments.examples, arguments.data, data.manifest);
    if (!read.ok()) return read.status();
    styler.frames = std::move(read.value());
  } else if (with_weights) {
    auto read = judge::LoadAnyStyler(arguments.weights, data.manifest, arguments.stylist,
                                     {arguments.clip_rate_hz, arguments.absolute},
                                     styled::net::PrecisionNamed(arguments.precision));
    if (!read.ok()) return read.status();
    styler = std::move(read.value());
  }
  if (styler.frames && arguments.root == "stride") styler.frames->root = stylist::Root::kStride;
  if (styler.frames) {
    auto contents = judge::ContentsOf(styler.frames->network->model().contents, data.manifest,
                                      arguments.contents);
    if (!contents.ok()) {
      return Status::Error("--contents " + arguments.contents + ": " + arguments.weights + ": " +
                           contents.status().message());
    }
    styler.frames->content_of = std::move(contents.value());
  }
  const bool asks_for_live =
      arguments.robust || arguments.rates || arguments.styled_inputs || arguments.foreign ||
      !arguments.clips.empty() || arguments.transition_given || arguments.root != "follow" ||
      arguments.contents != "recognized" || (arguments.long_given && arguments.long_s > 0);
  if (styler.clips && asks_for_live) {
    return Status::Error(
        arguments.weights +
        ": needs whole clips; --robust, --rates, --styled-inputs, --foreign, "
        "--clips, --long, --transition, --root and --contents judge networks that run "
        "live");
  }

  const auto panel = MakePanel(arguments, data);
  if (!panel.ok()) return panel.status();
  const judge::Judges& judges = panel.value().judges;
  std::optional<judge::ActionClassifiers> classifiers;  // before a test is begun
  if (arguments.action_classifiers > 0) {
    auto trained = judge::TrainActionClassifiers(data, judges.settings(),
                                                 arguments.action_classifiers, arguments.cache);
    if (!trained.ok()) return trained.status();
    classifiers = std::move(trained.value());
  }
  const nlohmann::json provenance =
      judge::Provenance(command, data, panel.value(), arguments.weights);
  judge::PrintProvenance(provenance);
  judge::TestUse use;
  if (arguments.split == judge::kTest) {
    use = judge::UseOf(provenance, arguments.commit);
    const Status begun = judge::BeginTest(use, arguments.again, arguments.ledger);
    if (!begun.ok()) return begun;
  }
  const judge::Evaluator evaluator(data.manifest, judges, data.train, data.judge, data.validation);
  PrintJudgesOnReal(evaluator, judges.settings().window);
  EvalSession session{arguments, data, judges, evaluator, {}, {}};
  session.json = {{"judges_on_real", evaluator.RealToJson()},
                  {"provenance", provenance},
                  {"glossary", judge::Glossary()}};

  Outputs outputs;
  if (with_weights)
    outputs.styled = StyleBy(styler, data, arguments.stylist, !arguments.examples.empty());
  outputs.offset = judge::ApplyBaseline(data);
  outputs.offset_per_content = judge::ApplyBaseline(data, judge::OffsetPer::kContent);
  const judge::Comparison comparison(data.manifest, judges, panel.value().parts, data.judge);
  JudgeOutputs(session, comparison, outputs);
  if (classifiers) JudgeActions(session, *classifiers, outputs);
  if (arguments.split == judge::kTest) {
    const Status ended = judge::EndTest(use, judge::LedgerFigures(session.json), arguments.ledger);
    if (!ended.ok()) return ended;
  }
  if (arguments.synthetic) JudgeSynthetic(session);
  if (styler.frames) {
    const Status judged = JudgeConditions(session, *styler.frames);
    if (!judged.ok()) return judged;
  }
  if (styler.clips) {
    JudgeCodes(session, *styler.clips);
    const judge::MixedFigures mixed = judge::MeasureMixed(data, judges, *styler.clips);
    judge::Print(data.manifest, mixed);
    session.json["mixed_acts"] = judge::ToJson(data.manifest, mixed);
    if (!arguments.report.empty()) session.pictures = judge::PicturesOf(data, *styler.clips);
  }
  judge::PrintGlossary();
  const Status results = WriteResults(session, outputs);
  if (!results.ok() || !arguments.write_evidence) return results;
  // By the styles of the weights' list.
  const Styled& of_lists = styler.frames ? outputs.styled.back() : outputs.styled.front();
  return judge::WriteEvidence(judge::EvidenceOf(data.manifest, data.train, judge::kJudgeRate_hz,
                                                evaluator.Measure("", of_lists.clips)),
                              {data.manifest.name, panel.value().hash}, arguments.weights);
}

}  // namespace
}  // namespace styled

int main(int argc, char** argv) {
  styled::train::UseFastKernels(argv);
  styled::EvalArguments arguments;
  CLI::App app("Judges weights on recorded clips, as they run live.");
  CLI::Option* const weights =
      app.add_option("--weights", arguments.weights,
                     "Weights to judge; without them only judges and baseline are reported");
  app.add_option("--examples", arguments.examples,
                 "Judge styles that are made from the clips of this manifest, of the same names, "
                 "instead of the weights' own; --weights may then be several, joined by '+', as "
                 "the daemon's")
      ->needs(weights);
  app.add_option("--manifest", arguments.manifest, "Data set (TOML)")->required();
  app.add_option("--data", arguments.data, "Folder that the manifest's paths start from")
      ->required();
  CLI::Option* const cache =
      app.add_option("--cache", arguments.cache, "Folder where trained judges are kept");
  CLI::Option* const write_offset =
      app.add_option("--write-offset", arguments.write_offset,
                     "Only write the baseline as weights to this file, to be judged as others are");
  CLI::Option* const write_evidence =
      app.add_flag("--write-evidence", arguments.write_evidence,
                   "Write into the weights how often each style is recognized and how much of it "
                   "was recorded")
          ->excludes(write_offset);
  CLI::Option* const judges =
      app.add_option("--judges", arguments.judges_file,
                     "File of trained judges, of --write-judges, instead of training them");
  CLI::Option* const write_judges =
      app.add_option("--write-judges", arguments.write_judges,
                     "Only train the judges and write them to this file")
          ->excludes(judges)
          ->excludes(write_offset)
          ->excludes(write_evidence);
  app.add_option("--split", arguments.split,
                 "The clips that are judged: validation, on which weights may be chosen, or test, "
                 "which is used once for the same weights")
      ->check(CLI::IsMember({styled::judge::kValidation, styled::judge::kTest}))
      ->capture_default_str();
  app.add_option(
      "--ledger", arguments.ledger,
      "With --split test: the file of all uses of test splits, model/weights/TESTED.tsv");
  app.add_option("--commit", arguments.commit,
                 "With --split test: the commit that the programs were built of, for the ledger");
  app.add_flag("--again", arguments.again,
               "With --split test: though the ledger has a line of these weights");
  app.add_option("--json", arguments.json, "Write every figure to this file, too");
  app.add_option("--report", arguments.report,
                 "Write a page (HTML) with tables, plots and animated stick figures");
  app.add_option("--inputs", arguments.inputs,
                 "Style the neutral validation clips of this manifest instead");
  CLI::Option* const long_s =
      app.add_option("--long", arguments.long_s,
                     "Judge also after this many seconds of continuous state; 0: do not")
          ->check(styled::Number(0, 86400))
          ->capture_default_str();
  app.add_flag("--absolute", arguments.absolute,
               "Judge the paper's absolute output, too; instead, if the network needs whole "
               "clips");
  app.add_option("--clip-rate", arguments.clip_rate_hz,
                 "If the network needs whole clips: 120 styles them as a live stream of that "
                 "rate, 30 as they were recorded")
      ->check(CLI::IsMember({30, 120}))
      ->capture_default_str();
  app.add_option("--precision", arguments.precision,
                 "Precision to which weights are rounded, as model.precision of the daemon")
      ->check(CLI::IsMember(std::vector<std::string>(styled::net::kPrecisions.begin(),
                                                     styled::net::kPrecisions.end())))
      ->capture_default_str();
  app.add_flag("--robust", arguments.robust, "Judge inputs with the errors of live rigs, too");
  app.add_flag("--rates", arguments.rates, "Judge rigs of 24 to 240 Hz, too");
  app.add_flag("--styled-inputs", arguments.styled_inputs,
               "Judge performers who move in a style already, too");
  app.add_flag("--foreign", arguments.foreign,
               "Judge postures that no training set has, too: sitting, crouching, falling, lying");
  app.add_option("--clips", arguments.clips, "Jitter and jumps on these BVH files, any rig's")
      ->check(CLI::ExistingFile);
  app.add_option("--change-tau", arguments.stylist.change_tau_s,
                 "Low-pass on the change of style, seconds")
      ->check(styled::Number(0, 1))
      ->capture_default_str();
  app.add_option("--root", arguments.root,
                 "Place of the styled body on the floor: follow, at the performer's place, or "
                 "stride, their path scaled by the style's effect on speed")
      ->check(CLI::IsMember({"follow", "stride"}))
      ->capture_default_str();
  app.add_option("--contents", arguments.contents,
                 "The content given to a network that takes it as input: recognized, as it "
                 "recognizes it live; unknown; or label, the clips' own. Feet, switches, "
                 "--foreign and --clips are judged with recognized ones")
      ->check(CLI::IsMember({"recognized", "unknown", "label"}))
      ->capture_default_str();
  app.add_flag("--synthetic", arguments.synthetic,
               "Does the content judge recognize the synthetic performer?");
  app.add_flag("!--no-feet", arguments.stylist.feet, "Do not hold feet that are planted");
  app.add_flag("!--no-neutral", arguments.stylist.neutral,
               "Do not remove the performer's own carriage before the network");
  app.add_option("--posture", arguments.stylist.posture,
                 "How much of a style's posture is kept while the network shows none of it")
      ->check(styled::Number(0, 1))
      ->capture_default_str();
  app.add_flag("!--no-limb-gate", arguments.stylist.limb_gate,
               "Do not withhold the style of limbs in unknown motions");
  app.add_flag(
      "!--no-ground", arguments.stylist.ground,
      "Do not shift the styled body vertically: shows the share of grounding in jitter and skate");
  CLI::Option* const transition =
      app.add_option("--transition", arguments.transition_s, "Cross-fade of a switch, seconds")
          ->check(styled::Number(0, 3))
          ->capture_default_str();
  app.add_option("--judge-iterations", arguments.judges.iterations, "Training steps of the judges")
      ->check(styled::Number(1, 1e7))
      ->capture_default_str();
  app.add_option("--judge-window", arguments.judges.window,
                 "Frames at 30 Hz; a multiple of 4, 24 to 240")
      ->check([](const std::string& text) -> std::string {
        const int frames = std::atoi(text.c_str());
        return frames >= 24 && frames <= 240 && frames % 4 == 0
                   ? ""
                   : "'" + text + "': expected a multiple of 4 from 24 to 240";
      })
      ->capture_default_str();
  app.add_option("--judge-seeds", arguments.judges.count,
                 "How many judges: figures are their mean, with the spread of what each says")
      ->check(styled::Whole(1, styled::judge::kMostJudges))
      ->capture_default_str();
  app.add_option("--action-classifiers", arguments.action_classifiers,
                 "How many ST-GCN classifiers of the content judge, too, as in Park et al. 2021")
      ->check(styled::Whole(0, styled::judge::kMostJudges))
      ->capture_default_str();
  app.add_option("--seed", arguments.judges.seed, "Seed of the first judge")
      ->check(styled::Whole(0, std::numeric_limits<unsigned>::max()))
      ->capture_default_str();
  if (const auto ended = styled::Parse(app, argc, argv)) return *ended;
  if (!write_evidence->empty() && arguments.weights.empty()) {
    std::cerr << "styleeval: --write-evidence needs --weights\n";
    return styled::kBadArguments;
  }
  arguments.long_given = long_s->count() > 0;
  arguments.transition_given = transition->count() > 0;
  if (cache->empty() && write_offset->empty() && judges->empty()) {
    std::cerr << "styleeval: --cache or --judges is required\n";
    return styled::kBadArguments;
  }
  if (arguments.action_classifiers > 0 && cache->empty()) {
    std::cerr << "styleeval: --action-classifiers needs --cache\n";
    return styled::kBadArguments;
  }
  const bool test = arguments.split == styled::judge::kTest;
  const bool recorded =
      !arguments.weights.empty() && !arguments.ledger.empty() && !arguments.commit.empty();
  if (test && (!recorded || !write_evidence->empty())) {
    std::cerr << "styleeval: --split test needs --weights, --ledger and --commit, and no "
                 "--write-evidence\n";
    return styled::kBadArguments;
  }
  const styled::Status status = styled::Run(arguments, styled::judge::CommandLine(argc, argv));
  if (status.ok()) return 0;
  std::cerr << "styleeval: " << status.message() << "\n";
  return 1;
}

// Judges styles by one example on walks and runs. Each style's example is a part of its walk.
//   The judges learn from a half of the rest of that walk, a half of the style's run and of its
//   dash; from all its other contents; from all of its set's neutral; and from the walks and runs
//   of the split "train" of the sources' set, in all its styles. With --leak also from the
//   examples. They never see the sources, nor the other halves, which are the row "real".
// A second fold exchanges the halves; all figures are means over both.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <map>

#include "model/feet/legs.h"
#include "model/tools/command_line.h"
#include "model/tools/number.h"
#include "model/tools/stylegaits_load.h"
#include "model/tools/stylegaits_table.h"
#include "model/train/blas.h"
#include "model/train/judge/examples.h"
#include "model/train/judge/gait_stream.h"
#include "model/train/judge/provenance.h"
#include "model/train/judge/unseen.h"
#include "model/train/judge/unseen_live.h"

namespace styled {
namespace {

constexpr int kOutputStride = 4, kRealStride = 1;  // frames between windows that are judged
constexpr int kFolds = 2;

struct Arguments {
  std::string weights, manifest, sources, data, cache, json, examples = "walk";
  std::vector<std::filesystem::path> strangers;
  judge::NeutralKnown known = judge::NeutralKnown::kCalibrated;
  bool neutral = false, leak = false;
  judge::JudgeSettings judges = {.count = judge::kUsualJudges};
  std::string command;
};

// One source in one style.
struct Output {
  std::size_t source = 0, style = 0;
  judge::InAndOut network;
  judge::Poses offset;
};
struct Group {
  std::string title, key;
  std::vector<judge::GaitSource> sources;
  std::vector<Output> outputs;
  GaitRows rows;
};

class Session {
 public:
  explicit Session(const Arguments& arguments) : arguments_(arguments) {}

  Status Run() {
    for (const auto step : {&Session::Load, &Session::LoadGroups, &Session::Style}) {
      Status status = (this->*step)();
      if (!status.ok()) return status;
    }
    for (int fold = 0; fold < kFolds; ++fold) {
      Status status = Score(fold);
      if (!status.ok()) return status;
    }
    judge::PrintWeights(judge::WeightsOf(arguments_.weights));
    for (const Group& group : groups_) {
      Print(group.title, names_, chosen_, group.rows);
      json_[group.key] = ToJson(names_, chosen_, group.rows);
    }
    if (arguments_.json.empty()) return Status::Ok();
    json_["command"] = arguments_.command;
    json_["weights"] = judge::WeightsOf(arguments_.weights);
    json_["leak"] = arguments_.leak;
    return judge::WriteJson(json_, arguments_.json);
  }

 private:
  judge::GaitParts PartsOf(int fold) const {
    judge::GaitParts parts =
        judge::SplitGaits(whole_.clips, names_.size(), whole_.manifest.contents,
                          {.least = static_cast<std::size_t>(arguments_.judges.window) + 1,
                           .fold = fold,
                           .leak = arguments_.leak,
                           .example_runs = arguments_.examples == "walk+run"});
    parts.judges.insert(parts.judges.end(), performers_.clips.begin(), performers_.clips.end());
    return parts;
  }

  Status Load() {
    Status status = train::CheckDataFolder(arguments_.data);
    if (!status.ok()) return status;
    auto network = judge::LoadJoined(arguments_.weights);
    if (!network.ok()) return network.status();
    styler_ = {
        network.value(), std::make_shared<const rig::Binding>(feet::HumanoidBinding()), {}, 0};
    auto whole = LoadWhole(arguments_.manifest, arguments_.data);
    if (!whole.ok()) return whole.status();
    whole_ = std::move(whole.value());
    for (const clip::ManifestStyle& style : whole_.manifest.styles) names_.push_back(style.name);
    examples_ = PartsOf(0).examples;
    const auto least = static_cast<std::size_t>(styler_.network->space()->least_frames());
    for (std::size_t style = 1; style < names_.size(); ++style) {
      if (examples_[style][0].size() >= least) chosen_.push_back(style);
    }
    if (chosen_.empty()) return Status::Error(arguments_.manifest + ": no style has a walk");
    if (!examples_[0][0].empty() || !arguments_.neutral) return Status::Ok();
    return Status::Error(arguments_.manifest + ": --neutral: no neutral walk");
  }

  Status LoadGroups() {
    auto sources = LoadSources(arguments_.sources, arguments_.data);
    if (!sources.ok()) return sources.status();
    AddGroup("sources", "sources", std::move(sources.value()));
    performers_.manifest = whole_.manifest;
    Status added = AddPerformers(arguments_.sources, arguments_.data, performers_);
    if (!added.ok()) return added;
    auto strangers = LoadStrangers(arguments_.strangers);
    if (!strangers.ok()) return strangers.status();
    if (!strangers.value().empty()) {
      AddGroup("strangers", "strangers", std::move(strangers.value()));
    }
    for (const Group& group : groups_) {
      for (std::size_t i = 0; i < group.sources.size(); ++i) {
        if (judge::NeutralSourceOf(group.sources, i) >= 0) continue;
        return Status::Error(group.sources[i].name + ": the only clip of " +
                             group.sources[i].person +
                             "; expected another one, from which their neutral is learned");
      }
    }
    return Status::Ok();
  }

  void AddGroup(const char* title, const char* key, std::vector<judge::GaitSource> sources) {
    judge::PerGait<int> counts{};
    for (const judge::GaitSource& source : sources) ++counts[static_cast<std::size_t>(source.gait)];
    std::string text = std::string(title) + ": " + std::to_string(counts[0]) + " walks, " +
                       std::to_string(counts[1]) + " runs (";
    for (const judge::GaitSource& source : sources) {
      text += (&source == sources.data() ? "" : ", ") + source.name;
    }
    groups_.push_back({text + ")", key, std::move(sources), {}, GaitRows(names_.size())});
  }

  net::StyleCode CodeOf(std::size_t style) const {
    const net::StyleSpace& space = *styler_.network->space();
    const auto code = [&](const judge::PerGait<judge::Poses>& examples) {
      net::StyleRequest request;
      for (const judge::Poses& example : examples) {
        const bool wanted = &example == examples.data() || arguments_.examples == "walk+run";
        if (example.empty() || !wanted) continue;
        request.sources.push_back({.style = -1, .seed = {}, .reference = example, .weight = 1});
      }
      return space.MakeCode(request);
    };
    if (!arguments_.neutral) return code(examples_[style]);
    return space.Difference(code(examples_[style]), code(examples_[0]));
  }

  Status Style() {
    std::map<std::size_t, net::StyleCode> codes;
    for (const std::size_t style : chosen_) codes[style] = CodeOf(style);
    for (Group& group : groups_) {
      const judge::GaitStream stream(styler_, group.sources, arguments_.known);
      for (std::size_t source = 0; source < group.sources.size(); ++source) {
        const judge::Poses neutral = judge::MeanNeutralOf(group.sources, source);
        for (const std::size_t style : chosen_) {
          Output output{source, style, stream.Style(source, codes[style]), {}};
          const judge::ConstantOffset offset = judge::OffsetBetween(neutral, examples_[style][0]);
          for (const body::Pose& pose : output.network.input) {
            output.offset.push_back(offset.Apply(pose));
          }
          group.outputs.push_back(std::move(output));
        }
      }
    }
    return Status::Ok();
  }

  Status Score(int fold) {
    const judge::GaitParts parts = PartsOf(fold);
    std::printf("\nfold %d: the examples | what the judges learn from%s | what is real\n", fold + 1,
                arguments_.leak ? ", examples included" : "");
    PrintParts(performers_.manifest, parts);
    json_["parts"].push_back(ToJson(performers_.manifest, parts));
    const auto judges =
        TrainGaitJudges(parts.judges, performers_.manifest, arguments_.judges, arguments_.cache);
    if (!judges.ok()) return judges.status();
    const nlohmann::json made = judge::JudgesOf(judges.value().panel);
    judge::PrintJudges(made);
    json_["judges"].push_back(made);
    for (Group& group : groups_) {
      ScoreOutputs(parts, judges.value(), group);
      ScoreReal(parts, judges.value(), group);
    }
    return Status::Ok();
  }

  static void ScoreOutputs(const judge::GaitParts& parts, const GaitJudges& judges, Group& group) {
    std::map<std::size_t, std::vector<judge::Recognition>> unstyled;  // by source
    for (const Output& output : group.outputs) {
      const auto gait = static_cast<std::size_t>(group.sources[output.source].gait);
      const judge::Poses& input = output.network.input;
      const auto score = [&](const judge::Poses& poses, const judge::Recognition& recognition,
                             judge::GaitTable& table) {
        table[output.style][gait].Add(
            judge::MeasureGaitOutput(input, poses, parts.wanted[output.style][gait], recognition));
      };
      const auto recognized = [&](const judge::Poses& poses) {
        return judges.Recognize(poses, kOutputStride)[output.style];
      };
      score(output.network.output, recognized(output.network.output), group.rows.network);
      score(output.offset, recognized(output.offset), group.rows.offset);
      auto& of_input = unstyled[output.source];
      if (of_input.empty()) of_input = judges.Recognize(input, kOutputStride);
      score(input, of_input[output.style], group.rows.unstyled);
    }
  }

  static void ScoreReal(const judge::GaitParts& parts, const GaitJudges& judges, Group& group) {
    for (const judge::RealPart& part : parts.real) {
      const auto style = static_cast<std::size_t>(part.style);
      const auto gait = static_cast<std::size_t>(part.gait);
      judge::Mean unchanged_m;
      for (const Output& output : group.outputs) {
        const bool fits = output.style == style && group.sources[output.source].gait == part.gait;
        if (!fits || parts.wanted[style][gait].empty()) continue;
        unchanged_m.Add(judge::MovementDistance_m(output.network.input, parts.wanted[style][gait]));
      }
      group.rows.real[style][gait].Add(
          judge::MeasureReal(part, parts.wanted[style][gait], unchanged_m.value(),
                             judges.Recognize(part.poses, kRealStride)[style]));
    }
  }

  const Arguments& arguments_;
  judge::Styler styler_;
  WholeClips whole_;
  std::vector<std::string> names_;   // of the manifest's styles
  std::vector<std::size_t> chosen_;  // those that have an example
  std::vector<judge::PerGait<judge::Poses>> examples_;
  std::vector<Group> groups_;
  WholeClips performers_;  // of the sources' set, for the judges; the manifest has all their styles
  nlohmann::json json_;
};

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--weights", arguments.weights,
                 "Live weights that take examples; several, joined by '+', as the daemon's")
      ->required();
  app.add_option("--manifest", arguments.manifest, "Data set with the styles (TOML)")->required();
  app.add_option("--sources", arguments.sources,
                 "Data set whose neutral walks and runs are styled: those of its splits "
                 "validation and judge (TOML)")
      ->required();
  app.add_option("--source", arguments.strangers,
                 "Further clips to style, reported apart (BVH); a folder is one person");
  app.add_option("--data", arguments.data, "Folder that the manifests' paths start from")
      ->required();
  app.add_option("--cache", arguments.cache, "Folder of trained judges")->required();
  app.add_option(
         "--neutral-known", arguments.known,
         "The performer's neutral: calibrated on another clip of theirs, learned in the 3 s "
         "before the clip, or mean, that of the network's performers")
      ->transform(CLI::CheckedTransformer(std::map<std::string, judge::NeutralKnown>{
          {"calibrated", judge::NeutralKnown::kCalibrated},
          {"learned", judge::NeutralKnown::kLearned},
          {"mean", judge::NeutralKnown::kMean}}));
  app.add_flag("--neutral", arguments.neutral,
               "Examples are shown beside the neutral walk of their actor: only what they differ "
               "by counts");
  app.add_option("--examples", arguments.examples,
                 "walk; or walk+run: the run, whole, is an example, too, and dashes alone are "
                 "judged")
      ->check(CLI::IsMember({"walk", "walk+run"}));
  app.add_flag("--leak", arguments.leak, "The judges learn from the examples, too");
  app.add_option("--judge-seeds", arguments.judges.count, "How many judges; figures are means")
      ->check(Whole(1, judge::kMostJudges))
      ->capture_default_str();
  app.add_option("--iterations", arguments.judges.iterations, "Of the judges' training")
      ->capture_default_str();
  app.add_option("--json", arguments.json, "Write the figures to this file, too");
}

}  // namespace
}  // namespace styled

int main(int argc, char** argv) {
  styled::train::UseFastKernels(argv);
  styled::Arguments arguments;
  arguments.command = styled::judge::CommandLine(argc, argv);
  arguments.judges.iterations = 400;  // few clips are learned soon
  CLI::App app("Judges styles by one example on walks and runs.");
  styled::AddOptions(app, arguments);
  if (const auto ended = styled::Parse(app, argc, argv)) return *ended;
  const styled::Status status = styled::Session(arguments).Run();
  if (status.ok()) return 0;
  std::cerr << "stylegaits: " << status.message() << "\n";
  return 1;
}

// Judges trained weights: Style-ERD's figures for every style, compared with the same judges on
// real clips and with the constant-offset baseline. Asserts nothing; `--json` is for comparing
// runs.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <numeric>

#include "model/clip/clip.h"
#include "model/clip/manifest.h"
#include "model/synthetic/performer.h"
#include "model/tools/number.h"
#include "model/train/blas.h"
#include "model/train/judge/judge_comparison.h"
#include "model/train/judge/judge_conditions.h"
#include "model/train/judge/judge_data.h"
#include "model/train/judge/judge_details.h"
#include "model/train/judge/judge_feet.h"
#include "model/train/judge/judge_foreign.h"
#include "model/train/judge/judge_html.h"
#include "model/train/judge/judge_nets.h"
#include "model/train/judge/judge_report.h"
#include "model/train/judge/judge_response.h"
#include "model/train/judge/judge_stream.h"

namespace {

namespace body = styled::body;
namespace clip = styled::clip;
namespace judge = styled::judge;
namespace train = styled::train;
using styled::Result;
using styled::Status;

constexpr int kBlendFrames = 10;  // overlap of chained clips, at the judges' rate

struct Arguments {
  std::string weights, manifest, inputs, data, cache, json, report, write_offset;
  double long_s = 60;
  bool absolute = false, synthetic = false, robust = false, rates = false, styled_inputs = false,
       foreign = false;
  std::vector<std::filesystem::path> clips;
  judge::JudgeSettings judges;
  styled::stylist::Options stylist;
  float transition_s = 0.1F;
};

// For every content the longest input (its first 6 s), with each style and the baseline.
std::vector<judge::Scene> Scenes(const judge::Data& data,
                                 const std::vector<judge::Transferred>& baseline,
                                 const std::vector<judge::Transferred>& styled) {
  const auto frames = static_cast<std::size_t>(6 * judge::kStreamRate_hz);
  const auto cut = [&](std::span<const body::Pose> poses) {
    return judge::Thin(poses.first(std::min(poses.size(), frames)));
  };
  std::vector<judge::Scene> scenes;
  for (std::size_t content = 0; content < data.manifest.contents.size(); ++content) {
    int longest = -1;
    for (std::size_t i = 0; i < data.inputs.size(); ++i) {
      if (data.contents[i] != static_cast<int>(content)) continue;
      if (longest < 0 || data.inputs[i].size() > data.inputs[longest].size()) {
        longest = static_cast<int>(i);
      }
    }
    for (const judge::Transferred& of : styled.empty() ? baseline : styled) {
      if (of.clip != longest) continue;
      const auto offset = std::find_if(baseline.begin(), baseline.end(), [&of](const auto& other) {
        return other.clip == of.clip && other.style == of.style;
      });
      scenes.push_back({data.manifest.contents[content], data.manifest.styles[of.style].name,
                        cut(of.input),
                        offset == baseline.end() ? judge::Poses() : cut(offset->output),
                        styled.empty() ? judge::Poses() : cut(of.output)});
    }
  }
  return scenes;
}

// A long stream of neutral clips, of one content or of all in turn, and its output in every style.
// The stream lasts `seconds` and then shows each clip once more.
struct LongRun {
  judge::Chain chain;                // at the stream's rate
  std::vector<int> contents;         // of each clip of the chain
  std::vector<judge::Poses> styled;  // per manifest style; empty where absent
};

LongRun RunLong(const Arguments& arguments, const judge::Styler& styler,
                const std::vector<const train::TrainingClip*>& neutral) {
  std::vector<judge::Poses> clips;
  LongRun run;
  for (const train::TrainingClip* c : neutral) {
    clips.push_back(c->poses);
    run.contents.push_back(c->content);
  }
  run.chain = judge::ChainClips(clips, judge::kJudgeRate_hz, arguments.long_s, kBlendFrames);
  if (run.chain.poses.empty()) return run;
  run.chain.poses =
      clip::ResamplePoses(run.chain.poses, judge::kJudgeRate_hz, judge::kStreamRate_hz);
  for (judge::Chain::Part& part : run.chain.parts) {
    part.begin *= judge::kStreamPerJudge;
    part.end = std::min(part.end * judge::kStreamPerJudge, run.chain.poses.size());
  }
  for (const int style : styler.style_of) {
    const judge::Switch start{0, judge::OneStyle(style, false)};
    run.styled.push_back(style == judge::kAbsent
                             ? judge::Poses()
                             : judge::StyleStream(styler.network, styler.binding, arguments.stylist,
                                                  {&start, 1}, run.chain.poses));
  }
  return run;
}

// One run per content, and a last one of all contents mixed.
std::vector<LongRun> RunLong(const Arguments& arguments, const judge::Data& data,
                             const judge::Styler& styler) {
  std::vector<std::vector<const train::TrainingClip*>> by_content(data.manifest.contents.size());
  std::size_t most = 0;
  for (const train::TrainingClip& c : data.validation) {
    if (c.style != 0) continue;
    auto& clips = by_content[static_cast<std::size_t>(c.content)];
    clips.push_back(&c);
    most = std::max(most, clips.size());
  }
  std::vector<const train::TrainingClip*> mixed;
  for (std::size_t i = 0; i < most; ++i) {
    for (const auto& clips : by_content) {
      if (i < clips.size()) mixed.push_back(clips[i]);
    }
  }
  std::vector<LongRun> runs;
  for (const auto& clips : by_content) {
    LongRun run = RunLong(arguments, styler, clips);
    if (!run.chain.poses.empty()) runs.push_back(std::move(run));
  }
  runs.push_back(RunLong(arguments, styler, mixed));
  return runs;
}

// Cuts out the clips of the long runs that begin after `seconds`, without the seams.
std::vector<judge::Transferred> TakeLate(std::span<const LongRun> runs, double seconds) {
  std::vector<judge::Transferred> late;
  const auto from = static_cast<std::size_t>(seconds * judge::kStreamRate_hz);
  int clip = 0;
  for (const LongRun& run : runs) {
    for (const judge::Chain::Part& part : run.chain.parts) {
      if (part.begin < from || part.end <= part.begin) continue;
      const auto cut = [&part](const judge::Poses& poses) {
        return std::span(poses).subspan(part.begin, part.end - part.begin);
      };
      for (std::size_t style = 1; style < run.styled.size(); ++style) {
        if (run.styled[style].empty()) continue;
        const auto styled = cut(run.styled[style]);
        late.push_back({clip, static_cast<int>(style),
                        run.contents[static_cast<std::size_t>(part.clip)], cut(run.chain.poses),
                        judge::Poses(styled.begin(), styled.end())});
      }
      ++clip;
    }
  }
  return late;
}

void PrintResponse(const judge::Response& response) {
  std::printf("\nswitching (%d switches)\n", response.switches);
  for (const judge::Seen& seen : {response.soon, response.sure}) {
    std::printf(
        "  windows of %.2f s (of real clips %.3f are judged rightly): the new style is seen after "
        "%.2f s (median), %.2f s (p90); an instant cut after %.2f and %.2f s; never %.1f %%\n",
        seen.window / judge::kJudgeRate_hz, seen.right_on_real, seen.median_s, seen.p90_s,
        seen.cut_median_s, seen.cut_p90_s, 100 * seen.never);
  }
  std::printf(
      "  largest joint acceleration in the second after a switch, over the input's p99.9: %.2f "
      "(median), %.2f (max); away from switches, p99.9: %.2f; above 1.5 times that and what both "
      "styles do then: %.1f %%\n",
      response.acceleration_median, response.acceleration_max, response.steady,
      100 * response.to_blame);
}

nlohmann::json ToJson(const judge::Seen& seen) {
  return {{"window_s", seen.window / judge::kJudgeRate_hz},
          {"right_on_real", seen.right_on_real},
          {"median_s", seen.median_s},
          {"p90_s", seen.p90_s},
          {"instant_cut_median_s", seen.cut_median_s},
          {"instant_cut_p90_s", seen.cut_p90_s},
          {"never", seen.never}};
}

Status JudgeWeights(const Arguments& arguments, const judge::Data& data,
                    const judge::Styler& styler, const judge::Judges& judges,
                    const judge::Evaluator& evaluator, std::vector<judge::Transferred>& styled,
                    std::vector<judge::Scene>& scenes, nlohmann::json& json) {
  const auto live = [&](bool absolute) {
    return judge::Style(data, styler, arguments.stylist, absolute);
  };
  const auto report = [&](const char* key, const std::string& title,
                          const std::vector<judge::Transferred>& clips) {
    const judge::Figures figures = evaluator.Measure(title, clips);
    if (figures.cra.windows == 0) {
      std::printf("\n%s: not judged, no clip is as long as a window\n", title.c_str());
      return;
    }
    evaluator.Print(figures);
    json[key] = evaluator.ToJson(figures);
  };
  styled = live(false);
  report("styled", "styled (detail-preserving, as live)", styled);
  if (arguments.absolute) report("absolute", "absolute (the paper's output)", live(true));

  const styled::stylist::Options& options = arguments.stylist;
  if (arguments.robust) json["spoilt"] = judge::JudgePerturbed(data, styler, evaluator, options);
  if (arguments.rates) json["rates"] = judge::JudgeRates(data, styler, evaluator, options);
  if (arguments.styled_inputs) {
    json["styled_inputs"] = judge::JudgeStyledInputs(data, styler, evaluator, options);
  }
  if (arguments.foreign) json["foreign"] = judge::JudgeForeign(data, styler, options, scenes);
  if (!arguments.clips.empty()) {
    auto others = judge::JudgeOtherClips(arguments.clips, styler, options, scenes);
    if (!others.ok()) return others.status();
    json["other_clips"] = std::move(others.value());
  }

  std::vector<judge::Poses> neutral;
  for (const judge::Poses& input : data.inputs) neutral.push_back(judge::Thin(input));
  const judge::Reconstruction reconstruction =
      judge::MeasureReconstruction(*styler.network, neutral);
  std::printf("\nreconstruction of neutral clips: %.2f degrees, %.2f cm (means over joints)\n",
              reconstruction.angle_deg.value(), reconstruction.position_cm.value());
  json["reconstruction"] = {{"angle_deg", reconstruction.angle_deg.value()},
                            {"position_cm", reconstruction.position_cm.value()}};
  if (arguments.stylist.feet) {
    std::vector<int> present;
    for (const int style : styler.style_of) {
      if (style > 0) present.push_back(style);
    }
    const judge::FeetStage stage = judge::MeasureFeetStage(styler.network, styler.binding,
                                                           arguments.stylist, present, data.inputs);
    judge::Print(stage);
    json["feet"] = judge::ToJson(stage);
  }
  if (arguments.long_s <= 0) return Status::Ok();

  const std::vector<LongRun> runs = RunLong(arguments, data, styler);
  char title[96];
  std::snprintf(title, sizeof title, "styled, after %.0f s of continuous state", arguments.long_s);
  const std::span<const LongRun> apart = std::span(runs).first(runs.size() - 1);
  report("long", title, TakeLate(apart, arguments.long_s));
  std::snprintf(title, sizeof title, "styled, contents mixed, after %.0f s", arguments.long_s);
  report("mixed", title, TakeLate(std::span(runs).last(1), arguments.long_s));

  std::vector<int> styles;
  std::vector<int> network_styles;
  for (std::size_t style = 1; style < styler.style_of.size(); ++style) {
    if (styler.style_of[style] == judge::kAbsent) continue;
    styles.push_back(static_cast<int>(style));
    network_styles.push_back(styler.style_of[style]);
  }
  if (styles.size() < 2) return Status::Ok();
  std::vector<judge::ResponseInput> inputs;
  for (const LongRun& run : apart) {
    const std::size_t frames = std::min<std::size_t>(
        run.chain.poses.size(), static_cast<std::size_t>(60 * judge::kStreamRate_hz));
    judge::ResponseInput input{run.contents.front(), std::span(run.chain.poses).first(frames), {}};
    for (const int style : styles)
      input.steady.push_back(std::span(run.styled[style]).first(frames));
    inputs.push_back(std::move(input));
  }
  const judge::Response response = judge::MeasureResponse(
      judges, data.validation, styles, network_styles, styler.network, styler.binding,
      arguments.stylist, arguments.transition_s, 4.0, inputs);
  PrintResponse(response);
  json["response"] = {{"switches", response.switches},
                      {"soon", ToJson(response.soon)},
                      {"sure", ToJson(response.sure)},
                      {"acceleration_median", response.acceleration_median},
                      {"acceleration_max", response.acceleration_max},
                      {"acceleration_steady", response.steady},
                      {"to_blame", response.to_blame}};
  return Status::Ok();
}

// A content, and the script with which the synthetic performer performs it.
struct Performance {
  const char* content;
  std::vector<styled::synthetic::ScriptItem> script;
};

std::vector<Performance> Performances() {
  using enum styled::synthetic::Motion;
  constexpr double kPause_s = 1.5;  // gestures return to rest in it
  return {{"walk", {{kWalk, 60}}},
          {"run", {{kRun, 60}}},
          {"turn", {{kTurnLeft, 6}, {kWalk, 1.5}, {kTurnRight, 6}, {kWalk, 1.5}}},
          {"raise",
           {{kRaiseLeft, 2},
            {kStand, kPause_s},
            {kRaiseRight, 2},
            {kStand, kPause_s},
            {kRaiseBoth, 2},
            {kStand, kPause_s}}},
          {"wave",
           {{kWaveLeft, 6},
            {kStand, kPause_s},
            {kWaveRight, 6},
            {kStand, kPause_s},
            {kWaveBoth, 6},
            {kStand, kPause_s}}}};
}

// Does the content judge, trained on real clips, recognize the synthetic performer? Counts only
// windows that belong to the content throughout (a pause belongs to none).
void JudgeSynthetic(const judge::Data& data, const judge::Judges& judges,
                    const judge::Evaluator& evaluator, nlohmann::json& json) {
  namespace synthetic = styled::synthetic;
  constexpr int kPerformers = 6;
  constexpr int kSeconds = 60;
  const std::vector<std::string>& contents = data.manifest.contents;
  std::printf("\nsynthetic performer, windows that the content judge recognizes\n");
  std::vector<judge::ClipVerdict> verdicts;
  for (const Performance& performance : Performances()) {
    const auto found = std::find(contents.begin(), contents.end(), performance.content);
    if (found == contents.end()) continue;
    const int content = static_cast<int>(found - contents.begin());
    const synthetic::Motion pause = performance.script.back().motion;
    const bool pauses = performance.script.size() > 1;
    std::vector<int> answers(contents.size(), 0);
    for (int k = 0; k < kPerformers; ++k) {
      synthetic::Performer human(
          synthetic::Vary(1, static_cast<std::uint64_t>(k), performance.script));
      judge::Poses poses(static_cast<std::size_t>(kSeconds * judge::kJudgeRate_hz));
      std::vector<int> counted(poses.size(), 0);  // frames since the last pause
      for (std::size_t i = 0; i < poses.size(); ++i) {
        human.Pose(static_cast<double>(i) / judge::kJudgeRate_hz, poses[i]);
        const bool paused = pauses && human.motion() == pause;
        counted[i] = paused ? 0 : (i > 0 ? counted[i - 1] : 0) + 1;
      }
      const judge::Verdicts said =
          judges.Judge(judge::MakeSequence(poses, 0, content, false, judges.parameters()), 8);
      judge::ClipVerdict verdict{.cell = content, .clip = k};
      for (std::size_t i = 0; i < said.starts.size(); ++i) {
        // Frame f of the sequence is pose f + 1.
        const int window = judges.settings().window;
        if (counted[static_cast<std::size_t>(said.starts[i] + window)] < window) continue;
        verdict.windows += 1;
        verdict.hits += said.content[i] == content;
        ++answers[static_cast<std::size_t>(said.content[i])];
      }
      verdicts.push_back(verdict);
    }
    double total = 0;
    for (const int count : answers) total += count;
    const double share = answers[static_cast<std::size_t>(content)] / std::max(1.0, total);
    std::printf("  %-6s %.3f of %4.0f:", performance.content, share, total);
    for (std::size_t i = 0; i < contents.size(); ++i) {
      std::printf("  %s %d", contents[i].c_str(), answers[i]);
    }
    std::printf("\n");
    json["synthetic"][performance.content] = {{"recognized", share}, {"windows", total}};
  }
  const judge::Share all = judge::MacroShare(verdicts, 1);
  std::printf("  mean   %.3f [%.3f %.3f]; on real clips %.3f\n", all.value, all.low, all.high,
              evaluator.real_content().value);
  json["synthetic"]["mean"] = all.value;
}

// Checks first what would otherwise fail only after minutes.
Status CheckFiles(const Arguments& arguments) {
  if (!arguments.weights.empty() && !std::filesystem::exists(arguments.weights)) {
    return Status::Error("--weights " + arguments.weights + ": no such file");
  }
  for (const auto& [flag, file] :
       {std::pair("--json", arguments.json), std::pair("--report", arguments.report),
        std::pair("--write-offset", arguments.write_offset)}) {
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

Status Run(const Arguments& arguments) {
  const Status files = CheckFiles(arguments);
  if (!files.ok()) return files;
  Result<judge::Data> loaded =
      judge::LoadData(arguments.manifest, arguments.inputs, arguments.data);
  if (!loaded.ok()) return loaded.status();
  const judge::Data& data = loaded.value();
  if (!arguments.write_offset.empty()) return judge::WriteBaseline(data, arguments.write_offset);
  std::printf(
      "%zu clips train the generator, %zu the judges; %zu are judged, %zu of them neutral\n",
      data.train.size(), data.judge.size(), data.validation.size(), data.inputs.size());

  auto trained = judge::TrainJudges(data, arguments.judges, arguments.cache);
  if (!trained.ok()) return trained.status();
  const judge::Judges& judges = trained.value();
  const auto parts = judge::TrainPartJudges(data, arguments.judges, arguments.cache);
  if (!parts.ok()) return parts.status();
  const judge::Evaluator evaluator(data.manifest, judges, data.train, data.judge, data.validation);
  const judge::Share& style = evaluator.real_style();
  const judge::Share& content = evaluator.real_content();
  std::printf(
      "judges on real clips (%.0f windows of %d frames): style %.3f [%.3f %.3f], worst %.2f (%s); "
      "content %.3f [%.3f %.3f], worst %.2f (%s)\n",
      style.windows, judges.settings().window, style.value, style.low, style.high, style.worst,
      evaluator.CellName(style.worst_cell).c_str(), content.value, content.low, content.high,
      content.worst, evaluator.CellName(content.worst_cell).c_str());
  nlohmann::json json = {{"judges_on_real", evaluator.RealToJson()}};

  if (arguments.synthetic) JudgeSynthetic(data, judges, evaluator, json);

  const std::vector<judge::Transferred> baseline = judge::ApplyBaseline(data);
  const judge::Figures figures =
      evaluator.Measure("baseline (a constant rotation per joint)", baseline);
  evaluator.Print(figures);
  json["baseline"] = evaluator.ToJson(figures);

  std::vector<judge::Transferred> styled;
  std::vector<judge::Scene> scenes;
  if (!arguments.weights.empty()) {
    Result<judge::Styler> styler = judge::LoadStyler(arguments.weights, data.manifest);
    if (!styler.ok()) return styler.status();
    const Status judged =
        JudgeWeights(arguments, data, styler.value(), judges, evaluator, styled, scenes, json);
    if (!judged.ok()) return judged;
  }
  const judge::Comparison comparison(data.manifest, judges, parts.value(), data.judge);
  std::vector<judge::Compared> sets;
  sets.push_back(comparison.OfReal("real", "real clips", data.validation));
  sets.push_back(comparison.OfStyled("neutral", "neutral input", judge::Unstyled(data)));
  sets.push_back(comparison.OfStyled("offset", "constant offset", baseline));
  sets.push_back(comparison.OfStyled("offset_per_content", "offset per content",
                                     judge::ApplyBaseline(data, judge::OffsetPer::kContent)));
  if (!styled.empty()) sets.push_back(comparison.OfStyled("styled", "styled", styled));
  judge::Print(data.manifest, sets);
  const judge::Details details =
      judge::MeasureDetails(data, "styled", styled.empty() ? baseline : styled);
  judge::Print(data.manifest, details);
  json["details"] = judge::ToJson(data.manifest, details);
  json["judges"] = judge::ToJson(data.manifest, sets);

  if (!arguments.report.empty()) {
    const std::vector<judge::Scene> of_data = Scenes(data, baseline, styled);
    scenes.insert(scenes.begin(), of_data.begin(), of_data.end());
    const auto name = [](const std::string& path) {
      return std::filesystem::path(path).filename().string();
    };
    const Status written = judge::WriteReport({.weights = name(arguments.weights),
                                               .manifest = data.manifest.name,
                                               .figures = json,
                                               .scenes = std::move(scenes)},
                                              arguments.report);
    if (!written.ok()) return written;
  }
  if (!arguments.json.empty()) {
    std::ofstream file(arguments.json);
    file << json.dump(2) << "\n";
    if (!file.flush()) return Status::Error(arguments.json + ": cannot be written");
  }
  return Status::Ok();
}

}  // namespace

int main(int argc, char** argv) {
  styled::train::UseFastKernels(argv);
  Arguments arguments;
  CLI::App app("Judges weights on recorded clips, as they run live.");
  app.add_option("--weights", arguments.weights,
                 "Weights to judge; without them only judges and baseline are reported");
  app.add_option("--manifest", arguments.manifest, "Data set (TOML)")->required();
  app.add_option("--data", arguments.data, "Folder that the manifest's paths start from")
      ->required();
  CLI::Option* const cache =
      app.add_option("--cache", arguments.cache, "Folder where trained judges are kept");
  CLI::Option* const write_offset =
      app.add_option("--write-offset", arguments.write_offset,
                     "Only write the baseline as weights to this file, to be judged as others are");
  app.add_option("--json", arguments.json, "Write every figure to this file, too");
  app.add_option("--report", arguments.report,
                 "Write a page (HTML) with tables, plots and animated stick figures");
  app.add_option("--inputs", arguments.inputs,
                 "Style the neutral validation clips of this manifest instead");
  app.add_option("--long", arguments.long_s,
                 "Judge also after so many seconds of continuous state; 0: do not")
      ->check(styled::Number(0, 86400))
      ->capture_default_str();
  app.add_flag("--absolute", arguments.absolute, "Judge the paper's absolute output, too");
  app.add_flag("--robust", arguments.robust, "Judge inputs as live rigs spoil them, too");
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
  app.add_flag("--synthetic", arguments.synthetic,
               "Does the content judge recognize the synthetic performer?");
  app.add_flag("!--no-feet", arguments.stylist.feet, "Do not hold feet that are planted");
  app.add_flag("!--no-ground", arguments.stylist.ground,
               "Do not shift the styled body vertically: what of jitter and skate is grounding");
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
  app.add_option("--seed", arguments.judges.seed, "Seed of the judges")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (cache->empty() && write_offset->empty()) {
    std::cerr << "styleeval: --cache is required\n";
    return 1;
  }
  const Status status = Run(arguments);
  if (status.ok()) return 0;
  std::cerr << "styleeval: " << status.message() << "\n";
  return 1;
}

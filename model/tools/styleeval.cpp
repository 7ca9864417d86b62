// Judges trained weights: style-ERD's figures for every style, beside the same judges on real clips
// and the constant-offset baseline. Nothing here is asserted; `--json` is for whoever compares
// runs.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <numeric>

#include "model/clip/clip.h"
#include "model/clip/manifest.h"
#include "model/train/judge/judge_nets.h"
#include "model/train/judge/judge_report.h"
#include "model/train/judge/judge_response.h"
#include "model/train/judge/judge_stream.h"
#include "sim/performer/performer.h"

namespace {

namespace body = styled::body;
namespace clip = styled::clip;
namespace erd = styled::erd;
namespace judge = styled::judge;
namespace train = styled::train;
using styled::Result;
using styled::Status;

constexpr int kBlendFrames = 10;  // at the judges' rate, where chained clips overlap
constexpr int kAbsent = -1;

struct Arguments {
  std::string weights, manifest, data, cache, json;
  double long_s = 60;
  bool absolute = false, synthetic = false;
  judge::JudgeSettings judges;
  styled::stylist::Options stylist;
  float transition_s = 0.4F;
};

struct Data {
  clip::Manifest manifest;
  std::vector<train::TrainingClip> train, judge, validation;
  // The neutral clips of `validation`, at the stream's rate.
  std::vector<judge::Poses> inputs;
  std::vector<int> contents;  // of inputs
};

struct Styler {
  std::shared_ptr<const erd::Network> network;
  std::shared_ptr<const styled::rig::Binding> binding;
  std::vector<int> style_of;  // manifest style -> network style
};

std::uint64_t Fnv1a(std::string_view text, std::uint64_t hash = 14695981039346656037ULL) {
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

// Names judges by all that they depend on.
std::string JudgeKey(const Data& data, const judge::JudgeSettings& settings) {
  std::string text = std::to_string(body::HumanoidHash()) + judge::kJudgeRecipe;
  for (const train::TrainingClip& c : data.judge) {
    text += std::filesystem::path(c.file).filename().string() + std::to_string(c.style) +
            std::to_string(c.content) + std::to_string(c.poses.size());
  }
  for (const double value :
       {static_cast<double>(settings.window), static_cast<double>(settings.iterations),
        static_cast<double>(settings.batch), static_cast<double>(settings.seed)}) {
    text += " " + std::to_string(value);
  }
  char key[17];
  std::snprintf(key, sizeof key, "%016llx", static_cast<unsigned long long>(Fnv1a(text)));
  return key;
}

Result<Data> Load(const Arguments& arguments) {
  if (Status status = train::CheckDataFolder(arguments.data); !status.ok()) return status;
  Result<clip::Manifest> manifest = clip::LoadManifest(arguments.manifest, arguments.data);
  if (!manifest.ok()) return manifest.status();
  Data data;
  data.manifest = std::move(manifest.value());
  body::FeatureParameters parameters;
  parameters.rate_hz = static_cast<float>(judge::kJudgeRate_hz);
  for (const auto& [split, clips] : {std::pair{"train", &data.train},
                                     {"judge", &data.judge},
                                     {"validation", &data.validation}}) {
    auto loaded = train::LoadClips(data.manifest, split, parameters, 2);
    if (!loaded.ok()) return loaded.status();
    *clips = std::move(loaded.value());
  }
  for (const train::TrainingClip& c : data.validation) {
    if (c.style != 0) continue;
    data.inputs.push_back(
        clip::ResamplePoses(c.poses, judge::kJudgeRate_hz, judge::kStreamRate_hz));
    data.contents.push_back(c.content);
  }
  return data;
}

// Mean target minus mean neutral, per joint, contents in equal parts, from the generator's clips.
std::vector<judge::ConstantOffset> Baselines(const Data& data) {
  const std::size_t styles = data.manifest.styles.size();
  const std::size_t contents = data.manifest.contents.size();
  body::FeatureParameters parameters;
  train::SetHemisphere(train::ComputeStatistics(data.train, parameters).mean, parameters);
  using Rotations = Eigen::Matrix<double, body::kRotationFeatures, 1>;
  std::vector<Rotations> sums(styles * contents, Rotations::Zero());
  std::vector<double> counts(styles * contents, 0);
  for (const train::TrainingClip& c : data.train) {
    const std::size_t cell = static_cast<std::size_t>(c.style) * contents + c.content;
    for (const body::Features& frame :
         judge::MakeSequence(c.poses, c.style, c.content, false, parameters).frames) {
      sums[cell] +=
          Eigen::Map<const Eigen::VectorXf>(frame.data(), body::kRotationFeatures).cast<double>();
      counts[cell] += 1;
    }
  }
  std::vector<Rotations> means(styles, Rotations::Zero());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (counts[i] > 0 && counts[i % contents] > 0) means[i / contents] += sums[i] / counts[i];
  }
  std::vector<judge::ConstantOffset> baselines(styles);
  for (std::size_t style = 0; style < styles; ++style) {
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const auto rotation = [joint](const Rotations& mean) {
        return body::Quat(Eigen::Vector4f(mean.segment<4>(4 * joint).normalized().cast<float>()));
      };
      baselines[style].offset[joint] = rotation(means[0]).conjugate() * rotation(means[style]);
    }
  }
  return baselines;
}

Result<Styler> LoadStyler(const std::string& weights, const clip::Manifest& manifest) {
  auto network = erd::Network::Load(weights);
  if (!network.ok()) return network.status();
  auto binding = judge::CanonicalBinding();
  if (!binding.ok()) return binding.status();
  Styler styler{network.value(), binding.value(), {}};
  int found = 0;
  for (const clip::ManifestStyle& style : manifest.styles) {
    const int index = styler.network->FindStyle(style.name);
    styler.style_of.push_back(index > 0 ? index : kAbsent);
    found += index > 0 ? 1 : 0;
  }
  if (found == 0) {
    return Status::Error(weights + ": has none of the manifest's styles besides neutral");
  }
  return styler;
}

template <typename Make>
std::vector<judge::Transferred> Transfer(const Data& data, const std::vector<int>& style_of,
                                         const Make& make) {
  std::vector<judge::Transferred> out;
  for (std::size_t i = 0; i < data.inputs.size(); ++i) {
    for (int style = 1; style < static_cast<int>(data.manifest.styles.size()); ++style) {
      if (style_of[style] == kAbsent) continue;
      out.push_back({static_cast<int>(i), style, data.contents[i], data.inputs[i],
                     make(data.inputs[i], style)});
    }
  }
  return out;
}

// The neutral clips of each content as one stream that goes on for `seconds` and then shows each
// clip once more, and what every style makes of it.
struct LongRun {
  judge::Chain chain;  // at the stream's rate
  int content = 0;
  std::vector<judge::Poses> styled;  // per manifest style; empty where absent
};

std::vector<LongRun> RunLong(const Arguments& arguments, const Data& data, const Styler& styler) {
  std::vector<LongRun> runs;
  for (int content = 0; content < static_cast<int>(data.manifest.contents.size()); ++content) {
    std::vector<judge::Poses> clips;
    for (const train::TrainingClip& c : data.validation) {
      if (c.style == 0 && c.content == content) clips.push_back(c.poses);
    }
    LongRun run;
    run.content = content;
    run.chain = judge::ChainClips(clips, judge::kJudgeRate_hz, arguments.long_s, kBlendFrames);
    if (run.chain.poses.empty()) continue;
    run.chain.poses =
        clip::ResamplePoses(run.chain.poses, judge::kJudgeRate_hz, judge::kStreamRate_hz);
    for (judge::Chain::Part& part : run.chain.parts) {
      part.begin *= judge::kStreamPerJudge;
      part.end = std::min(part.end * judge::kStreamPerJudge, run.chain.poses.size());
    }
    for (const int style : styler.style_of) {
      const judge::Switch start{0, judge::OneStyle(style, false)};
      run.styled.push_back(style == kAbsent ? judge::Poses()
                                            : judge::StyleStream(styler.network, styler.binding,
                                                                 arguments.stylist, {&start, 1},
                                                                 run.chain.poses));
    }
    runs.push_back(std::move(run));
  }
  return runs;
}

// The parts of the long runs that begin after `seconds`, clip by clip, seams left out.
std::vector<judge::Transferred> TakeLate(const std::vector<LongRun>& runs, double seconds) {
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
        late.push_back({clip, static_cast<int>(style), run.content, cut(run.chain.poses),
                        judge::Poses(styled.begin(), styled.end())});
      }
      ++clip;
    }
  }
  return late;
}

void PrintResponse(const judge::Response& response) {
  std::printf(
      "\nswitching (%d switches): judge sees the new style after %.2f s (median), %.2f s (p90); "
      "an instant cut %.2f and %.2f s; never %.1f %%\n"
      "  largest joint acceleration in the second after a switch, over the input's p99.9: %.2f "
      "(median), %.2f (max); away from switches, p99.9: %.2f\n",
      response.switches, response.median_s, response.p90_s, response.cut_median_s,
      response.cut_p90_s, 100 * response.never, response.acceleration_median,
      response.acceleration_max, response.steady);
}

void JudgeWeights(const Arguments& arguments, const Data& data, const Styler& styler,
                  const judge::Judges& judges, const judge::Evaluator& evaluator,
                  nlohmann::json& json) {
  const auto live = [&](bool absolute) {
    return Transfer(data, styler.style_of, [&](const judge::Poses& input, int style) {
      const judge::Switch start{0, judge::OneStyle(styler.style_of[style], absolute)};
      return judge::StyleStream(styler.network, styler.binding, arguments.stylist, {&start, 1},
                                input);
    });
  };
  const auto report = [&](const char* key, const std::string& title,
                          const std::vector<judge::Transferred>& clips) {
    const judge::Figures figures = evaluator.Measure(title, clips);
    evaluator.Print(figures);
    json[key] = evaluator.ToJson(figures);
  };
  report("styled", "styled (detail-preserving, as live)", live(false));
  if (arguments.absolute) report("absolute", "absolute (the paper's output)", live(true));

  std::vector<judge::Poses> neutral;
  for (const judge::Poses& input : data.inputs) neutral.push_back(judge::Thin(input));
  const judge::Reconstruction reconstruction =
      judge::MeasureReconstruction(*styler.network, neutral);
  std::printf("\nreconstruction of neutral clips: %.2f degrees, %.2f cm (means over joints)\n",
              reconstruction.angle_deg.value(), reconstruction.position_cm.value());
  json["reconstruction"] = {{"angle_deg", reconstruction.angle_deg.value()},
                            {"position_cm", reconstruction.position_cm.value()}};
  if (arguments.long_s <= 0) return;

  const std::vector<LongRun> runs = RunLong(arguments, data, styler);
  char title[96];
  std::snprintf(title, sizeof title, "styled, after %.0f s of continuous state", arguments.long_s);
  report("long", title, TakeLate(runs, arguments.long_s));

  std::vector<int> styles;
  std::vector<int> network_styles;
  for (std::size_t style = 1; style < styler.style_of.size(); ++style) {
    if (styler.style_of[style] == kAbsent) continue;
    styles.push_back(static_cast<int>(style));
    network_styles.push_back(styler.style_of[style]);
  }
  if (styles.size() < 2) return;
  std::vector<judge::ResponseInput> inputs;
  for (const LongRun& run : runs) {
    const std::size_t frames = std::min<std::size_t>(
        run.chain.poses.size(), static_cast<std::size_t>(60 * judge::kStreamRate_hz));
    judge::ResponseInput input{run.content, std::span(run.chain.poses).first(frames), {}};
    for (const int style : styles)
      input.steady.push_back(std::span(run.styled[style]).first(frames));
    inputs.push_back(std::move(input));
  }
  const judge::Response response =
      judge::MeasureResponse(judges, styles, network_styles, styler.network, styler.binding,
                             arguments.stylist, arguments.transition_s, 4.0, inputs);
  PrintResponse(response);
  json["response"] = {{"switches", response.switches},
                      {"median_s", response.median_s},
                      {"p90_s", response.p90_s},
                      {"instant_cut_median_s", response.cut_median_s},
                      {"instant_cut_p90_s", response.cut_p90_s},
                      {"never", response.never},
                      {"acceleration_median", response.acceleration_median},
                      {"acceleration_max", response.acceleration_max},
                      {"acceleration_steady", response.steady}};
}

// What the synthetic performer is asked for as one content, and for how long at a time.
struct Performance {
  const char* content;
  std::vector<styled::performer::ScriptItem> script;
};

std::vector<Performance> Performances() {
  using enum styled::performer::Motion;
  constexpr double kPause_s = 1.5;  // gestures fall back to rest in it
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

// Does the content judge, trained on real clips, recognize the synthetic performer? Counted are
// windows throughout which it does only what belongs to the content (a pause belongs to none).
void JudgeSynthetic(const Data& data, const judge::Judges& judges,
                    const judge::Evaluator& evaluator, nlohmann::json& json) {
  namespace performer = styled::performer;
  constexpr int kPerformers = 6;
  constexpr int kSeconds = 60;
  const std::vector<std::string>& contents = data.manifest.contents;
  std::printf("\nsynthetic performer, windows that the content judge recognizes\n");
  std::vector<judge::ClipVerdict> verdicts;
  for (const Performance& performance : Performances()) {
    const auto found = std::find(contents.begin(), contents.end(), performance.content);
    if (found == contents.end()) continue;
    const int content = static_cast<int>(found - contents.begin());
    const performer::Motion pause = performance.script.back().motion;
    const bool pauses = performance.script.size() > 1;
    std::vector<int> answers(contents.size(), 0);
    for (int k = 0; k < kPerformers; ++k) {
      performer::Performer human(
          performer::Vary(1, static_cast<std::uint64_t>(k), performance.script));
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

Status Run(const Arguments& arguments) {
  Result<Data> loaded = Load(arguments);
  if (!loaded.ok()) return loaded.status();
  const Data& data = loaded.value();
  std::printf(
      "%zu clips train the generator, %zu the judges; %zu are judged, %zu of them neutral\n",
      data.train.size(), data.judge.size(), data.validation.size(), data.inputs.size());

  auto trained =
      judge::Judges::TrainOrLoad(data.judge, static_cast<int>(data.manifest.styles.size()),
                                 static_cast<int>(data.manifest.contents.size()), arguments.judges,
                                 arguments.cache, JudgeKey(data, arguments.judges));
  if (!trained.ok()) return trained.status();
  const judge::Judges& judges = trained.value();
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

  const std::vector<judge::ConstantOffset> baselines = Baselines(data);
  const std::vector<int> all(data.manifest.styles.size(), 0);
  const judge::Figures baseline =
      evaluator.Measure("baseline (a constant rotation per joint)",
                        Transfer(data, all, [&](const judge::Poses& input, int target) {
                          judge::Poses output;
                          for (const body::Pose& pose : input)
                            output.push_back(baselines[target].Apply(pose));
                          return output;
                        }));
  evaluator.Print(baseline);
  json["baseline"] = evaluator.ToJson(baseline);

  if (!arguments.weights.empty()) {
    Result<Styler> styler = LoadStyler(arguments.weights, data.manifest);
    if (!styler.ok()) return styler.status();
    JudgeWeights(arguments, data, styler.value(), judges, evaluator, json);
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
  Arguments arguments;
  CLI::App app("Judges Style-ERD weights on recorded clips, as they run live.");
  app.add_option("--weights", arguments.weights,
                 "Weights to judge; without them only judges and baseline are reported");
  app.add_option("--manifest", arguments.manifest, "Data set (TOML)")->required();
  app.add_option("--data", arguments.data, "Folder that the manifest's paths start from")
      ->required();
  app.add_option("--cache", arguments.cache, "Folder where trained judges are kept")->required();
  app.add_option("--json", arguments.json, "Write every figure to this file, too");
  app.add_option("--long", arguments.long_s,
                 "Judge also after so many seconds of continuous state; 0: do not")
      ->capture_default_str();
  app.add_flag("--absolute", arguments.absolute, "Judge the paper's absolute output, too");
  app.add_option("--change-tau", arguments.stylist.change_tau_s,
                 "Low-pass on the change of style, seconds")
      ->capture_default_str();
  app.add_flag("--synthetic", arguments.synthetic,
               "Does the content judge recognize the synthetic performer?");
  app.add_flag("!--no-ground", arguments.stylist.ground,
               "Do not shift the styled body vertically: what of jitter and skate is grounding");
  app.add_option("--transition", arguments.transition_s, "Cross-fade of a switch, seconds")
      ->capture_default_str();
  app.add_option("--judge-iterations", arguments.judges.iterations, "Training steps of the judges")
      ->capture_default_str();
  app.add_option("--judge-window", arguments.judges.window, "Frames at 30 Hz; a multiple of 4")
      ->capture_default_str();
  app.add_option("--seed", arguments.judges.seed, "Seed of the judges")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const Status status = Run(arguments);
  if (status.ok()) return 0;
  std::cerr << "styleeval: " << status.message() << "\n";
  return 1;
}

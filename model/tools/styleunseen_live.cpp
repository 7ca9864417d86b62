// styleunseen on weights that run live: styles of examples, or of a library's files.
#include "model/tools/styleunseen_live.h"

#include <cstdio>
#include <filesystem>
#include <optional>

#include "model/clip/clip.h"
#include "model/rig/dialects.h"
#include "model/train/judge/provenance.h"
#include "model/train/judge/text.h"
#include "model/train/judge/unseen_live.h"
#include "model/train/stgcn_causal/style_file.h"

namespace styled {
namespace {

using judge::Poses;

constexpr int kJudgeIterations = 400;  // one clip or two of each style are learned soon

struct UnseenJudges {
  judge::Judges judges;
  // Whether they learned the examples themselves: of a data set without the split "judge".
  bool know_examples = false;
};

Result<Poses> ReadSource(const UnseenLive& of) {
  if (of.source.empty()) return of.walks[0];
  const Result<clip::Clip> clip = clip::ReadBvh(of.source);
  if (!clip.ok()) return clip.status();
  const Result<rig::Binding> binding = rig::BindDialect(clip.value().skeleton);
  if (!binding.ok()) return Status::Error(of.source + ": " + binding.status().message());
  return clip::ResamplePoses(clip::ToCanonical(clip.value(), binding.value()), clip.value().rate_hz,
                             judge::kJudgeRate_hz);
}

// The style of the library's file where there is one, else that of the walk as an example.
Result<net::StyleCode> StyleOf(const UnseenLive& of, std::size_t style) {
  const std::filesystem::path file =
      std::filesystem::path(of.library) / (of.manifest.styles[style].name + ".json");
  if (!of.library.empty() && std::filesystem::exists(file)) {
    auto read = train::st_gcn_causal::ReadStyleFile(file);
    if (!read.ok()) return read.status();
    return read.value().code;
  }
  net::StyleRequest request;
  request.sources = {{.style = -1, .seed = {}, .reference = of.walks[style], .weight = 1}};
  const net::StyleCode code = of.network.space.MakeCode(request);
  if (!of.neutral) return code;
  request.sources[0].reference = of.walks[0];
  return of.network.space.Difference(code, of.network.space.MakeCode(request));
}

// Of the split "judge", or of all clips where there is none.
Result<std::optional<UnseenJudges>> LoadJudges(const UnseenLive& of) {
  if (of.judges.empty()) return std::optional<UnseenJudges>();
  erd::FeatureParameters parameters;
  parameters.rate_hz = static_cast<float>(judge::kJudgeRate_hz);
  judge::JudgeSettings settings;
  settings.iterations = kJudgeIterations;
  settings.count = of.judge_seeds;
  std::vector<train::TrainingClip> clips;
  const auto load = [&](const char* split) {
    auto some = train::LoadClips(of.manifest, split, parameters, settings.window + 1);
    if (some.ok()) clips.insert(clips.end(), some.value().begin(), some.value().end());
  };
  load("judge");
  const bool know_examples = clips.empty();
  if (know_examples) {
    load("train");
    load("validation");
  }
  if (clips.empty()) return Status::Error(of.manifest.name + ": no clips for judges");
  auto judges = judge::Judges::TrainOrLoad(
      clips, static_cast<int>(of.manifest.styles.size()),
      static_cast<int>(of.manifest.contents.size()), settings, of.judges,
      "unseen-" + of.manifest.name + "-" + std::to_string(settings.iterations));
  if (!judges.ok()) return judges.status();
  return std::optional(UnseenJudges{std::move(judges.value()), know_examples});
}

struct Means {
  judge::Mean cosine, expression, movement, recognized;
  std::string Text(bool judged) const {
    return judge::Padded(judge::Measured(cosine), 8, 2) +
           judge::Padded(judge::Measured(expression), 11, 2) +
           judge::Padded(judge::Measured(movement), 9, 2) +
           (judged ? judge::Padded(recognized, 7, 2) : "");
  }
  void Add(const judge::Expression& mean, double movement_left, const judge::Mean& share) {
    cosine.Add(mean.cosine);
    expression.Add(mean.fraction);
    movement.Add(movement_left);
    recognized.Add(share.once());
  }
};

nlohmann::json ToJson(const judge::LiveUnseenFigures& of) {
  nlohmann::json json = {{"cosine", of.network.cosine},
                         {"expression", of.network.fraction},
                         {"movement", of.movement},
                         {"jerk", of.jerk},
                         {"offset_cosine", of.offset.cosine},
                         {"offset_expression", of.offset.fraction},
                         {"offset_movement", of.offset_movement}};
  for (const auto& [key, share] : {std::pair{"recognized", &of.recognized},
                                   {"offset_recognized", &of.offset_recognized},
                                   {"real_recognized", &of.real_recognized}}) {
    json[key] = judge::Value(judge::Measured(*share));
    json[std::string(key) + "_spread"] = judge::Value(share->spread());
  }
  return json;
}

// Why the columns of judges are not there, or what the real clips in them are.
void PrintJudging(const std::optional<UnseenJudges>& judges, const UnseenLive& of) {
  if (!judges) {
    std::printf("style recognition: not judged, since --judges was not given\n");
    return;
  }
  std::printf("judges: %d, of the data set %s; real clips are the examples%s\n",
              judges->judges.settings().count, of.manifest.name.c_str(),
              judges->know_examples ? ", which the judges learned from" : "");
}

}  // namespace

Status MeasureLive(const UnseenLive& of) {
  const Result<Poses> source = ReadSource(of);
  if (!source.ok()) return source.status();
  const auto judges = LoadJudges(of);
  if (!judges.ok()) return judges.status();
  const judge::Judges* const judge = judges.value() ? &judges.value()->judges : nullptr;
  const bool judged = judge != nullptr;
  PrintJudging(judges.value(), of);
  const int share = !judged ? 0 : of.judge_seeds > 1 ? 13 : 7;  // characters of a share
  const char* const sra = judged ? "SRA" : "";
  std::printf("%-16s %7s%11s%9s%*s %7s %8s%11s%9s%*s%*s\n", "", "cosine", "expression", "movement",
              share, sra, "jerk", "offset's", "expression", "movement", share, sra,
              share + (judged ? 5 : 0), judged ? "real SRA" : "");
  nlohmann::json json;
  Means network, offset;
  judge::Mean real;
  std::string left_out;
  for (const std::size_t style : of.styles) {
    const std::string& name = of.manifest.styles[style].name;
    if (of.walks[style].empty()) {
      left_out += " " + name;
      continue;
    }
    const Result<net::StyleCode> code = StyleOf(of, style);
    if (!code.ok()) return code.status();
    const judge::LiveUnseenFigures one =
        judge::MeasureLiveUnseen(of.network, code.value(), source.value(), of.walks[0],
                                 of.walks[style], judge, static_cast<int>(style));
    Means own, its_offset;
    own.Add(one.network, one.movement, one.recognized);
    its_offset.Add(one.offset, one.offset_movement, one.offset_recognized);
    network.Add(one.network, one.movement, one.recognized);
    offset.Add(one.offset, one.offset_movement, one.offset_recognized);
    real.Add(one.real_recognized.once());
    std::printf("%-16s%s%s %s%s\n", name.c_str(), own.Text(judged).c_str(),
                judge::Padded(one.jerk, 8, 2).c_str(), its_offset.Text(judged).c_str(),
                judged ? judge::Padded(one.real_recognized, 12, 2).c_str() : "");
    json[name] = ToJson(one);
  }
  if (json.empty()) {
    return Status::Error(of.manifest.name + ": no style to measure has a walk, expected one of" +
                         left_out);
  }
  std::printf("%-16s%s%s %s%s\n", "mean", network.Text(judged).c_str(), "        ",
              offset.Text(judged).c_str(), judged ? judge::Padded(real, 12, 2).c_str() : "");
  std::printf("%-16s%8.2f%11.2f%9.2f  by definition: the figures are relative to the example\n",
              "the real clip", 1.0, 1.0, 0.0);
  if (!left_out.empty()) std::printf("not measured, no walk:%s\n", left_out.c_str());
  if (judged && network.recognized.count < network.cosine.count) {
    std::printf("- in SRA: the clip is shorter than the judges' window of %d frames\n",
                judge->settings().window);
  }
  return of.json.empty() ? Status::Ok() : judge::WriteJson(json, of.json);
}

}  // namespace styled

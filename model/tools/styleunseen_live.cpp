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
Result<std::optional<judge::Judges>> LoadJudges(const UnseenLive& of) {
  if (of.judges.empty()) return std::optional<judge::Judges>();
  erd::FeatureParameters parameters;
  parameters.rate_hz = static_cast<float>(judge::kJudgeRate_hz);
  judge::JudgeSettings settings;
  settings.iterations = kJudgeIterations;
  std::vector<train::TrainingClip> clips;
  const auto load = [&](const char* split) {
    auto some = train::LoadClips(of.manifest, split, parameters, settings.window + 1);
    if (some.ok()) clips.insert(clips.end(), some.value().begin(), some.value().end());
  };
  load("judge");
  if (clips.empty()) {
    load("train");
    load("validation");
  }
  if (clips.empty()) return Status::Error(of.manifest.name + ": no clips for judges");
  auto judges = judge::Judges::TrainOrLoad(
      clips, static_cast<int>(of.manifest.styles.size()),
      static_cast<int>(of.manifest.contents.size()), settings, of.judges,
      "unseen-" + of.manifest.name + "-" + std::to_string(settings.iterations));
  if (!judges.ok()) return judges.status();
  return std::optional<judge::Judges>(std::move(judges.value()));
}

struct Means {
  judge::Mean cosine, expression, movement, recognized;
  std::string Text() const {
    return judge::Padded(cosine.value(), 8, 2) + judge::Padded(expression.value(), 11, 2) +
           judge::Padded(movement.value(), 9, 2) + judge::Padded(recognized.value(), 7, 2);
  }
  void Add(const judge::Expression& mean, double movement_left, double share) {
    cosine.Add(mean.cosine);
    expression.Add(mean.fraction);
    movement.Add(movement_left);
    recognized.Add(share);
  }
};

}  // namespace

Status MeasureLive(const UnseenLive& of) {
  const Result<Poses> source = ReadSource(of);
  if (!source.ok()) return source.status();
  const auto judges = LoadJudges(of);
  if (!judges.ok()) return judges.status();
  const judge::Judges* const judge = judges.value() ? &*judges.value() : nullptr;
  std::printf("%-16s %7s%11s%9s%7s %7s %8s%11s%9s%7s\n", "", "cosine", "expression", "movement",
              "SRA", "jerk", "offset's", "expression", "movement", "SRA");
  nlohmann::json json;
  Means network, offset;
  for (const std::size_t style : of.styles) {
    if (of.walks[style].empty()) continue;
    const std::string& name = of.manifest.styles[style].name;
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
    std::printf("%-16s%s%s %s\n", name.c_str(), own.Text().c_str(),
                judge::Padded(one.jerk, 8, 2).c_str(), its_offset.Text().c_str());
    json[name] = {{"cosine", one.network.cosine},
                  {"expression", one.network.fraction},
                  {"movement", one.movement},
                  {"recognized", one.recognized},
                  {"jerk", one.jerk},
                  {"offset_cosine", one.offset.cosine},
                  {"offset_expression", one.offset.fraction},
                  {"offset_movement", one.offset_movement},
                  {"offset_recognized", one.offset_recognized}};
  }
  std::printf("%-16s%s%s %s\n", "mean", network.Text().c_str(), "        ", offset.Text().c_str());
  return of.json.empty() ? Status::Ok() : judge::WriteJson(json, of.json);
}

}  // namespace styled

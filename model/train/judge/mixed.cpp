#include "model/train/judge/mixed.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "model/clip/clip.h"
#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

constexpr int kBlend = 15;                // frames: half a second
constexpr std::size_t kLongestAct = 128;  // frames: each act comes twice in 30 s

// The contents in the order of the acts.
std::vector<int> ActsOf(const clip::Manifest& manifest) {
  std::vector<int> acts;
  for (const char* name : {"walk", "turn", "wave", "run"}) {
    const auto found = std::find(manifest.contents.begin(), manifest.contents.end(), name);
    if (found != manifest.contents.end()) {
      acts.push_back(static_cast<int>(found - manifest.contents.begin()));
    }
  }
  if (acts.size() >= 2) return acts;
  acts.resize(manifest.contents.size());
  std::iota(acts.begin(), acts.end(), 0);
  return acts;
}

void AddVerdicts(const Judges& judges, std::span<const body::Pose> poses, int style, int content,
                 Mean* of_style, Mean& of_content) {
  const std::vector<Verdicts> by_judge =
      judges.Judge(MakeSequence(poses, style, content, false, judges.parameters()), kStride);
  const auto windows = static_cast<double>(by_judge.front().starts.size());
  if (of_style != nullptr) of_style->AddJudged(Hits(by_judge, &Verdicts::style, style), windows);
  of_content.AddJudged(Hits(by_judge, &Verdicts::content, content), windows);
}

}  // namespace

MixedClip MakeMixed(const Data& data, std::size_t frames) {
  std::vector<std::vector<const train::TrainingClip*>> by_act;
  for (const int act : ActsOf(data.manifest)) {
    auto& clips = by_act.emplace_back();
    for (const train::TrainingClip& clip : data.validation) {
      if (clip.style == 0 && clip.content == act && clip.poses.size() >= 3 * kBlend) {
        clips.push_back(&clip);
      }
    }
    if (clips.empty()) by_act.pop_back();
  }
  MixedClip mixed;
  if (by_act.empty()) return mixed;
  std::vector<Poses> clips;
  std::vector<int> contents;
  std::size_t length = kBlend;
  for (std::size_t round = 0; length < frames; ++round) {
    for (const auto& of_act : by_act) {
      const train::TrainingClip& clip = *of_act[round % of_act.size()];
      const auto used = std::min(clip.poses.size(), kLongestAct);
      clips.emplace_back(clip.poses.begin(),
                         clip.poses.begin() + static_cast<std::ptrdiff_t>(used));
      contents.push_back(clip.content);
      length += used - kBlend;
    }
  }
  Chain chain = ChainClips(clips, kJudgeRate_hz, 0, kBlend);
  mixed.poses = std::move(chain.poses);
  mixed.poses.resize(std::min(mixed.poses.size(), frames));
  for (const Chain::Part& part : chain.parts) {
    const std::size_t end = std::min(part.end, mixed.poses.size());
    if (part.begin >= end) continue;
    mixed.segments.push_back({contents[static_cast<std::size_t>(part.clip)], part.begin, end});
  }
  return mixed;
}

Poses RestyleRecorded(const ClipRestyler& restyler, const Poses& clip, const net::StyleCode& code) {
  if (restyler.rate_hz() == kJudgeRate_hz) return restyler.RestyleBy(clip, code);
  Poses out =
      Thin(restyler.RestyleBy(clip::ResamplePoses(clip, kJudgeRate_hz, kStreamRate_hz), code));
  out.resize(clip.size(), out.empty() ? body::Pose() : out.back());
  return out;
}

MixedFigures MeasureMixed(const Data& data, const Judges& judges, const ClipRestyler& restyler) {
  MixedFigures figures;
  figures.acts.resize(data.manifest.contents.size());
  const MixedClip mixed = MakeMixed(data);
  figures.seconds = static_cast<double>(mixed.poses.size()) / kJudgeRate_hz;
  if (mixed.poses.empty()) return figures;
  const auto cut = [](const Poses& poses, const MixedClip::Segment& segment) {
    return std::span(poses).subspan(segment.begin, segment.end - segment.begin);
  };
  for (const MixedClip::Segment& segment : mixed.segments) {
    AddVerdicts(judges, cut(mixed.poses, segment), 0, segment.content, nullptr,
                figures.acts[static_cast<std::size_t>(segment.content)].content_of_input);
  }
  const std::vector<ConstantOffset> offsets = StyleOffsets(data);
  for (int style = 1; style < static_cast<int>(data.manifest.styles.size()); ++style) {
    if (!restyler.Has(style)) continue;
    const ConstantOffset& offset = offsets[static_cast<std::size_t>(style)];
    const net::StyleCode code = restyler.CodeOf({.style = style});
    const Poses whole = RestyleRecorded(restyler, mixed.poses, code);
    for (const MixedClip::Segment& segment : mixed.segments) {
      MixedFigures::Act& act = figures.acts[static_cast<std::size_t>(segment.content)];
      const auto input = cut(mixed.poses, segment);
      const Poses alone = RestyleRecorded(restyler, Poses(input.begin(), input.end()), code);
      AddVerdicts(judges, cut(whole, segment), style, segment.content, &act.mixed.style,
                  act.mixed.content);
      AddVerdicts(judges, alone, style, segment.content, &act.alone.style, act.alone.content);
      Poses by_offset;
      for (const body::Pose& pose : input) by_offset.push_back(offset.Apply(pose));
      AddVerdicts(judges, by_offset, style, segment.content, &act.offset.style, act.offset.content);
    }
  }
  return figures;
}

void Print(const clip::Manifest& manifest, const MixedFigures& figures) {
  std::printf(
      "\nmixed acts (%.0f s in one clip, the mean code of each style), share of windows: style "
      "mixed, alone, constant offset; content mixed, alone, constant offset, input; windows\n",
      figures.seconds);
  for (std::size_t i = 0; i < figures.acts.size(); ++i) {
    const MixedFigures::Act& act = figures.acts[i];
    if (act.mixed.style.count <= 0) continue;
    std::printf("%-10s", manifest.contents[i].c_str());
    for (const Mean* share :
         {&act.mixed.style, &act.alone.style, &act.offset.style, &act.mixed.content,
          &act.alone.content, &act.offset.content, &act.content_of_input}) {
      std::printf("  %s", Padded(*share, 5, 2).c_str());
    }
    std::printf(" %8.0f\n", act.mixed.style.count);
  }
}

nlohmann::json ToJson(const clip::Manifest& manifest, const MixedFigures& figures) {
  nlohmann::json json = {{"seconds", figures.seconds}, {"acts", nlohmann::json::object()}};
  for (std::size_t i = 0; i < figures.acts.size(); ++i) {
    const MixedFigures::Act& act = figures.acts[i];
    if (act.mixed.style.count <= 0) continue;
    nlohmann::json& row = json["acts"][manifest.contents[i]];
    for (const auto& [key, share] : {std::pair{"sra_mixed", &act.mixed.style},
                                     {"sra_alone", &act.alone.style},
                                     {"sra_offset", &act.offset.style},
                                     {"cra_mixed", &act.mixed.content},
                                     {"cra_alone", &act.alone.content},
                                     {"cra_offset", &act.offset.content},
                                     {"cra_input", &act.content_of_input}}) {
      row[key] = Value(Measured(*share));
      row[std::string(key) + "_spread"] = Value(share->spread());
    }
    row["windows"] = act.mixed.style.count;
  }
  return json;
}

}  // namespace styled::judge

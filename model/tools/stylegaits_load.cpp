// The weights, clips and judges of stylegaits.
#include "model/tools/stylegaits_load.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>

#include "model/base/hash.h"
#include "model/clip/bind_clip.h"
#include "model/train/judge/unseen_live.h"

namespace styled {
namespace {

using judge::GaitSource;

// Of a source: its beginning, which does not count, and a window of the judges.
constexpr std::size_t kLeastSource = judge::kSettling + 33;

erd::FeatureParameters AtJudgeRate() {
  erd::FeatureParameters parameters;
  parameters.rate_hz = static_cast<float>(judge::kJudgeRate_hz);
  return parameters;
}

// Appends a split's clips; without an error if the manifest has no such split.
Status AddSplit(const clip::Manifest& manifest, const std::string& split, int least,
                std::vector<train::TrainingClip>& clips) {
  const auto of_split = [&](const clip::ManifestEntry& entry) { return entry.split == split; };
  if (std::none_of(manifest.entries.begin(), manifest.entries.end(), of_split)) return {};
  auto some = train::LoadClips(manifest, split, AtJudgeRate(), least);
  if (!some.ok()) return some.status();
  std::move(some.value().begin(), some.value().end(), std::back_inserter(clips));
  return {};
}

// A key of everything that the judges depend on but the seed.
std::string KeyOf(const std::vector<train::TrainingClip>& clips,
                  const judge::JudgeSettings& settings) {
  Fnv1a hash;
  hash.Text(judge::kJudgeRecipe);
  hash.Text(judge::kPartRecipe);
  const auto numbers = {settings.window, settings.iterations, settings.batch};
  for (const int number : numbers) hash.Number(number);
  for (const train::TrainingClip& clip : clips) {
    hash.Text(std::filesystem::path(clip.file).filename().string());
    hash.Number(clip.style);
    hash.Number(clip.content);
    for (const body::Pose& pose : clip.poses) {
      for (const float x : pose.hips_position_m) hash.Bytes(&x, sizeof x);
      for (const body::Quat& q : pose.rotations) hash.Bytes(q.coeffs().data(), 4 * sizeof(float));
    }
  }
  char text[32];
  std::snprintf(text, sizeof text, "gaits-%016llx", static_cast<unsigned long long>(hash.value()));
  return text;
}

// The share of windows with this answer, of each judge's answers.
judge::Mean ShareOf(const std::vector<std::vector<int>>& by_judge, int style) {
  std::vector<double> hits;
  for (const std::vector<int>& answers : by_judge) {
    hits.push_back(static_cast<double>(std::count(answers.begin(), answers.end(), style)));
  }
  judge::Mean share;
  share.AddJudged(hits, static_cast<double>(by_judge.front().size()));
  return share;
}

}  // namespace

Result<WholeClips> LoadWhole(const std::string& manifest, const std::string& data) {
  auto loaded = clip::LoadManifest(manifest, data);
  if (!loaded.ok()) return loaded.status();
  WholeClips whole{std::move(loaded.value()), {}};
  for (const char* split : {"train", "judge", "validation"}) {
    Status status = AddSplit(whole.manifest, split, 2, whole.clips);
    if (!status.ok()) return status;
  }
  return whole;
}

Result<std::vector<GaitSource>> LoadSources(const std::string& manifest, const std::string& data) {
  const auto loaded = clip::LoadManifest(manifest, data);
  if (!loaded.ok()) return loaded.status();
  std::vector<train::TrainingClip> clips;
  for (const char* split : {"validation", "judge"}) {
    Status status = AddSplit(loaded.value(), split, static_cast<int>(kLeastSource), clips);
    if (!status.ok()) return status;
  }
  std::vector<GaitSource> sources;
  for (train::TrainingClip& clip : clips) {
    const std::string& content = loaded.value().contents[static_cast<std::size_t>(clip.content)];
    if (clip.style != 0 || (content != "walk" && content != "run")) continue;
    sources.push_back({.name = std::filesystem::path(clip.file).stem().string(),
                       .person = loaded.value().name + clip.person,
                       .gait = content == "run" ? judge::GaitKind::kRun : judge::GaitKind::kWalk,
                       .poses = std::move(clip.poses)});
  }
  if (!sources.empty()) return sources;
  return Status::Error("--sources " + manifest +
                       ": no neutral walk or run in the splits validation and judge");
}

Status AddPerformers(const std::string& manifest, const std::string& data, WholeClips& judges) {
  const auto loaded = clip::LoadManifest(manifest, data);
  if (!loaded.ok()) return loaded.status();
  std::vector<train::TrainingClip> clips;
  Status status = AddSplit(loaded.value(), "train", 2, clips);
  if (!status.ok()) return status;
  std::vector<clip::ManifestStyle>& styles = judges.manifest.styles;
  const std::vector<std::string>& contents = judges.manifest.contents;
  for (train::TrainingClip& clip : clips) {
    const std::string& content = loaded.value().contents[static_cast<std::size_t>(clip.content)];
    const auto found = std::find(contents.begin(), contents.end(), content);
    if (found == contents.end() || (content != "walk" && content != "run")) continue;
    clip.content = static_cast<int>(found - contents.begin());
    clip::ManifestStyle style = loaded.value().styles[static_cast<std::size_t>(clip.style)];
    if (clip.style == 0) style.name = loaded.value().name + " " + style.name;
    const auto known = std::find_if(styles.begin(), styles.end(),
                                    [&](const auto& other) { return other.name == style.name; });
    clip.style = static_cast<int>(known - styles.begin());
    if (known == styles.end()) styles.push_back(style);
    judges.clips.push_back(std::move(clip));
  }
  return Status::Ok();
}

Result<std::vector<GaitSource>> LoadStrangers(const std::vector<std::filesystem::path>& files) {
  std::vector<GaitSource> sources;
  std::map<std::string, std::optional<rig::Binding>> bindings;  // by person
  for (const std::filesystem::path& file : files) {
    const Result<clip::Clip> clip = clip::ReadBvh(file);
    if (!clip.ok()) return clip.status();
    GaitSource source;
    source.name = file.stem().string();
    source.person = file.parent_path().string();
    std::optional<rig::Binding>& binding = bindings[source.person];
    if (!binding || binding->skeleton().names != clip.value().skeleton.names) {
      const auto bound = clip::BindClip(clip.value());
      if (!bound.ok()) return Status::Error(file.string() + ": " + bound.status().message());
      binding.emplace(bound.value().binding);
    }
    source.poses = clip::ResamplePoses(clip::ToCanonical(clip.value(), *binding),
                                       clip.value().rate_hz, judge::kJudgeRate_hz);
    if (source.poses.size() < kLeastSource) {
      return Status::Error(file.string() + ": found " + std::to_string(source.poses.size()) +
                           " frames at 30 Hz; expected at least " + std::to_string(kLeastSource));
    }
    source.gait = judge::GaitOf(source.poses);
    sources.push_back(std::move(source));
  }
  return sources;
}

std::vector<judge::Recognition> GaitJudges::Recognize(const judge::Poses& poses, int stride) const {
  const judge::Judges& judges = panel.judges;
  const std::vector<judge::Verdicts> verdicts =
      judges.Judge(judge::MakeSequence(poses, 0, 0, false, judges.parameters()), stride);
  std::vector<std::vector<int>> by_style;
  for (const judge::Verdicts& of : verdicts) by_style.push_back(of.style);
  std::vector<std::vector<int>> by_movement;
  for (auto& answers : panel.parts.Judge(poses, stride)) by_movement.push_back(answers[0]);
  std::vector<judge::Recognition> of(style_count);
  for (std::size_t style = 0; style < of.size(); ++style) {
    of[style] = {.style = ShareOf(by_style, static_cast<int>(style)),
                 .movement = ShareOf(by_movement, static_cast<int>(style))};
  }
  return of;
}

Result<GaitJudges> TrainGaitJudges(const std::vector<train::TrainingClip>& clips,
                                   const clip::Manifest& manifest,
                                   const judge::JudgeSettings& settings, const std::string& cache) {
  auto panel = judge::TrainPanel(clips, manifest, settings, cache, KeyOf(clips, settings));
  if (!panel.ok()) return panel.status();
  return GaitJudges{std::move(panel.value()), manifest.styles.size()};
}

}  // namespace styled

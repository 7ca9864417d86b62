#include "model/train/check.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "model/base/text.h"
#include "model/train/dataset.h"

namespace styled::train {
namespace {

namespace fs = std::filesystem;

bool Readable(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error) && ::access(file.c_str(), R_OK) == 0;
}

// The reason why no files can be created in a folder, which may not exist yet; "" if they can.
std::string WhyNotWritable(const fs::path& folder) {
  std::error_code error;
  fs::path there = fs::absolute(folder, error).lexically_normal();
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  if (!fs::is_directory(there, error)) return there.string() + " is not a folder";
  // For root everything is writable, but files cannot be created everywhere (/proc), so this tries
  // it.
  std::string probe = (there / ".styletrain-XXXXXX").string();
  if (::mkdtemp(probe.data()) == nullptr) return there.string() + " cannot be written";
  fs::remove(probe, error);
  return "";
}

class Check {
 public:
  Check(const RunConfig& run, const Needs& needs) : run_(run), needs_(needs) {}

  Plan Run() {
    Flags();
    Folders();
    Status data = CheckDataFolder(run_.data);
    Wrong(data);
    if (!Readable(run_.manifest)) {
      Wrong(Status::Error("--manifest " + run_.manifest.string() +
                          ": found no readable file, expected a manifest"));
    } else if (data.ok()) {
      const Result<clip::Manifest> manifest = clip::LoadManifest(run_.manifest, run_.data);
      Wrong(manifest.status());
      if (manifest.ok()) Clips(manifest.value());
    }
    return std::move(plan_);
  }

 private:
  void Wrong(const Status& status) {
    std::istringstream lines(status.message());
    for (std::string line; std::getline(lines, line);) plan_.wrong.push_back(line);
  }
  void Wrong(const std::string& sentence) { plan_.wrong.push_back(sentence); }

  void Flags();
  void Folders();
  void Clips(const clip::Manifest& manifest);
  void ReadClips(const clip::Manifest& manifest);
  void Count(const TrainingClip& clip, const std::string& split, StylePlan& style);
  // Lists the clips that a style lacks.
  void Missing(const clip::Manifest& manifest, std::size_t style);
  void MissingPart(const std::string& style, const char* split, const StylePlan::Part& part,
                   int frames, double rate_hz, const char* why);

  const RunConfig& run_;
  const Needs& needs_;
  Plan plan_;
  std::vector<std::vector<int>> cells_;  // training clips that count, by style and content
};

void Check::Flags() {
  for (const auto& [flag, value] : {std::pair{"--minutes", run_.minutes},
                                    {"--checkpoint-minutes", run_.checkpoint_minutes},
                                    {"--validate-minutes", run_.validate_minutes}}) {
    if (value >= 0 && std::isfinite(value)) continue;
    Wrong(std::string(flag) + ": found " + NumberText(value) + ", expected a number, 0 or more");
  }
  if (run_.minutes <= 0 && run_.iterations <= 0) {
    Wrong("--minutes: found neither it nor --iterations, expected the length of the run");
  }
  for (const auto& [flag, file] : needs_.files) {
    if (Readable(file)) continue;
    Wrong(flag + " " + file.string() + ": found no readable file, expected weights");
  }
}

void Check::Folders() {
  const std::string out = WhyNotWritable(run_.out);
  if (!out.empty()) Wrong("--out " + run_.out.string() + ": " + out);
  const fs::path checkpoint = run_.out / "checkpoint.pt";
  std::error_code error;
  const bool begun = fs::exists(checkpoint, error);
  if (run_.resume && !begun) {
    Wrong("--resume: found no " + checkpoint.string() + ", expected the run to continue");
  } else if (run_.resume && !Readable(checkpoint)) {
    Wrong("--resume: " + checkpoint.string() + " cannot be read");
  } else if (!run_.resume && begun) {
    Wrong("--out " + run_.out.string() +
          ": a run is there; continue it with --resume, or name another folder");
  }
  if (needs_.judges.empty()) return;
  const std::string judges = WhyNotWritable(needs_.judges);
  if (!judges.empty()) Wrong("--validate " + needs_.judges.string() + ": " + judges);
}

void Check::Clips(const clip::Manifest& manifest) {
  const std::size_t before = plan_.wrong.size();
  for (const clip::ManifestStyle& style : manifest.styles) {
    plan_.styles.emplace_back().style = style.name;
  }
  cells_.assign(manifest.styles.size(), std::vector<int>(manifest.contents.size()));
  ReadClips(manifest);
  // The missing clips may be in the files that cannot be read.
  if (plan_.wrong.size() > before) return;
  for (std::size_t style = 0; style < manifest.styles.size(); ++style) Missing(manifest, style);
}

void Check::ReadClips(const clip::Manifest& manifest) {
  erd::FeatureParameters parameters;
  parameters.rate_hz = static_cast<float>(needs_.rate_hz);
  clip::Manifest one = manifest;
  std::string failed;  // one file serves several splits
  for (const clip::ManifestEntry& entry : manifest.entries) {
    if (entry.file == failed) continue;
    one.entries.assign(1, entry);
    one.entries[0].person.clear();
    const Result<std::vector<TrainingClip>> read = LoadClips(one, entry.split, parameters, 1);
    if (!read.ok()) {
      failed = entry.file.string();
      const std::string& why = read.status().message();
      Wrong(why.starts_with(failed) ? why : failed + ": " + why);
      continue;
    }
    if (entry.split == "test") continue;  // no run uses it
    const TrainingClip& clip = read.value().front();
    Count(clip, entry.split, plan_.styles[static_cast<std::size_t>(clip.style)]);
  }
  if (!failed.empty()) return;
  // Persons are known by several clips together.
  std::erase_if(one.entries = manifest.entries, [&](const clip::ManifestEntry& entry) {
    return entry.split != "train" || entry.style != manifest.styles[0].name;
  });
  const auto has_person = [](const clip::ManifestEntry& entry) { return !entry.person.empty(); };
  if (std::ranges::none_of(one.entries, has_person)) return;
  const Result<std::vector<TrainingClip>> read = LoadClips(one, "train", parameters, 1);
  if (!read.ok()) Wrong(read.status().message());
}

void Check::Count(const TrainingClip& clip, const std::string& split, StylePlan& style) {
  const int frames = static_cast<int>(clip.poses.size());
  const bool judge = split == "judge";
  StylePlan::Part& part = judge ? style.judge : split == "train" ? style.train : style.validation;
  const double judged = needs_.judge_frames / 30.0 * needs_.rate_hz;
  const int fewest = judge ? static_cast<int>(std::ceil(judged)) : needs_.train_frames;
  if (frames < fewest) {
    ++part.too_short;
    return;
  }
  ++part.clips;
  part.seconds += frames / needs_.rate_hz;
  if (split != "train") return;
  style.windows += std::max(1, frames - needs_.window_frames + 1);
  ++cells_[static_cast<std::size_t>(clip.style)][static_cast<std::size_t>(clip.content)];
}

void Check::MissingPart(const std::string& style, const char* split, const StylePlan::Part& part,
                        int frames, double rate_hz, const char* why) {
  if (part.clips > 0) return;
  const std::string found = part.too_short == 0
                                ? "no clip"
                                : std::to_string(part.too_short) +
                                      (part.too_short == 1 ? " clip" : " clips") + ", none longer";
  Wrong(run_.manifest.string() + ": style \"" + style + "\", split \"" + split + "\": found " +
        found + ", expected one of " + NumberText(frames / rate_hz, 2) + " s or more (" +
        std::to_string(frames) + " frames), " + why);
}

void Check::Missing(const clip::Manifest& manifest, std::size_t style) {
  const StylePlan& of = plan_.styles[style];
  MissingPart(of.style, "train", of.train, needs_.train_frames, needs_.rate_hz,
              "for the network to learn from");
  MissingPart(of.style, "validation", of.validation, needs_.train_frames, needs_.rate_hz,
              "for the figures of monitor.csv");
  if (!needs_.judges.empty()) {
    MissingPart(of.style, "judge", of.judge, needs_.judge_frames, 30,
                "for the judges of --validate to learn from");
  }
  if (!needs_.paired || style == 0 || of.train.clips == 0) return;
  std::string alone, shared;
  for (std::size_t content = 0; content < manifest.contents.size(); ++content) {
    if (cells_[style][content] == 0) continue;
    std::string& names = cells_[0][content] > 0 ? shared : alone;
    names += (names.empty() ? "\"" : "\", \"") + manifest.contents[content];
  }
  if (alone.empty()) return;
  const std::string sentence = run_.manifest.string() + ": style \"" + of.style + "\": content " +
                               alone + "\" has no " + plan_.styles[0].style + " training clip";
  if (shared.empty()) {
    Wrong(sentence + ", expected one of at least one content of the style");
  } else {
    plan_.doubtful.push_back(sentence + ": the style is not learnt in it");
  }
}

std::string PartText(const StylePlan::Part& part) {
  std::ostringstream text;
  text << part.clips << " clips " << NumberText(part.seconds, 1) << " s";
  if (part.too_short > 0) text << " (" << part.too_short << " too short)";
  return text.str();
}

}  // namespace

Plan CheckBeforeTraining(const RunConfig& run, const Needs& needs) {
  return Check(run, needs).Run();
}

std::string PlanText(const Plan& plan, const Needs& needs) {
  std::string text;
  for (const StylePlan& style : plan.styles) {
    text += style.style + ": train " + PartText(style.train) + ", " +
            std::to_string(style.windows) + " windows of " + std::to_string(needs.window_frames) +
            " frames; judge " + PartText(style.judge) + "; validation " +
            PartText(style.validation) + "\n";
  }
  return text;
}

}  // namespace styled::train

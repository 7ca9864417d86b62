#include "model/train/judge/evidence.h"

#include <algorithm>
#include <cmath>

#include "model/net/weights_file.h"
#include "model/train/judge/sha256.h"

namespace styled::judge {

using Json = nlohmann::ordered_json;  // keeps the order of the keys

namespace {

bool IsCalled(const Json& style, const std::string& name) {
  net::StyleInfo info{.name = style["name"].get<std::string>(),
                      .aliases = style["aliases"].get<std::vector<std::string>>()};
  return net::FindStyle({std::move(info)}, name) == 0;
}

Status NoneOfTheStyles(const std::filesystem::path& weights) {
  return Status::Error(weights.string() + ": has none of the manifest's styles");
}

// A style whose figure stays beside those of `by`.
Status CheckJudges(const Json& style, const JudgedBy& by, const std::filesystem::path& weights) {
  const auto judged = style.find("judged_by");
  if (judged == style.end() || !judged->is_object()) return Status::Ok();
  const auto text = [&](const char* key) {
    const auto found = judged->find(key);
    return found != judged->end() && found->is_string() ? found->get<std::string>() : "";
  };
  if (text("manifest") != by.manifest || text("judges") == by.judges) return Status::Ok();
  return Status::Error(weights.string() + ": style '" + style["name"].get<std::string>() +
                       "' was judged on " + by.manifest + " by judges of SHA-256 " +
                       Shown(text("judges")) + ", expected " + Shown(by.judges) +
                       ", those of the new figures: judge all of them by the same");
}

}  // namespace

Result<TrainingSet> ReadTrainingSet(const std::filesystem::path& manifest,
                                    const std::filesystem::path& folder) {
  const Status found = train::CheckDataFolder(folder);
  if (!found.ok()) return found;
  auto read = clip::LoadManifest(manifest, folder);
  if (!read.ok()) return read.status();
  erd::FeatureParameters parameters;
  parameters.rate_hz = static_cast<float>(kStreamRate_hz / kStreamPerJudge);
  auto clips = train::LoadClips(read.value(), "train", parameters, 2);
  if (!clips.ok()) return clips.status();
  return TrainingSet{std::move(read.value()), std::move(clips.value()),
                     static_cast<double>(parameters.rate_hz)};
}

Status EditMetadata(const std::filesystem::path& weights,
                    const std::function<Status(Json& keys)>& edit) {
  const auto bytes = net::ReadFile(weights);
  if (!bytes.ok()) return bytes.status();
  // Checks the file's common keys, so that those read below are there.
  const auto parsed = net::ParseWeights(bytes.value(), weights.string());
  if (!parsed.ok()) return parsed.status();
  auto metadata = parsed.value().view.metadata;
  Json keys = Json::parse(metadata.at("styled"));
  if (Status edited = edit(keys); !edited.ok()) return edited;
  metadata["styled"] = keys.dump();
  const auto written = net::WithMetadata(bytes.value(), metadata, weights.string());
  if (!written.ok()) return written.status();
  const auto readable = net::ParseWeights(written.value(), weights.string());
  if (!readable.ok()) return readable.status();
  return net::WriteFile(weights, written.value());
}

Status EditStyles(const std::filesystem::path& weights, std::span<const std::string> names,
                  const std::function<void(std::size_t name, Json& style)>& edit) {
  return EditMetadata(weights, [&](Json& keys) {
    bool any = false;
    for (Json& style : keys["styles"]) {
      for (std::size_t name = 0; name < names.size(); ++name) {
        if (!IsCalled(style, names[name])) continue;
        edit(name, style);
        any = true;
      }
    }
    return any ? Status::Ok() : NoneOfTheStyles(weights);
  });
}

std::vector<Evidence> EvidenceOf(const clip::Manifest& manifest,
                                 std::span<const train::TrainingClip> clips, double rate_hz,
                                 const Figures& figures) {
  std::vector<Evidence> all;
  for (std::size_t style = 1; style < manifest.styles.size(); ++style) {
    Evidence evidence{.style = manifest.styles[style].name};
    for (const train::TrainingClip& clip : clips) {
      if (clip.style != static_cast<int>(style)) continue;
      evidence.recorded_s += static_cast<double>(clip.poses.size()) / rate_hz;
    }
    if (evidence.recorded_s == 0) continue;
    const Share& sra = figures.styles[style].sra;
    evidence.recognized = sra.windows > 0 ? sra.value : -1;
    all.push_back(evidence);
  }
  return all;
}

Status WriteEvidence(std::span<const Evidence> evidence, const JudgedBy& by,
                     const std::filesystem::path& weights) {
  return EditMetadata(weights, [&](Json& keys) {
    bool any = false;
    for (Json& style : keys["styles"]) {
      const auto found = std::find_if(evidence.begin(), evidence.end(), [&](const Evidence& of) {
        return IsCalled(style, of.style);
      });
      if (found == evidence.end()) {
        const Status same = CheckJudges(style, by, weights);
        if (!same.ok()) return same;
        continue;
      }
      any = true;
      style["recorded_s"] = std::round(10 * found->recorded_s) / 10;
      if (found->recognized < 0) continue;
      // 0 means not measured: a style that is never recognized has the least figure instead.
      style["recognized"] = std::max(0.001, std::round(1000 * found->recognized) / 1000);
      style["judged_by"] = {{"manifest", by.manifest}, {"judges", by.judges}};
    }
    return any ? Status::Ok() : NoneOfTheStyles(weights);
  });
}

Status WriteGate(const net::GateBounds& gate, const std::filesystem::path& weights) {
  return EditMetadata(weights, [&gate](nlohmann::ordered_json& keys) {
    keys["gate"] = nlohmann::ordered_json(net::AsJson(gate));
    return Status::Ok();
  });
}

}  // namespace styled::judge

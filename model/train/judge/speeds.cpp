#include "model/train/judge/speeds.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string_view>

#include "model/train/judge/evidence.h"
#include "model/train/judge/gait.h"
#include "model/train/judge/stream.h"

namespace styled::judge {
namespace {

using Json = nlohmann::ordered_json;  // keeps the order of the keys

// The mean speed and cadence of some clips.
struct Pace {
  Mean speed_mps, cadence_spm;

  // To the centimetre per second and the tenth of a step per minute: clips of one style differ by
  // more.
  double Speed() const { return Rounded(speed_mps, 100); }
  double Cadence() const { return Rounded(cadence_spm, 10); }

 private:
  static double Rounded(const Mean& mean, double parts) {
    return mean.count > 0 ? std::round(parts * mean.value()) / parts : 0;
  }
};

void Enter(const char* key, double figure, Json& style) {
  if (figure > 0) style[key] = figure;
}

}  // namespace

std::vector<StyleSpeeds> MeasureSpeeds(const clip::Manifest& manifest,
                                       std::span<const train::TrainingClip> clips, double rate_hz) {
  std::vector<StyleSpeeds> speeds;
  for (std::size_t style = 0; style < manifest.styles.size(); ++style) {
    const auto of = [&](std::string_view content) {
      Pace pace;
      for (const train::TrainingClip& clip : clips) {
        if (clip.style != static_cast<int>(style)) continue;
        if (manifest.contents[static_cast<std::size_t>(clip.content)] != content) continue;
        const Gait gait = MeasureGait(clip.poses, rate_hz);
        if (gait.speed_cm_s.count > 0) pace.speed_mps.Add(gait.speed_cm_s.value() / 100);
        if (gait.cadence_per_min.count > 0) pace.cadence_spm.Add(gait.cadence_per_min.value());
      }
      return pace;
    };
    const Pace walk = of("walk"), run = of("run");
    speeds.push_back(
        {manifest.styles[style].name, walk.Speed(), run.Speed(), walk.Cadence(), run.Cadence()});
  }
  return speeds;
}

Status WriteSpeeds(std::span<const StyleSpeeds> speeds, const std::filesystem::path& weights) {
  std::vector<std::string> names;
  for (const StyleSpeeds& measured : speeds) names.push_back(measured.style);
  return EditStyles(weights, names, [speeds](std::size_t name, Json& style) {
    Enter("walk_mps", speeds[name].walk_mps, style);
    Enter("run_mps", speeds[name].run_mps, style);
    Enter("walk_spm", speeds[name].walk_spm, style);
    Enter("run_spm", speeds[name].run_spm, style);
  });
}

Status MeasureAndWriteSpeeds(const std::filesystem::path& manifest_file,
                             const std::filesystem::path& folder,
                             const std::filesystem::path& weights) {
  const auto set = ReadTrainingSet(manifest_file, folder);
  if (!set.ok()) return set.status();
  const auto& [manifest, clips, rate_hz] = set.value();
  const auto speeds = MeasureSpeeds(manifest, clips, rate_hz);
  for (const StyleSpeeds& style : speeds) {
    std::printf("%-16s walk %.2f m/s, %.1f steps/min; run %.2f m/s, %.1f steps/min\n",
                style.style.c_str(), style.walk_mps, style.walk_spm, style.run_mps, style.run_spm);
  }
  return WriteSpeeds(speeds, weights);
}

}  // namespace styled::judge

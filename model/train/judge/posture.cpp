#include "model/train/judge/posture.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "model/net/weights_file.h"
#include "model/train/judge/evidence.h"
#include "model/train/mean_carriage.h"

namespace styled::judge {
namespace {

using body::Pose;
using body::Vec3;

train::MeanCarriage MeanOf(const std::vector<Pose>& poses, train::MeanCarriage mean) {
  for (const Pose& own : poses) {
    Pose mirrored;
    body::Mirror(own, mirrored);
    for (const body::Joint joint : net::kPostureJoints) {
      mean.Add(joint, own.rotations[joint]);
      mean.Add(joint, mirrored.rotations[joint]);
    }
  }
  return mean;
}

}  // namespace

std::vector<std::optional<net::Posture>> MeasurePostures(std::span<const train::TrainingClip> clips,
                                                         std::size_t style_count) {
  // By style; then by source and content: performers differ between sources.
  std::vector<std::map<std::pair<int, int>, train::MeanCarriage>> means(style_count);
  for (const train::TrainingClip& clip : clips) {
    train::MeanCarriage& mean =
        means[static_cast<std::size_t>(clip.style)][{clip.source, clip.content}];
    mean = MeanOf(clip.poses, mean);
  }
  std::vector<std::optional<net::Posture>> postures(style_count);
  for (std::size_t style = 1; style < style_count; ++style) {
    net::Posture sum;
    sum.fill(Vec3::Zero());
    int acts = 0;
    for (const auto& [act, mean] : means[style]) {
      const auto neutral = means[0].find(act);
      if (neutral == means[0].end()) continue;
      const neutral::Carriage from = neutral->second.Value();
      const neutral::Carriage to = mean.Value();
      for (std::size_t i = 0; i < sum.size(); ++i) {
        const body::Joint joint = net::kPostureJoints[i];
        sum[i] += body::Log(from.rotations[joint].conjugate() * to.rotations[joint]);
      }
      ++acts;
    }
    if (acts == 0) continue;
    for (Vec3& turn : sum) turn /= static_cast<float>(acts);
    postures[style] = sum;
  }
  return postures;
}

Status WritePostures(std::span<const std::optional<net::Posture>> postures,
                     std::span<const std::string> names, const std::filesystem::path& weights) {
  return EditStyles(weights, names, [&](std::size_t name, nlohmann::ordered_json& style) {
    if (postures[name]) style["posture"] = nlohmann::ordered_json(net::AsJson(*postures[name]));
  });
}

Status MeasureAndWritePostures(const std::filesystem::path& manifest,
                               const std::filesystem::path& folder,
                               const std::filesystem::path& weights) {
  const auto set = ReadTrainingSet(manifest, folder);
  if (!set.ok()) return set.status();
  std::vector<std::string> names;
  for (const auto& style : set.value().manifest.styles) names.push_back(style.name);
  const auto postures = MeasurePostures(set.value().clips, names.size());
  for (std::size_t style = 0; style < names.size(); ++style) {
    if (!postures[style]) continue;
    std::printf("%-16s", names[style].c_str());
    for (std::size_t i = 0; i < net::kPostureJoints.size(); ++i) {
      constexpr double kDegrees = 180 / M_PI;
      const std::string joint(body::kHumanoid[net::kPostureJoints[i]].name);
      std::printf(" %s %.1f", joint.c_str(),
                  kDegrees * static_cast<double>((*postures[style])[i].norm()));
    }
    std::printf(" degrees\n");
  }
  return WritePostures(postures, names, weights);
}

}  // namespace styled::judge

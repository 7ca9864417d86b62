#include "model/train/judge/judges_file.h"

#include <cmath>
#include <cstdio>
#include <tuple>

#include "model/base/hash.h"
#include "model/body/humanoid.h"
#include "model/net/sha256.h"
#include "model/net/weights_file.h"

namespace styled::judge {
namespace {

constexpr const char* kKey = "styled-judges";  // of the metadata
constexpr int kVersion = 1;

std::string Hex(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

// The facts that must be the same for a file's judges to see what these programs show them.
nlohmann::json NeedsOf(const clip::Manifest& manifest) {
  nlohmann::json styles = nlohmann::json::array();
  for (const clip::ManifestStyle& style : manifest.styles) styles.push_back(style.name);
  return {{"version", kVersion},
          {"humanoid_hash", Hex(body::HumanoidHash())},
          {"features", erd::kFeatureCount},
          {"rate_hz", static_cast<int>(kJudgeRate_hz)},
          {"recipes", {kJudgeRecipe, kPartRecipe}},
          {"styles", styles},
          {"contents", manifest.contents}};
}

std::vector<std::byte> BytesOf(const Panel& panel) {
  std::vector<net::NamedTensor> tensors = panel.judges.Tensors();
  for (net::NamedTensor& tensor : panel.parts.Tensors()) tensors.push_back(std::move(tensor));
  return net::SerializeSafetensors(tensors, {{kKey, panel.header.dump()}});
}

// The settings of a header whose other values are checked.
Result<JudgeSettings> SettingsOf(const nlohmann::json& header, const std::string& name) {
  JudgeSettings settings;
  for (const auto& [key, value, most] : {std::tuple{"window", &settings.window, 240},
                                         {"iterations", &settings.iterations, 10000000},
                                         {"batch", &settings.batch, 65536},
                                         {"count", &settings.count, kMostJudges}}) {
    const auto found = header.find(key);
    if (found == header.end() || !found->is_number_integer() || *found < 1 || *found > most) {
      return Status::Error(name + ": key '" + key + "': expected a whole number from 1 to " +
                           std::to_string(most) + ", found " +
                           (found == header.end() ? "none" : found->dump()));
    }
    *value = found->get<int>();
  }
  const auto found = header.find("seed");
  if (found == header.end() || !found->is_number_unsigned()) {
    return Status::Error(name + ": key 'seed': expected a whole number");
  }
  settings.seed = found->get<unsigned>();
  return settings;
}

}  // namespace

nlohmann::json OfClips(const std::vector<train::TrainingClip>& clips) {
  Fnv1a hash;
  std::size_t frames = 0;
  for (const train::TrainingClip& clip : clips) {
    hash.Text(std::filesystem::path(clip.file).filename().string());
    hash.Number(clip.style);
    hash.Number(clip.content);
    for (const body::Pose& pose : clip.poses) {
      const auto add = [&hash](float value) {
        hash.Number(static_cast<std::int64_t>(std::lround(1e4F * value)));
      };
      for (int axis = 0; axis < 3; ++axis) add(pose.hips_position_m[axis]);
      for (const body::Quat& rotation : pose.rotations) {
        for (int i = 0; i < 4; ++i) add(rotation.coeffs()[i]);
      }
    }
    frames += clip.poses.size();
  }
  return {{"clips", clips.size()}, {"frames", frames}, {"hash", Hex(hash.value())}};
}

Result<Panel> TrainPanel(const std::vector<train::TrainingClip>& clips,
                         const clip::Manifest& manifest, const JudgeSettings& settings,
                         const std::filesystem::path& cache, const std::string& key) {
  const auto styles = static_cast<int>(manifest.styles.size());
  const auto contents = static_cast<int>(manifest.contents.size());
  auto judges = Judges::TrainOrLoad(clips, styles, contents, settings, cache, key);
  if (!judges.ok()) return judges.status();
  auto parts = PartJudges::TrainOrLoad(clips, styles, contents, settings, cache, key);
  if (!parts.ok()) return parts.status();
  nlohmann::json header = NeedsOf(manifest);
  header.update({{"manifest", manifest.name},
                 {"seed", settings.seed},
                 {"count", settings.count},
                 {"iterations", settings.iterations},
                 {"batch", settings.batch},
                 {"window", settings.window},
                 {"clips", OfClips(clips)}});
  Panel panel{std::move(judges.value()), std::move(parts.value()), std::move(header), {}};
  panel.hash = net::Sha256(BytesOf(panel));
  return panel;
}

Result<Panel> ReadPanel(const std::filesystem::path& file,
                        const std::vector<train::TrainingClip>& clips,
                        const clip::Manifest& manifest) {
  const std::string name = file.string();
  const auto bytes = net::ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  auto view = net::ParseSafetensors(bytes.value(), name);
  if (!view.ok()) return view.status();
  const auto text = view.value().metadata.find(kKey);
  nlohmann::json header = text == view.value().metadata.end()
                              ? nlohmann::json()
                              : nlohmann::json::parse(text->second, nullptr, false);
  if (!header.is_object()) {
    return Status::Error(name + ": no judges; `styleeval --write-judges` writes a file of them");
  }
  net::Faults faults(name);
  const nlohmann::json needs = NeedsOf(manifest);
  for (const auto& [key, value] : needs.items()) net::ExpectEqual(header, key, value, faults);
  const nlohmann::json learned = OfClips(clips);
  // Not the hash: the last digit of a pose may differ between machines.
  for (const char* const key : {"clips", "frames"}) {
    net::ExpectEqual(header.value("clips", nlohmann::json::object()), key, learned[key], faults);
  }
  if (!faults.none()) return faults.status();
  const auto settings = SettingsOf(header, name);
  if (!settings.ok()) return settings.status();
  net::TensorReader tensors(view.value(), faults);
  const auto styles = static_cast<int>(manifest.styles.size());
  auto judges =
      Judges::Read(tensors, styles, static_cast<int>(manifest.contents.size()), settings.value());
  auto parts = PartJudges::Read(tensors, styles, settings.value());
  tensors.Finish();
  if (!faults.none()) return faults.status();
  return Panel{std::move(judges), std::move(parts), std::move(header), net::Sha256(bytes.value())};
}

Status WritePanel(const Panel& panel, const std::filesystem::path& file) {
  return net::WriteFile(file, BytesOf(panel));
}

}  // namespace styled::judge

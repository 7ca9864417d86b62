#include "model/train/judge/examples.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "model/clip/entry_reader.h"
#include "model/feet/legs.h"
#include "model/net/several.h"
#include "model/net/shipped_weights.h"
#include "model/trial/trial.h"

namespace styled::judge {

Result<std::vector<std::filesystem::path>> JoinedFiles(const std::string& weights) {
  std::istringstream names(std::filesystem::exists(weights) ? "" : weights);
  std::vector<std::string> parts;
  for (std::string name; std::getline(names, name, '+');) parts.push_back(name);
  if (parts.empty()) parts = {weights};
  std::vector<std::filesystem::path> files;
  for (const std::string& part : parts) {
    auto file = net::FindWeights(part);
    if (!file.ok()) return file.status();
    files.push_back(std::move(file.value()));
  }
  return files;
}

Result<std::shared_ptr<const net::Stylizer>> LoadJoined(const std::string& weights) {
  const auto files = JoinedFiles(weights);
  if (!files.ok()) return files.status();
  std::vector<net::NamedNetwork> networks;
  for (const std::filesystem::path& file : files.value()) {
    auto network = trial::Load(file);
    if (!network.ok()) return network.status();
    networks.push_back({file.stem().string(), std::move(network.value())});
  }
  auto joined = net::Combine(std::move(networks));
  if (!joined.ok()) return Status::Error("--weights " + weights + ": " + joined.status().message());
  if (joined.value()->space() != nullptr) return joined;
  return Status::Error("--weights " + weights + ": takes no examples; expected a family of " +
                       net::SpaceFamilyNames());
}

Result<Styler> LoadByExamples(const std::string& weights, const std::filesystem::path& examples,
                              const std::filesystem::path& data, const clip::Manifest& of) {
  const auto loaded = LoadJoined(weights);
  if (!loaded.ok()) return loaded.status();
  const auto manifest = clip::LoadManifest(examples, data);
  if (!manifest.ok()) return manifest.status();
  std::shared_ptr<const net::Stylizer> network = loaded.value();
  Styler styler;
  styler.style_of.assign(of.styles.size(), kAbsent);
  for (std::size_t style = 1; style < of.styles.size(); ++style) {
    const std::string& name = of.styles[style].name;
    std::vector<Poses> clips;
    clip::EntryReader reader;
    for (const clip::ManifestEntry& entry : manifest.value().entries) {
      if (entry.style != name) continue;
      auto poses = reader.Read(entry, static_cast<double>(network->model().rate_hz));
      if (!poses.ok()) return poses.status();
      clips.push_back(std::move(poses.value()));
    }
    if (clips.empty()) continue;
    net::StyleRequest request;
    for (const Poses& clip : clips) {
      request.sources.push_back({.style = -1, .seed = {}, .reference = clip, .weight = 1});
    }
    const net::StyleCode code = network->space()->MakeCode(request);
    const auto number = static_cast<int>(network->model().styles.size());
    if (!code.empty()) network = network->With(number, {.name = "of examples: " + name}, code);
    if (code.empty() || network == nullptr) {
      return Status::Error(examples.string() + ": \"" + name + "\": no style comes of its clips");
    }
    styler.style_of[style] = number;
  }
  if (std::ranges::all_of(styler.style_of, [](int number) { return number == kAbsent; })) {
    return Status::Error(examples.string() + ": has a clip of none of the styles of \"" + of.name +
                         "\"");
  }
  styler.network = std::move(network);
  styler.binding = std::make_shared<const rig::Binding>(feet::HumanoidBinding());
  return styler;
}

}  // namespace styled::judge

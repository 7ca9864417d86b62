// MakeLive: weights, what refers to their styles, and avatars.
#include "daemon/pipeline/profile.h"
#include "daemon/supervisor.h"
#include "model/erd/safetensors.h"
#include "model/erd/shipped_weights.h"
#include "model/trial/trial.h"
#include "proto/rigs/native/datagram.h"

namespace styled {
namespace {

Status CheckStyles(const config::Config& config, const erd::Network& network) {
  for (const auto& preset : config.presets) {
    pipeline::Look look;
    std::string why;
    // style.initial, consoles and who reads a list could not tell them apart.
    if (const int style = network.FindStyle(preset.name); style >= 0) {
      const auto& proper = network.metadata().styles[static_cast<std::size_t>(style)].name;
      return Status::Error(preset.place + ": presets." + preset.name + ": \"" + preset.name +
                           "\" is a style's name" +
                           (proper == preset.name ? "" : " too, an alias of \"" + proper + "\"") +
                           "; expected another");
    }
    if (!pipeline::LookUp(preset.name, config.presets, network, look, why)) {
      return Status::Error(preset.place + ": presets." + preset.name + ": " + why);
    }
  }
  if (config.style.initial.empty()) return Status::Ok();
  pipeline::Look look;
  std::string why;
  if (pipeline::LookUp(config.style.initial, config.presets, network, look, why)) {
    return Status::Ok();
  }
  return Status::Error("style.initial: \"" + config.style.initial + "\" is no preset, and " + why);
}

// The running one where nothing about it changed, so that performers need not start anew.
std::shared_ptr<const pipeline::AvatarOutput> KeepRunning(
    std::shared_ptr<const pipeline::AvatarOutput> fresh, const pipeline::Live* running) {
  if (running == nullptr) return fresh;
  for (const auto& kept : running->avatars) {
    const bool same = kept->body.SerializeAsString() == fresh->body.SerializeAsString() &&
                      kept->performers == fresh->performers &&
                      kept->skeleton.above_translation == fresh->skeleton.above_translation;
    if (same) return kept;
  }
  return fresh;
}

}  // namespace

Result<std::shared_ptr<const pipeline::Live>> MakeLive(const config::Config& config,
                                                       const pipeline::Live* running,
                                                       std::uint32_t& crc) {
  const auto path = erd::FindWeights(config.model.weights);
  if (!path.ok()) return path.status();
  const auto bytes = erd::ReadFile(path.value());
  if (!bytes.ok()) return bytes.status();
  auto live = std::make_shared<pipeline::Live>();
  const std::uint32_t fresh_crc = native::Crc32c(bytes.value());
  if (running != nullptr && fresh_crc == crc) {
    live->network = running->network;
  } else {
    auto network = trial::Parse(bytes.value(), path.value().string());
    if (!network.ok()) return network.status();
    live->network = std::move(network.value());
  }
  const Status status = CheckStyles(config, *live->network);
  if (!status.ok()) return status;
  if (running != nullptr) {
    live->joints = running->joints;  // sources change at a restart only
  } else {
    for (const auto& source : config.sources) live->joints.push_back(source.joints);
  }
  for (const auto& output : config.outputs) {
    auto avatar = pipeline::ReadAvatarOutput(output);
    if (!avatar.ok()) return avatar.status();
    live->avatars.push_back(KeepRunning(std::move(avatar.value()), running));
  }
  live->weights_name = path.value().filename().string();
  live->performers = config.performers;
  live->style = config.style;
  for (const auto& cue : config.cues) {
    auto made = pipeline::MakeCue(cue, config.presets, *live->network);
    if (!made.ok()) return made.status();
    live->cues.push_back(std::move(made.value()));
  }
  live->presets = config.presets;
  live->stylist = config.model.stylist;
  crc = fresh_crc;
  return std::shared_ptr<const pipeline::Live>(std::move(live));
}

}  // namespace styled

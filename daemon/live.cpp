// MakeLive: weights, what refers to their styles, and avatars.
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "daemon/pipeline/profile.h"
#include "daemon/supervisor.h"
#include "model/erd/shipped_weights.h"
#include "model/trial/trial.h"
#include "proto/rigs/native/datagram.h"

namespace styled {
namespace {

Result<std::vector<std::byte>> ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Status::Error(path.string() + ": " + std::strerror(errno));
  const std::vector<char> text((std::istreambuf_iterator<char>(file)),
                               std::istreambuf_iterator<char>());
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return std::vector<std::byte>(begin, begin + text.size());
}

Status CheckStyles(const config::Config& config, const erd::Network& network) {
  for (const auto& preset : config.presets) {
    pipeline::Look look;
    std::string why;
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
  const auto bytes = ReadFile(path.value());
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

// MakeLive: weights and what refers to their styles.
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "daemon/pipeline/profile.h"
#include "daemon/supervisor.h"
#include "model/erd/shipped_weights.h"
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
    auto network = erd::Network::Parse(bytes.value(), path.value().string());
    if (!network.ok()) return network.status();
    live->network = std::move(network.value());
  }
  const Status status = CheckStyles(config, *live->network);
  if (!status.ok()) return status;
  live->weights_name = path.value().filename().string();
  live->performers = config.performers;
  live->style = config.style;
  live->presets = config.presets;
  live->stylist = config.model.stylist;
  crc = fresh_crc;
  return std::shared_ptr<const pipeline::Live>(std::move(live));
}

}  // namespace styled

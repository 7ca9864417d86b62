#include "daemon/pipeline/runtime_config.h"

#include <array>
#include <cstdio>
#include <utility>

#include "daemon/pipeline/library.h"
#include "daemon/pipeline/profile.h"
#include "model/net/safetensors.h"
#include "model/net/shipped_weights.h"
#include "model/trial/trial.h"
#include "proto/rigs/native/datagram.h"

namespace styled::pipeline {
namespace {

Status CheckStyles(const config::Config& config, const net::Styles& styles) {
  for (const auto& preset : config.presets) {
    v1::Look look = InitialLook();
    std::string why;
    // A preset with a style's name would be ambiguous in style.initial, on consoles and in lists.
    if (const int style = net::FindStyle(styles, preset.name); style >= 0) {
      const auto& proper = styles[static_cast<std::size_t>(style)].name;
      return Status::Error(preset.place + ": presets." + preset.name + ": \"" + preset.name +
                           "\" is a style's name" +
                           (proper == preset.name ? "" : " too, an alias of \"" + proper + "\"") +
                           "; expected another");
    }
    if (!LookUp(preset.name, config.presets, styles, look, why)) {
      return Status::Error(preset.place + ": presets." + preset.name + ": " + why);
    }
  }
  v1::Look look = InitialLook();
  v1::Look change = config.style.look;
  std::string why;
  if (!ProperNames(styles, change, why)) return Status::Error("style.input_style: " + why);
  if (config.style.initial.empty()) return Status::Ok();
  styled::Apply(change, look);
  if (LookUp(config.style.initial, config.presets, styles, look, why)) {
    return Status::Ok();
  }
  return Status::Error("style.initial: \"" + config.style.initial + "\" is no preset, and " + why);
}

std::string HashText(std::uint32_t crc) {
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "crc32c:%08x", crc);
  return text.data();
}

// Returns the running output if nothing about it changed, so that performers need not restart.
std::shared_ptr<const RetargetOutput> KeepUnchanged(std::shared_ptr<const RetargetOutput> fresh,
                                                    const RuntimeConfig* running) {
  if (running == nullptr) return fresh;
  for (const auto& kept : running->outputs) {
    const bool same = kept->body.SerializeAsString() == fresh->body.SerializeAsString() &&
                      kept->performers == fresh->performers &&
                      kept->skeleton.above_translation == fresh->skeleton.above_translation;
    if (same) return kept;
  }
  return fresh;
}

}  // namespace

Result<std::shared_ptr<const RuntimeConfig>> MakeRuntimeConfig(const config::Config& config,
                                                               const RuntimeConfig* running,
                                                               std::uint32_t& weights_crc) {
  const auto path = net::FindWeights(config.model.weights);
  if (!path.ok()) return path.status();
  const auto bytes = net::ReadFile(path.value());
  if (!bytes.ok()) return bytes.status();
  auto made = std::make_shared<RuntimeConfig>();
  const std::uint32_t fresh_crc = native::Crc32c(bytes.value());
  if (running != nullptr && fresh_crc == weights_crc) {
    made->network = running->network;
    made->own_styles = running->own_styles;
  } else {
    auto network = trial::Parse(bytes.value(), path.value().string());
    if (!network.ok()) return network.status();
    made->network = std::move(network.value());
    made->own_styles = static_cast<int>(made->network->model().styles.size());
  }
  made->weights_hash = HashText(fresh_crc);
  made->style = config.style;
  made->presets = config.presets;
  if (running != nullptr && made->network == running->network) made->kept = running->kept;
  ReadLibrary(*made);
  const Status status = CheckStyles(config, made->network->model().styles);
  if (!status.ok()) return status;
  if (running != nullptr) {
    made->joints = running->joints;  // sources change only at a restart
  } else {
    for (const auto& source : config.sources) made->joints.push_back(source.joints);
  }
  for (const auto& output : config.outputs) {
    auto read = ReadRetargetOutput(output);
    if (!read.ok()) return read.status();
    made->outputs.push_back(KeepUnchanged(std::move(read.value()), running));
  }
  made->weights_name = path.value().filename().string();
  made->performers = config.performers;
  for (const auto& cue : config.cues) {
    auto checked = MakeCue(cue, config.presets, made->network->model().styles);
    if (!checked.ok()) return checked.status();
    made->cues.push_back(std::move(checked.value()));
  }
  made->stylist = config.model.stylist;
  weights_crc = fresh_crc;
  return std::shared_ptr<const RuntimeConfig>(std::move(made));
}

}  // namespace styled::pipeline

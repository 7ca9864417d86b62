#include "daemon/styles/make_config.h"

#include <utility>

#include "daemon/looks/profile.h"
#include "daemon/styles/library.h"
#include "daemon/styles/networks.h"

namespace styled::pipeline {
namespace {

Status CheckStyles(const config::Config& config, const net::Styles& styles) {
  for (const auto& preset : config.presets) {
    v1::Look look = InitialLook();
    // A preset with a style's name would be ambiguous in style.initial, on consoles and in lists.
    if (const int style = net::FindStyle(styles, preset.name); style >= 0) {
      const auto& proper = styles[static_cast<std::size_t>(style)].name;
      return Status::Error(preset.place + ": presets." + preset.name + ": \"" + preset.name +
                           "\" is a style's name" +
                           (proper == preset.name ? "" : " too, an alias of \"" + proper + "\"") +
                           "; expected another");
    }
    const Status status = LookUp(preset.name, config.presets, styles, look);
    if (!status.ok()) {
      return Status::Error(preset.place + ": presets." + preset.name + ": " + status.message());
    }
  }
  v1::Look look = InitialLook();
  v1::Look change = config.style.look;
  Status status = ProperNames(styles, change);
  if (!status.ok()) return Status::Error("style.input_style: " + status.message());
  if (config.style.initial.empty()) return Status::Ok();
  styled::Apply(change, look);
  status = LookUp(config.style.initial, config.presets, styles, look);
  if (status.ok()) return status;
  return Status::Error("style.initial: \"" + config.style.initial + "\" is not a preset, and " +
                       status.message());
}

// Returns the running output if it is unchanged, so that performers need not restart.
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
  const auto networks =
      ReadNetworks(config.model, running == nullptr ? std::nullopt : std::optional(weights_crc));
  if (!networks.ok()) return networks.status();
  auto made = std::make_shared<RuntimeConfig>();
  if (networks.value().network == nullptr && running != nullptr) {
    made->network = running->network;
    made->loaded = running->loaded;
    made->own_styles = running->own_styles;
    made->weights_hash = running->weights_hash;
    made->terms = running->terms;
  } else {
    made->network = made->loaded = networks.value().network;
    made->own_styles = networks.value().own_styles;
    made->weights_hash = networks.value().examples_hash;
    made->terms = std::move(networks.value().terms);
  }
  made->style = config.style;
  made->presets = config.presets;
  if (running != nullptr && made->network == running->network) {
    made->made = running->made;
    made->retired = running->retired;
    made->last_place = running->last_place;
    made->kept = running->kept;
  }
  ReadLibrary(*made);
  const Status status = CheckStyles(config, made->network->model().styles);
  if (!status.ok()) return status;
  if (running != nullptr) {
    made->joints = running->joints;  // sources change only at a restart
    made->smoothing = running->smoothing;
    made->idle = running->idle;
    made->props = running->props;
  } else {
    for (const auto& source : config.sources) {
      made->joints.push_back(source.joints);
      made->smoothing.push_back(source.smoothing);
      made->idle.push_back(source.FaceAlone() ? 1.0F : 0.0F);
      made->props.push_back(source.props);
    }
  }
  for (const auto& output : config.outputs) {
    auto read = ReadRetargetOutput(output);
    if (!read.ok()) return read.status();
    made->outputs.push_back(KeepUnchanged(std::move(read.value()), running));
  }
  made->weights_name = networks.value().names;
  made->weights_crc = networks.value().crc;
  made->performers = config.performers;
  for (const auto& cue : config.cues) {
    auto checked = MakeCue(cue, config.presets, made->network->model().styles);
    if (!checked.ok()) return checked.status();
    made->cues.push_back(std::move(checked.value()));
  }
  made->stylist = config.model.stylist;
  weights_crc = networks.value().crc;
  return std::shared_ptr<const RuntimeConfig>(std::move(made));
}

}  // namespace styled::pipeline

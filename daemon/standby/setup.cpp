#include "daemon/standby/setup.h"

#include <concepts>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/styles/style_list.h"
#include "model/base/text.h"

namespace styled::pipeline {
namespace {

// Above this number, all entries of one kind are hashed into one row.
constexpr std::size_t kMostRows = 64;

// Concatenates numbers and texts unambiguously, for a hash.
class HashedValues {
 public:
  HashedValues& Add(std::string_view text) {
    text_ += std::to_string(text.size()) + ":";
    text_ += text;
    return *this;
  }
  template <std::floating_point T>
  HashedValues& Add(T value) {
    return Add(std::string_view(NumberText(value)));
  }
  template <std::integral T>
  HashedValues& Add(T value) {
    return Add(std::string_view(std::to_string(value)));
  }
  std::string Hash() const { return HashOfExample(text_); }

 private:
  std::string text_;
};

using Rows = std::vector<std::pair<std::string, HashedValues>>;

v1::Setting MakeSetting(std::string name, std::string value) {
  v1::Setting setting;
  setting.set_name(std::move(name));
  setting.set_value(std::move(value));
  return setting;
}

std::vector<v1::Setting> Hashed(const std::string& kind, const Rows& rows) {
  std::vector<v1::Setting> settings;
  if (rows.size() <= kMostRows) {
    for (const auto& [name, values] : rows) {
      settings.push_back(MakeSetting(kind + " " + name, values.Hash()));
    }
    return settings;
  }
  HashedValues all;
  for (const auto& [name, values] : rows) all.Add(name).Add(values.Hash());
  settings.push_back(MakeSetting(kind + "s", all.Hash()));
  return settings;
}

class SetupRows {
 public:
  void Add(std::string name, std::string value) {
    *setup_.add_settings() = MakeSetting(std::move(name), std::move(value));
  }
  void Add(std::string name, bool value) { Add(std::move(name), value ? "true" : "false"); }
  void Add(std::string name, const char* value) { Add(std::move(name), std::string(value)); }
  void Add(std::string name, int value) { Add(std::move(name), std::to_string(value)); }
  void Add(std::string name, float value) { Add(std::move(name), NumberText(value)); }
  void AddMs(std::string name, float value_s) {
    Add(std::move(name), NumberText(value_s * 1000, 3));
  }
  void Add(const std::vector<v1::Setting>& settings) {
    setup_.mutable_settings()->Add(settings.begin(), settings.end());
  }
  v1::Setup Pop() { return std::move(setup_); }

 private:
  v1::Setup setup_;
};

// The structured binding names every field, so a new field does not compile until it is added here.
void AddModel(const stylist::Options& options, SetupRows& setup) {
  const auto& [change_tau_s, gap_reset_s, restart_fade_s, jump_m, jump_accept_frames,
               out_of_domain_begin_rad, out_of_domain_end_rad, out_of_domain_fade_s, tilt_begin_rad,
               tilt_end_rad, neutral, limb_gate, posture, ground_tau_s, knees, ground, feet,
               feet_options, own_cadence, bypass] = options;
  setup.AddMs("model.change_tau_ms", change_tau_s);
  setup.AddMs("model.gap_reset_ms", gap_reset_s);
  setup.AddMs("model.restart_fade_ms", restart_fade_s);
  setup.Add("model.jump_m", jump_m);
  setup.Add("model.jump_accept_frames", jump_accept_frames);
  setup.Add("model.out_of_domain_begin_rad", out_of_domain_begin_rad);
  setup.Add("model.out_of_domain_end_rad", out_of_domain_end_rad);
  setup.AddMs("model.out_of_domain_fade_ms", out_of_domain_fade_s);
  setup.Add("model.tilt_begin_rad", tilt_begin_rad);
  setup.Add("model.tilt_end_rad", tilt_end_rad);
  setup.Add("model.neutral", neutral);
  setup.Add("model.limb_gate", limb_gate);
  setup.Add("model.posture", posture);
  setup.AddMs("model.ground_tau_ms", ground_tau_s);
  setup.Add("model.knees", knees);
  setup.Add("model.ground", ground);
  setup.Add("model.feet", feet);
  setup.Add("model.own_cadence", own_cadence);
  setup.Add("model.bypass", bypass);
  const auto& [low_m, high_m, slow_mps, fast_mps, blend_in_s, blend_out_s, reach_m, return_s,
               centre_s, centre, stretch, hips_drop_m, hips_tau_s] = feet_options;
  HashedValues others;  // options that no configuration key sets
  others.Add(low_m).Add(high_m).Add(slow_mps).Add(fast_mps).Add(centre_s).Add(centre).Add(stretch);
  setup.AddMs("model.feet_blend_in_ms", blend_in_s);
  setup.AddMs("model.feet_blend_out_ms", blend_out_s);
  setup.Add("model.feet_reach_m", reach_m);
  setup.AddMs("model.feet_return_ms", return_s);
  setup.Add("model.feet_hips_drop_m", hips_drop_m);
  setup.Add("model.feet, others", others.Add(hips_tau_s).Hash());
}

void AddPerformers(const config::Performers& performers, SetupRows& setup) {
  const auto& [max_performers, stale_s, forget_s, takeover_s, clock_back_s, late_s, backlog_s] =
      performers;
  setup.Add("performers.max_performers", max_performers);
  setup.AddMs("performers.stale_ms", stale_s);
  setup.Add("performers.forget_s", forget_s);
  setup.AddMs("performers.takeover_ms", takeover_s);
  setup.AddMs("performers.clock_back_ms", clock_back_s);
  setup.AddMs("performers.late_ms", late_s);
  setup.AddMs("performers.backlog_ms", backlog_s);
}

HashedValues ValuesOf(const RetargetOutput& output) {
  HashedValues values;
  values.Add(output.body.SerializeAsString()).Add(output.performers.size());
  for (const std::string& id : output.performers) values.Add(id);
  for (const float number : output.skeleton.above_translation) values.Add(number);
  return values;
}

HashedValues ValuesOf(const Cue& cue) {
  HashedValues values;
  values.Add(cue.at ? std::to_string(*cue.at) : "none").Add(cue.performer);
  return values.Add(cue.request.SerializeAsString());
}

HashedValues ValuesOf(const config::Source& source) {
  const auto& [name, type, listen, performer, up, server, group, interface, multicast, coordinates,
               trackers, joints, rate_hz, delay_s, receive_buffer_bytes, max_connections, usb_id,
               serial, smoothing, merge_into, parts, body, expressions, props, sender_limit_hz] =
      source;
  // These belong to each machine.
  (void)listen, (void)server, (void)group, (void)interface, (void)multicast;
  (void)receive_buffer_bytes, (void)max_connections, (void)usb_id, (void)serial;
  (void)sender_limit_hz;
  HashedValues values;
  values.Add(name).Add(type).Add(performer).Add(up).Add(coordinates).Add(rate_hz).Add(delay_s);
  values.Add(smoothing.rest_hz).Add(smoothing.per_speed).Add(merge_into).Add(body);
  values.Add(expressions);
  values.Add(trackers.size());
  for (const config::Tracker& tracker : trackers) values.Add(tracker.id).Add(tracker.part);
  values.Add(joints.size());
  for (const auto& [canonical, theirs] : joints) values.Add(canonical).Add(theirs);
  values.Add(parts.size());
  for (const std::string& part : parts) values.Add(part);
  for (const auto& [prop, hand] : props) values.Add(prop).Add(static_cast<int>(hand));
  return values;
}

}  // namespace

std::vector<v1::Setting> SettingsOf(const std::vector<config::Source>& sources) {
  Rows rows;
  for (const config::Source& source : sources) {
    // Two sources of the same name get two rows.
    rows.emplace_back(std::to_string(rows.size()) + " " + source.name, ValuesOf(source));
  }
  return Hashed("source", rows);
}

v1::Setup SetupOf(const RuntimeConfig& config, const std::vector<v1::Setting>& sources) {
  SetupRows setup;
  setup.Add("version", STYLED_VERSION);
  setup.Add("weights", HashText(config.weights_crc));  // the checksum includes their precision
  AddModel(config.stylist, setup);
  AddPerformers(config.performers, setup);
  setup.Add("style.initial", config.style.initial);
  setup.Add("style", HashOfExample(config.style.look.SerializeAsString()));
  Rows presets, cues, outputs;
  for (const config::Preset& preset : config.presets) {
    presets.emplace_back(preset.name, HashedValues().Add(preset.look.SerializeAsString()));
  }
  for (const Cue& cue : config.cues) cues.emplace_back(cue.name, ValuesOf(cue));
  for (const auto& output : config.outputs) outputs.emplace_back(output->name, ValuesOf(*output));
  setup.Add(Hashed("preset", presets));
  setup.Add(Hashed("cue", cues));
  setup.Add(Hashed("output", outputs));
  setup.Add(sources);
  return setup.Pop();
}

}  // namespace styled::pipeline

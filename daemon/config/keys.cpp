#include "daemon/config/keys.h"

#include <algorithm>
#include <sstream>

#include "daemon/config/look_keys.h"
#include "daemon/config/table_keys.h"
#include "daemon/runtime/helpers.h"
#include "model/base/text.h"
#include "proto/rigs/types.h"

namespace styled::config {
namespace {

std::string ShownNode(const toml::node& node) {
  if (const auto* number = node.as_floating_point()) return NumberText(number->get());
  std::ostringstream text;
  node.visit([&text](const auto& value) { text << value; });
  constexpr std::size_t kLongest = 200;  // enough to recognize the value
  return Printable(text.str(), kLongest);
}

}  // namespace

Status Expected(const std::string& what, const toml::node& node) {
  return Status::Error("expected " + what + ", found " + ShownNode(node));
}

namespace {

// A number in [low, high], in the file's unit. The struct holds the number times `factor`.
template <typename T, typename Field>
Key<T> Float(std::string_view name, double low, double high, double factor, Field field) {
  return {name, [=](const toml::node& node, T& out) {
            const auto value = node.value<double>();
            if (!node.is_number() || !value || !(*value >= low && *value <= high)) {
              return Expected("a number from " + NumberText(low) + " to " + NumberText(high), node);
            }
            field(out) = static_cast<float>(*value * factor);
            return Status::Ok();
          }};
}

template <typename T, typename Field>
Key<T> Integer(std::string_view name, std::int64_t low, std::int64_t high, Field field) {
  return {name, [=](const toml::node& node, T& out) {
            const auto value = node.value<std::int64_t>();
            if (!node.is_integer() || *value < low || *value > high) {
              return Expected(
                  "a whole number from " + std::to_string(low) + " to " + std::to_string(high),
                  node);
            }
            field(out) = static_cast<int>(*value);
            return Status::Ok();
          }};
}

template <typename T, typename Field>
Key<T> Flag(std::string_view name, Field field) {
  return {name, [=](const toml::node& node, T& out) {
            if (!node.is_boolean()) return Expected("true or false", node);
            field(out) = *node.value<bool>();
            return Status::Ok();
          }};
}

template <typename T, typename Field>
Key<T> Text(std::string_view name, Field field) {
  return {name, [=](const toml::node& node, T& out) {
            if (!node.is_string()) return Expected("a string in quotes", node);
            field(out) = *node.value<std::string>();
            return Status::Ok();
          }};
}

template <typename T, typename Field>
Key<T> OneOf(std::string_view name, const std::vector<std::string_view>& words, Field field) {
  return {name, [=](const toml::node& node, T& out) {
            const auto value = node.value<std::string>();
            if (value && std::find(words.begin(), words.end(), *value) != words.end()) {
              field(out) = *value;
              return Status::Ok();
            }
            std::string list;
            for (const auto word : words) {
              if (!list.empty()) list += ", ";
              list.append("\"").append(word).append("\"");
            }
            return Expected("one of " + list, node);
          }};
}

#define STYLED_FIELD(path) ([](auto& c) -> auto& { return c.path; })

constexpr double kMs = 1e-3;
constexpr std::int64_t kGiB = 1 << 30;

Section ModelSection() {
  using C = Config;
  const auto begin = STYLED_FIELD(model.stylist.out_of_domain_begin_rad);
  const auto end = STYLED_FIELD(model.stylist.out_of_domain_end_rad);
  const auto fade = STYLED_FIELD(model.stylist.out_of_domain_fade_s);
  return {
      "model",
      {Text<C>("weights", STYLED_FIELD(model.weights)),
       Text<C>("examples", STYLED_FIELD(model.examples)),
       Text<C>("gaits", STYLED_FIELD(model.gaits)),
       OneOf<C>("precision", {"int8", "float32"}, STYLED_FIELD(model.precision)),
       Float<C>("change_tau_ms", 0, 1000, kMs, STYLED_FIELD(model.stylist.change_tau_s)),
       Float<C>("gap_reset_ms", 10, 10000, kMs, STYLED_FIELD(model.stylist.gap_reset_s)),
       Float<C>("restart_fade_ms", 0, 5000, kMs, STYLED_FIELD(model.stylist.restart_fade_s)),
       Float<C>("jump_m", 0.1, 100, 1, STYLED_FIELD(model.stylist.jump_m)),
       Integer<C>("jump_accept_frames", 1, 1000, STYLED_FIELD(model.stylist.jump_accept_frames)),
       Float<C>("out_of_domain_begin_rad", 0, 4, 1, begin),
       Float<C>("foreign_begin_rad", 0, 4, 1, begin),  // former name of the key
       Float<C>("out_of_domain_end_rad", 0, 4, 1, end),
       Float<C>("foreign_end_rad", 0, 4, 1, end),
       Float<C>("out_of_domain_fade_ms", 0, 10000, kMs, fade),
       Float<C>("foreign_fade_ms", 0, 10000, kMs, fade),
       Float<C>("tilt_begin_rad", 0, 4, 1, STYLED_FIELD(model.stylist.tilt_begin_rad)),
       Float<C>("tilt_end_rad", 0, 4, 1, STYLED_FIELD(model.stylist.tilt_end_rad)),
       Flag<C>("neutral", STYLED_FIELD(model.stylist.neutral)),
       Float<C>("posture", 0, 1, 1, STYLED_FIELD(model.stylist.posture)),
       Flag<C>("limb_gate", STYLED_FIELD(model.stylist.limb_gate)),
       Flag<C>("knees", STYLED_FIELD(model.stylist.knees)),
       Flag<C>("ground", STYLED_FIELD(model.stylist.ground)),
       Float<C>("ground_tau_ms", 0, 1000, kMs, STYLED_FIELD(model.stylist.ground_tau_s)),
       Flag<C>("feet", STYLED_FIELD(model.stylist.feet)),
       Float<C>("feet_reach_m", 0.001, 1, 1, STYLED_FIELD(model.stylist.feet_options.reach_m)),
       Float<C>("feet_blend_in_ms", 0, 1000, kMs,
                STYLED_FIELD(model.stylist.feet_options.blend_in_s)),
       Float<C>("feet_blend_out_ms", 0, 1000, kMs,
                STYLED_FIELD(model.stylist.feet_options.blend_out_s)),
       Float<C>("feet_return_ms", 1, 10000, kMs, STYLED_FIELD(model.stylist.feet_options.return_s)),
       Float<C>("feet_hips_drop_m", 0, 1, 1,
                STYLED_FIELD(model.stylist.feet_options.hips_drop_m))}};
}

// The fields of a look by their names, and by former ones.
template <typename T, typename Field>
void AddLookKeys(Field look, std::vector<Key<T>>& keys) {
  for (const LookField& field : kLookFields) {
    for (const std::string_view name : {field.name, field.former}) {
      if (name.empty()) continue;
      keys.push_back({name, [&field, look](const toml::node& node, T& out) {
                        return ReadLookField(field, node, look(out));
                      }});
    }
  }
}

// `initial` names the preset or style that `mix` and `preset` would set.
Section StyleSection() {
  Section section{"style",
                  {Text<Config>("initial", STYLED_FIELD(style.initial)),
                   Text<Config>("library", STYLED_FIELD(style.library))}};
  AddLookKeys(STYLED_FIELD(style.look), section.keys);
  std::erase_if(section.keys,
                [](const Key<Config>& key) { return key.name == "mix" || key.name == "preset"; });
  return section;
}

Section PerformersSection() {
  using C = Config;
  return {"performers",
          {Integer<C>("max_performers", 1, 1024, STYLED_FIELD(performers.max_performers)),
           Float<C>("stale_ms", 20, 60000, kMs, STYLED_FIELD(performers.stale_s)),
           Float<C>("forget_s", 1, 86400, 1, STYLED_FIELD(performers.forget_s)),
           Float<C>("takeover_ms", 10, 60000, kMs, STYLED_FIELD(performers.takeover_s)),
           Float<C>("clock_back_ms", 10, 60000, kMs, STYLED_FIELD(performers.clock_back_s)),
           Float<C>("late_ms", 1, 10000, kMs, STYLED_FIELD(performers.late_s)),
           Float<C>("backlog_ms", 1, 10000, kMs, STYLED_FIELD(performers.backlog_s))}};
}

// An octal file mode as for chmod, e.g. "0660".
template <typename Field>
Key<Config> Mode(std::string_view name, Field field) {
  return {name, [=](const toml::node& node, Config& out) {
            const auto text = node.value<std::string>();
            const bool octal = text && text->size() >= 3 && text->size() <= 4 &&
                               text->find_first_not_of("01234567") == std::string::npos;
            const unsigned long mode = octal ? std::stoul(*text, nullptr, 8) : 01000;
            if (mode > 0777) return Expected("a file's mode in quotes, e.g. \"0660\"", node);
            field(out) = static_cast<int>(mode);
            return Status::Ok();
          }};
}

// A list of users, e.g. ["anna", 1001].
template <typename Field>
Key<Config> Users(std::string_view name, Field field) {
  return {
      name, [=](const toml::node& node, Config& out) {
        const std::string expected = "a list of users, names or numbers, e.g. [\"anna\", 1001]";
        const toml::array* list = node.as_array();
        if (list == nullptr) return Expected(expected, node);
        field(out).clear();
        for (const auto& user : *list) {
          const auto number = user.value<std::int64_t>();
          const bool is_number = user.is_integer() && *number >= 0 && *number < 0xFFFFFFFF;
          if (!is_number && !user.is_string()) return Expected(expected, user);
          field(out).push_back(is_number ? std::to_string(*number) : *user.value<std::string>());
        }
        return Status::Ok();
      }};
}

std::vector<Section> MakeSections() {
  using C = Config;
  return {
      {"publish",
       {Text<C>("address", STYLED_FIELD(publish.address)),
        Mode("ipc_mode", STYLED_FIELD(publish.ipc.mode)),
        Users("ipc_users", STYLED_FIELD(publish.ipc.users)),
        Flag<C>("allow_unauthenticated_remote", STYLED_FIELD(publish.allow_unauthenticated_remote)),
        Integer<C>("high_water_mark", 1, kMostHighWaterMark, STYLED_FIELD(publish.high_water_mark)),
        Integer<C>("send_buffer_bytes", 4096, kGiB, STYLED_FIELD(publish.send_buffer_bytes)),
        Integer<C>("max_subscriptions", 1, 100000, STYLED_FIELD(publish.max_subscriptions)),
        Flag<C>("canary", STYLED_FIELD(publish.canary))}},
      {"control",
       {Text<C>("address", STYLED_FIELD(control.address)),
        Mode("ipc_mode", STYLED_FIELD(control.ipc.mode)),
        Users("ipc_users", STYLED_FIELD(control.ipc.users)),
        Flag<C>("allow_unauthenticated_remote",
                STYLED_FIELD(control.allow_unauthenticated_remote))}},
      {"security", {Text<C>("keys", STYLED_FIELD(security.keys))}},
      ModelSection(),
      PerformersSection(),
      StyleSection(),
      {"osc",
       {Text<C>("listen", STYLED_FIELD(osc.listen)),
        Flag<C>("allow_unauthenticated_remote", STYLED_FIELD(osc.allow_unauthenticated_remote))}},
      {"standby",
       {Text<C>("peer", STYLED_FIELD(standby.peer)),
        Text<C>("peer_key", STYLED_FIELD(standby.peer_key)),
        Text<C>("address", STYLED_FIELD(standby.address)),
        Flag<C>("allow_unauthenticated_remote", STYLED_FIELD(standby.allow_unauthenticated_remote)),
        Flag<C>("first", STYLED_FIELD(standby.first)),
        Float<C>("hold_ms", 20, 5000, kMs, STYLED_FIELD(standby.hold_s))}},
      {"time", {Text<C>("ptp4l", STYLED_FIELD(time.ptp4l))}},
      {"state", {Text<C>("dir", STYLED_FIELD(state.dir))}},
      {"record",
       {Text<C>("file", STYLED_FIELD(record.file)),
        Integer<C>("min_free_mb", 0, 1 << 30, STYLED_FIELD(record.min_free_mb))}},
      {"log",
       {OneOf<C>("level", {"trace", "debug", "info", "warn", "error", "off"},
                 STYLED_FIELD(log.level))}},
      {"realtime",
       {Flag<C>("lock_memory", STYLED_FIELD(realtime.lock_memory)),
        Integer<C>("priority", 0, 99, STYLED_FIELD(realtime.priority)),
        Integer<C>("cpu", -1, 1023, STYLED_FIELD(realtime.cpu)),
        OneOf<C>("wait", {"block", "hybrid", "busy"}, STYLED_FIELD(realtime.wait)),
        Flag<C>("prewarm", STYLED_FIELD(realtime.prewarm)),
        Flag<C>("relieve", STYLED_FIELD(realtime.relieve)),
        Integer<C>("styling_threads", 1, runtime::Helpers::kMost + 1,
                   STYLED_FIELD(realtime.styling_threads))}},
  };
}

std::vector<std::string_view> SourceTypeNames() {
  std::vector<std::string_view> names;
  names.reserve(rigs::kSourceTypes.size());
  for (const auto& type : rigs::kSourceTypes) names.push_back(type.name);
  return names;
}

// Levenshtein distance; one row of the matrix suffices, with the diagonal neighbour saved.
std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

}  // namespace

const std::vector<Section>& Sections() {
  static const std::vector<Section> sections = MakeSections();
  return sections;
}

const std::vector<Key<Source>>& SourceKeys() {
  using S = Source;
  static const std::vector<Key<Source>> keys{
      Text<S>("name", STYLED_FIELD(name)),
      OneOf<S>("type", SourceTypeNames(), STYLED_FIELD(type)),
      Text<S>("listen", STYLED_FIELD(listen)),
      Text<S>("performer", STYLED_FIELD(performer)),
      OneOf<S>("up", {"auto", "y", "z"}, STYLED_FIELD(up)),
      Text<S>("server", STYLED_FIELD(server)),
      Text<S>("merge_into", STYLED_FIELD(merge_into)),
      Key<S>{"parts", ReadParts},
      OneOf<S>("body", {"auto", "none", "standing", "seated"}, STYLED_FIELD(body)),
      OneOf<S>("expressions", {"arkit", "vrm"}, STYLED_FIELD(expressions)),
      Flag<S>("multicast", STYLED_FIELD(multicast)),
      Text<S>("group", STYLED_FIELD(group)),
      Text<S>("interface", STYLED_FIELD(interface)),
      OneOf<S>("coordinates", {"auto", "global", "local"}, STYLED_FIELD(coordinates)),
      Float<S>("rate_hz", 10, 1000, 1, STYLED_FIELD(rate_hz)),
      Key<S>{"trackers", ReadTrackers},
      Key<S>{"joints", [](const toml::node& node, S& out) { return ReadJoints(node, out.joints); }},
      Key<S>{"props", ReadProps},
      Float<S>("delay_ms", 0, 1000, kMs, STYLED_FIELD(delay_s)),
      Float<S>("smooth_hz", 0, 60, 1, STYLED_FIELD(smoothing.rest_hz)),
      Float<S>("smooth_per_speed", 0, 100, 1, STYLED_FIELD(smoothing.per_speed)),
      Integer<S>("receive_buffer_bytes", 4096, kGiB, STYLED_FIELD(receive_buffer_bytes)),
      Integer<S>("max_connections", 1, 1024, STYLED_FIELD(max_connections)),
      Integer<S>("sender_limit_hz", 0, 100000000, STYLED_FIELD(sender_limit_hz)),
      Text<S>("usb_id", STYLED_FIELD(usb_id)),
      Text<S>("serial", STYLED_FIELD(serial)),
  };
  return keys;
}

const std::vector<Key<Output>>& OutputKeys() {
  using O = Output;
  static const std::vector<Key<Output>> keys{
      Text<O>("name", STYLED_FIELD(name)),
      Text<O>("avatar", STYLED_FIELD(avatar)),
      Text<O>("dialect", STYLED_FIELD(dialect)),
      Key<O>{"joints", [](const toml::node& node, O& out) { return ReadJoints(node, out.joints); }},
      Key<O>{"performers", ReadPerformers},
  };
  return keys;
}

const std::vector<Key<Cue>>& CueKeys() {
  using C = Cue;
  static const std::vector<Key<Cue>> keys = [] {
    std::vector<Key<Cue>> made{
        Text<C>("name", STYLED_FIELD(name)),
        Text<C>("at", STYLED_FIELD(at)),
        Text<C>("performer", STYLED_FIELD(performer)),
        Text<C>("style", STYLED_FIELD(style)),
        Flag<C>("panic", STYLED_FIELD(panic)),
        Key<C>{"clear",
               [](const toml::node& node, C& out) {
                 if (!node.is_boolean()) return Expected("true or false", node);
                 out.look.set_clear(*node.value<bool>());
                 return Status::Ok();
               }},
    };
    AddLookKeys(STYLED_FIELD(look), made);
    return made;
  }();
  return keys;
}

Status ReadPreset(const toml::node& node, Preset& preset) {
  return ReadLookField(*FindLookField("mix"), node, preset.look);
}

std::string Nearest(std::string_view text, const std::vector<std::string_view>& candidates) {
  if (text.size() > kLongestName) return "";  // no key is near to that
  std::string_view best;
  std::size_t best_distance = text.size() / 2 + 2;
  for (const auto candidate : candidates) {
    const std::size_t distance = EditDistance(text, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best.empty() ? "" : ", nearest is \"" + std::string(best) + "\"";
}

}  // namespace styled::config

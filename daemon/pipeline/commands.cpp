#include "daemon/pipeline/commands.h"

#include <algorithm>
#include <utility>

#include "model/base/text.h"
#include "proto/styled/body_parts.h"

namespace styled::pipeline {
namespace {

// Bytes of a name in a reason, which has to be valid UTF-8: clients cannot read the reply
// otherwise.
constexpr std::size_t kShown = 80;

void Refuse(v1::Reply& reply, v1::Code code, std::string reason) {
  reply.set_code(code);
  reply.set_reason(std::move(reason));
  reply.clear_applied();
}

bool InRange(float value, float low, float high) { return value >= low && value <= high; }

bool CheckTransition(bool given, float transition_ms, v1::Reply& reply) {
  if (!given || InRange(transition_ms, 0, 60000)) return true;
  Refuse(reply, v1::CODE_OUT_OF_RANGE,
         "transition_ms is " + NumberText(transition_ms) + ", expected 0 to 60000");
  return false;
}

}  // namespace

bool Commands::Apply(const v1::Request& request, v1::Reply& reply) {
  reply.set_id(request.id());
  switch (request.command_case()) {
    case v1::Request::kList:
      List(reply);
      return true;
    case v1::Request::kSet:
      Set(request, reply);
      return true;
    case v1::Request::kPin:
      Pin(request, reply);
      return true;
    case v1::Request::kPreset:
      Preset(request, reply);
      return true;
    case v1::Request::kPanic:
      Panic(reply);
      return true;
    case v1::Request::kReset:
      Reset(request, reply);
      return true;
    case v1::Request::kCue:
      Fire(request.cue(), reply);
      return true;
    case v1::Request::kStatus:
      return false;
    case v1::Request::kCalibrate:  // the pipeline's own
    case v1::Request::COMMAND_NOT_SET:
      break;
  }
  Refuse(reply, v1::CODE_UNKNOWN_COMMAND,
         "no command that this daemon knows; expected list, set, pin, preset, panic, reset, cue, "
         "calibrate or status");
  return true;
}

Commands::Targets Commands::Find(const std::string& performer, v1::Reply& reply) {
  Targets targets;
  if (performer == "*") {
    targets.ok = targets.all = true;
    for (const auto& [id, profile] : roster_.profiles) targets.profiles.push_back(profile.get());
    return targets;
  }
  if (!config::IsPerformerId(performer)) {
    Refuse(reply, v1::CODE_UNKNOWN_PERFORMER,
           "performer \"" + Printable(performer, kShown) + "\": expected SOURCE.NAME or *");
    return targets;
  }
  if (!roster_.KnowsSource(performer.substr(0, performer.find('.')))) {
    std::string reason = "performer \"" + performer + "\": no such source; the sources are";
    for (const auto& name : roster_.source_names()) reason += " " + name;
    Refuse(reply, v1::CODE_UNKNOWN_PERFORMER, std::move(reason));
    return targets;
  }
  Profile* profile = roster_.EnsureProfile(performer);
  if (profile == nullptr) {
    Refuse(reply, v1::CODE_BUSY,
           std::to_string(roster_.profiles.size()) +
               " performers have settings already; clear those of some who do not come");
    return targets;
  }
  targets.ok = true;
  targets.profiles.push_back(profile);
  return targets;
}

void Commands::List(v1::Reply& reply) const {
  auto& list = *reply.mutable_list();
  const auto& styles = roster_.config().network->model().styles;
  for (std::size_t i = 0; i < styles.size(); ++i) {
    auto& info = *list.add_styles();
    info.set_name(styles[i].name);
    for (const auto& alias : styles[i].aliases) info.add_aliases(alias);
    info.set_neutral(i == 0);
  }
  for (const Cue& cue : roster_.config().cues) {
    auto& info = *list.add_cues();
    info.set_name(cue.name);
    info.set_performer(cue.performer);
    if (cue.at) info.set_at(TimecodeText(*cue.at));
  }
  for (const auto& preset : roster_.config().presets) {
    auto& info = *list.add_presets();
    info.set_name(preset.name);
    for (const auto& [style, weight] : preset.mix) {
      auto& entry = *info.add_mix();
      entry.set_style(style);
      entry.set_weight(weight);
    }
  }
}

void Commands::Applied(const Profile& profile, v1::Reply& reply) const {
  auto& applied = *reply.add_applied();
  applied.set_performer(profile.id);
  applied.set_first_sequence(profile.next_sequence);
}

template <typename Change>
void Commands::ChangeLooks(const std::string& performer, Change change, v1::Reply& reply) {
  const net::Styles& styles = roster_.config().network->model().styles;
  const Targets targets = Find(performer, reply);
  if (!targets.ok) return;
  std::vector<std::pair<Profile*, Look>> wanted;
  const auto add = [&](Profile& profile) {
    if (profile.pinned) {
      if (!targets.all) Refuse(reply, v1::CODE_PINNED, profile.id + " is pinned; unpin it first");
      return targets.all;
    }
    Look look = profile.look;
    change(look);
    std::vector<std::string> unknown;
    const auto error =
        stylist::Validate(Resolve(look, styles, unknown), static_cast<int>(styles.size()));
    if (error != stylist::SettingsError::kNone) {
      Refuse(reply, v1::CODE_OUT_OF_RANGE, profile.id + ": " + Explain(error));
      return false;
    }
    wanted.emplace_back(&profile, std::move(look));
    return true;
  };
  for (Profile* profile : targets.profiles) {
    if (add(*profile)) continue;
    if (!targets.all) roster_.DropUnused(*profile);
    return;
  }
  if (targets.all && !add(roster_.to_come)) return;
  for (auto& [profile, look] : wanted) {
    profile->look = std::move(look);
    profile->configured = true;
    if (Performer* live = roster_.LiveOf(*profile)) (void)live->ApplyLook(roster_.config());
    if (profile != &roster_.to_come) Applied(*profile, reply);
    if (!targets.all) roster_.NoteNamed(*profile);
  }
  changed_ = true;
}

void Commands::Set(const v1::Request& request, v1::Reply& reply) {
  const v1::Set& set = request.set();
  if (set.clear() && set.mix_size() > 0) {
    return Refuse(reply, v1::CODE_MALFORMED, "set: clear and mix exclude each other");
  }
  if (set.mix_size() > net::kMaxMix) {
    return Refuse(reply, v1::CODE_OUT_OF_RANGE,
                  "set: " + std::to_string(set.mix_size()) + " styles, expected at most " +
                      std::to_string(net::kMaxMix));
  }
  if (set.has_strength() && !InRange(set.strength(), 0, net::kMaxStrength)) {
    return Refuse(reply, v1::CODE_OUT_OF_RANGE,
                  "set: strength is " + NumberText(set.strength()) + ", expected 0 to 1.5");
  }
  if (!CheckTransition(set.has_transition_ms(), set.transition_ms(), reply)) return;
  for (const int part : set.only()) {
    if (!v1::BodyPart_IsValid(part)) {
      return Refuse(reply, v1::CODE_OUT_OF_RANGE,
                    "set: only has " + std::to_string(part) + ", expected a BodyPart, 0 to 6");
    }
  }
  const body::Parts parts = PartsOf(set.only());
  std::vector<std::pair<std::string, float>> mix;
  for (const auto& entry : set.mix()) mix.emplace_back(entry.style(), entry.weight());
  std::string why;
  std::vector<std::pair<std::string, float>> own;  // one or none
  if (!set.own_style().empty()) own.emplace_back(set.own_style(), 1.0F);
  const net::Styles& styles = roster_.config().network->model().styles;
  if (!ProperNames(styles, mix, why) || !ProperNames(styles, own, why)) {
    return Refuse(reply, v1::CODE_UNKNOWN_STYLE, "set: " + why);
  }
  if (!own.empty() && net::FindStyle(styles, own.front().first) == 0) own.clear();
  ChangeLooks(
      request.performer(),
      [&](Look& look) {
        if (set.clear() || !mix.empty()) {
          look.mix = mix;
          look.preset.clear();
        }
        if (set.has_strength()) look.strength = set.strength();
        if (set.has_transition_ms()) look.transition_s = set.transition_ms() * 1e-3F;
        if (set.has_absolute()) look.absolute = set.absolute();
        if (parts != 0) look.parts = parts;
        if (set.has_own_style()) look.input_style = own.empty() ? "" : own.front().first;
      },
      reply);
  if (set.clear() && reply.code() == v1::CODE_OK) ForgetMisnamed(request.performer());
}

// Who was named by mistake, or never came, is not to be listed for ever.
void Commands::ForgetMisnamed(const std::string& id) {
  Profile* const profile = roster_.FindProfile(id);
  if (profile == nullptr || profile->seen || profile->pinned || profile->rest ||
      profile->look != roster_.to_come.look) {
    return;
  }
  profile->configured = false;
  roster_.DropUnused(*profile);
}

void Commands::Preset(const v1::Request& request, v1::Reply& reply) {
  const auto& presets = roster_.config().presets;
  const std::string& name = request.preset().name();
  const auto preset = std::find_if(presets.begin(), presets.end(),
                                   [&name](const config::Preset& p) { return p.name == name; });
  if (preset == presets.end()) {
    std::string reason = "no preset \"" + Printable(name, kShown) + "\"; the presets are";
    for (const auto& known : presets) reason += " " + known.name;
    return Refuse(reply, v1::CODE_UNKNOWN_PRESET,
                  presets.empty() ? "no presets are configured" : reason);
  }
  const bool timed = request.preset().has_transition_ms();
  const float transition_ms = request.preset().transition_ms();
  if (!CheckTransition(timed, transition_ms, reply)) return;
  auto mix = preset->mix;
  std::string why;
  if (!ProperNames(roster_.config().network->model().styles, mix, why)) {
    return Refuse(reply, v1::CODE_UNKNOWN_STYLE, "preset: " + why);
  }
  ChangeLooks(
      request.performer(),
      [&](Look& look) {
        look.mix = mix;
        look.preset = name;
        if (timed) look.transition_s = transition_ms * 1e-3F;
      },
      reply);
}

void Commands::Pin(const v1::Request& request, v1::Reply& reply) {
  const Targets targets = Find(request.performer(), reply);
  for (Profile* profile : targets.profiles) {
    profile->pinned = request.pin().pinned();
    profile->configured = true;
    if (!targets.all) roster_.NoteNamed(*profile);
    changed_ = true;
    Applied(*profile, reply);
  }
}

void Commands::Panic(v1::Reply& reply) {
  const auto clear = [&](Profile& profile) {
    profile.look.mix.clear();
    profile.look.preset.clear();
    profile.configured = true;
    if (Performer* live = roster_.LiveOf(profile)) (void)live->ApplyLook(roster_.config());
  };
  for (const auto& [id, profile] : roster_.profiles) {
    clear(*profile);
    Applied(*profile, reply);
  }
  clear(roster_.to_come);
  changed_ = true;
}

void Commands::FireOne(const Cue& cue, const std::string& performer, v1::Reply& reply) {
  for (std::size_t i = 0; i < cue.requests.size(); ++i) {
    v1::Request request = cue.requests[i];
    request.set_performer(performer);
    v1::Reply one;
    (void)Apply(request, one);
    if (one.code() == v1::CODE_PINNED) continue;
    if (one.code() != v1::CODE_OK && reply.code() == v1::CODE_OK) {
      reply.set_code(one.code());
      reply.set_reason("cue " + cue.name + ": " + one.reason());
    }
    if (i + 1 == cue.requests.size()) reply.mutable_applied()->MergeFrom(one.applied());
  }
}

void Commands::Fire(const v1::Cue& wanted, v1::Reply& reply) {
  bool found = false;
  for (const Cue& cue : roster_.config().cues) {
    if (cue.name != wanted.name()) continue;
    found = true;
    FireOne(cue, cue.performer, reply);
  }
  if (found) return;
  std::string reason = "no cue \"" + Printable(wanted.name(), kShown) + "\"; the cues are";
  for (const Cue& cue : roster_.config().cues) reason += " " + cue.name;
  Refuse(reply, v1::CODE_UNKNOWN_CUE,
         roster_.config().cues.empty() ? "no cues are configured" : reason);
}

bool Commands::Pass(Performer& performer, const Timecode& timecode, std::string& said) {
  const std::int64_t now = TimecodeLabel(timecode);
  const auto last = std::exchange(performer.timecode, now);
  if (!last || *last == now) return false;
  for (const Cue& cue : roster_.config().cues) {
    if (!cue.at || !Passes(*cue.at, *last, now)) continue;
    if (cue.performer != "*" && cue.performer != performer.profile.id) continue;
    v1::Reply reply;
    FireOne(cue, performer.profile.id, reply);
    said += (said.empty() ? "cue " : ", cue ") + cue.name;
    if (reply.code() != v1::CODE_OK) said += " (" + reply.reason() + ")";
  }
  return !said.empty();
}

void Commands::Reset(const v1::Request& request, v1::Reply& reply) {
  if (request.performer() != "*") {
    const Profile* known = roster_.FindProfile(request.performer());
    if (known == nullptr || !known->seen) {
      return Refuse(
          reply, v1::CODE_UNKNOWN_PERFORMER,
          "performer \"" + Printable(request.performer(), kShown) + "\" was not seen yet");
    }
  }
  const Targets targets = Find(request.performer(), reply);
  for (Profile* profile : targets.profiles) {
    if (Performer* live = roster_.LiveOf(*profile)) live->Restart();
    Applied(*profile, reply);
  }
}

}  // namespace styled::pipeline

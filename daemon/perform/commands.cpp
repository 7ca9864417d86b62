#include "daemon/perform/commands.h"

#include <algorithm>
#include <utility>

#include "daemon/looks/refusal.h"
#include "daemon/perform/terms.h"
#include "model/base/text.h"

namespace styled::pipeline {
namespace {

// Shown bytes of a name, in a reason. The text must be valid UTF-8; otherwise clients cannot parse
// the reply.
constexpr std::size_t kShown = 80;

}  // namespace

bool Commands::Apply(const v1::Request& request, v1::Reply& reply) {
  reply.set_id(request.id());
  Status status = Status::Ok();
  switch (request.command_case()) {
    case v1::Request::kList:
      List(reply);
      break;
    case v1::Request::kSet:
      status = Change(request.performer(), request.set(), "set", reply);
      break;
    case v1::Request::kPin:
      status = Pin(request, reply);
      break;
    case v1::Request::kPreset: {
      v1::Look change;
      change.set_preset(request.preset().name());
      if (request.preset().has_transition_ms()) {
        change.set_transition_ms(request.preset().transition_ms());
      }
      status = Change(request.performer(), std::move(change), "preset", reply);
      break;
    }
    case v1::Request::kPanic:
      Panic(reply);
      break;
    case v1::Request::kReset:
      status = Reset(request, reply);
      break;
    case v1::Request::kCue:
      status = Fire(request.cue(), reply);
      break;
    case v1::Request::kStatus:
      return false;
    case v1::Request::kCalibrate:  // handled by the pipeline
    case v1::Request::kTakeCheckpoint:
    case v1::Request::kRestoreCheckpoint:
    case v1::Request::kLead:
    case v1::Request::kExplain:
    case v1::Request::kLike:  // handled by the files thread
    case v1::Request::kPreview:
    case v1::Request::kExportStyle:
    case v1::Request::kImportStyle:
    case v1::Request::kRenameStyle:
    case v1::Request::kRemoveStyle:
    case v1::Request::COMMAND_NOT_SET:
      status = Refused(
          v1::CODE_UNKNOWN_COMMAND,
          "no command that this daemon knows; expected list, set, pin, preset, panic, reset, cue, "
          "calibrate, like, preview, export_style, import_style, rename_style, remove_style, "
          "take_checkpoint, restore_checkpoint, lead, explain or status");
  }
  FillReply(status, reply);
  return true;
}

void Commands::FollowStyles(const v1::Request& request, v1::Reply& reply) {
  const bool renamed = request.has_rename_style();
  if (!renamed && !request.has_remove_style()) return;
  const std::string& name = renamed ? request.rename_style().name() : request.remove_style().name();
  const std::string to = renamed ? request.rename_style().to() : "";
  const auto follow = [&](Profile& profile) {
    if (!ReplaceStyle(name, to, profile.look)) return;
    changed_ = true;
    if (profile.id != roster_.to_come.id) Applied(profile, roster_.LiveOf(profile), reply);
  };
  for (const auto& [id, profile] : roster_.profiles) follow(*profile);
  follow(roster_.to_come);
}

std::optional<v1::Request> SetThatShows(const v1::Request& like) {
  if (!like.has_like() || like.like().measure() || like.performer().empty()) return std::nullopt;
  v1::Request request;
  request.set_performer(like.performer());
  v1::Look& look = *request.mutable_set();
  auto& mix = *look.add_mix();
  mix.set_style(like.like().name());
  mix.set_weight(1);
  if (like.like().has_transition_ms()) look.set_transition_ms(like.like().transition_ms());
  return request;
}

void Commands::Show(const v1::Request& like, v1::Reply& reply) {
  auto request = SetThatShows(like);
  if (!request) return;
  const Status status =
      Change(request->performer(), std::move(*request->mutable_set()), "like", reply);
  if (!status.ok()) FillReply(status, reply);
}

Result<Commands::Targets> Commands::Find(const std::string& performer) {
  Targets targets;
  if (performer == "*") {
    targets.all = true;
    for (const auto& [id, profile] : roster_.profiles) targets.profiles.push_back(profile.get());
    return targets;
  }
  if (!config::IsPerformerId(performer)) {
    return Refused(v1::CODE_UNKNOWN_PERFORMER,
                   "performer \"" + Printable(performer, kShown) + "\": expected SOURCE.NAME or *");
  }
  if (!roster_.KnowsSource(performer.substr(0, performer.find('.')))) {
    std::string reason = "performer \"" + performer + "\": no such source; the sources are";
    for (const auto& name : roster_.source_names()) reason += " " + name;
    return Refused(v1::CODE_UNKNOWN_PERFORMER, std::move(reason));
  }
  Profile* profile = roster_.EnsureProfile(performer);
  if (profile == nullptr) {
    return Refused(v1::CODE_BUSY,
                   std::to_string(roster_.profiles.size()) +
                       " performers have settings already; clear settings that you no longer need");
  }
  targets.profiles.push_back(profile);
  return targets;
}

namespace {

void ListSliders(const net::StyleSpace& space, v1::ListReply& list) {
  for (const net::Slider& slider : space.sliders()) {
    v1::SliderInfo& info = *list.add_sliders();
    info.set_name(slider.name);
    info.set_title(slider.title);
    info.set_group(slider.group);
    info.set_unit(slider.unit);
    info.set_least(slider.least);
    info.set_most(slider.most);
    info.set_usual(slider.usual);
    info.set_what(slider.what);
  }
  for (const net::Preset& preset : space.presets()) {
    v1::DesignInfo& info = *list.add_designs();
    info.set_name(preset.name);
    for (const net::SliderValue& slider : preset.values) {
      (*info.mutable_sliders())[slider.name] = slider.value;
    }
  }
}

}  // namespace

void Commands::List(v1::Reply& reply) const {
  auto& list = *reply.mutable_list();
  const net::StyleSpace* const space = roster_.config().network->space();
  const auto& styles = roster_.config().network->model().styles;
  for (std::size_t i = 0; i < styles.size(); ++i) {
    if (styles[i].retired) continue;
    auto& info = *list.add_styles();
    info.set_name(styles[i].name);
    for (const auto& alias : styles[i].aliases) info.add_aliases(alias);
    info.set_neutral(i == 0);
    info.set_recognized(styles[i].recognized);
    info.set_recorded_s(styles[i].recorded_s);
    info.set_weak(net::IsWeak(styles[i]));
    info.set_model(styles[i].model);
    info.set_varies(styles[i].varies);
    info.set_designable(styles[i].designable);
    const bool own = static_cast<int>(i) < roster_.config().own_styles;
    const auto found = roster_.config().made.find(styles[i].name);
    const bool made = !own && found != roster_.config().made.end();
    if (made) {
      info.set_licence(found->second->licence);
    } else {
      FillTerms(styles[i], roster_.config().terms, info);
    }
    const int listed = list.styles_size() - 1;
    FillCommercialUse(listed > 0 ? &list.styles(listed - 1) : nullptr, info);
    if (!made) continue;
    info.set_made(true);
    info.set_source(found->second->source);
    info.set_nearest(found->second->nearest);
    info.set_distance(found->second->distance);
    for (const net::SliderValue& slider : found->second->sliders) {
      (*info.mutable_sliders())[slider.name] = slider.value;
    }
  }
  if (space != nullptr) ListSliders(*space, list);
  for (const net::Terms& terms : roster_.config().terms) FillTerms(terms, *list.add_terms());
  for (const Cue& cue : roster_.config().cues) {
    auto& info = *list.add_cues();
    info.set_name(cue.name);
    info.set_performer(cue.performer);
    if (cue.at) info.set_at(TimecodeText(*cue.at));
  }
  for (const auto& preset : roster_.config().presets) {
    auto& info = *list.add_presets();
    info.set_name(preset.name);
    *info.mutable_mix() = preset.look.mix();
  }
}

void Commands::Applied(const Profile& profile, const Performer* live, v1::Reply& reply) const {
  auto& applied = *reply.add_applied();
  applied.set_performer(profile.id);
  applied.set_first_sequence(profile.next_sequence);
  applied.set_absent(live == nullptr);
  applied.set_no_strength(profile.look.strength() == 0 && !profile.look.mix().empty());
  applied.set_not_varied(NotVaried(profile.look, roster_.config().network->model().styles));
}

Status Commands::ChangeLooks(const std::string& performer, const v1::Look& change,
                             v1::Reply& reply) {
  const net::Styles& styles = roster_.config().network->model().styles;
  const auto found = Find(performer);
  if (!found.ok()) return found.status();
  const Targets& targets = found.value();
  std::vector<std::pair<Profile*, v1::Look>> changed;
  // Checks the change of one profile; pinned profiles are skipped with "*".
  const auto add = [&](Profile& profile) {
    if (profile.pinned) {
      if (targets.all) return Status::Ok();
      return Refused(v1::CODE_PINNED, profile.id + " is pinned; unpin it first");
    }
    v1::Look look = profile.look;
    styled::Apply(change, look);
    std::vector<std::string> unknown;
    const auto error =
        stylist::Validate(Resolve(look, styles, unknown), static_cast<int>(styles.size()));
    if (error != stylist::SettingsError::kNone) {
      return Refused(v1::CODE_OUT_OF_RANGE, profile.id + ": " + Explain(error));
    }
    changed.emplace_back(&profile, std::move(look));
    return Status::Ok();
  };
  // With "*" a performer whose other settings do not allow the change keeps them, and stops none of
  // the others.
  Status first = Status::Ok();
  std::vector<v1::Applied> refused;
  const auto attempt = [&](Profile& profile) {
    Status status = add(profile);
    if (status.ok()) return;
    v1::Applied& entry = refused.emplace_back();
    entry.set_performer(profile.id);
    entry.set_refused(status.message());
    if (first.ok()) first = std::move(status);
  };
  for (Profile* profile : targets.profiles) attempt(*profile);
  if (targets.all) attempt(roster_.to_come);
  if (changed.empty() && !first.ok()) {
    if (!targets.all) roster_.DropUnused(*targets.profiles.front());
    return first;
  }
  for (v1::Applied& entry : refused) *reply.add_applied() = std::move(entry);
  for (auto& [profile, look] : changed) {
    profile->look = std::move(look);
    profile->configured = true;
    Performer* const live = roster_.LiveOf(*profile);
    if (live != nullptr) (void)live->ApplyLook(roster_.config());
    if (profile != &roster_.to_come) Applied(*profile, live, reply);
    if (!targets.all) roster_.NoteNamed(*profile);
  }
  changed_ = true;
  return Status::Ok();
}

Status Commands::FillPreset(v1::Look& change, const std::string& what) const {
  const auto& presets = roster_.config().presets;
  if (const config::Preset* const preset = FindPreset(change.preset(), presets)) {
    *change.mutable_mix() = preset->look.mix();
    return Status::Ok();
  }
  std::string reason =
      what + ": no preset \"" + Printable(change.preset(), kShown) + "\"; the presets are";
  for (const auto& known : presets) reason += " " + known.name;
  return Refused(v1::CODE_UNKNOWN_PRESET,
                 presets.empty() ? what + ": no presets are configured" : reason);
}

Status Commands::Change(const std::string& performer, v1::Look change, const std::string& what,
                        v1::Reply& reply) {
  // A complete look has an empty preset if its mix came from no preset; ignore it in a change.
  if (what == "set" && change.preset().empty()) change.clear_preset();
  const bool by_preset = change.has_preset();
  const int mixes = static_cast<int>(change.clear()) + static_cast<int>(change.mix_size() > 0) +
                    static_cast<int>(by_preset);
  if (mixes > 1) return Malformed(what + ": expected one of mix, preset and clear");
  if (const Status in_range = CheckLook(change); !in_range.ok()) {
    return Refused(v1::CODE_OUT_OF_RANGE, what + ": " + in_range.message());
  }
  if (by_preset) {
    if (Status status = FillPreset(change, what); !status.ok()) return status;
  }
  const Status named = ProperNames(roster_.config().network->model().styles, change);
  if (!named.ok()) return Refused(v1::CODE_UNKNOWN_STYLE, what + ": " + named.message());
  Status status = ChangeLooks(performer, change, reply);
  if (change.clear() && status.ok()) ForgetMisnamed(performer);
  return status;
}

// Forgets a performer that was named by mistake or never arrived, so that it is not listed forever.
void Commands::ForgetMisnamed(const std::string& id) {
  Profile* const profile = roster_.FindProfile(id);
  if (profile == nullptr || profile->seen || profile->pinned || profile->rest ||
      !Equal(profile->look, roster_.to_come.look)) {
    return;
  }
  profile->configured = false;
  roster_.DropUnused(*profile);
}

Status Commands::Pin(const v1::Request& request, v1::Reply& reply) {
  const auto targets = Find(request.performer());
  if (!targets.ok()) return targets.status();
  for (Profile* profile : targets.value().profiles) {
    profile->pinned = request.pin().pinned();
    profile->configured = true;
    if (!targets.value().all) roster_.NoteNamed(*profile);
    changed_ = true;
    Applied(*profile, roster_.LiveOf(*profile), reply);
  }
  return Status::Ok();
}

void Commands::Panic(v1::Reply& reply) {
  v1::Look whole;
  whole.set_clear(true);
  whole.set_vary(0);
  whole.set_vary_each(false);
  whole.set_drift_s(0);
  whole.add_parts(v1::BODY_PART_ALL);
  const auto clear = [&](Profile& profile) {
    styled::Apply(whole, profile.look);
    if (profile.look.strength() == 0 || profile.look.strength() > 1) profile.look.set_strength(1);
    profile.configured = true;
    Performer* const live = roster_.LiveOf(profile);
    if (live != nullptr) (void)live->ApplyLook(roster_.config());
    return live;
  };
  for (const auto& [id, profile] : roster_.profiles) Applied(*profile, clear(*profile), reply);
  clear(roster_.to_come);
  changed_ = true;
}

Status Commands::FireOne(const Cue& cue, const std::string& performer, v1::Reply& reply) {
  v1::Request request = cue.request;
  request.set_performer(performer);
  v1::Reply one;
  (void)Apply(request, one);
  reply.mutable_applied()->MergeFrom(one.applied());
  if (one.code() == v1::CODE_OK) return Status::Ok();
  return Refused(one.code(), "cue " + cue.name + ": " + one.reason());
}

// All cues of the name are fired, those behind one that is refused, too.
Status Commands::Fire(const v1::Cue& wanted, v1::Reply& reply) {
  bool found = false;
  std::string pinned;
  Status first = Status::Ok();
  for (const Cue& cue : roster_.config().cues) {
    if (cue.name != wanted.name()) continue;
    found = true;
    Status status = FireOne(cue, cue.performer, reply);
    if (status.code() == int{v1::CODE_PINNED}) {
      pinned += (pinned.empty() ? "" : ", ") + cue.performer;
    } else if (first.ok()) {
      first = std::move(status);
    }
  }
  // A cue that changed no performer is not a success.
  if (!pinned.empty() && first.ok() && reply.applied().empty()) {
    return Refused(v1::CODE_PINNED,
                   "cue " + wanted.name() + ": " + pinned + ": pinned; unpin them first");
  }
  if (found) return first;
  std::string reason = "no cue \"" + Printable(wanted.name(), kShown) + "\"; the cues are";
  for (const Cue& cue : roster_.config().cues) reason += " " + cue.name;
  return Refused(v1::CODE_UNKNOWN_CUE,
                 roster_.config().cues.empty() ? "no cues are configured" : reason);
}

Commands::Cues Commands::FireCues(Performer& performer, const Timecode& timecode) {
  const std::int64_t now = TimecodeLabel(timecode);
  const auto last = std::exchange(performer.timecode, now);
  Cues cues;
  if (last == now) return cues;
  const auto append = [](std::string& text, const std::string& part) {
    text += (text.empty() ? "" : ", ") + part;
  };
  for (const Cue& cue : roster_.config().cues) {
    if (!cue.at || !Passes(*cue.at, last, now)) continue;
    if (cue.performer != "*" && cue.performer != performer.profile.id) continue;
    v1::Reply reply;
    const Status status = FireOne(cue, performer.profile.id, reply);
    if (status.ok()) {
      append(cues.fired, "cue " + cue.name);
    } else {
      append(cues.refused, status.message());  // names the cue and the performer
    }
  }
  return cues;
}

Status Commands::Reset(const v1::Request& request, v1::Reply& reply) {
  if (request.performer() != "*") {
    const Profile* known = roster_.FindProfile(request.performer());
    if (known == nullptr || !known->seen) {
      return Refused(
          v1::CODE_UNKNOWN_PERFORMER,
          "performer \"" + Printable(request.performer(), kShown) + "\" was not seen yet");
    }
  }
  const auto targets = Find(request.performer());
  if (!targets.ok()) return targets.status();
  for (Profile* profile : targets.value().profiles) {
    Performer* const live = roster_.LiveOf(*profile);
    if (live != nullptr) live->Restart();
    Applied(*profile, live, reply);
  }
  return Status::Ok();
}

}  // namespace styled::pipeline

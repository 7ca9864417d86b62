#include "daemon/perform/checkpoints.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "model/base/checkpoint_bytes.h"
#include "model/base/crc32c.h"
#include "model/base/text.h"
#include "proto/styled/look.h"

namespace styled::pipeline {
namespace {

constexpr std::uint32_t kCheckpointVersion = 3;  // 2: without posture; 1: without neutral
constexpr std::size_t kQuoted = 80;              // shown bytes of a name, in a reason
// Beyond any real number: at 120 Hz it is reached after a thousand million years. A larger number
// could wrap around, and subscribers would drop every frame as an old one.
constexpr std::uint64_t kMostSequence = std::uint64_t{1} << 62U;

// Appended to the state, so that a damaged file is detected.
std::array<std::byte, 4> Checksum(std::span<const std::byte> state) {
  return std::bit_cast<std::array<std::byte, 4>>(Crc32c(state));
}

void Deny(v1::Code code, std::string reason, v1::Reply& reply) {
  reply.set_code(code);
  reply.set_reason(std::move(reason));
}

v1::Checkpoint StateOf(Performer& performer, const RuntimeConfig& config, std::int64_t now_ns) {
  v1::Checkpoint checkpoint;
  checkpoint.set_version(kCheckpointVersion);
  checkpoint.set_performer(performer.profile.id);
  checkpoint.set_weights(config.weights_name);
  checkpoint.set_weights_crc(config.weights_crc);
  for (const auto& style : config.network->model().styles) checkpoint.add_styles(style.name);
  for (const auto& output : config.outputs) checkpoint.add_outputs(output->name);
  const Profile& profile = performer.profile;
  *checkpoint.mutable_look() = profile.look;
  checkpoint.set_pinned(profile.pinned);
  if (profile.rest) {
    v1::Rest& rest = *checkpoint.mutable_rest();
    const auto add = [](const rig::Quat& q, auto* to) {
      for (const float number : {q.x(), q.y(), q.z(), q.w()}) to->Add(number);
    };
    rest.set_skeleton(profile.rest->skeleton);
    rest.set_left_handed(profile.rest->left_handed);
    add(profile.rest->canonical_from_source, rest.mutable_canonical_from_source());
    for (const rig::Quat& rotation : profile.rest->rotations) {
      add(rotation, rest.mutable_rotations());
    }
  }
  *checkpoint.mutable_body() = performer.binding().given();
  checkpoint.set_body_crc(performer.binding().crc());
  checkpoint.set_sequence(profile.next_sequence);
  auto state = CheckpointBytes([&](Checkpoint& c) { performer.Carry(c, now_ns); });
  std::ranges::copy(Checksum(state), std::back_inserter(state));
  checkpoint.set_state(state.data(), state.size());
  return checkpoint;
}

// Compares the checkpoint's version, weights, styles and outputs with this daemon's. Returns the
// first difference, or "".
std::string WhatDiffers(const v1::Checkpoint& checkpoint, const RuntimeConfig& config) {
  if (checkpoint.version() != kCheckpointVersion) {
    return "version " + std::to_string(checkpoint.version()) + ", expected " +
           std::to_string(kCheckpointVersion);
  }
  if (checkpoint.weights_crc() != config.weights_crc) {
    return "it was made with the weights " + Printable(checkpoint.weights(), kQuoted) +
           ", expected the contents of " + config.weights_name;
  }
  const auto& styles = config.network->model().styles;
  const bool same_styles = std::equal(
      styles.begin(), styles.end(), checkpoint.styles().begin(), checkpoint.styles().end(),
      [](const net::StyleInfo& here, const std::string& there) { return here.name == there; });
  if (!same_styles) {
    return "it has " + std::to_string(checkpoint.styles_size()) + " styles, expected the " +
           std::to_string(styles.size()) +
           " of this daemon, by the same names: import the made styles";
  }
  const bool same_outputs =
      std::equal(config.outputs.begin(), config.outputs.end(), checkpoint.outputs().begin(),
                 checkpoint.outputs().end(),
                 [](const auto& here, const std::string& there) { return here->name == there; });
  if (!same_outputs) return "its [[output]] tables differ from this daemon's";
  return "";
}

// Checks sequence and checksum. Returns the error, or "".
std::string WhatIsBroken(const v1::Checkpoint& checkpoint) {
  if (checkpoint.sequence() == 0 || checkpoint.sequence() > kMostSequence) {
    return "its sequence is " + std::to_string(checkpoint.sequence()) + ", expected 1 to 2^62";
  }
  const auto state = std::as_bytes(std::span(checkpoint.state()));
  constexpr std::size_t kSum = sizeof(decltype(Checksum({})));
  if (state.size() < kSum ||
      !std::ranges::equal(Checksum(state.first(state.size() - kSum)), state.last(kSum))) {
    return "its state is damaged: the checksum at its end does not match";
  }
  return "";
}

// Reads the checkpoint's settings into a profile. Returns the error, or "".
std::string ReadSettings(const v1::Checkpoint& checkpoint, const RuntimeConfig& config,
                         Profile& profile) {
  v1::Look look = InitialLook();
  v1::Look change = checkpoint.look();
  std::string why = CheckLook(change);
  if (!why.empty() || !ProperNames(config.network->model().styles, change, why)) return why;
  change.clear_preset();
  styled::Apply(change, look);
  look.set_preset(checkpoint.look().preset());
  std::vector<std::string> unknown;
  const auto error = stylist::Validate(Resolve(look, config.network->model().styles, unknown),
                                       static_cast<int>(config.network->model().styles.size()));
  if (error != stylist::SettingsError::kNone) return Explain(error);
  profile.look = std::move(look);
  profile.pinned = checkpoint.pinned();
  profile.rest.reset();
  if (!checkpoint.has_rest()) return "";
  const v1::Rest& given = checkpoint.rest();
  const auto sound = [](float number) { return std::abs(number) <= 1.001F; };
  if (given.canonical_from_source_size() != 4 || given.rotations_size() % 4 != 0 ||
      !std::ranges::all_of(given.canonical_from_source(), sound) ||
      !std::ranges::all_of(given.rotations(), sound)) {
    return "its rest pose does not consist of rotations";
  }
  const auto read = [](const auto& numbers, int at) {
    return rig::Quat(numbers[at + 3], numbers[at], numbers[at + 1], numbers[at + 2]);
  };
  KeptRest& rest = profile.rest.emplace();
  rest.skeleton = given.skeleton();
  rest.left_handed = given.left_handed();
  rest.canonical_from_source = read(given.canonical_from_source(), 0);
  for (int i = 0; i < given.rotations_size(); i += 4) {
    rest.rotations.push_back(read(given.rotations(), i));
  }
  return "";
}

Status GiveState(const v1::Checkpoint& checkpoint, const RuntimeConfig& config, std::int64_t now_ns,
                 Performer& performer) {
  source::SourceFrame body;
  body.is_body = true;
  body.body = std::make_shared<const v1::Body>(checkpoint.body());
  body.body_crc = checkpoint.body_crc();
  if (Status status = performer.AcceptBody(body, config); !status.ok()) return status;
  auto state = std::as_bytes(std::span(checkpoint.state()));
  Checkpoint reader = Checkpoint::From(state.first(state.size() - Checksum({}).size()));
  performer.Carry(reader, now_ns);
  if (reader.complete()) return Status::Ok();
  return Status::Error(
      "its state does not fit: it was made with another [stylist], or with fingers of other "
      "sources");
}

}  // namespace

void TakeCheckpoint(const v1::Request& request, Roster& roster, std::int64_t now_ns,
                    std::int64_t wall_ns, v1::Reply& reply) {
  reply.set_id(request.id());
  Profile* const profile = roster.FindProfile(request.performer());
  Performer* const performer = profile == nullptr ? nullptr : roster.LiveOf(*profile);
  if (performer == nullptr) {
    return Deny(v1::CODE_UNKNOWN_PERFORMER,
                "performer \"" + Printable(request.performer(), kQuoted) +
                    "\": expected one that is present",
                reply);
  }
  if (!performer->binding().bound()) {
    return Deny(v1::CODE_NOT_READY,
                profile->id + ": no body is bound yet; expected a performer that is styled", reply);
  }
  v1::Checkpoint& checkpoint = *reply.mutable_checkpoint();
  checkpoint = StateOf(*performer, roster.config(), now_ns);
  checkpoint.set_epoch(roster.epoch());
  checkpoint.set_wall_time_ns(static_cast<std::uint64_t>(wall_ns));
}

Performer* RestoreCheckpoint(const v1::Request& request, Roster& roster, Layers& layers,
                             std::int64_t now_ns, v1::Reply& reply) {
  reply.set_id(request.id());
  const v1::Checkpoint& checkpoint = request.restore_checkpoint().checkpoint();
  const std::string& id =
      request.performer().empty() ? checkpoint.performer() : request.performer();
  const auto refuse = [&](v1::Code code, std::string reason) -> Performer* {
    Deny(code, std::move(reason), reply);
    return nullptr;
  };
  const std::size_t dot = id.find('.');
  const auto& sources = roster.source_names();
  const auto source = std::ranges::find(sources, id.substr(0, dot));
  if (!config::IsPerformerId(id) || source == sources.end()) {
    return refuse(v1::CODE_UNKNOWN_PERFORMER,
                  "performer \"" + Printable(id, kQuoted) +
                      "\": expected SOURCE.NAME with a source of this daemon");
  }
  const RuntimeConfig& config = roster.config();
  if (const std::string why = WhatDiffers(checkpoint, config); !why.empty()) {
    return refuse(v1::CODE_MALFORMED, "checkpoint: " + why);
  }
  if (const std::string why = WhatIsBroken(checkpoint); !why.empty()) {
    return refuse(v1::CODE_MALFORMED, "checkpoint: " + why);
  }
  Profile settings;
  if (const std::string why = ReadSettings(checkpoint, config, settings); !why.empty()) {
    return refuse(v1::CODE_MALFORMED, "checkpoint: " + why);
  }
  const int index = static_cast<int>(source - sources.begin());
  Performer* performer = roster.Find(index, std::string_view(id).substr(dot + 1));
  const bool fresh = performer == nullptr;
  if (fresh) performer = roster.Add(index, std::string_view(id).substr(dot + 1), now_ns);
  if (performer == nullptr) {
    return refuse(v1::CODE_BUSY, "checkpoint: there are " +
                                     std::to_string(roster.performers.size()) +
                                     " performers already, expected room for one more");
  }
  if (fresh) performer->SetFingers(layers.FingersOf(id));
  Profile& profile = performer->profile;
  // The state is read into the performer itself, so after an error the state before must be
  // restored. A performer that waits for a calibration has no such state: it is forgotten, and
  // returns with its next body.
  std::optional<v1::Checkpoint> before;
  if (!fresh && performer->binding().bound()) before = StateOf(*performer, config, now_ns);
  const auto exchange = [&profile](Profile& other) {
    std::swap(profile.look, other.look);
    std::swap(profile.pinned, other.pinned);
    std::swap(profile.rest, other.rest);
  };
  exchange(settings);
  const Status status = GiveState(checkpoint, config, now_ns, *performer);
  if (!status.ok()) {
    exchange(settings);
    if (before) {
      (void)GiveState(*before, config, now_ns, *performer);
    } else {
      roster.Forget(*performer);
    }
    return refuse(v1::CODE_MALFORMED, "checkpoint: " + status.message());
  }
  profile.configured = true;
  // The number never decreases: subscribers drop frames with lower numbers as reordered ones.
  profile.next_sequence = std::max(profile.next_sequence, checkpoint.sequence());
  roster.NoteNamed(profile);
  auto& applied = *reply.add_applied();
  applied.set_performer(id);
  applied.set_first_sequence(profile.next_sequence);
  return performer;
}

}  // namespace styled::pipeline

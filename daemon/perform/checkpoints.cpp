#include "daemon/perform/checkpoints.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "daemon/looks/refusal.h"
#include "model/base/checkpoint_bytes.h"
#include "model/base/crc32c.h"
#include "model/base/text.h"
#include "proto/styled/look.h"

namespace styled::pipeline {
namespace {

constexpr std::uint32_t kCheckpointVersion = 4;  // without idle motion 3, posture 2, neutral 1
constexpr std::size_t kQuoted = 80;              // shown bytes of a name, in a reason
// Beyond any real number: at 120 Hz it is reached after a thousand million years. A larger number
// could wrap around, and subscribers would drop every frame as an old one.
constexpr std::uint64_t kMostSequence = std::uint64_t{1} << 62U;

// Appended to the state, so that a damaged file is detected.
std::array<std::byte, 4> Checksum(std::span<const std::byte> state) {
  return std::bit_cast<std::array<std::byte, 4>>(Crc32c(state));
}

Status Bad(const std::string& what) { return Malformed("checkpoint: " + what); }

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

// Compares the checkpoint's version, weights, styles and outputs with this daemon's.
Status CheckSame(const v1::Checkpoint& checkpoint, const RuntimeConfig& config) {
  if (checkpoint.version() != kCheckpointVersion) {
    return Bad("version " + std::to_string(checkpoint.version()) + ", expected " +
               std::to_string(kCheckpointVersion));
  }
  if (checkpoint.weights_crc() != config.weights_crc) {
    return Bad("it was made with the weights " + Printable(checkpoint.weights(), kQuoted) +
               ", expected the contents of " + config.weights_name);
  }
  const auto& styles = config.network->model().styles;
  const bool same_styles = std::equal(
      styles.begin(), styles.end(), checkpoint.styles().begin(), checkpoint.styles().end(),
      [](const net::StyleInfo& here, const std::string& there) { return here.name == there; });
  if (!same_styles) {
    return Bad("it has " + std::to_string(checkpoint.styles_size()) + " styles, expected the " +
               std::to_string(styles.size()) +
               " of this daemon, by the same names: import the made styles");
  }
  const bool same_outputs =
      std::equal(config.outputs.begin(), config.outputs.end(), checkpoint.outputs().begin(),
                 checkpoint.outputs().end(),
                 [](const auto& here, const std::string& there) { return here->name == there; });
  if (!same_outputs) return Bad("its [[output]] tables differ from this daemon's");
  return Status::Ok();
}

// Whether the checkpoint is whole.
Status CheckWhole(const v1::Checkpoint& checkpoint) {
  if (checkpoint.sequence() == 0 || checkpoint.sequence() > kMostSequence) {
    return Bad("its sequence is " + std::to_string(checkpoint.sequence()) + ", expected 1 to 2^62");
  }
  const auto state = std::as_bytes(std::span(checkpoint.state()));
  constexpr std::size_t kSum = sizeof(decltype(Checksum({})));
  if (state.size() < kSum ||
      !std::ranges::equal(Checksum(state.first(state.size() - kSum)), state.last(kSum))) {
    return Bad("its state is damaged: the checksum at its end does not match");
  }
  return Status::Ok();
}

// Puts the checkpoint's settings into a profile.
Status ReadSettings(const v1::Checkpoint& checkpoint, const RuntimeConfig& config,
                    Profile& profile) {
  v1::Look look = InitialLook();
  v1::Look change = checkpoint.look();
  if (Status status = CheckLook(change); !status.ok()) return Bad(status.message());
  const Status named = ProperNames(config.network->model().styles, change);
  if (!named.ok()) return Bad(named.message());
  change.clear_preset();
  styled::Apply(change, look);
  look.set_preset(checkpoint.look().preset());
  std::vector<std::string> unknown;
  const auto error = stylist::Validate(Resolve(look, config.network->model().styles, unknown),
                                       static_cast<int>(config.network->model().styles.size()));
  if (error != stylist::SettingsError::kNone) return Bad(Explain(error));
  profile.look = std::move(look);
  profile.pinned = checkpoint.pinned();
  profile.rest.reset();
  if (!checkpoint.has_rest()) return Status::Ok();
  const v1::Rest& given = checkpoint.rest();
  const auto sound = [](float number) { return std::abs(number) <= 1.001F; };
  if (given.canonical_from_source_size() != 4 || given.rotations_size() % 4 != 0 ||
      !std::ranges::all_of(given.canonical_from_source(), sound) ||
      !std::ranges::all_of(given.rotations(), sound)) {
    return Bad("its rest pose does not consist of rotations");
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
  return Status::Ok();
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

Result<v1::Checkpoint> TakeCheckpoint(const std::string& id, Roster& roster, std::int64_t now_ns,
                                      std::int64_t wall_ns) {
  Profile* const profile = roster.FindProfile(id);
  Performer* const performer = profile == nullptr ? nullptr : roster.LiveOf(*profile);
  if (performer == nullptr) {
    return Refused(v1::CODE_UNKNOWN_PERFORMER,
                   "performer \"" + Printable(id, kQuoted) + "\": expected one that is present");
  }
  if (!performer->binding().bound()) {
    return Refused(v1::CODE_NOT_READY,
                   profile->id + ": no body is bound yet; expected a performer that is styled");
  }
  v1::Checkpoint checkpoint = StateOf(*performer, roster.config(), now_ns);
  checkpoint.set_epoch(roster.epoch());
  checkpoint.set_wall_time_ns(static_cast<std::uint64_t>(wall_ns));
  return checkpoint;
}

Result<Performer*> RestoreCheckpoint(const std::string& to, const v1::Checkpoint& checkpoint,
                                     Roster& roster, Layers& layers, std::int64_t now_ns) {
  const std::string& id = to.empty() ? checkpoint.performer() : to;
  const std::size_t dot = id.find('.');
  const auto& sources = roster.source_names();
  const auto source = std::ranges::find(sources, id.substr(0, dot));
  if (!config::IsPerformerId(id) || source == sources.end()) {
    return Refused(v1::CODE_UNKNOWN_PERFORMER,
                   "performer \"" + Printable(id, kQuoted) +
                       "\": expected SOURCE.NAME with a source of this daemon");
  }
  const RuntimeConfig& config = roster.config();
  if (Status status = CheckSame(checkpoint, config); !status.ok()) return status;
  if (Status status = CheckWhole(checkpoint); !status.ok()) return status;
  Profile settings;
  if (Status status = ReadSettings(checkpoint, config, settings); !status.ok()) return status;
  const int index = static_cast<int>(source - sources.begin());
  Performer* performer = roster.Find(index, std::string_view(id).substr(dot + 1));
  const bool fresh = performer == nullptr;
  if (fresh) performer = roster.Add(index, std::string_view(id).substr(dot + 1), now_ns);
  if (performer == nullptr) {
    return Refused(v1::CODE_BUSY, "checkpoint: there are " +
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
    return Bad(status.message());
  }
  profile.configured = true;
  // The number never decreases: subscribers drop frames with lower numbers as reordered ones.
  profile.next_sequence = std::max(profile.next_sequence, checkpoint.sequence());
  roster.NoteNamed(profile);
  return performer;
}

}  // namespace styled::pipeline

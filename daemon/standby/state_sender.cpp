#include "daemon/standby/state_sender.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "daemon/log/recorder.h"
#include "daemon/looks/state_file.h"
#include "daemon/perform/checkpoints.h"
#include "daemon/standby/setup.h"
#include "daemon/styles/style_file.h"
#include "daemon/styles/style_list.h"

namespace styled::standby {
namespace {

using pipeline::Places;
using pipeline::Profile;

// Per part of the state. Each may contain the calibration of a rig with many joints, 10 kB of text.
constexpr std::size_t kSettingsPerPart = 16;

}  // namespace

void StateSender::AdvertiseSetup(const std::vector<config::Source>& sources) {
  source_settings_ = pipeline::SettingsOf(sources);
  AdvertiseSetup();
}

void StateSender::AdvertiseSetup() {
  standby_.SetSetup(pipeline::SetupOf(performance_.roster.config(), source_settings_));
}

void StateSender::Clear() {
  unsent_.clear();
  unsent_settings_.clear();
}

int StateSender::DoWork() {
  const int read = standby_.DoSubscriptions();
  if (!standby_.leads()) return read;
  if (!unsent_.empty()) {
    SendPart();
  } else if (standby_.PopAsked() || resend_) {
    SendBeginning();
  } else {
    return read;
  }
  standby_.Send(performance_.clock.Now_ns(), performance_.clock.Wall_ns());
  return read + 1;
}

void StateSender::SendBeginning() {
  v1::Beginning& beginning = *standby_.NewEntry().mutable_beginning();
  beginning.set_changed(std::exchange(resend_, false));
  standby_.SetEpoch(performance_.roster.epoch());
  if (performance_.roster.to_come.configured)
    unsent_settings_.push_back(performance_.roster.to_come.id);
  for (const auto& [id, profile] : performance_.roster.profiles) {
    if (profile->configured) unsent_settings_.push_back(id);
  }
  unsent_.push_back({Part::Kind::kSettings, {}});
  const pipeline::RuntimeConfig& config = performance_.roster.config();
  const Places places = PlacesOf(config);
  beginning.set_last_place(static_cast<std::uint32_t>(places.last));
  for (std::size_t i = 0; i < places.entries.size(); ++i) {
    const auto& [name, retired] = places.entries[i];
    beginning.add_places(name);
    if (!retired) {
      beginning.add_styles(name);
      unsent_.push_back({Part::Kind::kStyle, name});
      continue;
    }
    beginning.add_retired(static_cast<std::uint32_t>(i));
    if (!places.fading.contains(i) || !IsNamed(config.own_styles + static_cast<int>(i))) continue;
    beginning.add_fading(static_cast<std::uint32_t>(i));
    unsent_.push_back({Part::Kind::kFading, name, i});
  }
}

void StateSender::SendPart() {
  const Part part = std::move(unsent_.front());
  unsent_.pop_front();
  v1::Journal& entry = standby_.NewEntry();
  switch (part.kind) {
    case Part::Kind::kSettings:
      return FillSettings(*entry.mutable_settings());
    case Part::Kind::kStyle:
      return FillStyle(part.name, *entry.mutable_style());
    case Part::Kind::kFading:
      return FillFading(part, *entry.mutable_style());
    case Part::Kind::kCheckpoint:
      return FillCheckpoint(part.name, *entry.mutable_checkpoint());
  }
}

// The standby has the settings of performers that arrive after the last part.
void StateSender::FillSettings(v1::SettingsPart& part) {
  std::vector<Profile> profiles;
  while (!unsent_settings_.empty() && profiles.size() < kSettingsPerPart) {
    auto saved = performance_.roster.SavedOf(unsent_settings_.front());
    unsent_settings_.pop_front();
    if (saved) profiles.push_back(std::move(*saved));
  }
  part.set_text(FormatProfiles(profiles));
  part.set_last(unsent_settings_.empty());
  if (!part.last()) return unsent_.push_front({Part::Kind::kSettings, {}});
  unsent_.push_back({Part::Kind::kCheckpoint, kJournalSequences});
  part.add_performers(kJournalSequences);
  for (const auto& performer : performance_.roster.performers) {
    unsent_.push_back({Part::Kind::kCheckpoint, performer->profile.id});
    part.add_performers(performer->profile.id);
  }
}

void StateSender::FillStyle(const std::string& name, v1::StylePart& part) {
  part.set_name(name);
  const pipeline::RuntimeConfig& config = performance_.roster.config();
  const auto made = config.made.find(name);
  if (made != config.made.end()) part.set_file(FormatStyleFile(*made->second, config));
}

// A style that was replaced or removed, while performers still fade out of it.
void StateSender::FillFading(const Part& from, v1::StylePart& part) {
  part.set_name(from.name);
  part.set_fading(static_cast<std::uint32_t>(from.place));
  const pipeline::RuntimeConfig& config = performance_.roster.config();
  const auto found = config.retired.find(config.own_styles + static_cast<int>(from.place));
  if (found != config.retired.end()) part.set_file(FormatStyleFile(*found->second, config));
}

// Whether a performer's motion still refers to the style of this number.
bool StateSender::IsNamed(int style) const {
  return std::ranges::any_of(performance_.roster.performers,
                             [style](const auto& performer) { return performer->Names(style); });
}

void StateSender::FillCheckpoint(const std::string& id, v1::Checkpoint& checkpoint) {
  if (id == kJournalSequences) {
    checkpoint.set_sequence(performance_.roster.FirstSequence());
  } else {
    auto taken = TakeCheckpoint(id, performance_.roster, performance_.clock.Now_ns(),
                                performance_.clock.Wall_ns());
    // There is no checkpoint of a performer who is gone or not calibrated yet: the message then has
    // their name alone.
    if (taken.ok()) checkpoint.Swap(&taken.value());
  }
  checkpoint.set_performer(id);
}

bool StateSender::Sends() {
  if (!standby_.leads()) return false;
  if (standby_.wanted()) return true;
  standby_.SkipEntry();
  return false;
}

void StateSender::OnFrames(int source, std::span<const decide::FrameInTransit> frames,
                           std::int64_t receive_ns, std::int64_t wall_ns) {
  if (!Sends()) return;
  v1::Batch& batch = *standby_.NewEntry().mutable_batch();
  batch.set_source(static_cast<std::uint32_t>(source));
  batch.set_name(performance_.roster.source_names()[static_cast<std::size_t>(source)]);
  for (const decide::FrameInTransit& frame : frames) {
    if (!frame.decision.postponed) log::Write(frame, *batch.add_frames());
  }
  standby_.Send(receive_ns, wall_ns);
}

void StateSender::OnSilence(std::int64_t now_ns, const v1::Silence& silence) {
  if (!Sends()) return;
  *standby_.NewEntry().mutable_silence() = silence;
  standby_.Send(now_ns, performance_.clock.Wall_ns());
}

void StateSender::OnRequest(std::int64_t now_ns, const v1::Request& request,
                            const v1::Reply& reply) {
  const bool done = reply.code() == v1::CODE_OK || reply.has_like();  // the style is made
  if (!done || !log::Changes(request) || !Sends()) return;
  v1::Request& entry = *standby_.NewEntry().mutable_request();
  entry = request;
  // A made style is sent as a file, so that the standby does not make it again.
  const pipeline::RuntimeConfig& config = performance_.roster.config();
  const auto made = config.made.find(reply.like().name());
  if ((request.has_like() || request.has_import_style()) && made != config.made.end()) {
    entry.mutable_import_style()->set_file(FormatStyleFile(*made->second, config));
    entry.mutable_import_style()->set_replace(true);
    entry.mutable_import_style()->set_in_place(request.like().in_place() ||
                                               request.import_style().in_place());
  }
  standby_.Send(now_ns, performance_.clock.Wall_ns());
  const auto shows = pipeline::SetThatShows(request);
  if (!shows || reply.code() != v1::CODE_OK) return;
  *standby_.NewEntry().mutable_request() = *shows;
  standby_.Send(now_ns, performance_.clock.Wall_ns());
}

}  // namespace styled::standby

// What a leader with [standby] tells the other daemon (daemon/standby/README.md): what it handles,
// and on demand its state. The other one repeats it (following.cpp).
#include "daemon/looks/state_file.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/standby/setup.h"
#include "daemon/styles/style_file.h"
#include "daemon/styles/style_list.h"

namespace styled::pipeline {
namespace {

// In one part of the state. Each may have the calibration of a rig of many joints, 10 kB of text.
constexpr std::size_t kSettingsPerPart = 16;

}  // namespace

void Pipeline::TellSetup() {
  if (to_.standby != nullptr) to_.standby->SetSetup(SetupOf(roster_.config(), source_settings_));
}

// A part a turn, so that no frame waits for all of them. Who asks meanwhile waits for the end.
int Pipeline::SendState() {
  const int read = to_.standby->DoSubscriptions();
  if (!leads()) return read;
  if (!unsent_.empty()) {
    SendPart();
  } else if (to_.standby->PopAsked() || tells_all_) {
    SendBeginning();
  } else {
    return read;
  }
  to_.standby->Send(to_.clock.Now_ns(), to_.clock.Wall_ns());
  return read + 1;
}

void Pipeline::SendBeginning() {
  v1::Beginning& beginning = *to_.standby->NewEntry().mutable_beginning();
  beginning.set_changed(std::exchange(tells_all_, false));
  to_.standby->SetEpoch(roster_.epoch());
  if (roster_.to_come.configured) unsent_settings_.push_back(roster_.to_come.id);
  for (const auto& [id, profile] : roster_.profiles) {
    if (profile->configured) unsent_settings_.push_back(id);
  }
  unsent_.push_back({Part::Kind::kSettings, {}});
  const Places places = PlacesOf(roster_.config());
  beginning.set_last_place(static_cast<std::uint32_t>(places.last));
  for (std::size_t i = 0; i < places.entries.size(); ++i) {
    const auto& [name, retired] = places.entries[i];
    beginning.add_places(name);
    if (retired) {
      beginning.add_retired(static_cast<std::uint32_t>(i));
      if (!places.fading.contains(i) ||
          !IsNamed(roster_.config().own_styles + static_cast<int>(i))) {
        continue;
      }
      beginning.add_fading(static_cast<std::uint32_t>(i));
      unsent_.push_back({Part::Kind::kFading, name, i});
      continue;
    }
    beginning.add_styles(name);
    unsent_.push_back({Part::Kind::kStyle, name});
  }
}

void Pipeline::SendPart() {
  const Part part = std::move(unsent_.front());
  unsent_.pop_front();
  v1::Journal& entry = to_.standby->NewEntry();
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

// Performers who come behind the last part find their settings at the standby.
void Pipeline::FillSettings(v1::SettingsPart& part) {
  std::vector<Profile> profiles;
  while (!unsent_settings_.empty() && profiles.size() < kSettingsPerPart) {
    auto saved = roster_.SavedOf(unsent_settings_.front());
    unsent_settings_.pop_front();
    if (saved) profiles.push_back(std::move(*saved));
  }
  part.set_text(FormatProfiles(profiles));
  part.set_last(unsent_settings_.empty());
  if (!part.last()) return unsent_.push_front({Part::Kind::kSettings, {}});
  unsent_.push_back({Part::Kind::kCheckpoint, kJournalSequences});
  part.add_performers(kJournalSequences);
  for (const auto& performer : roster_.performers) {
    unsent_.push_back({Part::Kind::kCheckpoint, performer->profile.id});
    part.add_performers(performer->profile.id);
  }
}

void Pipeline::FillStyle(const std::string& name, v1::StylePart& part) {
  part.set_name(name);
  const auto made = roster_.config().made.find(name);
  if (made == roster_.config().made.end()) return;
  part.set_file(FormatStyleFile(*made->second, roster_.config()));
}

// A style that has another place by now, or none, and from which performers still fade out.
void Pipeline::FillFading(const Part& from, v1::StylePart& part) {
  part.set_name(from.name);
  part.set_fading(static_cast<std::uint32_t>(from.place));
  const auto found =
      roster_.config().retired.find(roster_.config().own_styles + static_cast<int>(from.place));
  if (found == roster_.config().retired.end()) return;
  part.set_file(FormatStyleFile(*found->second, roster_.config()));
}

// Whether somebody's motion names the style of this number.
bool Pipeline::IsNamed(int style) const {
  return std::ranges::any_of(roster_.performers,
                             [style](const auto& performer) { return performer->Names(style); });
}

void Pipeline::FillCheckpoint(const std::string& id, v1::Checkpoint& checkpoint) {
  if (id == kJournalSequences) {
    checkpoint.set_sequence(roster_.FirstSequence());
  } else {
    v1::Request request;
    request.set_performer(id);
    request.mutable_take_checkpoint();
    v1::Reply reply;
    Answer(request, reply);
    // There is no checkpoint of a performer who is gone or not calibrated yet: the message then has
    // their name alone.
    if (reply.code() == v1::CODE_OK) checkpoint.Swap(reply.mutable_checkpoint());
  }
  checkpoint.set_performer(id);
}

void Pipeline::JournalFrames(int source, std::span<const source::SourceFrame> frames) {
  if (to_.standby == nullptr || !to_.standby->leads()) return;
  if (!to_.standby->wanted()) return to_.standby->SkipEntry();
  v1::Batch& batch = *to_.standby->NewEntry().mutable_batch();
  batch.set_source(static_cast<std::uint32_t>(source));
  batch.set_name(roster_.source_names()[static_cast<std::size_t>(source)]);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (transit_[i].decision.postponed) continue;
    log::Write(transit_[i], *batch.add_frames());
  }
  to_.standby->Send(receive_ns_, wall_ns_);
}

void Pipeline::JournalSilence(std::int64_t now_ns) {
  if (silence_.stale().empty() && silence_.forgotten().empty()) return;
  if (!journals()) {
    silence_.Clear();
    return to_.standby->SkipEntry();
  }
  to_.standby->NewEntry().mutable_silence()->Swap(&silence_);
  silence_.Clear();
  to_.standby->Send(now_ns, to_.clock.Wall_ns());
}

void Pipeline::JournalRequest(const v1::Request& request, const v1::Reply& reply) {
  if (to_.standby == nullptr || !to_.standby->leads()) return;
  const bool done = reply.code() == v1::CODE_OK || reply.has_like();  // the style is made
  if (!done || !log::Changes(request)) return;
  if (!to_.standby->wanted()) return to_.standby->SkipEntry();
  v1::Request& entry = *to_.standby->NewEntry().mutable_request();
  entry = request;
  // A style that was made is handed over as it is, not made again.
  const std::string& name = reply.like().name();
  const auto made = roster_.config().made.find(name);
  if ((request.has_like() || request.has_import_style()) && made != roster_.config().made.end()) {
    entry.mutable_import_style()->set_file(FormatStyleFile(*made->second, roster_.config()));
    entry.mutable_import_style()->set_replace(true);
  }
  to_.standby->Send(to_.clock.Now_ns(), to_.clock.Wall_ns());
  const auto shows = SetThatShows(request);
  if (!shows || reply.code() != v1::CODE_OK) return;
  *to_.standby->NewEntry().mutable_request() = *shows;
  to_.standby->Send(to_.clock.Now_ns(), to_.clock.Wall_ns());
}

}  // namespace styled::pipeline

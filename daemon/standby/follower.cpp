#include "daemon/standby/follower.h"

#include <array>
#include <span>
#include <string>
#include <utility>

#include "daemon/log/entry.h"
#include "daemon/looks/state_file.h"
#include "daemon/perform/checkpoints.h"
#include "daemon/perform/requests.h"
#include "daemon/perform/silence.h"
#include "daemon/standby/state_sender.h"
#include "daemon/styles/style_requests.h"
#include "model/base/text.h"

namespace styled::standby {
namespace {

using pipeline::Performer;
using pipeline::Profile;

constexpr std::size_t kShownReason = 200;  // bytes of the leader's text in a log line
// Longest wait for a style. It takes 2 to 20 ms on the files thread, 400 ms on a slow disk. Entries
// that have waited longer are performed without the style, and the state is fetched again. A longer
// wait would let the standby lead with old poses, 0.35 s late (measured with 46 performers and a
// wait of 1 s).
constexpr std::int64_t kLongestStyle_ns = 500'000'000;

}  // namespace

void Follower::OnEntry(v1::Journal& entry, std::int64_t own_ns) {
  if (!awaits_style_ && waiting_.empty()) return Perform(entry, own_ns);
  waiting_.push_back({{}, own_ns, performance_.clock.Now_ns()});
  waiting_.back().entry.Swap(&entry);
}

int Follower::DoWaiting(int most) {
  const std::int64_t since_ns = waiting_.empty() ? awaits_since_ns_ : waiting_.front().read_ns;
  const bool waits = awaits_style_ || (!waiting_.empty() && standby_.whole());
  if (waits && performance_.clock.Now_ns() - since_ns >= kLongestStyle_ns) {
    standby_.Failed("styles change at the leader faster than this daemon can follow");
    styles_.FetchAfterwards();
    awaits_style_ = false;
  }
  int done = 0;
  for (; done < most && !awaits_style_ && !waiting_.empty(); ++done) PerformFirst();
  return done;
}

void Follower::PerformFirst() {
  const Waiting first = std::move(waiting_.front());
  waiting_.pop_front();
  Perform(first.entry, first.own_ns);
}

void Follower::EndWait() {
  while (!waiting_.empty()) PerformFirst();
  awaits_style_ = false;
}

void Follower::Clear() {
  waiting_.clear();
  awaits_style_ = false;
}

void Follower::Perform(const v1::Journal& entry, std::int64_t own_ns) {
  standby_.clock().Stand(own_ns, entry.wall_ns());
  switch (entry.what_case()) {
    case v1::Journal::kBeginning:
      OnBeginning(entry);
      break;
    case v1::Journal::kSettings:
      OnSettings(entry.settings());
      break;
    case v1::Journal::kStyle:
      if (standby_.fetches() && styles_.OnStyle(entry.style())) {
        standby_.StyleRestored(entry.style());
      }
      break;
    case v1::Journal::kCheckpoint:
      OnCheckpoint(entry.checkpoint());
      break;
    case v1::Journal::kBatch:
      OnBatch(entry.batch(), own_ns);
      break;
    case v1::Journal::kSilence:
      OnSilence(entry.silence(), own_ns);
      break;
    case v1::Journal::kRequest:
      OnRequest(entry.request());
      break;
    case v1::Journal::kTooLarge:
      standby_.Failed("the leader cannot send " + Printable(entry.too_large(), kShownReason));
      break;
    case v1::Journal::WHAT_NOT_SET:
      break;
  }
  standby_.clock().Run();
}

void Follower::OnBeginning(const v1::Journal& entry) {
  if (!standby_.Begin(entry)) return;
  styles_.OnBeginning(entry.beginning());
  performance_.roster.Clear(entry.epoch());
  standby_.configured.clear();
}

void Follower::OnSettings(const v1::SettingsPart& part) {
  if (!standby_.fetches()) return;
  auto kept = pipeline::ParseProfiles(part.text(), "the leader's settings");
  if (!kept.ok()) return standby_.Failed(kept.status().message());
  for (const Profile& profile : kept.value()) standby_.configured.insert(profile.id);
  performance_.roster.Restore(std::move(kept.value()));
  if (!part.last()) return;
  standby_.SettingsRestored(part);
  performance_.commands.MarkChanged();
}

void Follower::OnCheckpoint(const v1::Checkpoint& checkpoint) {
  if (!standby_.fetches()) return;
  const std::string& id = checkpoint.performer();
  if (id == kJournalSequences) performance_.roster.BeginSequencesAt(checkpoint.sequence());
  if (checkpoint.version() == 0) return standby_.Restored(id);
  const auto restored = RestoreCheckpoint("", checkpoint, performance_.roster, performance_.layers,
                                          performance_.clock.Now_ns());
  if (!restored.ok()) return standby_.Failed(restored.status().message());
  restored.value()->profile.configured = standby_.configured.contains(id);
  standby_.Restored(id);
}

void Follower::OnBatch(const v1::Batch& batch, std::int64_t own_ns) {
  const auto& names = performance_.roster.source_names();
  const auto count = static_cast<std::size_t>(batch.frames_size());
  if (batch.source() >= names.size() || names[batch.source()] != batch.name() ||
      count > source::kBatch) {
    return standby_.Failed("frames of source \"" + batch.name() + "\", number " +
                           std::to_string(batch.source()) +
                           "; expected the same [[source]] tables as the leader has");
  }
  std::array<source::SourceFrame, source::kBatch> given;
  std::array<decide::FrameInTransit, source::kBatch> leaders;
  for (std::size_t i = 0; i < count; ++i) {
    const v1::Handled& entry = batch.frames(static_cast<int>(i));
    if (!log::Read(entry, given[i], leaders[i])) return;
    if (entry.is_body() || leaders[i].decision.fate == v1::FATE_REFUSED) continue;
    standby_.last[batch.name() + "." + entry.performer()] = {
        given[i].machine,        given[i].session,  given[i].sequence,
        given[i].source_time_ns, PoseCrc(given[i]), own_ns};
  }
  const auto here = frames_.Process({.source = static_cast<int>(batch.source()),
                                     .frames = std::span(given).first(count),
                                     .leaders = std::span(leaders).first(count)});
  for (std::size_t i = 0; i < count; ++i) {
    if (leaders[i].decision.fate != v1::FATE_STYLED && here[i].decision.fate != v1::FATE_STYLED) {
      continue;
    }
    if (performance_.roster.Find(static_cast<int>(batch.source()), given[i].performer) == nullptr)
      continue;
    standby_.Compared(log::Compare(here[i], leaders[i]));
  }
}

void Follower::OnSilence(const v1::Silence& silence, std::int64_t own_ns) {
  PerformSilence(performance_, silence, own_ns);
  for (const std::string& id : silence.forgotten()) standby_.last.erase(id);
}

void Follower::OnRequest(const v1::Request& request) {
  if (pipeline::IsStyleRequest(request)) {
    awaits_style_ = standby_.whole();
    awaits_since_ns_ = standby_.clock().base().Now_ns();
    if (!awaits_style_) styles_.FetchAfterwards();
    return styles_.Follow(request);
  }
  v1::Reply reply;
  (void)PerformRequest(request, transports_, performance_, reply);
  if (reply.code() != v1::CODE_OK) {
    // While the state is being fetched, the performer's part may still be missing.
    if (!standby_.fetches()) standby_.Failed(reply.reason());
    return;
  }
  performance_.log.OnRequest(performance_.clock.Now_ns(), request, reply);
}

}  // namespace styled::standby

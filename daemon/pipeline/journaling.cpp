// What a leader with [standby] tells the other daemon (daemon/standby/README.md): what it handles,
// and on demand its state. The other one repeats it (following.cpp).
#include "daemon/pipeline/keeping.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/pipeline/style_file.h"

namespace styled::pipeline {

// A checkpoint a turn, so that no frame waits for all of them.
int Pipeline::SendState() {
  standby::Standby& standby = *to_.standby;
  const bool asked = standby.TakeAsked();
  if (!leads()) return 0;
  if (asked || std::exchange(tells_all_, false)) {
    const auto kept = roster_.Snapshot();
    v1::Beginning& beginning = *standby.NewEntry().mutable_beginning();
    beginning.set_settings(FormatProfiles(*kept));
    unsent_ = {kJournalSequences};
    beginning.add_performers(kJournalSequences);
    for (const auto& performer : roster_.performers) {
      unsent_.push_back(performer->profile.id);
      beginning.add_performers(performer->profile.id);
    }
    const auto& styles = roster_.config().network->model().styles;
    for (auto i = static_cast<std::size_t>(roster_.config().own_styles); i < styles.size(); ++i) {
      const auto made = roster_.config().made.find(styles[i].name);
      if (made == roster_.config().made.end()) continue;
      beginning.add_styles(FormatStyleFile(*made->second, roster_.config()));
    }
    standby.SetEpoch(roster_.epoch());
    standby.Send(to_.clock.Now_ns(), to_.clock.Wall_ns());
    return 1;
  }
  if (unsent_.empty()) return 0;
  v1::Request request;
  request.set_performer(unsent_.front());
  request.mutable_take_checkpoint();
  v1::Reply reply;
  if (unsent_.front() == kJournalSequences) {
    reply.set_code(v1::CODE_UNKNOWN_PERFORMER);
  } else {
    Answer(request, reply);
  }
  v1::Checkpoint& checkpoint = *standby.NewEntry().mutable_checkpoint();
  if (unsent_.front() == kJournalSequences) checkpoint.set_sequence(roster_.FirstSequence());
  // A performer who is gone, or waits for a calibration, has no checkpoint: the name alone is sent.
  if (reply.code() == v1::CODE_OK) checkpoint.Swap(reply.mutable_checkpoint());
  checkpoint.set_performer(unsent_.front());
  unsent_.pop_front();
  standby.Send(to_.clock.Now_ns(), to_.clock.Wall_ns());
  return 1;
}

void Pipeline::JournalFrames(int source, std::span<const source::SourceFrame> frames) {
  if (to_.standby == nullptr || !to_.standby->leads()) return;
  if (!to_.standby->wanted()) return to_.standby->SkipEntry();
  v1::Batch& batch = *to_.standby->NewEntry().mutable_batch();
  batch.set_source(static_cast<std::uint32_t>(source));
  batch.set_name(roster_.source_names()[static_cast<std::size_t>(source)]);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    standby::Write(frames[i], outcomes_[i], *batch.add_frames());
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
  if (!done || !record::Changes(request)) return;
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
}

}  // namespace styled::pipeline

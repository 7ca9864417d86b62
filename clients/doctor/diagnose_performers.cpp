// Checks each performer: whether arriving datagrams result in frames, and apparent errors of the
// rig.
#include <algorithm>
#include <cctype>
#include <string>

#include "clients/doctor/examination.h"
#include "proto/styled/explain.h"

namespace styled::doctor {
namespace {

constexpr RefusalReason kOtherReason{"", "the daemon refuses them",
                                     "look at the counters of stylectl status"};

const RefusalReason& ReasonOf(std::string_view counter) {
  const RefusalReason* const found = FindRefusalReason(counter);
  return found == nullptr ? kOtherReason : *found;
}

// As a sentence, with the command that tells of each frame.
std::string Sentence(std::string cure, const std::string& performer) {
  cure.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(cure.front())));
  return cure + ". stylectl explain " + performer + " tells of each frame.";
}

}  // namespace

// Frames are published without it; it is needed if machines must agree about the time.
void Examination::Clock() {
  if (!facts_.daemon_answers() || !facts_.daemon.after.stats().has_clock()) return;
  const v1::ClockState& clock = facts_.daemon.after.stats().clock();
  if (clock.locked()) return;
  const bool ptp = clock.source() == v1::ClockState::SOURCE_PTP;
  Report(Severity::kNote, Step::kDaemon, nullptr, "clock_free",
         ptp ? "The daemon's clock is not synchronized, although ptp4l answers there."
             : "The daemon's clock is not synchronized.",
         "The wall times of frames drift away from those of other machines; their order and the "
         "styling do not depend on it.",
         ptp ? "Run phc2sys: it sets the system's clock by ptp4l's."
             : "If machines must agree about the time: run chrony, or ptp4l and phc2sys.");
}

// Checks a pair: without this, a pair in which no daemon could take over would only be noticed
// during a show.
void Examination::Standby() {
  if (!facts_.daemon_answers() || !facts_.daemon.after.stats().has_standby()) return;
  const v1::StandbyState& standby = facts_.daemon.after.stats().standby();
  if (!standby.heard()) {
    Report(Severity::kWarning, Step::kDaemon, nullptr, "standby_alone",
           "The other daemon, " + standby.peer() + ", does not answer.",
           "It does not run, its [standby] address or peer is different, or a network or a key is "
           "between them. No daemon would take over if this one ended.",
           "Start it; stylectl status there and its log show what it receives.");
  }
  if (standby.role() == "following" && standby.heard() && !standby.ready()) {
    Report(Severity::kWarning, Step::kDaemon, nullptr, "standby_unready",
           "This standby would not continue like the leader: " + standby.why_not() + ".",
           "It needs the leader's weights, styles, outputs, sources and settings. Alone it leads "
           "anyway, with its own.",
           "Make the two configurations the same, and start this daemon again.");
  }
  StandbyLinks(standby);
  for (const auto& performer : standby.without_input()) {
    Report(Severity::kWarning, Step::kDaemon, nullptr, "standby_without_input",
           performer + ": their frames reach the leader, but not this standby.",
           "The rig sends to only one of the two machines.",
           "Let the rig send to both: with a second target, multicast, or a repeater.");
  }
}

// Problems of its pair that a leader detects, and messages from other programs that either of them
// receives.
void Examination::StandbyLinks(const v1::StandbyState& standby) {
  if (standby.role() == "leading" && standby.differs_size() > 0) {
    Report(Severity::kWarning, Step::kDaemon, nullptr, "standby_differs",
           "The standby has other settings: " + standby.differs(0) +
               (standby.differs_size() > 1 ? "; stylectl status lists more." : "."),
           "Poses would differ after a takeover.",
           "Make the two configurations the same, and start the standby again.");
  }
  if (standby.role() == "leading" && !standby.too_large().empty()) {
    Report(Severity::kWarning, Step::kDaemon, nullptr, "standby_too_large",
           "The standby cannot get " + standby.too_large() + ".",
           "It is larger than the limit of a journal message.",
           "Remove the style, or make the file smaller and import it again.");
  }
  if (standby.refused() > 0) {
    Report(Severity::kWarning, Step::kDaemon, nullptr, "standby_refused",
           std::to_string(standby.refused()) + " messages from " + standby.peer() +
               " were ignored; the last: " + standby.refused_why() + ".",
           "Another program may have that address, or a daemon of another version.",
           "Check what listens there; keys ([security]) admit only the other daemon.");
  }
}

void Examination::Performers() {
  if (!facts_.daemon_answers()) return;
  const auto& before = facts_.daemon.before.stats().performers();
  for (const auto& now : facts_.daemon.after.stats().performers()) {
    const auto then = std::ranges::find(before, now.performer(), &v1::PerformerStats::performer);
    const bool known = then != before.end();
    const std::uint64_t refused = now.refused() - (known ? then->refused() : 0);
    const std::uint64_t left = now.published() - (known ? then->published() : 0);
    if (!now.warning().empty()) {
      Report(Severity::kWarning, Step::kSkeleton, nullptr, "rig_warning",
             now.performer() + ": " + now.warning() + ".",
             "The daemon detects it in the rig's poses.",
             "Fix the rig as described; if it is intended acting, do nothing.");
    }
    if (refused == 0) continue;
    if (left > 0 && now.refused_as() == "pipeline.second_sender") {
      Report(Severity::kWarning, Step::kFrames, nullptr, "second_sender",
             now.performer() +
                 ": two senders send the same performer; the frames of the one leave, "
                 "the other's are refused.",
             std::to_string(refused) + " datagrams while we listened.",
             "Stop that sender, or give it another performer's name.");
      continue;
    }
    if (left > refused) continue;
    const RefusalReason& reason = ReasonOf(now.refused_as());
    Report(left == 0 ? Severity::kProblem : Severity::kWarning, Step::kFrames, nullptr,
           "performer_refused",
           now.performer() + ": " + std::to_string(refused) + " datagrams arrived and " +
               (left == 0 ? "no frame" : "only " + std::to_string(left) + " frames") +
               " left, because " + std::string(reason.why) + ".",
           (now.refused_as().empty() ? "Counted while we listened."
                                     : "Counted as " + now.refused_as() + " while we listened."),
           Sentence(CureText(reason, now.performer()), now.performer()));
  }
}

bool Examination::RefusesPerformers(const SourceFacts& source) const {
  return std::ranges::any_of(facts_.daemon.after.stats().performers(), [&](const auto& performer) {
    return performer.performer().starts_with(source.expected.name + ".") &&
           !performer.refused_as().empty() && !performer.live();
  });
}

}  // namespace styled::doctor

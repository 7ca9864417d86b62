// Counters of the daemon that grew and that no step has explained, and problems that only a state
// shows.
#include <algorithm>
#include <array>

#include "clients/doctor/counter_words.h"
#include "clients/doctor/examination.h"

namespace styled::doctor {
namespace {

// The cause that a finding about the bytes of a source explains; it names formats instead of
// counters.
constexpr std::array<std::string_view, 5> kOfFormats{"wrong_format", "damaged", "unusable_version",
                                                     "mixed_formats", "unknown_format"};
constexpr std::array<std::string_view, 10> kFormatCounters{
    "source.too_short",       "source.too_long",     "source.bad_magic",    "source.bad_version",
    "source.length_mismatch", "source.bad_checksum", "source.bad_reserved", "source.bad_kind",
    "source.no_session",      "source.malformed"};

bool Contains(auto&& range, std::string_view what) {
  return std::ranges::find(range, what) != std::ranges::end(range);
}

}  // namespace

// Frames that do not leave within a period of their rig, and styles that fade out because of it.
void Examination::Lateness() {
  const auto& before = facts_.daemon.before.stats().performers();
  std::string late, relieved;
  std::uint64_t over = 0, left = 0;
  for (const auto& now : facts_.daemon.after.stats().performers()) {
    const auto then = std::ranges::find(before, now.performer(), &v1::PerformerStats::performer);
    const v1::PerformerStats earlier = then == before.end() ? v1::PerformerStats() : *then;
    // Smaller than before: the daemon was restarted meanwhile.
    if (now.over_budget() < earlier.over_budget()) continue;
    const std::uint64_t grown = now.over_budget() - earlier.over_budget();
    over += grown;
    left += now.published() - earlier.published();
    if (grown > 0) {
      late += (late.empty() ? "" : ", ") + now.performer() + " " + std::to_string(grown);
    }
    if (now.overload_bypass()) relieved += (relieved.empty() ? "" : ", ") + now.performer();
  }
  if (!late.empty()) {
    // Up to one in a hundred is excluded from p99.
    Report(100 * over > left ? Severity::kWarning : Severity::kNote, Step::kFrames, nullptr,
           "over_budget",
           "Frames left later than a period of their rig after they arrived: " + late + " of " +
               std::to_string(left) + ".",
           "pipeline.over_budget_frames grew while we listened.",
           "Give the daemon a core and a priority: realtime.cpu, realtime.priority = 20; end other "
           "programs; stylectl status shows P99 and the slow stage.");
  }
  if (!relieved.empty()) {
    Report(Severity::kWarning, Step::kFrames, nullptr, "overload",
           "The machine is overloaded: the style of " + relieved + " is faded out.",
           "Otherwise frames of all performers would be late (pipeline.overload_bypassed_frames).",
           "Use fewer performers or a faster machine. realtime.relieve = false keeps styles on and "
           "frames late.");
  }
}

// A recording that is configured and not running.
void Examination::Recording() {
  const v1::StatusReply& now = facts_.daemon.after;
  const std::uint64_t lost = facts_.Grown("record.lost");
  if (lost == 0 && (ValueOf(now, "record.failures") == 0 || ValueOf(now, "record.on") != 0)) return;
  Report(Severity::kWarning, Step::kDaemon, nullptr, "recording_incomplete",
         lost > 0
             ? "The recording lacks " + std::to_string(lost) + " records of data that just arrived."
             : "Nothing is recorded, although [record] file is set.",
         "The disk is slow, full or gone, or less than record.min_free_mb is free on it; the "
         "daemon's log says which (record.lost, record.failures).",
         "Make room there, or restart the daemon with another record.file.");
}

void Examination::Counters() {
  if (!facts_.daemon_answers()) return;
  Lateness();
  Recording();
  const bool formats = std::ranges::any_of(
      findings_, [](const Finding& finding) { return Contains(kOfFormats, finding.code); });
  for (const v1::Counter& counter : facts_.daemon.after.stats().counters()) {
    const std::string& name = counter.name();
    const std::uint64_t grown = facts_.Grown(name);
    if (grown == 0 || (formats && Contains(kFormatCounters, name))) continue;
    const bool reported = std::ranges::any_of(findings_, [&](const Finding& finding) {
      return finding.why.find(name) != std::string::npos;
    });
    if (reported || (name == "source.kernel_dropped" && Reported("kernel_drops")) ||
        (name == "pipeline.second_sender" && Reported("second_sender"))) {
      continue;
    }
    const CounterWords words = WordsOf(name);
    if (!words.trouble) continue;
    Report(words.always ? Severity::kWarning : Severity::kNote, Step::kFrames, nullptr,
           "counter_grew", name + " grew by " + std::to_string(grown) + ": " + words.meaning + ".",
           words.always ? "It always has a cause to find."
                        : "Normal at a low rate, a problem when it grows steadily.",
           words.change + ".");
  }
}

bool Examination::Reported(std::string_view code) const {
  return std::ranges::any_of(findings_,
                             [code](const Finding& finding) { return finding.code == code; });
}

}  // namespace styled::doctor

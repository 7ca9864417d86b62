#include "daemon/perform/explain.h"

#include <algorithm>
#include <string>

#include "daemon/looks/refusal.h"
#include "model/base/text.h"
#include "proto/styled/explain.h"

namespace styled::pipeline {
namespace {

constexpr std::size_t kShownName = 80;       // shown bytes of a name, in a reason
constexpr std::size_t kShownPerformers = 5;  // named in a reason
// Limits a reply to a megabyte.
constexpr std::size_t kMostExplained = log::FrameHistory::kKept;

// Why a performer is unknown: those who are here, or the counters of the sources.
std::string WhyNobody(const Performance& performance) {
  using runtime::Counter;
  const auto count = [&](Counter counter) { return performance.counters.Get(counter); };
  if (count(Counter::kSourceReceived) == 0) {
    return "nothing arrived from any source yet: stylectl doctor finds the step that fails";
  }
  if (count(Counter::kPipelinePerformersRefused) > 0) {
    return "max_performers are here already, and another one was refused: raise it in [performers]";
  }
  const bool refused = count(Counter::kPipelineBodiesRefused) > 0;
  if (const auto here = performance.roster.Here(); !here.empty()) {
    std::string text = "no performer of this name is here; here: ";
    for (std::size_t i = 0; i < here.size() && i < kShownPerformers; ++i) {
      text += (i == 0 ? "" : ", ") + Printable(here[i], kShownName);
    }
    if (here.size() > kShownPerformers) {
      text += " and " + std::to_string(here.size() - kShownPerformers) + " more";
    }
    return text + (refused ? ". A skeleton was refused; the log says why" : "");
  }
  if (refused) return "a skeleton was refused; the log says why";
  if (count(Counter::kPipelineBeforeBody) > 0) {
    return "frames came without a skeleton: let the rig send it";
  }
  return "no performer of this name sends";
}

// The requested frames: [first, last).
struct Range {
  std::size_t first = 0, last = 0;
};

Range RangeOf(const v1::Explain& asked, const log::FrameHistory& history) {
  Range range{history.size(), history.size()};
  if (asked.sequence() != 0) {
    for (std::size_t i = 0; i < history.size(); ++i) {
      if (history.SequenceOf(i) == asked.sequence()) return {i, i + 1};
    }
  } else if (asked.after_ns() != 0) {
    while (range.first > 0 && history.ArrivalOf(range.first - 1) > asked.after_ns()) --range.first;
  } else {
    const std::size_t wanted = std::clamp<std::size_t>(asked.last(), 1, kMostExplained);
    range.first -= std::min(wanted, history.size());
  }
  return range;
}

std::string KeptText(const log::FrameHistory& history) {
  std::uint64_t least = 0, most = 0;
  for (std::size_t i = 0; i < history.size(); ++i) {
    const std::uint64_t sequence = history.SequenceOf(i);
    if (sequence == 0) continue;
    if (least == 0) least = sequence;
    most = sequence;
  }
  return least == 0 ? "none was published" : std::to_string(least) + " to " + std::to_string(most);
}

// The rig's name of a joint of the performer's skeleton.
std::string JointName(const Performer& performer, int joint) {
  if (!performer.binding().bound()) return "";
  const rig::Skeleton& skeleton = performer.binding().body().binding->skeleton();
  return joint < skeleton.joint_count() ? skeleton.names[static_cast<std::size_t>(joint)] : "";
}

}  // namespace

Status Explain(const std::string& id, const v1::Explain& which, const Performance& performance,
               v1::ExplainReply& reply) {
  const Profile* const profile = performance.roster.FindProfile(id);
  const Performer* const performer =
      profile == nullptr ? nullptr : performance.roster.LiveOf(*profile);
  if (performer == nullptr) {
    return Refused(v1::CODE_UNKNOWN_PERFORMER, "explain: performer \"" + Printable(id, kShownName) +
                                                   "\": " + WhyNobody(performance));
  }
  const log::FrameHistory& history = performer->history;
  const Range range = RangeOf(which, history);
  if (range.first == range.last && which.after_ns() == 0) {
    return Refused(v1::CODE_OUT_OF_RANGE,
                   "explain: sequence: found " + std::to_string(which.sequence()) +
                       ", expected a frame that is kept: " + KeptText(history));
  }
  reply.set_now_ns(performance.clock.Now_ns());
  for (std::size_t i = range.first; i < range.last; ++i) {
    v1::FrameFate& fate = *reply.add_frames();
    fate.set_performer(id);
    history.Fill(i, fate);
    fate.set_period_ms(static_cast<float>(performer->latency.rig.period_ns()) * 1e-6F);
    if (fate.held_joints() > 0) {
      fate.set_held_joint(JointName(*performer, history.FirstHeldJoint(i)));
    }
    fate.set_text(ExplainText(fate));
    fate.set_cause(CauseText(fate));
  }
  return Status::Ok();
}

}  // namespace styled::pipeline

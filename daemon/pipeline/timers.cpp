// The pipeline's work that depends on time: deadlines, silence, bodies, statistics.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "daemon/pipeline/pipeline.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;
using runtime::kSecond_ns;
using runtime::Nanoseconds;

constexpr int kNamed = 8;  // performers in one line of the log
constexpr std::int64_t kStaysWarm_ns = 2 * runtime::kMillisecond_ns;

}  // namespace

std::int64_t Pipeline::NextDeadline_ns() const {
  std::int64_t next_ns = stats_.due_ns();
  for (const auto& transport : transports_) {
    next_ns = std::min(next_ns, transport->NextDeadline_ns());
  }
  if (to_.standby != nullptr) next_ns = std::min(next_ns, to_.standby->NextDeadline_ns());
  if (!leads()) return next_ns;  // silence is the leader's decision
  for (const auto& performer : roster_.performers) {
    const auto& limits = roster_.config().performers;
    const std::int64_t silent_ns =
        performer->admission.live()
            ? performer->admission.last_frame_ns() +
                  performer->admission.StaleAfter_ns(Nanoseconds(limits.stale_s))
            : performer->admission.session.last_arrival_ns() + Nanoseconds(limits.forget_s);
    next_ns = std::min({next_ns, performer->next_body_ns, silent_ns});
    if (to_.anticipate) next_ns = std::min(next_ns, Prepare_ns(*performer));
  }
  return next_ns;
}

// When to wake for a performer's next frame. Where caches are still warm it is not worth it: of 16
// performers a frame took 82 us of CPU instead of 51.
std::int64_t Pipeline::Prepare_ns(const Performer& performer) const {
  const std::int64_t prepare_ns = performer.admission.anticipation.prepare_ns();
  const bool warm = prepare_ns < receive_ns_ + kStaysWarm_ns;
  return warm && !to_.polls ? decide::Anticipation::kNever : prepare_ns;
}

bool Pipeline::Expects(std::int64_t now_ns) const {
  return to_.anticipate &&
         std::any_of(roster_.performers.begin(), roster_.performers.end(),
                     [now_ns](const auto& p) { return p->admission.anticipation.Expects(now_ns); });
}

// Prewarms only after a pause: while frames keep arriving the caches stay warm by themselves.
void Pipeline::Prepare(Performer& performer, std::int64_t now_ns) {
  if (!performer.admission.anticipation.Prepare(now_ns)) return;
  if (!to_.prewarm || now_ns - receive_ns_ < kStaysWarm_ns) return;
  performer.Prewarm();
  to_.counters.Add(Counter::kPipelinePrewarmed);
}

int Pipeline::DoTimers(std::int64_t now_ns, bool drained) {
  const auto& limits = roster_.config().performers;
  int work = 0;
  // A standby does it when the leader does.
  for (std::size_t i = leads() ? 0 : roster_.performers.size(); i < roster_.performers.size();) {
    Performer& performer = *roster_.performers[i++];
    const std::int64_t silence_ns = now_ns - performer.admission.session.last_arrival_ns();
    if (to_.anticipate && drained) Prepare(performer, now_ns);
    if (drained && performer.admission.live() &&
        now_ns - performer.admission.last_frame_ns() >=
            performer.admission.StaleAfter_ns(Nanoseconds(limits.stale_s))) {
      Stale(performer, now_ns);
      ++work;
    }
    if (performer.FacingChanged()) {
      const std::string warning = performer.Warning();
      log_.LogOf(LogLimit::Kind::kFacing, {}, performer.profile.id,
                 warning.empty() ? Event::Level::kInfo : Event::Level::kWarning,
                 warning.empty() ? "walks where the toes point again" : warning);
    }
    if (drained && !performer.admission.live() && silence_ns >= Nanoseconds(limits.forget_s)) {
      log_.LogOf(LogLimit::Kind::kForgotten, {}, performer.profile.id, Event::Level::kInfo,
                 "forgotten after silence");
      to_.counters.Add(Counter::kPipelineForgotten);
      if (to_.standby != nullptr) silence_.add_forgotten(performer.profile.id);
      roster_.Forget(performer);
      --i;
      ++work;
    } else if (now_ns >= performer.next_body_ns) {
      performer.next_body_ns = now_ns + kSecond_ns;
      performer.outputs.SendBodies(to_.publisher);
      ++work;
    }
  }
  JournalSilence(now_ns);
  work += LogLayers(now_ns);
  if (now_ns >= stats_.due_ns()) {
    LookAtWallClock();
    stats_.Publish();
    TellCalibrated();
    roster_.Age(now_ns);
    for (auto& text : roster_.PopLog()) log_.Log(Event::Level::kInfo, std::move(text));
    if (roster_.PopChanged()) commands_.MarkChanged();
    ++work;
  }
  return work;
}

// Calibrations of a neutral take seconds; their replies came at the beginning.
void Pipeline::TellCalibrated() {
  for (const auto& performer : roster_.performers) {
    if (!performer->PopNeutralCalibrated()) continue;
    commands_.MarkChanged();
    const bool done = performer->calibrated();
    log_.Log(done ? Event::Level::kInfo : Event::Level::kWarning,
             performer->profile.id +
                 (done ? ": their neutral is calibrated"
                       : ": hardly stood or walked, so their neutral is not calibrated; it goes on "
                         "being learned"));
  }
}

// Timecode and motion do not depend on it; what other machines make of the frames' wall times does.
void Pipeline::LookAtWallClock() {
  const std::int64_t step_ns = wall_watch_.Look(to_.clock);
  if (step_ns == 0) return;
  to_.counters.Add(Counter::kPipelineWallClockSteps);
  std::array<char, 64> by{};
  std::snprintf(by.data(), by.size(), "%+.3f", static_cast<double>(step_ns) * 1e-9);
  log_.Log(Event::Level::kWarning,
           std::string("the wall clock was set by ") + by.data() +
               " s, or the machine slept: the frames' wall times follow it");
}

// Who loses their style first: who shows least of it, before those who are pinned; of equals the
// one who came last. In the opposite order they get it back.
void Pipeline::BalanceLoad(std::int64_t now_ns) {
  if (!overload_.due(now_ns)) return;
  const auto share = [](const Performer& performer) {
    float sum = 0;
    for (const auto& entry : performer.profile.look.mix()) sum += entry.weight();
    return sum * performer.profile.look.strength();
  };
  const auto before = [&](const Performer& a, const Performer& b) {
    if (a.profile.pinned != b.profile.pinned) return b.profile.pinned;
    if (share(a) != share(b)) return share(a) < share(b);
    return a.added_ns > b.added_ns;
  };
  int styled = 0, relieved = 0;
  for (const auto& performer : roster_.performers) {
    if (performer->admission.live()) ++(performer->relieved() ? relieved : styled);
  }
  const int change = overload_.Decide(now_ns, styled, relieved);
  std::string names;
  for (int i = 0; i < std::abs(change); ++i) {
    Performer* next = nullptr;
    for (const auto& performer : roster_.performers) {
      if (!performer->admission.live() || performer->relieved() == (change > 0)) continue;
      const bool better =
          next == nullptr || (change > 0 ? before(*performer, *next) : before(*next, *performer));
      if (better) next = performer.get();
    }
    if (next == nullptr) break;
    next->Relieve(change > 0);
    if (i < kNamed) names += (names.empty() ? "" : ", ") + next->profile.id;
    if (i == kNamed) names += " and of others";
  }
  if (names.empty()) return;
  const long percent = std::lround(100 * overload_.load());
  log_.LogOf(LogLimit::Kind::kOverload, {}, "overload",
             change > 0 ? Event::Level::kWarning : Event::Level::kInfo,
             (change > 0 ? "frames leave too late at a load of " : "there is room at a load of ") +
                 std::to_string(percent) + " %: the style of " + names +
                 (change > 0 ? " fades out" : " comes back"));
}

// A phone or a glove that is switched off is seen nowhere else.
int Pipeline::LogLayers(std::int64_t now_ns) {
  int changes = 0;
  const auto log = [&](const Layer& layer, MergedPart& part, LogLimit::Kind kind, const char* comes,
                       const char* goes) {
    const int change = part.Change(now_ns);
    if (change == 0) return;
    ++changes;
    log_.LogOf(kind, {}, layer.into, change > 0 ? Event::Level::kInfo : Event::Level::kWarning,
               "source " + layer.source + (change > 0 ? comes : goes));
  };
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    Layer* const layer = layers_.Of(static_cast<int>(i));
    if (layer == nullptr) continue;
    if (layer->face) {
      log(*layer, *layer->face, LogLimit::Kind::kFace, " is the face",
          " is silent: the face has faded");
    }
    if (layer->fingers) {
      log(*layer, *layer->fingers, LogLimit::Kind::kFingers, " gives the fingers",
          " is silent: the fingers have turned back");
    }
  }
  return changes;
}

void Pipeline::Stale(Performer& performer, std::int64_t now_ns) {
  performer.admission.MarkStale();
  decide::FrameInTransit now;
  now.arrival_ns = now.receive_ns = performer.admission.last_frame_ns();
  now.publish_ns = now_ns;
  now.wall_ns = to_.clock.Wall_ns();
  if (!performer.Repeat(now)) return;
  performer.Send(to_.publisher, bundles_, now_ns);
  SendBundles();
  to_.counters.Add(Counter::kPipelineStale);
  if (to_.standby == nullptr || !leads()) return;
  auto& stale = *silence_.add_stale();
  stale.set_performer(performer.profile.id);
  stale.set_first_sequence(performer.profile.next_sequence - 1);
}

}  // namespace styled::pipeline

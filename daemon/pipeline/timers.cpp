#include "daemon/pipeline/timers.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <utility>

#include "daemon/perform/silence.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;
using runtime::kSecond_ns;
using runtime::Nanoseconds;

constexpr std::int64_t kStaysWarm_ns = 2 * runtime::kMillisecond_ns;
// Performers whose rigs are silent may not delay those whose rigs send, and each of their frames
// takes tens of microseconds of the pipeline's thread: at most this many between two looks at the
// sources, and one per kEachIdle_ns in the mean.
constexpr int kIdleFramesPerTurn = 8;
constexpr std::int64_t kEachIdle_ns = 150'000;

std::int64_t StaleAt_ns(const Performer& performer, const config::Performers& limits) {
  return performer.admission.last_frame_ns() +
         performer.admission.StaleAfter_ns(Nanoseconds(limits.stale_s));
}

std::int64_t ForgottenAt_ns(const Performer& performer, const config::Performers& limits) {
  return std::max(performer.admission.session.last_arrival_ns(), performer.refused_ns) +
         Nanoseconds(limits.forget_s);
}

}  // namespace

std::int64_t Timers::NextDeadline_ns(std::int64_t batch_ns) const {
  std::int64_t next_ns = stats_.due_ns();
  if (!dependencies_.decides_silence()) return next_ns;  // only the leader decides on silence
  const auto& limits = performance_.roster.config().performers;
  for (const auto& performer : performance_.roster.performers) {
    const std::int64_t silent_ns = performer->admission.live() ? StaleAt_ns(*performer, limits)
                                   : performer->idles()        ? performer->next_idle_ns
                                                               : ForgottenAt_ns(*performer, limits);
    next_ns = std::min({next_ns, performer->next_body_ns, silent_ns});
    if (dependencies_.anticipate) next_ns = std::min(next_ns, Prepare_ns(*performer, batch_ns));
  }
  return next_ns;
}

// When to wake for a performer's next frame. Not worthwhile while the caches are warm: with 16
// performers it raised the cost of a frame from 51 to 82 us of CPU.
std::int64_t Timers::Prepare_ns(const Performer& performer, std::int64_t batch_ns) const {
  const std::int64_t prepare_ns = performer.admission.anticipation.prepare_ns();
  const bool warm = prepare_ns < batch_ns + kStaysWarm_ns;
  return warm && !dependencies_.polls ? decide::Anticipation::kNever : prepare_ns;
}

bool Timers::Expects(std::int64_t now_ns) const {
  return dependencies_.anticipate &&
         std::ranges::any_of(performance_.roster.performers, [now_ns](const auto& p) {
           return p->admission.anticipation.Expects(now_ns);
         });
}

// Prewarms only after a pause, because frames in succession keep the caches warm.
void Timers::Prepare(Performer& performer, std::int64_t now_ns, std::int64_t batch_ns) {
  if (!performer.admission.anticipation.Prepare(now_ns)) return;
  if (!dependencies_.prewarm || now_ns - batch_ns < kStaysWarm_ns) return;
  performer.Prewarm();
  performance_.counters.Add(Counter::kPipelinePrewarmed);
}

int Timers::DoWork(std::int64_t now_ns, bool drained, std::int64_t batch_ns) {
  int work = 0;
  if (dependencies_
          .decides_silence()) {  // a standby does it when the journal says that the leader did
    auto& performers = performance_.roster.performers;
    for (std::size_t i = 0; i < performers.size();) {
      const std::size_t count = performers.size();
      if (dependencies_.anticipate && drained) Prepare(*performers[i], now_ns, batch_ns);
      work += DoPerformer(*performers[i], now_ns, drained);
      if (performers.size() == count) ++i;  // unless it was forgotten
    }
    work += IdleAll(now_ns);
    if (silence_.stale_size() + silence_.idle_size() + silence_.forgotten_size() > 0) {
      performance_.log.OnSilence(now_ns, silence_);
      silence_.Clear();
    }
  }
  work += LogLayers(now_ns);
  if (now_ns < stats_.due_ns()) return work;
  CheckWallClock();
  stats_.Publish();
  LogCalibrated();
  LogStray(now_ns);
  performance_.roster.Age(now_ns);
  for (auto& text : performance_.roster.PopLog())
    performance_.events.Log(Event::Level::kInfo, std::move(text));
  if (performance_.roster.PopChanged()) performance_.commands.MarkChanged();
  return work + 1;
}

int Timers::DoPerformer(Performer& performer, std::int64_t now_ns, bool drained) {
  const auto& limits = performance_.roster.config().performers;
  int work = 0;
  if (drained && performer.admission.live() && now_ns >= StaleAt_ns(performer, limits)) {
    ++work;
    if (SendStale(performance_, performer, now_ns)) {
      v1::Applied& stale = *silence_.add_stale();
      stale.set_performer(performer.profile.id);
      stale.set_first_sequence(performer.profile.next_sequence - 1);
    }
    performer.next_idle_ns = now_ns;
  }
  LogFacing(performer);
  if (drained && !performer.admission.live() && now_ns >= ForgottenAt_ns(performer, limits) &&
      !Stays(performer)) {
    performance_.events.LogOf(LogLimit::Kind::kForgotten, {}, performer.profile.id,
                              Event::Level::kInfo, "forgotten after silence");
    performance_.counters.Add(Counter::kPipelineForgotten);
    silence_.add_forgotten(performer.profile.id);
    performance_.roster.Forget(performer);
    return work + 1;
  }
  if (now_ns < performer.next_body_ns) return work;
  performer.next_body_ns = now_ns + kSecond_ns;
  performer.outputs.SendBodies(performance_.publisher);
  return work + 1;
}

// Sends the frames that are due of performers whose rigs are silent.
int Timers::IdleAll(std::int64_t now_ns) {
  const auto& performers = performance_.roster.performers;
  const auto idles = [](const auto& performer) {
    return !performer->admission.live() && performer->idles();
  };
  const auto idling = std::ranges::count_if(performers, idles);
  int sent = 0;
  for (std::size_t i = 0; idling > 0 && i < performers.size() && sent < kIdleFramesPerTurn; ++i) {
    const std::size_t place = (first_to_idle_ + i) % performers.size();
    Performer& performer = *performers[place];
    if (!idles(performers[place]) || now_ns < performer.next_idle_ns) continue;
    Idle(performer, now_ns, idling * kEachIdle_ns);
    if (++sent == kIdleFramesPerTurn) first_to_idle_ = place + 1;
  }
  return sent;
}

// The frames of a silent performer follow each other as those of the rig did, between 30 and 120 a
// second, or more slowly where many are silent.
void Timers::Idle(Performer& performer, std::int64_t now_ns, std::int64_t least_period_ns) {
  constexpr std::int64_t kShortest_ns = kSecond_ns / 120, kLongest_ns = kSecond_ns / 30;
  // Since the last frame; after a takeover that is not known.
  const std::int64_t since_ns =
      now_ns - std::max(performer.frame().arrival_ns, performer.admission.last_frame_ns());
  const std::int64_t elapsed_ns =
      performer.elapsed_ns() + std::clamp(since_ns, runtime::kMillisecond_ns, kSecond_ns);
  if (SendIdle(performance_, performer, elapsed_ns, now_ns)) {
    v1::IdleFrame& idle = *silence_.add_idle();
    idle.set_performer(performer.profile.id);
    idle.set_published(performer.profile.next_sequence - 1);
    idle.set_elapsed_ns(elapsed_ns);
  }
  const std::int64_t period_ns = std::max(
      std::clamp(performer.latency.rig.period_ns(), kShortest_ns, kLongest_ns), least_period_ns);
  performer.next_idle_ns = std::max(performer.next_idle_ns + period_ns, now_ns + period_ns / 2);
}

// A performer whose body moves by itself stays until another one needs the place.
bool Timers::Stays(const Performer& performer) const {
  const auto most =
      static_cast<std::size_t>(performance_.roster.config().performers.max_performers);
  return performer.idles() && performance_.roster.performers.size() < most;
}

void Timers::LogFacing(Performer& performer) {
  if (!performer.FacingChanged()) return;
  const std::string warning = performer.Warning();
  performance_.events.LogOf(LogLimit::Kind::kFacing, {}, performer.profile.id,
                            warning.empty() ? Event::Level::kInfo : Event::Level::kWarning,
                            warning.empty() ? "walks where the toes point again" : warning);
}

// Calibrations of a neutral take seconds; they were answered at their beginning.
void Timers::LogCalibrated() {
  for (const auto& performer : performance_.roster.performers) {
    if (!performer->PopNeutralCalibrated()) continue;
    performance_.commands.MarkChanged();
    const bool done = performer->calibrated();
    performance_.events.Log(
        done ? Event::Level::kInfo : Event::Level::kWarning,
        performer->profile.id +
            (done ? ": their neutral is calibrated"
                  : ": hardly stood or walked, so their neutral is not calibrated and "
                    "continues to be learned"));
  }
}

// A step of the wall clock does not affect timecode and motion, but other machines use the frames'
// wall times.
void Timers::CheckWallClock() {
  const std::int64_t step_ns = wall_watch_.Look(performance_.clock);
  if (step_ns == 0) return;
  performance_.counters.Add(Counter::kPipelineWallClockSteps);
  std::array<char, 64> by{};
  std::snprintf(by.data(), by.size(), "%+.3f", static_cast<double>(step_ns) * 1e-9);
  performance_.events.Log(Event::Level::kWarning,
                          std::string("the wall clock was set by ") + by.data() +
                              " s, or the machine slept: the frames' wall times follow it");
}

// Only this log line shows a phone or a glove that was switched off.
int Timers::LogLayers(std::int64_t now_ns) {
  int changes = 0;
  const auto log = [&](const Layer& layer, MergedPart& part, LogLimit::Kind kind, const char* comes,
                       const char* goes) {
    const int change = part.Change(now_ns);
    if (change == 0 || layer.into.empty()) return;  // LogStray has no performer for it
    ++changes;
    performance_.events.LogOf(kind, {}, layer.into,
                              change > 0 ? Event::Level::kInfo : Event::Level::kWarning,
                              "source " + layer.source + (change > 0 ? comes : goes));
  };
  for (std::size_t i = 0; i < performance_.layers.size(); ++i) {
    Layer* const layer = performance_.layers.Of(static_cast<int>(i));
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

// A phone whose face is shown on no performer looks as if it were broken.
void Timers::LogStray(std::int64_t now_ns) {
  stray_.resize(performance_.layers.size());
  for (std::size_t i = 0; i < stray_.size(); ++i) {
    std::string why;
    if (performance_.layers.Arrives(i, now_ns)) {
      why = performance_.layers.Stray(i, performance_.roster.Here(), now_ns);
    }
    if (why == stray_[i]) continue;
    if (!why.empty()) {
      const std::string& name = performance_.roster.source_names()[i];
      performance_.events.LogOf(LogLimit::Kind::kStray, {}, name, Event::Level::kWarning, why);
    }
    stray_[i] = std::move(why);
  }
}

}  // namespace styled::pipeline

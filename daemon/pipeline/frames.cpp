// A frame's path through the pipeline: the hot half of pipeline.h.
#include <algorithm>
#include <iterator>
#include <utility>

#include "daemon/pipeline/pipeline.h"

namespace styled::pipeline {
namespace {

using decide::Decision;
using decide::FrameInTransit;
using runtime::Counter;
using runtime::kSecond_ns;
using runtime::Nanoseconds;

constexpr std::int64_t kLongestPeriod_ns = kSecond_ns / 10;
// What binding bodies may take of a turn while somebody performs: half of a frame's period at 120
// Hz. One took 2.3 ms beside three builds.
constexpr std::int64_t kBindingBudget_ns = kSecond_ns / 240;
// Frames and bodies. 64 who begin at once are bound within 0.15 s, in which they send 576 frames at
// 60 Hz. What exceeds it is handled at once.
constexpr std::size_t kMostPutOff = 1024;

}  // namespace

void Pipeline::OnFrames(int source, std::span<const source::SourceFrame> frames,
                        bool more_waiting) {
  runtime::HotSection hot;
  receive_ns_ = to_.clock.Now_ns();
  wall_ns_ = to_.clock.Wall_ns();
  to_.counters.Add(Counter::kSourceReceived, frames.size());
  batch_ = {};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    transit_[i] = FrameInTransit();
    transit_[i].given = &frames[i];
    whose_[i] = nullptr;
  }
  if (Layer* const layer = layers_.Of(source)) {
    AcceptLayer(*layer, source, frames, hot);
    return JournalFrames(source, frames);
  }
  const std::int64_t elsewhere_ns = stages_.Elsewhere_ns();
  const std::int64_t styling_ns = stages_.Spent_ns(Stages::kStyle);
  // 1 Examine all frames, to find each performer's newest one.
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].is_body) whose_[i] = roster_.Find(source, frames[i].performer);
    NoteNewest(static_cast<int>(i));
  }
  // 2 Process them in order and send them. Frames of different performers are styled together.
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].is_body) {
      StyleAccepted(hot);
      transit_[i].decision.postponed = PutsOff(source, frames[i]);
      if (transit_[i].decision.postponed) continue;
      const std::int64_t begin_ns = to_.clock.Now_ns();
      AcceptBody(source, frames[i]);
      binding_ns_ += to_.clock.Now_ns() - begin_ns;
    } else {
      if (!put_off_.empty() && WaitsForBody(source, frames[i].performer)) {
        StyleAccepted(hot);
        transit_[i].decision.postponed = PutOffFrame(source, frames[i]);
        if (transit_[i].decision.postponed) continue;
      }
      hot.Enter();
      AcceptFrame(source, static_cast<int>(i), more_waiting, hot);
    }
  }
  StyleAccepted(hot);
  MeasureLatencies(source, frames, SendBundles());
  for (const auto& performer : roster_.performers) performer->newest_in_batch = -1;
  JournalFrames(source, frames);
  const std::int64_t batch_ns = to_.clock.Now_ns() - receive_ns_;
  batch_.busy_ns = batch_ns;
  batch_.styling_ns = stages_.Spent_ns(Stages::kStyle) - styling_ns;
  overload_.Add(batch_);
  // kTake gets the part of the batch's time that no other stage accounts for.
  stages_.Add(Stages::kTake, batch_ns - (stages_.Elsewhere_ns() - elsewhere_ns));
}

void Pipeline::AcceptLayer(Layer& layer, int source, std::span<const source::SourceFrame> frames,
                           runtime::HotSection& hot) {
  for (const source::SourceFrame& frame : frames) {
    if (frame.is_body) {
      hot.Leave();
      if (layer.fingers) AcceptLayerBody(*layer.fingers, source, frame);
      continue;
    }
    hot.Enter();
    const Counter why = layer.Take(frame, receive_ns_);
    if (why != MergedPart::kTaken) to_.counters.AddOf(source, why);
  }
  hot.Leave();
}

// A source without fingers says so once a body, not with every frame.
void Pipeline::AcceptLayerBody(FingerLayer& fingers, int source, const source::SourceFrame& body) {
  std::string why;
  const FingerLayer::Body became = fingers.Accept(body, receive_ns_, why);
  if (became == FingerLayer::Body::kNotNext) return to_.counters.AddOf(source, fingers.why());
  if (became != FingerLayer::Body::kRefused) return;
  to_.counters.AddOf(source, Counter::kPipelineBodiesRefused);
  log_.LogOf(LogLimit::Kind::kBodyRefused, body.machine,
             roster_.source_names()[static_cast<std::size_t>(source)], Event::Level::kWarning,
             "gives no fingers: " + why);
}

void Pipeline::NoteNewest(int index) noexcept {
  Performer* const performer = whose_[static_cast<std::size_t>(index)];
  if (performer == nullptr) return;
  const source::SourceFrame& frame = *transit_[static_cast<std::size_t>(index)].given;
  // A frame that will not be admitted must not count as newer than one that will.
  if (!performer->admission.session.Plausible(frame.machine, frame.session, frame.sequence,
                                              receive_ns_, rules_)) {
    return;
  }
  int& newest = performer->newest_in_batch;
  if (newest >= 0) {  // a later duplicate or old frame is not newer
    const source::SourceFrame& best = *transit_[static_cast<std::size_t>(newest)].given;
    if (best.session == frame.session && best.sequence >= frame.sequence) return;
  }
  newest = index;
}

void Pipeline::AcceptFrame(int source, int index, bool full, runtime::HotSection& hot) {
  const auto at = static_cast<std::size_t>(index);
  FrameInTransit& transit = transit_[at];
  const source::SourceFrame& frame = *transit.given;
  // A body earlier in the batch may have created the performer.
  if (whose_[at] == nullptr) whose_[at] = roster_.Find(source, frame.performer);
  if (whose_[at] == nullptr) {
    to_.counters.AddOf(source, Counter::kPipelineBeforeBody);
    return;
  }
  Performer& performer = *whose_[at];
  // A performer's second frame, or a full batch, ends the group that is styled together.
  const auto last = accepted_.begin() + static_cast<std::ptrdiff_t>(accepted_count_);
  if (accepted_count_ == accepted_.size() ||
      std::find(accepted_.begin(), last, &performer) != last) {
    StyleAccepted(hot);
    hot.Enter();
  }
  const std::int64_t before_ns = performer.admission.session.elapsed_ns();
  if (!Admit(performer, frame)) return;
  performer.admission.sends_frames = true;
  performer.latency.rig.NoteFrame(frame.sequence, performer.admission.session.elapsed_ns());

  const std::int64_t now_ns = to_.clock.Now_ns();
  const std::int64_t lateness_ns =
      performer.admission.schedule.Lateness_ns(performer.admission.session.elapsed_ns(), now_ns);
  AwaitNext(performer, before_ns);
  Decision& decision = transit.decision;
  decision.late = lateness_ns > Nanoseconds(roster_.config().performers.late_s);
  bool passed_over = PassOver(performer, index, full, lateness_ns);
  if (!decided_.empty()) {
    const Decision& leaders = decided_[at].decision;
    decision.late = leaders.late;
    passed_over = leaders.fate == v1::FATE_PASSED_OVER;
    // The pose of a performer who waits for a calibration is only remembered.
    if (leaders.fate == v1::FATE_REFUSED && !performer.binding().waits()) return;
    if (leaders.fate == v1::FATE_STYLED) {
      performer.profile.next_sequence = leaders.sequence;
      performer.Relieve(leaders.relieved);
    }
  }
  if (passed_over) {
    decision.fate = v1::FATE_PASSED_OVER;
    to_.counters.AddOf(source, Counter::kPipelineBacklogDropped);
    if (now_ns - ArrivalOf(frame) > performer.latency.rig.period_ns()) ++batch_.dropped;
    return;  // not a refusal: the newest frame is sent
  }
  if (frame.has_timecode && !roster_.config().cues.empty()) {
    PassCues(performer, frame.timecode, hot);
  }
  transit.source_sequence = frame.sequence;
  transit.source_time_ns = frame.source_time_ns;
  transit.has_timecode = frame.has_timecode;
  transit.timecode = frame.timecode;
  transit.elapsed_ns = performer.admission.session.elapsed_ns();
  transit.arrival_ns = ArrivalOf(frame);
  transit.receive_ns = receive_ns_;
  transit.wall_ns = wall_ns_ - (receive_ns_ - transit.arrival_ns);
  transit.flags = decision.late ? v1::FLAG_LATE : v1::FLAG_NONE;
  transit.face = layers_.FaceOf(performer.profile.id, frame.face, receive_ns_);
  const Counter why = performer.Accept(transit);
  if (why != Decision::kNoReason) {
    to_.counters.AddOf(source, why);
    performer.admission.MarkRefused(why);
    return;
  }
  decision.fate = v1::FATE_STYLED;
  decision.relieved = performer.relieved();
  if (decision.relieved) {
    performer.CountRelieved();
    to_.counters.AddOf(source, Counter::kPipelineOverloadBypassed);
  }
  accepted_items_[accepted_count_] = index;
  accepted_[accepted_count_++] = &performer;
  performer.admission.MarkLive(receive_ns_);
  to_.counters.Add(Counter::kPipelineFrames);
  if (decision.late) to_.counters.Add(Counter::kPipelineLate);
}

// Styles and sends the accepted frames. Leaves the hot section.
void Pipeline::StyleAccepted(runtime::HotSection& hot) {
  const auto batch = std::span(accepted_).first(accepted_count_);
  if (batch.empty()) return hot.Leave();
  accepted_count_ = 0;
  hot.Enter();
  const std::int64_t begin_ns = to_.clock.Now_ns();
  std::array<stylist::Stylist::Job, stylist::Stylist::kTogether> jobs;
  for (std::size_t i = 0; i < batch.size(); ++i) jobs[i] = batch[i]->Style();
  stylist::Stylist::ProcessTogether(std::span(jobs).first(batch.size()));
  const std::int64_t styled_ns = to_.clock.Now_ns();
  for (Performer* const performer : batch) performer->Attach();
  for (Performer* const performer : batch) ShareProps(*performer);
  for (Performer* const performer : batch) performer->Finish(styled_ns);
  if (!takes_.empty()) {
    for (const Performer* const performer : batch) takes_.OnFrame(*performer);
  }
  hot.Leave();
  const std::int64_t serialized_ns = to_.clock.Now_ns();
  std::int64_t sent_ns = serialized_ns;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    batch[i]->Send(to_.publisher, bundles_, sent_ns);
    sent_ns = to_.clock.Now_ns();
    FrameInTransit& transit = transit_[static_cast<std::size_t>(accepted_items_[i])];
    transit.sent_ns = sent_ns;
    transit.decision.sequence = batch[i]->frame().decision.sequence;
  }
  if (to_.standby != nullptr) {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const auto at = static_cast<std::size_t>(accepted_items_[i]);
      transit_[at].styled_crc = batch[i]->StyledCrc();
      const body::Pose* const pose = batch[i]->styled();
      if (pose == nullptr) continue;
      rounded_poses_[at] = log::Rounded(*pose);
      transit_[at].rounded_pose = std::as_bytes(std::span(&rounded_poses_[at], 1));
    }
  }
  stages_.AddFrames(batch.size());
  stages_.Add(Stages::kStyle, styled_ns - begin_ns);
  stages_.Add(Stages::kSerialize, serialized_ns - styled_ns);
  stages_.Add(Stages::kSend, sent_ns - serialized_ns);
}

// One message a cycle, for who shows the whole stage. Returns whether there was one.
bool Pipeline::SendBundles() noexcept {
  if (std::ranges::all_of(bundles_, &publish::Bundle::empty)) return false;
  const std::int64_t begin_ns = to_.clock.Now_ns();
  for (publish::Bundle& bundle : bundles_) bundle.Send(to_.publisher);
  stages_.Add(Stages::kSend, to_.clock.Now_ns() - begin_ns);
  return true;
}

// A frame has left when its last message has: with `bundled`, that of the whole batch. What a
// standby repeats leaves nowhere.
void Pipeline::MeasureLatencies(int source, std::span<const source::SourceFrame> frames,
                                bool bundled) noexcept {
  if (!leads()) return;
  const std::int64_t now_ns = to_.clock.Now_ns();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (transit_[i].sent_ns == 0) continue;
    // A new performer later in the batch has cleared the pointers.
    Performer* performer = whose_[i];
    if (performer == nullptr) performer = roster_.Find(source, frames[i].performer);
    if (performer == nullptr) continue;
    ++batch_.sent;
    const std::int64_t left_ns = bundled ? now_ns : transit_[i].sent_ns;
    if (!performer->latency.Add(left_ns - ArrivalOf(frames[i]))) continue;
    ++batch_.late;
    to_.counters.AddOf(source, Counter::kPipelineOverBudgetFrames);
  }
}

// A prop of the scene that one performer holds is not in the frames of the others: it would be
// there twice. It comes and goes where it is let go, and there it is in the same place for all.
void Pipeline::ShareProps(Performer& performer) noexcept {
  if (!performer.shares_props()) return;
  for (const auto& other : roster_.performers) {
    const bool together = other.get() != &performer && other->source == performer.source;
    if (together && other->admission.live()) performer.LeavePropsTo(*other);
  }
}

// The next frame is expected one period of the sender's clock later, if that period is plausible.
void Pipeline::AwaitNext(Performer& performer, std::int64_t before_ns) noexcept {
  const std::int64_t elapsed_ns = performer.admission.session.elapsed_ns();
  const std::int64_t period_ns = elapsed_ns - before_ns;
  const bool steady = period_ns > 0 && period_ns < kLongestPeriod_ns;
  performer.admission.anticipation.Await(
      steady ? performer.admission.schedule.Due_ns(elapsed_ns + period_ns)
             : decide::Anticipation::kNever);
}

// Most frames pass no cue and stay in the hot section.
void Pipeline::PassCues(Performer& performer, const Timecode& timecode, runtime::HotSection& hot) {
  const std::int64_t now = TimecodeLabel(timecode);
  const auto passed = [&](const Cue& cue) {
    return cue.at && Passes(*cue.at, performer.timecode, now);
  };
  const auto& cues = roster_.config().cues;
  if (std::none_of(cues.begin(), cues.end(), passed)) {
    performer.timecode = now;
    return;
  }
  StyleAccepted(hot);  // the frames before the cue
  std::string said;
  if (commands_.Pass(performer, timecode, said)) {
    to_.counters.Add(Counter::kPipelineCues);
    log_.LogOf(LogLimit::Kind::kCue, {}, performer.profile.id, Event::Level::kInfo,
               said + " from frame " + std::to_string(performer.profile.next_sequence));
  }
  hot.Enter();
}

bool Pipeline::Admit(Performer& performer, const source::SourceFrame& frame) noexcept {
  const auto count = [&](Counter counter) {
    to_.counters.AddOf(performer.source, counter);
    performer.admission.MarkRefused(counter);
    return false;
  };
  const std::uint64_t lost = performer.admission.session.lost();
  switch (performer.admission.session.Admit(frame.machine, frame.session, frame.sequence,
                                            receive_ns_, rules_)) {
    case decide::Session::Arrival::kDuplicate:
      return count(Counter::kPipelineDuplicate);
    case decide::Session::Arrival::kReordered:
      return count(Counter::kPipelineReordered);
    case decide::Session::Arrival::kSecondSender:
      return count(Counter::kPipelineSecondSender);
    case decide::Session::Arrival::kFarAhead:
      return count(Counter::kPipelineFarAhead);
    case decide::Session::Arrival::kNewSession:
      StartSession(performer);
      break;
    case decide::Session::Arrival::kRecounted:
      Recount(performer);
      break;
    case decide::Session::Arrival::kNext:
      break;
  }
  if (performer.admission.session.lost() > lost) {
    to_.counters.AddOf(performer.source, Counter::kPipelineLost,
                       performer.admission.session.lost() - lost);
  }
  // A session that has not sent its body may still refer to the last session's body.
  if (!performer.binding().has_body() ||
      (frame.body_crc == 0 && !performer.admission.session_has_body)) {
    return count(Counter::kPipelineBeforeBody);
  }
  if (frame.body_crc != 0 && frame.body_crc != performer.binding().crc()) {
    return count(performer.admission.session_has_body ? Counter::kPipelineWrongBody
                                                      : Counter::kPipelineBeforeBody);
  }
  switch (performer.admission.session.AdmitTime(frame.source_time_ns, rules_)) {
    case decide::Session::Time::kOld:
      return count(Counter::kPipelineOldTime);
    case decide::Session::Time::kJump:
      to_.counters.AddOf(performer.source, Counter::kPipelineClockJumps);
      StartSession(performer);
      performer.admission.session_has_body = true;  // the sender is the same
      break;
    case decide::Session::Time::kNext:
      break;
  }
  return true;
}

void Pipeline::StartSession(Performer& performer) noexcept {
  to_.counters.Add(Counter::kPipelineSessions);
  performer.admission.StartSession();
  performer.Restart();
}

// The sender is the same, and its body stays valid until it sends another.
void Pipeline::Recount(Performer& performer) noexcept {
  const bool had_body = performer.admission.session_has_body;
  StartSession(performer);
  performer.admission.session_has_body = had_body;
  to_.counters.AddOf(performer.source, Counter::kPipelineRecounts);
}

// Up to backlog_s all late frames are published; beyond that only the newest one. If the batch is
// full, the newest frame may still be waiting. Then only one frame per backlog_s is published, so
// that a machine that cannot keep up shows as much as it can.
bool Pipeline::PassOver(Performer& performer, int index, bool full,
                        std::int64_t lateness_ns) const noexcept {
  const std::int64_t backlog_ns = Nanoseconds(roster_.config().performers.backlog_s);
  if (lateness_ns <= backlog_ns || feeds_) return false;
  if (performer.newest_in_batch != index) return true;
  return full && receive_ns_ - performer.outputs.last_send_ns() < backlog_ns;
}

// Whether the body's binding waits for a later turn. It takes milliseconds: of many performers who
// begin at once, all in one turn would keep the frames of those who are live waiting. A standby
// binds when its leader did, and on a replay's clock nothing takes time.
bool Pipeline::PutsOff(int source, const source::SourceFrame& body) {
  if (!decided_.empty() || feeds_) return false;
  const Performer* const performer = roster_.Find(source, body.performer);
  const bool binds = performer == nullptr || !performer->binding().has_body() ||
                     body.body_crc != performer->binding().crc();
  if (!binds) return false;
  if (WaitsForBody(source, body.performer)) return PutOffFrame(source, body);
  const bool keeps_waiting = std::ranges::any_of(
      roster_.performers, [](const auto& other) { return other->admission.live(); });
  if (binding_ns_ <= kBindingBudget_ns || !keeps_waiting) return false;
  return PutOffFrame(source, body);
}

// A performer's frames come behind their body, and are not lost.
bool Pipeline::WaitsForBody(int source, std::string_view performer) const noexcept {
  return std::ranges::any_of(put_off_, [&](const auto& waiting) {
    return waiting->source == source && waiting->frame.performer == performer;
  });
}

bool Pipeline::PutOffFrame(int source, const source::SourceFrame& frame) {
  if (put_off_.size() >= kMostPutOff) return false;
  put_off_.push_back(std::make_unique<PutOff>());
  put_off_.back()->source = source;
  put_off_.back()->frame = put_off_.back()->memory.Keep(frame);
  return true;
}

int Pipeline::DoPutOff() {
  binding_ns_ = 0;
  if (put_off_.empty()) return 0;  // nearly always; even an empty deque allocates when it is made
  int work = 0;
  auto waiting = std::exchange(put_off_, {});
  for (; !waiting.empty() && binding_ns_ <= kBindingBudget_ns; ++work) {
    const std::unique_ptr<PutOff> next = std::move(waiting.front());
    waiting.pop_front();
    OnFrames(next->source, {&next->frame, 1}, false);
  }
  std::ranges::move(put_off_, std::back_inserter(waiting));
  put_off_ = std::move(waiting);
  return work;
}

void Pipeline::AcceptBody(int source, const source::SourceFrame& body) {
  Performer* performer = roster_.Find(source, body.performer);
  const bool fresh = performer == nullptr;
  if (fresh) {
    performer = roster_.Add(source, body.performer, receive_ns_);
    // Another performer may have been replaced, and its frames may still be in this batch.
    whose_.fill(nullptr);
  }
  if (performer == nullptr) {
    to_.counters.AddOf(source, Counter::kPipelinePerformersRefused);
    return;
  }
  if (fresh) performer->SetFingers(layers_.FingersOf(performer->profile.id));
  const std::uint64_t lost = performer->admission.session.lost();
  const auto arrival = performer->admission.session.Admit(body.machine, body.session, body.sequence,
                                                          receive_ns_, rules_);
  const auto refuse = [&](Counter why) {
    to_.counters.AddOf(source, why);
    performer->admission.MarkRefused(why);
  };
  if (performer->admission.session.lost() > lost) {
    to_.counters.AddOf(source, Counter::kPipelineLost, performer->admission.session.lost() - lost);
  }
  if (arrival == decide::Session::Arrival::kDuplicate) {
    return refuse(Counter::kPipelineDuplicate);
  }
  if (arrival == decide::Session::Arrival::kSecondSender)
    return refuse(Counter::kPipelineSecondSender);
  if (arrival == decide::Session::Arrival::kFarAhead) return refuse(Counter::kPipelineFarAhead);
  if (arrival == decide::Session::Arrival::kNewSession) StartSession(*performer);
  if (arrival == decide::Session::Arrival::kRecounted) Recount(*performer);
  // A session's first body is accepted even if frames overtook it.
  if (arrival == decide::Session::Arrival::kReordered && performer->admission.session_has_body) {
    return refuse(Counter::kPipelineReordered);
  }
  AdoptBody(*performer, body, fresh);
}

void Pipeline::AdoptBody(Performer& performer, const source::SourceFrame& body, bool fresh) {
  if (!performer.binding().has_body() || body.body_crc != performer.binding().crc()) {
    if (performer.binding().has_body() && !performer.admission.MayChangeBody(receive_ns_)) {
      to_.counters.AddOf(performer.source, Counter::kPipelineBodiesRefused);
      performer.admission.MarkRefused(Counter::kPipelineBodiesRefused);
      return log_.LogOf(
          LogLimit::Kind::kBodyRefused, body.machine, performer.profile.id, Event::Level::kWarning,
          "the body changes again and again, expected twice a second at most: the last "
          "one stays");
    }
    const Status status = performer.AcceptBody(body, roster_.config());
    if (!status.ok()) {
      to_.counters.AddOf(performer.source, Counter::kPipelineBodiesRefused);
      performer.admission.MarkRefused(Counter::kPipelineBodiesRefused);
      log_.LogOf(LogLimit::Kind::kBodyRefused, body.machine, performer.profile.id,
                 Event::Level::kWarning, status.message());
      performer.admission.session_has_body = performer.binding().waits();
      if (fresh && !performer.binding().waits()) roster_.Forget(performer);
      return;
    }
    if (!fresh) to_.counters.Add(Counter::kPipelineBodyChanges);
    const std::string hands = performer.HandsWithoutPlace();
    log_.LogOf(LogLimit::Kind::kBodyBound, body.machine, performer.profile.id,
               hands.empty() ? Event::Level::kInfo : Event::Level::kWarning,
               hands.empty() ? "body bound"
                             : "body bound; the merged fingers of the " + hands +
                                   " hand are not shown: the body lacks the hand, or has no room "
                                   "for more joints");
    performer.outputs.SendBodies(to_.publisher);
    performer.next_body_ns = receive_ns_ + kSecond_ns;
  }
  performer.admission.session_has_body = true;
  to_.counters.Add(Counter::kPipelineBodies);
}

}  // namespace styled::pipeline

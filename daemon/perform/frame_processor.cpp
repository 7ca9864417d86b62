#include "daemon/perform/frame_processor.h"

#include <algorithm>
#include <utility>

namespace styled::pipeline {

using decide::Decision;
using decide::FrameInTransit;
using runtime::Counter;
using runtime::kSecond_ns;

namespace {

constexpr std::size_t kTogether = stylist::Stylist::kTogether;
// Frames that one thread styles at least: two of v2 take some 40 us. Not picked by a figure yet.
constexpr std::size_t kFewest = 2;

}  // namespace

std::span<const FrameInTransit> FrameProcessor::Process(const Batch& batch) {
  runtime::HotSection hot;
  receive_ns_ = performance_.clock.Now_ns();
  wall_ns_ = performance_.clock.Wall_ns();
  performance_.counters.Add(Counter::kSourceReceived, batch.frames.size());
  load_ = {};
  const auto transit = std::span(transit_).first(batch.frames.size());
  for (std::size_t at = 0; at < transit.size(); ++at) {
    transit[at] = FrameInTransit();
    transit[at].given = &batch.frames[at];
    whose_[at] = nullptr;
  }
  if (Layer* const layer = performance_.layers.Of(batch.source)) {
    ProcessLayer(*layer, batch, hot);
    performance_.log.OnFrames(batch.source, transit, receive_ns_, wall_ns_);
    return transit;
  }
  const std::int64_t elsewhere_ns = performance_.stages.Elsewhere_ns();
  const std::int64_t styling_ns = performance_.stages.Spent_ns(Stages::kStyle);
  // 1 Find the newest frame of each performer: a backlog publishes only that one.
  for (std::size_t at = 0; at < transit.size(); ++at) NoteNewest(batch.source, at);
  // 2 Process frames and bodies in order, and send them. Frames of different performers are styled
  // together. A body ends the group, because binding it changes the performer and leaves the hot
  // section.
  for (std::size_t at = 0; at < transit.size(); ++at) {
    const source::SourceFrame& frame = batch.frames[at];
    const bool behind = !postponed_.empty() && postponed_.Has(batch.source, frame.performer);
    if (frame.is_body || behind) {
      StyleAccepted(hot);
      transit[at].decision.postponed = Postpones(batch, frame, behind);
      if (transit[at].decision.postponed) continue;
    }
    if (frame.is_body) {
      const std::int64_t begin_ns = performance_.clock.Now_ns();
      ProcessBody(batch.source, transit[at]);
      postponed_.Spend(performance_.clock.Now_ns() - begin_ns);
    } else {
      hot.Enter();
      ProcessFrame(batch, at, hot);
    }
  }
  StyleAccepted(hot);
  // 3 Send the bundles, measure latencies and log the fates.
  MeasureLatencies(batch, performance_.SendBundles());
  for (const auto& performer : performance_.roster.performers) performer->newest_in_batch = -1;
  performance_.log.OnFrames(batch.source, transit, receive_ns_, wall_ns_);
  load_.busy_ns = performance_.clock.Now_ns() - receive_ns_;
  load_.styling_ns = performance_.stages.Spent_ns(Stages::kStyle) - styling_ns;
  performance_.overload.Add(load_);
  // kTake gets the part of the batch's time that no other stage measures.
  performance_.stages.Add(Stages::kTake,
                          load_.busy_ns - (performance_.stages.Elsewhere_ns() - elsewhere_ns));
  return transit;
}

void FrameProcessor::ProcessLayer(Layer& layer, const Batch& batch, runtime::HotSection& hot) {
  for (const source::SourceFrame& frame : batch.frames) {
    if (frame.is_body) {
      hot.Leave();
      if (layer.fingers) AcceptLayerBody(*layer.fingers, batch.source, frame);
      continue;
    }
    hot.Enter();
    const Counter why = layer.Accept(frame, receive_ns_);
    if (why != MergedPart::kAccepted) performance_.counters.AddOf(batch.source, why);
  }
  hot.Leave();
}

// Reports a source without fingers once per body, not with every frame.
void FrameProcessor::AcceptLayerBody(FingerLayer& fingers, int source,
                                     const source::SourceFrame& body) {
  const auto accepted = fingers.AcceptBody(body, receive_ns_);
  if (accepted.ok()) {
    if (accepted.value() != FingerLayer::Body::kNotNext) return;
    return performance_.counters.AddOf(source, fingers.why());
  }
  performance_.counters.AddOf(source, Counter::kPipelineBodiesRefused);
  performance_.events.LogOf(LogLimit::Kind::kBodyRefused, body.machine,
                            performance_.roster.source_names()[static_cast<std::size_t>(source)],
                            Event::Level::kWarning,
                            "gives no fingers: " + accepted.status().message());
}

void FrameProcessor::NoteNewest(int source, std::size_t at) noexcept {
  const source::SourceFrame& frame = *transit_[at].given;
  if (frame.is_body) return;
  Performer* const performer = performance_.roster.Find(source, frame.performer);
  whose_[at] = performer;
  if (performer == nullptr) return;
  // A frame that will be refused must not replace the newest one.
  if (!performance_.decider.IsPlausible(performer->admission, frame, receive_ns_)) return;
  int& newest = performer->newest_in_batch;
  if (newest >= 0) {  // a later duplicate or old frame is not newer
    const source::SourceFrame& best = *transit_[static_cast<std::size_t>(newest)].given;
    if (best.session == frame.session && best.sequence >= frame.sequence) return;
  }
  newest = static_cast<int>(at);
}

// Whether a body waits for a later turn, or a frame that is `behind` a waiting body. On a standby
// no body waits: it binds when its leader did. On a replay's clock binding takes no time, so none
// waits there.
bool FrameProcessor::Postpones(const Batch& batch, const source::SourceFrame& frame, bool behind) {
  if (!frame.is_body) return postponed_.Add(batch.source, frame);
  if (batch.keep_all || !batch.leaders.empty()) return false;
  const Performer* const performer = performance_.roster.Find(batch.source, frame.performer);
  const bool binds = performer == nullptr || !performer->binding().has_body() ||
                     frame.body_crc != performer->binding().crc();
  if (!binds) return false;
  const bool keeps_waiting = std::ranges::any_of(
      performance_.roster.performers, [](const auto& other) { return other->admission.live(); });
  if (!behind && (!postponed_.spent() || !keeps_waiting)) return false;
  return postponed_.Add(batch.source, frame);
}

int FrameProcessor::DoPostponed() {
  postponed_.BeginTurn();
  // Returns early because even an empty deque allocates when it is made.
  if (postponed_.empty()) return 0;
  int work = 0;
  auto waiting = postponed_.Pop();
  for (; !waiting.empty() && !postponed_.spent(); ++work) {
    const std::unique_ptr<Postponed::Frame> next = std::move(waiting.front());
    waiting.pop_front();
    (void)Process({.source = next->source, .frames = {&next->frame, 1}});
  }
  postponed_.PutBack(std::move(waiting));
  return work;
}

void FrameProcessor::ProcessFrame(const Batch& batch, std::size_t at, runtime::HotSection& hot) {
  FrameInTransit& transit = transit_[at];
  const source::SourceFrame& frame = *transit.given;
  // A body earlier in the batch may have created the performer.
  if (whose_[at] == nullptr) whose_[at] = performance_.roster.Find(batch.source, frame.performer);
  if (whose_[at] == nullptr) {
    transit.decision.reason = Counter::kPipelineBeforeBody;
    return performance_.counters.AddOf(batch.source, transit.decision.reason);
  }
  Performer& performer = *whose_[at];
  // 1 Make room in the group that is styled together, which has one frame per performer: its second
  // frame needs the state after its first one.
  MakeWay(performer, hot);
  // 2 Decide the fate. Losses and restarts count even if the frame is refused, because they
  // describe the frames before it.
  Decision& decision = transit.decision;
  decision = Decide(batch, at, performer);
  CountArrival(performer, decision);
  FillFrame(performer, transit);
  const bool admitted =
      decision.reason == Decision::kNoReason || decision.fate == v1::FATE_PASSED_OVER;
  if (admitted) performer.latency.rig.NoteFrame(frame.sequence, transit.elapsed_ns);
  if (decision.fate == v1::FATE_PASSED_OVER) {
    performance_.counters.AddOf(batch.source, decision.reason);
    if (performance_.clock.Now_ns() - transit.arrival_ns > performer.latency.rig.period_ns()) {
      ++load_.dropped;
    }
    return performer.history.Add(transit);  // not a refusal: the newest frame is sent
  }
  if (decision.reason != Decision::kNoReason) return Refuse(performer, transit);
  // A standby drops a frame that the leader refused. Exception: a performer that waits for a
  // calibration, because Accept stores its pose, which the calibration needs.
  if (decision.fate == v1::FATE_REFUSED && !performer.binding().waits()) return;
  // A standby takes sequence and relief from the leader, so that its output has the same bits.
  if (decision.fate == v1::FATE_STYLED && !batch.leaders.empty()) {
    performer.profile.next_sequence = decision.sequence;
    performer.Relieve(decision.relieved);
  }
  // 3 Accept the pose. Cues come first, because they apply from this frame on. The face is a view,
  // which Accept copies.
  if (frame.has_timecode && !performance_.roster.config().cues.empty()) {
    PassCues(performer, frame.timecode, hot);
  }
  const bool alone = performance_.roster.performers.size() == 1;
  transit.face = performance_.layers.FaceOf(performer.profile.id, alone, frame.face, receive_ns_);
  decision.reason = performer.Accept(transit);
  if (decision.reason != Decision::kNoReason) {
    decision.fate = v1::FATE_REFUSED;
    return Refuse(performer, transit);
  }
  decision.fate = v1::FATE_STYLED;
  decision.relieved = performer.relieved();
  if (decision.relieved) {
    performer.CountRelieved();
    performance_.counters.AddOf(batch.source, Counter::kPipelineOverloadBypassed);
  }
  accepted_at_[accepted_count_] = at;
  accepted_[accepted_count_++] = &performer;
  performer.admission.MarkLive(receive_ns_);
  performance_.counters.Add(Counter::kPipelineFrames);
  if (decision.late) performance_.counters.Add(Counter::kPipelineLate);
}

// Styles the group if it is full or has a frame of this performer.
void FrameProcessor::MakeWay(const Performer& performer, runtime::HotSection& hot) {
  const auto group = std::span(accepted_).first(accepted_count_);
  if (group.size() < MostInGroup() && std::ranges::find(group, &performer) == group.end()) {
    return;
  }
  StyleAccepted(hot);
  hot.Enter();
}

Decision FrameProcessor::Decide(const Batch& batch, std::size_t at, Performer& performer) noexcept {
  const decide::Question question{.frame = *transit_[at].given,
                                  .has_body = performer.binding().has_body(),
                                  .body_crc = performer.binding().crc(),
                                  .receive_ns = receive_ns_,
                                  .now_ns = performance_.clock.Now_ns(),
                                  .newest = performer.newest_in_batch == static_cast<int>(at),
                                  .more_waiting = batch.more_waiting,
                                  .keep_all = batch.keep_all,
                                  .last_send_ns = performer.outputs.last_send_ns()};
  if (batch.leaders.empty()) return performance_.decider.OfFrame(performer.admission, question);
  return performance_.decider.OfFrame(performer.admission, question, batch.leaders[at].decision);
}

// Counts the losses and restarts that a datagram reveals, whatever its fate.
void FrameProcessor::CountArrival(Performer& performer, const Decision& decision) noexcept {
  if (decision.lost > 0) {
    performance_.counters.AddOf(performer.source, Counter::kPipelineLost, decision.lost);
  }
  if (decision.restart == v1::RESTART_NONE) return;
  if (decision.restart == v1::RESTART_CLOCK_JUMP) {
    performance_.counters.AddOf(performer.source, Counter::kPipelineClockJumps);
  }
  if (decision.restart == v1::RESTART_RECOUNT) {
    performance_.counters.AddOf(performer.source, Counter::kPipelineRecounts);
  }
  performance_.counters.Add(Counter::kPipelineSessions);
  performer.Restart();
}

void FrameProcessor::Refuse(Performer& performer, const FrameInTransit& transit) noexcept {
  performance_.counters.AddOf(performer.source, transit.decision.reason);
  performer.admission.MarkRefused(transit.decision.reason);
  performer.history.Add(transit);
}

void FrameProcessor::FillFrame(const Performer& performer, FrameInTransit& transit) const noexcept {
  const source::SourceFrame& frame = *transit.given;
  transit.source_sequence = frame.sequence;
  transit.source_time_ns = frame.source_time_ns;
  transit.has_timecode = frame.has_timecode;
  transit.timecode = frame.timecode;
  transit.elapsed_ns = performer.admission.session.elapsed_ns();
  transit.arrival_ns = ArrivalOf(frame);
  transit.receive_ns = receive_ns_;
  transit.wall_ns = wall_ns_ - (receive_ns_ - transit.arrival_ns);
  transit.flags = transit.decision.late ? v1::FLAG_LATE : v1::FLAG_NONE;
}

// Most frames fire no cue and stay in the hot section.
void FrameProcessor::PassCues(Performer& performer, const Timecode& timecode,
                              runtime::HotSection& hot) {
  const std::int64_t now = TimecodeLabel(timecode);
  const auto passed = [&](const Cue& cue) {
    return cue.at && Passes(*cue.at, performer.timecode, now);
  };
  const auto& cues = performance_.roster.config().cues;
  if (std::none_of(cues.begin(), cues.end(), passed)) {
    performer.timecode = now;
    return;
  }
  StyleAccepted(hot);  // the frames before the cue
  const Commands::Cues cues_passed = performance_.commands.FireCues(performer, timecode);
  if (!cues_passed.fired.empty()) {
    performance_.counters.Add(Counter::kPipelineCues);
    performance_.events.LogOf(
        LogLimit::Kind::kCue, {}, performer.profile.id, Event::Level::kInfo,
        cues_passed.fired + " from frame " + std::to_string(performer.profile.next_sequence));
  }
  if (!cues_passed.refused.empty()) {
    performance_.counters.Add(Counter::kPipelineCuesRefused);
    performance_.events.LogOf(LogLimit::Kind::kCueRefused, {}, performer.profile.id,
                              Event::Level::kWarning, "not changed by " + cues_passed.refused);
  }
  hot.Enter();
}

// The frames that are styled before any of them is sent.
std::size_t FrameProcessor::MostInGroup() const noexcept {
  return helpers_ == nullptr ? kTogether : source::kBatch;
}

// Calls work(from, to) for all of `count` frames, at most kTogether at a time. With helpers, for as
// many parts as there are threads, but of kFewest frames at least.
template <typename Work>
void FrameProcessor::Share(std::size_t count, const Work& work) noexcept {
  const std::size_t threads =
      helpers_ == nullptr ? 1 : static_cast<std::size_t>(helpers_->count()) + 1;
  const std::size_t each = std::clamp((count + threads - 1) / threads, kFewest, kTogether);
  const auto part = [&](int index) noexcept {
    const std::size_t from = static_cast<std::size_t>(index) * each;
    work(from, std::min(count, from + each));
  };
  const int parts = static_cast<int>((count + each - 1) / each);
  if (helpers_ == nullptr) {
    for (int index = 0; index < parts; ++index) part(index);
  } else {
    helpers_->Run(parts, [&](int index) noexcept {
      const runtime::HotSection hot;
      part(index);
    });
  }
}

// Styles and sends the group of accepted frames, and empties it. Leaves the hot section.
void FrameProcessor::StyleAccepted(runtime::HotSection& hot) {
  const auto group = std::span(accepted_).first(accepted_count_);
  if (group.empty()) return hot.Leave();
  accepted_count_ = 0;
  hot.Enter();
  const std::int64_t begin_ns = performance_.clock.Now_ns();
  Share(group.size(), [group](std::size_t from, std::size_t to) noexcept {
    std::array<stylist::Stylist::Job, kTogether> jobs;
    for (std::size_t i = from; i < to; ++i) jobs[i - from] = group[i]->Style();
    stylist::Stylist::ProcessTogether(std::span(jobs).first(to - from));
  });
  const std::int64_t styled_ns = performance_.clock.Now_ns();
  // A performer sees the props of those of its own sixteen as they are now, and of later ones as
  // they were, with helpers or without.
  for (auto rest = group; !rest.empty();) {
    const auto some = rest.first(std::min(rest.size(), kTogether));
    for (Performer* const performer : some) performer->Attach();
    for (Performer* const performer : some) ShareProps(*performer);
    rest = rest.subspan(some.size());
  }
  Share(group.size(), [group, styled_ns](std::size_t from, std::size_t to) noexcept {
    for (std::size_t i = from; i < to; ++i) group[i]->Finish(styled_ns);
  });
  if (!performance_.takes.empty()) {
    for (const Performer* const performer : group) performance_.takes.OnFrame(*performer);
  }
  hot.Leave();
  const std::int64_t serialized_ns = performance_.clock.Now_ns();
  std::int64_t sent_ns = serialized_ns;
  for (std::size_t i = 0; i < group.size(); ++i) {
    group[i]->Send(performance_.publisher, performance_.bundles, sent_ns);
    sent_ns = performance_.clock.Now_ns();
    // The performer's copy has the results, but not the views into this batch and the decision.
    FrameInTransit& transit = transit_[accepted_at_[i]];
    const source::SourceFrame* const given = transit.given;
    const bool relieved = transit.decision.relieved;
    transit = group[i]->frame();
    transit.given = given;
    transit.decision.fate = v1::FATE_STYLED;
    transit.decision.relieved = relieved;
    transit.sent_ns = sent_ns;
    group[i]->history.Add(transit);
  }
  if (logs_poses_) LogPoses(group);
  performance_.stages.AddFrames(group.size());
  performance_.stages.Add(Stages::kStyle, styled_ns - begin_ns);
  performance_.stages.Add(Stages::kSerialize, serialized_ns - styled_ns);
  performance_.stages.Add(Stages::kSend, sent_ns - serialized_ns);
}

void FrameProcessor::LogPoses(std::span<Performer* const> performers) {
  for (std::size_t i = 0; i < performers.size(); ++i) {
    const std::size_t at = accepted_at_[i];
    transit_[at].styled_crc = performers[i]->StyledCrc();
    const body::Pose* const pose = performers[i]->styled();
    if (pose == nullptr) continue;
    rounded_poses_[at] = log::Rounded(*pose);
    transit_[at].rounded_pose = std::as_bytes(std::span(&rounded_poses_[at], 1));
  }
}

// A prop of the scene that one performer holds is left out of the other performers' frames, so that
// it is not shown twice. It disappears and reappears where it is picked up and put down: there it
// is in the same place for all.
void FrameProcessor::ShareProps(Performer& performer) noexcept {
  if (!performer.shares_props()) return;
  for (const auto& other : performance_.roster.performers) {
    const bool together = other.get() != &performer && other->source == performer.source;
    if (together && other->admission.live()) performer.LeavePropsTo(*other);
  }
}

// A frame has left when its last message has: with `bundled`, the bundle of the whole batch. A
// standby sends nothing, so it measures nothing.
void FrameProcessor::MeasureLatencies(const Batch& batch, bool bundled) noexcept {
  if (!batch.leaders.empty()) return;
  const std::int64_t now_ns = performance_.clock.Now_ns();
  for (std::size_t at = 0; at < batch.frames.size(); ++at) {
    FrameInTransit& transit = transit_[at];
    if (transit.sent_ns == 0) continue;
    if (bundled) transit.sent_ns = now_ns;
    // A new performer later in the batch has cleared the pointers.
    Performer* performer = whose_[at];
    if (performer == nullptr) {
      performer = performance_.roster.Find(batch.source, batch.frames[at].performer);
    }
    if (performer == nullptr) continue;
    ++load_.sent;
    const std::int64_t latency_ns = transit.sent_ns - transit.arrival_ns;
    if (bundled) performer->history.NoteSent(transit.decision.sequence, latency_ns);
    if (!performer->latency.Add(latency_ns)) continue;
    ++load_.late;
    performance_.counters.AddOf(batch.source, Counter::kPipelineOverBudgetFrames);
  }
}

void FrameProcessor::ProcessBody(int source, FrameInTransit& transit) {
  const source::SourceFrame& body = *transit.given;
  Performer* performer = performance_.roster.Find(source, body.performer);
  const bool fresh = performer == nullptr;
  if (fresh) {
    performer = performance_.roster.Add(source, body.performer, receive_ns_);
    // Add may have replaced another performer that still has frames in this batch: look them all up
    // again.
    whose_.fill(nullptr);
  }
  if (performer == nullptr) {
    transit.decision.reason = Counter::kPipelinePerformersRefused;
    return performance_.counters.AddOf(source, transit.decision.reason);
  }
  if (fresh) performer->SetFingers(performance_.layers.FingersOf(performer->profile.id));
  if (body.refusal != nullptr) return RefuseBody(*performer, transit);
  transit.decision = performance_.decider.OfBody(performer->admission, body, receive_ns_);
  CountArrival(*performer, transit.decision);
  transit.source_sequence = body.sequence;
  transit.arrival_ns = ArrivalOf(body);
  if (transit.decision.reason != Decision::kNoReason) return Refuse(*performer, transit);
  performer->refusal = nullptr;
  AdoptBody(*performer, transit, fresh);
}

// The performer is listed while such bodies come; the log has the reason once. They are not
// admitted as datagrams of the performer, so that a sender of a whole body does not wait for their
// end.
void FrameProcessor::RefuseBody(Performer& performer, FrameInTransit& transit) {
  const source::SourceFrame& body = *transit.given;
  const bool live = performer.admission.live();
  transit.source_sequence = body.sequence;
  transit.arrival_ns = ArrivalOf(body);
  transit.decision.reason = live ? Counter::kPipelineSecondSender : Counter::kPipelineBodiesRefused;
  Refuse(performer, transit);
  if (live) return;
  performer.refused_ns = receive_ns_;
  const bool known = performer.refusal != nullptr && *performer.refusal == *body.refusal;
  performer.refusal = body.refusal;
  if (known) return;
  performance_.events.LogOf(LogLimit::Kind::kBodyRefused, body.machine, performer.profile.id,
                            Event::Level::kWarning, *body.refusal);
}

void FrameProcessor::AdoptBody(Performer& performer, FrameInTransit& transit, bool fresh) {
  const source::SourceFrame& body = *transit.given;
  const auto complain = [&](const std::string& why) {
    transit.decision.reason = Counter::kPipelineBodiesRefused;
    Refuse(performer, transit);
    performance_.events.LogOf(LogLimit::Kind::kBodyRefused, body.machine, performer.profile.id,
                              Event::Level::kWarning, why);
  };
  if (!performer.binding().has_body() || body.body_crc != performer.binding().crc()) {
    if (performer.binding().has_body() && !performer.admission.MayChangeBody(receive_ns_)) {
      return complain(
          "the body changes too often, expected at most twice a second: the last one stays");
    }
    const Status status = performer.AcceptBody(body, performance_.roster.config());
    if (!status.ok()) {
      complain(status.message());
      performer.admission.session_has_body = performer.binding().waits();
      if (fresh && !performer.binding().waits()) performance_.roster.Forget(performer);
      return;
    }
    if (!fresh) performance_.counters.Add(Counter::kPipelineBodyChanges);
    const std::string hands = performer.HandsWithoutPlace();
    performance_.events.LogOf(LogLimit::Kind::kBodyBound, body.machine, performer.profile.id,
                              hands.empty() ? Event::Level::kInfo : Event::Level::kWarning,
                              hands.empty()
                                  ? "body bound"
                                  : "body bound; the merged fingers of the " + hands +
                                        " hand are not shown: the body lacks the hand, or has no "
                                        "room for more joints");
    performer.outputs.SendBodies(performance_.publisher);
    performer.next_body_ns = receive_ns_ + kSecond_ns;
  }
  performer.admission.session_has_body = true;
  performance_.counters.Add(Counter::kPipelineBodies);
}

}  // namespace styled::pipeline

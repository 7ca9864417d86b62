#include "daemon/decide/decider.h"

#include "daemon/runtime/clock.h"

namespace styled::decide {
namespace {

using runtime::Counter;

constexpr std::int64_t kLongestPeriod_ns = runtime::kSecond_ns / 10;

Decision Refused(Decision decision, Counter reason) noexcept {
  decision.fate = v1::FATE_REFUSED;
  decision.reason = reason;
  return decision;
}

// The sender is the same, and its body stays valid until it sends another.
void StartWithBody(Admission& admission, bool has_body) noexcept {
  admission.StartSession();
  admission.session_has_body = has_body;
}

// What the session makes of a frame or body. `reason` is set if it is not the next one.
Decision Arrive(Admission& admission, const source::SourceFrame& frame, std::int64_t receive_ns,
                const SessionRules& rules) noexcept {
  Decision decision;
  const std::uint64_t lost = admission.session.lost();
  const Session::Arrival arrival =
      admission.session.Admit(frame.machine, frame.session, frame.sequence, receive_ns, rules);
  decision.lost = admission.session.lost() - lost;
  switch (arrival) {
    case Session::Arrival::kDuplicate:
      return Refused(decision, Counter::kPipelineDuplicate);
    case Session::Arrival::kReordered:
      return Refused(decision, Counter::kPipelineReordered);
    case Session::Arrival::kSecondSender:
      return Refused(decision, Counter::kPipelineSecondSender);
    case Session::Arrival::kFarAhead:
      return Refused(decision, Counter::kPipelineFarAhead);
    case Session::Arrival::kNewSession:
      decision.restart = v1::RESTART_SESSION;
      admission.StartSession();
      break;
    case Session::Arrival::kRecounted:
      decision.restart = v1::RESTART_RECOUNT;
      StartWithBody(admission, admission.session_has_body);
      break;
    case Session::Arrival::kNext:
      break;
  }
  return decision;
}

// The next frame is expected one period of the sender's clock later, if that period is plausible.
void AwaitNext(Admission& admission, std::int64_t before_ns) noexcept {
  const std::int64_t elapsed_ns = admission.session.elapsed_ns();
  const std::int64_t period_ns = elapsed_ns - before_ns;
  const bool steady = period_ns > 0 && period_ns < kLongestPeriod_ns;
  admission.anticipation.Await(steady ? admission.schedule.Due_ns(elapsed_ns + period_ns)
                                      : Anticipation::kNever);
}

}  // namespace

Decision Decider::Admit(Admission& admission, const Question& question) const noexcept {
  const source::SourceFrame& frame = question.frame;
  const std::int64_t before_ns = admission.session.elapsed_ns();
  Decision decision = Arrive(admission, frame, question.receive_ns, limits_.rules);
  if (decision.reason != Decision::kNoReason) return decision;
  // A session that has not sent its body may still refer to the last session's body.
  if (!question.has_body || (frame.body_crc == 0 && !admission.session_has_body)) {
    return Refused(decision, Counter::kPipelineBeforeBody);
  }
  if (frame.body_crc != 0 && frame.body_crc != question.body_crc) {
    return Refused(decision, admission.session_has_body ? Counter::kPipelineWrongBody
                                                        : Counter::kPipelineBeforeBody);
  }
  switch (admission.session.AdmitTime(frame.source_time_ns, limits_.rules)) {
    case Session::Time::kOld:
      return Refused(decision, Counter::kPipelineOldTime);
    case Session::Time::kJump:
      decision.restart = v1::RESTART_CLOCK_JUMP;
      StartWithBody(admission, true);
      break;
    case Session::Time::kNext:
      break;
  }
  admission.sends_frames = true;
  decision.lateness_ns =
      admission.schedule.Lateness_ns(admission.session.elapsed_ns(), question.now_ns);
  decision.late = decision.lateness_ns > limits_.late_ns;
  AwaitNext(admission, before_ns);
  decision.fate = v1::FATE_STYLED;
  return decision;
}

Decision Decider::OfFrame(Admission& admission, const Question& question) const noexcept {
  Decision decision = Admit(admission, question);
  if (decision.fate == v1::FATE_STYLED && PassOver(question, decision.lateness_ns)) {
    decision.fate = v1::FATE_PASSED_OVER;
    decision.reason = Counter::kPipelineBacklogDropped;
  }
  return decision;
}

Decision Decider::OfFrame(Admission& admission, const Question& question,
                          const Decision& leaders) const noexcept {
  Decision decision = Admit(admission, question);
  if (decision.fate != v1::FATE_STYLED) return decision;
  decision.fate = leaders.fate;
  decision.late = leaders.late;
  decision.relieved = leaders.relieved;
  decision.sequence = leaders.sequence;
  if (leaders.fate == v1::FATE_PASSED_OVER) decision.reason = Counter::kPipelineBacklogDropped;
  return decision;
}

Decision Decider::OfBody(Admission& admission, const source::SourceFrame& body,
                         std::int64_t receive_ns) const noexcept {
  Decision decision = Arrive(admission, body, receive_ns, limits_.rules);
  // A session's first body is accepted even if frames overtook it.
  if (decision.reason == Counter::kPipelineReordered && !admission.session_has_body) {
    decision.reason = Decision::kNoReason;
  }
  return decision;
}

bool Decider::IsPlausible(const Admission& admission, const source::SourceFrame& frame,
                          std::int64_t receive_ns) const noexcept {
  return admission.session.Plausible(frame.machine, frame.session, frame.sequence, receive_ns,
                                     limits_.rules);
}

// Up to backlog_ns all late frames are published; beyond that only the newest one. If the batch is
// full, the newest frame may still be waiting. Then only one frame per backlog_ns is published, so
// that a machine that cannot keep up shows as much as it can.
bool Decider::PassOver(const Question& question, std::int64_t lateness_ns) const noexcept {
  if (lateness_ns <= limits_.backlog_ns || question.keep_all) return false;
  if (!question.newest) return true;
  return question.more_waiting && question.receive_ns - question.last_send_ns < limits_.backlog_ns;
}

}  // namespace styled::decide

// The requests to QTM, and the handling of its answers.
#include <algorithm>
#include <array>

#include "daemon/runtime/clock.h"
#include "daemon/source/rigs/qtm.h"

namespace styled::source {
namespace {

using qtm::PacketType;
using runtime::Counter;
using runtime::kSecond_ns;

constexpr std::int64_t kAnswer_ns = 5 * kSecond_ns;  // QTM answers within milliseconds
constexpr std::int64_t kAgain_ns = 5 * kSecond_ns;   // requests whose failure an operator has to
                                                     // fix
// Pauses between readings of the skeletons: each reading that changes nothing doubles the pause.
constexpr std::int64_t kFirstPause_ns = kSecond_ns, kLongestPause_ns = 60 * kSecond_ns;
constexpr std::string_view kAllParameters = "GetParameters General 3D Skeleton";

}  // namespace

void Qtm::Connected(std::int64_t now_ns) {
  stage_ = Stage::kGreeting;
  minor_ = qtm::kNewestMinor;
  timecode_wanted_ = true;
  asked_.clear();
  fault_.clear();
  logged_.Forget(now_ns);
  frequency_hz_.reset();
  up_ = qtm::Axis::kZ;
  answer_ns_ = now_ns + kAnswer_ns;
  again_ns_ = reread_ns_ = silence_ns_ = kNever;
  no_measurement_ = silence_said_ = only_skeletons_ = false;
  reread_pause_ns_ = kFirstPause_ns;
}

void Qtm::Tick(std::int64_t now_ns, Outbox& out) {
  if (now_ns >= again_ns_) {
    again_ns_ = kNever;
    Enter(stage_, now_ns, out);
  }
  if (now_ns >= reread_ns_) RequestSkeletons(now_ns, out);
  if (now_ns >= silence_ns_) ReportNoFrame(out);
  if (now_ns < answer_ns_) return;
  answer_ns_ = kNever;
  out.LeaveHotSection();
  const std::string seconds = std::to_string(kAnswer_ns / kSecond_ns) + " s";
  fault_ = asked_.empty() ? "did not greet within " + seconds + ": is it QTM's port " +
                                std::to_string(qtm::kPort) + "?"
                          : "did not answer \"" + asked_ + "\" within " + seconds;
}

// Sends the stage's request.
void Qtm::Enter(Stage stage, std::int64_t now_ns, Outbox& out) {
  stage_ = stage;
  switch (stage) {
    case Stage::kGreeting:
      return;
    case Stage::kVersion:
      out.LeaveHotSection();
      return Ask("Version 1." + std::to_string(minor_), now_ns, out);
    case Stage::kGeneral:
      return Ask("GetParameters General", now_ns, out);
    case Stage::kSpace:
      return Ask("GetParameters 3D", now_ns, out);
    case Stage::kSkeletons:
      return RequestSkeletons(now_ns, out);
    case Stage::kStreaming:
      return StartStream(now_ns, out);
  }
}

void Qtm::Ask(std::string_view command, std::int64_t now_ns, Outbox& out) {
  out.LeaveHotSection();
  asked_ = command;  // has room for every request, so that requests caused by frames do not
                     // allocate
  answer_ns_ = now_ns + kAnswer_ns;
  Send(command, out);
}

void Qtm::Send(std::string_view command, Outbox& out) noexcept {
  std::array<std::byte, 128> buffer;
  out.Reply(server_,
            std::span(buffer).first(qtm::EncodeText(PacketType::kCommand, command, buffer)));
}

void Qtm::RequestSkeletons(std::int64_t now_ns, Outbox& out) {
  reread_ns_ = kNever;
  // No frame has requested them since they could have been read.
  if (now_ns - asked_skeletons_ns_ >= 2 * reread_pause_ns_) reread_pause_ns_ = kFirstPause_ns;
  asked_skeletons_ns_ = now_ns;
  const bool all = stage_ == Stage::kStreaming && !only_skeletons_;
  Ask(all ? kAllParameters : "GetParameters Skeleton", now_ns, out);
}

// Not while an error might be the answer to StreamFrames: an error does not say which request it
// answers.
void Qtm::ScheduleSkeletons(std::int64_t now_ns) noexcept {
  if (stage_ != Stage::kStreaming || IsAsking()) return;  // the pending request will be answered
  const std::int64_t stream_ns = stream_confirmed_ ? now_ns : stream_ns_ + kAnswer_ns;
  reread_ns_ =
      std::min(reread_ns_, std::max({now_ns, asked_skeletons_ns_ + reread_pause_ns_, stream_ns}));
}

void Qtm::EndReread(bool changed, std::int64_t now_ns) noexcept {
  reread_pause_ns_ = changed ? kFirstPause_ns : std::min(2 * reread_pause_ns_, kLongestPause_ns);
  // An operator may add a skeleton.
  if (performers_.empty()) reread_ns_ = now_ns + kAgain_ns;
}

std::string_view Qtm::StreamCommand() const noexcept {
  return timecode_wanted_ ? "StreamFrames AllFrames Skeleton Timecode"
                          : "StreamFrames AllFrames Skeleton";
}

// The only answer is frames, which arrive when a measurement runs, or an error.
void Qtm::StartStream(std::int64_t now_ns, Outbox& out) {
  Send(StreamCommand(), out);
  stream_ns_ = now_ns;
  stream_confirmed_ = false;
  silence_ns_ = silence_said_ ? kNever : now_ns + kAnswer_ns;
  if (reread_ns_ != kNever) reread_ns_ = std::max(reread_ns_, now_ns + kAnswer_ns);
  if (performers_.empty() && !IsAsking()) reread_ns_ = now_ns + kAgain_ns;
}

void Qtm::ConfirmStream(std::int64_t now_ns) noexcept {
  if (stream_confirmed_) return;
  stream_confirmed_ = true;
  no_measurement_ = false;
  silence_ns_ = kNever;
  if (reread_ns_ == kNever) return;
  reread_ns_ = kNever;  // this was the awaited answer
  ScheduleSkeletons(now_ns);
}

void Qtm::ReportNoFrame(Outbox& out) {
  silence_ns_ = kNever;
  silence_said_ = true;
  out.LeaveHotSection();
  const std::string seconds = std::to_string(kAnswer_ns / kSecond_ns);
  const std::string text =
      Server() + (no_measurement_ ? " runs no measurement: frames come when one begins"
                                  : " sent no frame within " + seconds +
                                        " s: frames come when a measurement runs in QTM, or a file "
                                        "plays in real time");
  if (logged_.Add(text)) out.Notice([&text] { return text; });
}

void Qtm::Say(const std::string& text, Outbox& out) {
  out.LeaveHotSection();
  if (logged_.Add(text)) out.Note([&text] { return text; });
}

void Qtm::HandleText(std::string_view text, std::int64_t now_ns, Outbox& out) {
  out.LeaveHotSection();
  if (qtm::IsGreeting(text)) {
    Connected(now_ns);  // a recording has no other sign of a new connection
    return Enter(Stage::kVersion, now_ns, out);
  }
  if (stage_ == Stage::kGreeting) {
    fault_ = "greets with \"" + qtm::ToString(text) + "\", expected \"" +
             std::string(qtm::kGreeting) + "\"";
    return;
  }
  if (stage_ == Stage::kVersion) return HandleVersion(text, now_ns, out);
  out.Refuse(Counter::kSourceIgnored);
}

void Qtm::HandleVersion(std::string_view answer, std::int64_t now_ns, Outbox& out) {
  if (qtm::AcceptsVersion(answer)) return Enter(Stage::kGeneral, now_ns, out);
  if (minor_ > qtm::kOldestMinor) {
    --minor_;
    return Enter(Stage::kVersion, now_ns, out);
  }
  fault_ = "speaks none of QTM RT 1." + std::to_string(qtm::kNewestMinor) + " to 1." +
           std::to_string(qtm::kOldestMinor) +
           " (skeletons need QTM 2019 or later); it answered \"" + qtm::ToString(answer) + "\"";
}

void Qtm::HandleError(std::string_view text, std::int64_t now_ns, Outbox& out) {
  out.LeaveHotSection();
  const std::string words = '"' + qtm::ToString(text) + '"';
  switch (stage_) {
    case Stage::kGreeting:
      fault_ = "refuses: " + words;
      return;
    case Stage::kVersion:
      return HandleVersion(text, now_ns, out);
    case Stage::kGeneral:
      Say(Server() + " answers \"" + asked_ + "\" with " + words, out);
      return Enter(Stage::kSpace, now_ns, out);
    case Stage::kSpace:
      Say(Server() + " answers \"" + asked_ + "\" with " + words + "; +Z is taken to be up", out);
      return Enter(Stage::kSkeletons, now_ns, out);
    case Stage::kSkeletons:
      Say(Server() + " answers \"" + asked_ + "\" with " + words, out);
      answer_ns_ = kNever;
      again_ns_ = now_ns + kAgain_ns;
      return;
    case Stage::kStreaming:
      return IsAsking() ? RefuseReread(words, now_ns, out) : RefuseStream(words, now_ns, out);
  }
}

void Qtm::RefuseReread(const std::string& words, std::int64_t now_ns, Outbox& out) {
  answer_ns_ = kNever;
  // The server may lack one of the other sections; the skeletons matter most.
  if (asked_ == kAllParameters) {
    only_skeletons_ = true;
    return RequestSkeletons(now_ns, out);
  }
  Say(Server() + " answers \"" + asked_ + "\" with " + words, out);
  EndReread(false, now_ns);
  ScheduleSkeletons(now_ns + kAgain_ns);
}

void Qtm::RefuseStream(const std::string& words, std::int64_t now_ns, Outbox& out) {
  if (stream_confirmed_) return Say(Server() + " complains: " + words, out);
  silence_ns_ = kNever;
  if (!timecode_wanted_) {
    Say(Server() + " answers \"" + std::string(StreamCommand()) + "\" with " + words, out);
    again_ns_ = now_ns + kAgain_ns;
    return;
  }
  timecode_wanted_ = false;
  StartStream(now_ns, out);
}

}  // namespace styled::source

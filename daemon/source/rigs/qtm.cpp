#include "daemon/source/rigs/qtm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "daemon/config/sources.h"
#include "daemon/runtime/clock.h"
#include "daemon/source/rigs/named_performers.h"
#include "model/base/text.h"

namespace styled::source {
namespace {

using qtm::DecodeResult;
using qtm::PacketType;
using runtime::Counter;
using runtime::kSecond_ns;

constexpr std::int64_t kAnswer_ns = 5 * kSecond_ns;  // QTM answers within milliseconds
constexpr std::int64_t kAgain_ns = 5 * kSecond_ns;   // questions that an operator has to make good
// Pauses between reading skeletons anew: twice as long after each that changed nothing.
constexpr std::int64_t kFirstPause_ns = kSecond_ns, kLongestPause_ns = 60 * kSecond_ns;
constexpr std::string_view kAllParameters = "GetParameters General 3D Skeleton";
constexpr std::size_t kMaxQuestion = 64;  // bytes; the longest has 41

}  // namespace

Qtm::Qtm(const config::Source& config) : config_(config) {
  asked_.reserve(kMaxQuestion);
  const auto server = config::ParseServer(config.server, qtm::kPort);
  if (!server.ok()) return;  // a recording's; the configuration of a live source was checked
  std::memcpy(&server_.address, &server.value(), sizeof server.value());
  server_.address_size = sizeof server.value();
}

void Qtm::Connected(std::int64_t now_ns) {
  stage_ = Stage::kGreeting;
  minor_ = qtm::kNewestMinor;
  timecode_wanted_ = true;
  asked_.clear();
  fault_.clear();
  said_.Forget(now_ns);
  frequency_hz_.reset();
  up_ = qtm::Axis::kZ;
  answer_ns_ = now_ns + kAnswer_ns;
  again_ns_ = reread_ns_ = silence_ns_ = kNever;
  no_measurement_ = silence_said_ = only_skeletons_ = false;
  reread_pause_ns_ = kFirstPause_ns;
}

void Qtm::Take(std::span<const std::byte> record, const Peer& /*peer*/, std::int64_t now_ns,
               Outbox& out) {
  qtm::Packet packet;
  if (qtm::DecodePacket(record, packet) != DecodeResult::kOk) {
    return out.Refuse(Counter::kSourceMalformed);
  }
  switch (packet.type) {
    case PacketType::kData:
      return TakeFrame(packet.payload, now_ns, out);
    case PacketType::kNoMoreData:  // the stream goes on with the next measurement
      no_measurement_ = true;
      return;
    case PacketType::kCommand:
      return TakeText(qtm::TextOf(packet.payload), now_ns, out);
    case PacketType::kError:
      return TakeError(qtm::TextOf(packet.payload), now_ns, out);
    case PacketType::kXml:
      return TakeXml(qtm::TextOf(packet.payload), now_ns, out);
    case PacketType::kEvent:
      return TakeEvent(static_cast<qtm::Event>(packet.payload.front()), now_ns, out);
    default:
      return out.Refuse(Counter::kSourceIgnored);
  }
}

void Qtm::Tick(std::int64_t now_ns, Outbox& out) {
  if (now_ns >= again_ns_) {
    again_ns_ = kNever;
    Enter(stage_, now_ns, out);
  }
  if (now_ns >= reread_ns_) AskForSkeletons(now_ns, out);
  if (now_ns >= silence_ns_) SayThatNoFrameCame(out);
  if (now_ns < answer_ns_) return;
  answer_ns_ = kNever;
  out.LeaveHotSection();
  const std::string seconds = std::to_string(kAnswer_ns / kSecond_ns) + " s";
  fault_ = asked_.empty() ? "did not greet within " + seconds + ": is it QTM's port " +
                                std::to_string(qtm::kPort) + "?"
                          : "did not answer \"" + asked_ + "\" within " + seconds;
}

// Asks the stage's question.
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
      return AskForSkeletons(now_ns, out);
    case Stage::kStreaming:
      return StartStream(now_ns, out);
  }
}

void Qtm::Ask(std::string_view command, std::int64_t now_ns, Outbox& out) {
  out.LeaveHotSection();
  asked_ = command;  // has room for every question, so that none that frames cause allocates
  answer_ns_ = now_ns + kAnswer_ns;
  Send(command, out);
}

void Qtm::Send(std::string_view command, Outbox& out) noexcept {
  std::array<std::byte, 128> buffer;
  out.Reply(server_,
            std::span(buffer).first(qtm::EncodeText(PacketType::kCommand, command, buffer)));
}

void Qtm::AskForSkeletons(std::int64_t now_ns, Outbox& out) {
  reread_ns_ = kNever;
  // Nobody wanted them as soon as they might have been read.
  if (now_ns - asked_skeletons_ns_ >= 2 * reread_pause_ns_) reread_pause_ns_ = kFirstPause_ns;
  asked_skeletons_ns_ = now_ns;
  const bool all = stage_ == Stage::kStreaming && !only_skeletons_;
  Ask(all ? kAllParameters : "GetParameters Skeleton", now_ns, out);
}

// Not while an error might be the answer to StreamFrames: nothing in it says what it answers.
void Qtm::WantSkeletons(std::int64_t now_ns) noexcept {
  if (stage_ != Stage::kStreaming || IsAsking()) return;  // what was asked will be answered
  const std::int64_t stream_ns = stream_confirmed_ ? now_ns : stream_ns_ + kAnswer_ns;
  reread_ns_ =
      std::min(reread_ns_, std::max({now_ns, asked_skeletons_ns_ + reread_pause_ns_, stream_ns}));
}

void Qtm::EndReread(bool changed, std::int64_t now_ns) noexcept {
  reread_pause_ns_ = changed ? kFirstPause_ns : std::min(2 * reread_pause_ns_, kLongestPause_ns);
  // Somebody may add one.
  if (performers_.empty()) reread_ns_ = now_ns + kAgain_ns;
}

std::string_view Qtm::StreamCommand() const noexcept {
  return timecode_wanted_ ? "StreamFrames AllFrames Skeleton Timecode"
                          : "StreamFrames AllFrames Skeleton";
}

// There is no answer but frames, which come when a measurement runs, or an error.
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
  reread_ns_ = kNever;  // waited for this
  WantSkeletons(now_ns);
}

void Qtm::SayThatNoFrameCame(Outbox& out) {
  silence_ns_ = kNever;
  silence_said_ = true;
  out.LeaveHotSection();
  const std::string seconds = std::to_string(kAnswer_ns / kSecond_ns);
  const std::string text =
      Server() + (no_measurement_ ? " runs no measurement: frames come when one begins"
                                  : " sent no frame within " + seconds +
                                        " s: frames come when a measurement runs in QTM, or a file "
                                        "plays in real time");
  if (said_.Add(text)) out.News([&text] { return text; });
}

void Qtm::Say(const std::string& text, Outbox& out) {
  out.LeaveHotSection();
  if (said_.Add(text)) out.Note([&text] { return text; });
}

void Qtm::TakeText(std::string_view text, std::int64_t now_ns, Outbox& out) {
  out.LeaveHotSection();
  if (qtm::IsGreeting(text)) {
    Connected(now_ns);  // a recording says in no other way that the connection is another one
    return Enter(Stage::kVersion, now_ns, out);
  }
  if (stage_ == Stage::kGreeting) {
    fault_ = "greets with \"" + qtm::ToString(text) + "\", expected \"" +
             std::string(qtm::kGreeting) + "\"";
    return;
  }
  if (stage_ == Stage::kVersion) return TakeVersion(text, now_ns, out);
  out.Refuse(Counter::kSourceIgnored);
}

void Qtm::TakeVersion(std::string_view answer, std::int64_t now_ns, Outbox& out) {
  if (qtm::TakesVersion(answer)) return Enter(Stage::kGeneral, now_ns, out);
  if (minor_ > qtm::kOldestMinor) {
    --minor_;
    return Enter(Stage::kVersion, now_ns, out);
  }
  fault_ = "speaks none of QTM RT 1." + std::to_string(qtm::kNewestMinor) + " to 1." +
           std::to_string(qtm::kOldestMinor) +
           " (skeletons need QTM 2019 or later); it answered \"" + qtm::ToString(answer) + "\"";
}

void Qtm::TakeError(std::string_view text, std::int64_t now_ns, Outbox& out) {
  out.LeaveHotSection();
  const std::string words = '"' + qtm::ToString(text) + '"';
  switch (stage_) {
    case Stage::kGreeting:
      fault_ = "refuses: " + words;
      return;
    case Stage::kVersion:
      return TakeVersion(text, now_ns, out);
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
  // Perhaps it lacks one of the others: skeletons matter most.
  if (asked_ == kAllParameters) {
    only_skeletons_ = true;
    return AskForSkeletons(now_ns, out);
  }
  Say(Server() + " answers \"" + asked_ + "\" with " + words, out);
  EndReread(false, now_ns);
  WantSkeletons(now_ns + kAgain_ns);
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

void Qtm::TakeXml(std::string_view xml, std::int64_t now_ns, Outbox& out) {
  // The answer to a question for parameters; what was not asked for is not read.
  if (!IsAsking() || stage_ < Stage::kGeneral) return out.Refuse(Counter::kSourceIgnored);
  out.LeaveHotSection();
  const auto read = qtm::ReadParameters(xml);
  if (!read.ok()) {
    out.Refuse(Counter::kSourceMalformed);
    fault_ = "sent parameters that cannot be used: " + read.status().message();
    return;
  }
  answer_ns_ = kNever;
  const qtm::Parameters& parameters = read.value();
  bool changed = TakeVolume(parameters);
  switch (stage_) {
    case Stage::kGeneral:
      return Enter(Stage::kSpace, now_ns, out);
    case Stage::kSpace:
      return Enter(Stage::kSkeletons, now_ns, out);
    case Stage::kSkeletons:
      TakeSkeletons(parameters.skeletons.value_or(std::vector<qtm::SkeletonDescription>()), true,
                    out);
      return Enter(Stage::kStreaming, now_ns, out);
    case Stage::kStreaming:
      if (parameters.skeletons) changed = TakeSkeletons(*parameters.skeletons, changed, out);
      return EndReread(changed, now_ns);
    default:  // asks nothing that XML answers
      return;
  }
}

bool Qtm::TakeVolume(const qtm::Parameters& parameters) {
  const auto before = std::pair(frequency_hz_, up_);
  if (parameters.frequency_hz) frequency_hz_ = parameters.frequency_hz;
  if (parameters.up) up_ = *parameters.up;
  if (config_.up != "auto") up_ = config_.up == "y" ? qtm::Axis::kY : qtm::Axis::kZ;
  return std::pair(frequency_hz_, up_) != before;
}

bool Qtm::TakeSkeletons(const std::vector<qtm::SkeletonDescription>& skeletons, bool changed,
                        Outbox& out) {
  if (skeletons.empty()) {
    Say(Server() + " has no skeleton: in QTM add one, and switch its solver on for real time", out);
  } else if (skeletons.size() > qtm::kMaxSkeletons) {
    Say(Server() + " has " + std::to_string(skeletons.size()) + " skeletons, the first " +
            std::to_string(qtm::kMaxSkeletons) + " are taken",
        out);
  }
  std::vector<std::unique_ptr<Performer>> performers;
  const std::size_t count = std::min(skeletons.size(), qtm::kMaxSkeletons);
  changed = changed || count != performers_.size();
  for (const auto& skeleton : std::span(skeletons).first(count)) {
    changed = Adopt(skeleton, performers, out) || changed;
  }
  performers_ = std::move(performers);
  if (!changed) return false;
  std::string names;
  for (const auto& skeleton : skeletons) {
    names.append(names.empty() ? "skeletons: " : ", ").append(skeleton.name);
  }
  const std::string rate = frequency_hz_ ? NumberText(*frequency_hz_) + " Hz, " : "";
  Say(Server() + ": QTM RT 1." + std::to_string(minor_) + ", " + rate +
          std::string(qtm::Name(up_)) + " up, " +
          (names.empty() ? "no skeletons" : qtm::ToString(names)),
      out);
  return true;
}

// Reuses the performer of this skeleton's name, or makes one.
bool Qtm::Adopt(const qtm::SkeletonDescription& description,
                std::vector<std::unique_ptr<Performer>>& performers, Outbox& out) {
  auto skeleton = QtmSkeleton::Make(description, up_);
  if (!skeleton.ok()) {
    Say(Server() + ": " + skeleton.status().message(), out);
    out.Refuse(Counter::kPipelineBodiesRefused);
    performers.push_back(nullptr);  // frames count it
    return false;
  }
  Performer& performer = AdoptNamed(description.name, performers_, performers);
  if (performer.stream.has_body() && performer.skeleton == skeleton.value()) return false;
  performer.skeleton = std::move(skeleton.value());
  performer.stream.SetBody(performer.skeleton.body(), out);
  performer.pose = rig::RigPose(performer.skeleton.body().skeleton);
  return true;
}

void Qtm::TakeEvent(qtm::Event event, std::int64_t now_ns, Outbox& out) {
  switch (event) {
    case qtm::Event::kConnected:
    case qtm::Event::kCaptureStarted:
    case qtm::Event::kRtFromFileStarted:
      return BeginSession(now_ns);
    case qtm::Event::kShuttingDown:
      out.LeaveHotSection();
      fault_ = "QTM shuts down";
      return;
    default:
      return;
  }
}

// What begins may have other skeletons.
void Qtm::BeginSession(std::int64_t now_ns) noexcept {
  if (any_frame_) {
    for (auto& performer : performers_) {
      if (performer != nullptr) performer->stream.Restart();
    }
  }
  any_frame_ = false;
  only_skeletons_ = false;
  WantSkeletons(now_ns);
}

bool Qtm::ReadTimecode() noexcept {
  if (!frame_->has_timecode || frame_->timecode.kind == qtm::Timecode::Kind::kCamera) return false;
  const qtm::ClockTime time = qtm::Unpack(frame_->timecode);
  if (time.hours > 23 || time.minutes > 59 || time.seconds > 59) return false;
  const bool irig = frame_->timecode.kind == qtm::Timecode::Kind::kIrig;  // tenths of a second
  timecode_ = {time.hours, time.minutes, time.seconds, time.parts, irig ? 10.0F : 0.0F, false};
  return true;
}

void Qtm::TakeFrame(std::span<const std::byte> payload, std::int64_t now_ns, Outbox& out) {
  if (qtm::DecodeFrame(payload, *frame_) != DecodeResult::kOk) {
    return out.Refuse(Counter::kSourceMalformed);
  }
  if (stage_ == Stage::kStreaming) ConfirmStream(now_ns);
  if (stage_ != Stage::kStreaming || !frame_->has_skeletons) {
    return out.Refuse(Counter::kSourceIgnored);
  }
  PerformerStream::FrameInfo info;
  if (any_frame_ && frame_->timestamp_us == last_us_) {
    return out.Refuse(Counter::kPipelineDuplicate);
  }
  if (any_frame_ && frame_->timestamp_us < last_us_) {
    BeginSession(now_ns);
  } else if (any_frame_ && frame_->number > last_number_) {
    info.lost = frame_->number - last_number_ - 1;
  }
  any_frame_ = true;
  last_us_ = frame_->timestamp_us;
  last_number_ = frame_->number;
  info.source_time_ns = static_cast<std::uint64_t>(frame_->timestamp_us) * 1000;
  info.now_ns = now_ns;
  if (ReadTimecode()) info.timecode = &timecode_;
  bool unknown = frame_->skeleton_count < performers_.size();
  for (std::size_t k = 0; k < frame_->skeleton_count; ++k) {
    const qtm::SkeletonPose& segments = frame_->skeletons[k];
    Performer* performer = k < performers_.size() ? performers_[k].get() : nullptr;
    unknown = unknown || k >= performers_.size();
    if (segments.segment_count == 0) continue;  // QTM does not see it
    if (performer == nullptr || !performer->skeleton.Convert(segments, performer->pose)) {
      unknown = unknown || performer != nullptr;
      out.Refuse(Counter::kPipelineBeforeBody);
      continue;
    }
    performer->stream.Send(performer->pose, info, out);
  }
  if (unknown) WantSkeletons(now_ns);
}

std::unique_ptr<Translator> MakeQtm(const config::Source& config) {
  return std::make_unique<Qtm>(config);
}

}  // namespace styled::source

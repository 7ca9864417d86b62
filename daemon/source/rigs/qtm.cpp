#include "daemon/source/rigs/qtm.h"

#include <algorithm>
#include <cstring>

#include "daemon/config/sources.h"
#include "daemon/source/rigs/named_performers.h"
#include "model/base/text.h"

namespace styled::source {
namespace {

using qtm::PacketType;
using runtime::Counter;

constexpr std::size_t kMaxQuestion = 64;  // bytes of a request; the longest has 41

}  // namespace

Qtm::Qtm(const config::Source& config) : config_(config) {
  asked_.reserve(kMaxQuestion);
  const auto server = config::ParseServer(config.server, qtm::kPort);
  if (!server.ok())
    return;  // true for a recording's; the configuration of a live source is
             // already validated
  std::memcpy(&server_.address, &server.value(), sizeof server.value());
  server_.address_size = sizeof server.value();
}

void Qtm::Handle(std::span<const std::byte> record, const Peer& /*peer*/, std::int64_t now_ns,
                 Outbox& out) {
  qtm::Packet packet;
  if (qtm::DecodePacket(record, packet) != qtm::DecodeResult::kOk) {
    return out.Refuse(Counter::kSourceMalformed);
  }
  switch (packet.type) {
    case PacketType::kData:
      return HandleFrame(packet.payload, now_ns, out);
    case PacketType::kNoMoreData:  // the stream continues with the next measurement
      no_measurement_ = true;
      return;
    case PacketType::kCommand:
      return HandleText(qtm::TextOf(packet.payload), now_ns, out);
    case PacketType::kError:
      return HandleError(qtm::TextOf(packet.payload), now_ns, out);
    case PacketType::kXml:
      return HandleXml(qtm::TextOf(packet.payload), now_ns, out);
    case PacketType::kEvent:
      return HandleEvent(static_cast<qtm::Event>(packet.payload.front()), now_ns, out);
    default:
      return out.Refuse(Counter::kSourceIgnored);
  }
}

void Qtm::HandleXml(std::string_view xml, std::int64_t now_ns, Outbox& out) {
  // The answer to a request for parameters. Sections that were not requested are not read.
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
  bool changed = HandleVolume(parameters);
  switch (stage_) {
    case Stage::kGeneral:
      return Enter(Stage::kSpace, now_ns, out);
    case Stage::kSpace:
      return Enter(Stage::kSkeletons, now_ns, out);
    case Stage::kSkeletons:
      HandleSkeletons(parameters.skeletons.value_or(std::vector<qtm::SkeletonDescription>()), true,
                      out);
      return Enter(Stage::kStreaming, now_ns, out);
    case Stage::kStreaming:
      if (parameters.skeletons) changed = HandleSkeletons(*parameters.skeletons, changed, out);
      return EndReread(changed, now_ns);
    default:  // requests nothing that is answered in XML
      return;
  }
}

bool Qtm::HandleVolume(const qtm::Parameters& parameters) {
  const auto before = std::pair(frequency_hz_, up_);
  if (parameters.frequency_hz) frequency_hz_ = parameters.frequency_hz;
  if (parameters.up) up_ = *parameters.up;
  if (config_.up != "auto") up_ = config_.up == "y" ? qtm::Axis::kY : qtm::Axis::kZ;
  return std::pair(frequency_hz_, up_) != before;
}

bool Qtm::HandleSkeletons(const std::vector<qtm::SkeletonDescription>& skeletons, bool changed,
                          Outbox& out) {
  if (skeletons.empty()) {
    Log(Server() + " has no skeleton: in QTM add one, and switch its solver on for real time", out);
  } else if (skeletons.size() > qtm::kMaxSkeletons) {
    Log(Server() + " has " + std::to_string(skeletons.size()) + " skeletons, the first " +
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
  Log(Server() + ": QTM RT 1." + std::to_string(minor_) + ", " + rate +
          std::string(qtm::Name(up_)) + " up, " +
          (names.empty() ? "no skeletons" : qtm::ToString(names)),
      out);
  return true;
}

// Reuses the performer with this skeleton's name, or makes one.
bool Qtm::Adopt(const qtm::SkeletonDescription& description,
                std::vector<std::unique_ptr<Performer>>& performers, Outbox& out) {
  auto skeleton = QtmSkeleton::Make(description, up_);
  if (!skeleton.ok()) {
    Log(Server() + ": " + skeleton.status().message(), out);
    out.Refuse(Counter::kPipelineBodiesRefused);
    performers.push_back(nullptr);  // the counter `frames` includes it
    return false;
  }
  Performer& performer = AdoptNamed(description.name, performers_, performers);
  if (performer.stream.has_body() && performer.skeleton == skeleton.value()) return false;
  performer.skeleton = std::move(skeleton.value());
  performer.stream.SetBody(performer.skeleton.body(), out);
  performer.pose = rig::RigPose(performer.skeleton.body().skeleton);
  return true;
}

void Qtm::HandleEvent(qtm::Event event, std::int64_t now_ns, Outbox& out) {
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

// A measurement that begins may have other skeletons.
void Qtm::BeginSession(std::int64_t now_ns) noexcept {
  if (any_frame_) {
    for (auto& performer : performers_) {
      if (performer != nullptr) performer->stream.Restart();
    }
  }
  any_frame_ = false;
  only_skeletons_ = false;
  ScheduleSkeletons(now_ns);
}

bool Qtm::ReadTimecode() noexcept {
  if (!frame_->has_timecode || frame_->timecode.kind == qtm::Timecode::Kind::kCamera) return false;
  const qtm::ClockTime time = qtm::Unpack(frame_->timecode);
  if (time.hours > 23 || time.minutes > 59 || time.seconds > 59) return false;
  const bool irig = frame_->timecode.kind == qtm::Timecode::Kind::kIrig;  // tenths of a second
  timecode_ = {time.hours, time.minutes, time.seconds, time.parts, irig ? 10.0F : 0.0F, false};
  return true;
}

void Qtm::HandleFrame(std::span<const std::byte> payload, std::int64_t now_ns, Outbox& out) {
  if (qtm::DecodeFrame(payload, *frame_) != qtm::DecodeResult::kOk) {
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
    if (segments.segment_count == 0) continue;  // QTM does not see the skeleton
    if (performer == nullptr || !performer->skeleton.Convert(segments, performer->pose)) {
      unknown = unknown || performer != nullptr;
      out.Refuse(Counter::kPipelineBeforeBody);
      continue;
    }
    performer->stream.Send(performer->pose, info, out);
  }
  if (unknown) ScheduleSkeletons(now_ns);
}

std::unique_ptr<Translator> MakeQtm(const config::Source& config) {
  return std::make_unique<Qtm>(config);
}

}  // namespace styled::source

#include "daemon/source/performer_stream.h"

#include <algorithm>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "model/base/crc32c.h"
#include "model/base/random_id.h"

namespace styled::source {
namespace {

// A larger step of the rig's own count is a jump, not lost frames. Half of the largest step that
// the pipeline accepts (Session::kFarAhead).
constexpr std::uint64_t kMostLost = 512;
// A performer is listed as refused if a datagram was refused in the last second.
constexpr std::int64_t kRefusedPeriod_ns = runtime::kSecond_ns / 2;

v1::Body MakeMessage(const std::string& performer, const rig::RigBody& body) {
  v1::Body message;
  message.set_performer(performer);
  const auto& skeleton = body.skeleton;
  for (std::size_t j = 0; j < skeleton.names.size(); ++j) {
    message.add_names(skeleton.names[j]);
    message.add_parents(skeleton.parents[j]);
    for (const float value : skeleton.offsets[j]) message.add_offsets(value);
  }
  for (const rig::Quat& rotation : body.rest) {
    for (const float value : rotation.coeffs()) message.add_rest(value);
  }
  message.set_metres_per_unit(body.metres_per_unit);
  message.set_dialect(body.dialect);
  return message;
}

}  // namespace

std::string MakeName(std::string_view text) {
  std::string name(text.substr(0, 32));
  for (char& c : name) {
    if (!config::IsName({&c, 1})) c = '_';
  }
  return name.empty() ? "performer" : name;
}

PerformerStream::PerformerStream(std::string performer)
    : performer_(std::move(performer)), session_(RandomId() | 1U) {}

void PerformerStream::Restart() noexcept {
  session_ += 2;  // of the same sender (WIRE.md); stays odd: never 0
  sequence_ = 0;
  next_body_ns_ = 0;
}

void PerformerStream::SetBody(const rig::RigBody& body, Outbox& out) {
  if (has_body() && body == body_) return;
  out.LeaveHotSection();
  body_ = body;
  message_ = std::make_shared<const v1::Body>(MakeMessage(performer_, body));
  const std::string bytes = message_->SerializeAsString();
  body_crc_ = Crc32c(std::as_bytes(std::span(bytes)));
  next_body_ns_ = 0;
}

SourceFrame PerformerStream::Next() noexcept {
  SourceFrame next;
  next.performer = performer_;
  next.session = session_;
  next.sequence = sequence_++;
  next.body_crc = body_crc_;
  return next;
}

void PerformerStream::Send(const rig::RigPose& pose, const FrameInfo& info, Outbox& out) noexcept {
  if (!has_body()) return;
  if (info.now_ns >= next_body_ns_) {
    next_body_ns_ = info.now_ns + runtime::kSecond_ns;
    SourceFrame body = Next();
    body.is_body = true;
    body.body = message_;
    out.Put(body);
  }
  sequence_ += std::min(info.lost, kMostLost);
  if (info.timecode != nullptr) {
    timecode_ = *info.timecode;
    has_timecode_ = true;
  }
  SourceFrame frame = Next();
  frame.arrival_ns = info.now_ns;
  frame.source_time_ns = info.source_time_ns;
  frame.has_timecode = has_timecode_;
  frame.timecode = timecode_;
  frame.root_position = std::as_bytes(std::span(pose.translations.front().data(), 3));
  frame.rotations = std::as_bytes(std::span(pose.rotations));
  if (info.face != nullptr) {
    frame.face = std::span<const std::byte>(face_).first(EncodeFace(*info.face, face_));
  }
  frame.props = std::span<const std::byte>(props_).first(EncodeProps(info.props, props_));
  frame.scene_props = info.scene_props;
  out.Put(frame);
}

void PerformerStream::SendRefused(const std::shared_ptr<const std::string>& why,
                                  std::int64_t now_ns, Outbox& out) noexcept {
  if (!has_body() || now_ns < next_body_ns_) return;
  next_body_ns_ = now_ns + kRefusedPeriod_ns;
  SourceFrame body = Next();
  body.is_body = true;
  body.arrival_ns = now_ns;
  body.body = message_;
  body.refusal = why;
  out.Put(body);
}

}  // namespace styled::source

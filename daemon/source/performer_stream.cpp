#include "daemon/source/performer_stream.h"

#include <algorithm>
#include <random>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "proto/styled/v1/body.pb.h"

namespace styled::source {
namespace {

// A rig's own count that goes on by more did not lose frames: it jumped. Half of what the pipeline
// believes at once (Session::kFarAhead).
constexpr std::uint64_t kMostLost = 512;

std::uint64_t RandomSession() {
  std::random_device device;
  const std::uint64_t high = device();
  return (high << 32U) | device() | 1U;
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
    : performer_(std::move(performer)), session_(RandomSession()) {
  frame_.set_performer(performer_);
}

void PerformerStream::Restart() noexcept {
  session_ += 2;  // of the same sender (WIRE.md); odd stays odd: never 0
  sequence_ = 0;
  next_body_ns_ = 0;
}

void PerformerStream::SetBody(const rig::RigBody& body, Outbox& out) {
  if (has_body() && body == body_) return;
  out.LeaveHotSection();
  body_ = body;
  v1::Body message;
  message.set_performer(performer_);
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
  body_bytes_ = message.SerializeAsString();
  body_crc_ = native::Crc32c(std::as_bytes(std::span(body_bytes_)));
  next_body_ns_ = 0;
  frame_.set_body_crc(body_crc_);
  frame_.mutable_root_position()->Resize(3, 0.0F);
  frame_.mutable_rotations()->Resize(4 * skeleton.joint_count(), 0.0F);
}

void PerformerStream::ReserveFace(std::size_t expressions, std::size_t name_bytes,
                                  std::size_t thrus, std::size_t thru_bytes) {
  for (std::size_t i = 0; i < expressions; ++i) {
    frame_.add_expressions()->set_name(std::string(name_bytes, ' '));
  }
  for (std::size_t i = 0; i < thrus; ++i) frame_.add_thru(std::string(thru_bytes, ' '));
  SetFace(nullptr);
}

// Cleared elements keep their memory for the next frame's.
void PerformerStream::SetFace(const Face* face) {
  frame_.clear_expressions();
  frame_.clear_thru();
  if (face == nullptr) return;
  for (const auto& expression : face->expressions) {
    v1::Expression& out = *frame_.add_expressions();
    out.set_name(expression.name.data(), expression.name.size());
    out.set_value(expression.value);
  }
  for (const auto bytes : face->thru) frame_.add_thru(bytes.data(), bytes.size());
}

void PerformerStream::SendBody(std::int64_t now_ns, Outbox& out) noexcept {
  next_body_ns_ = now_ns + runtime::kSecond_ns;
  out.Put(native::Encode(
      {native::Kind::kBody, session_, sequence_++, std::as_bytes(std::span(body_bytes_))},
      out.Slot()));
}

void PerformerStream::Send(const rig::RigPose& pose, const FrameInfo& info, Outbox& out) noexcept {
  if (!has_body()) return;
  if (info.now_ns >= next_body_ns_) SendBody(info.now_ns, out);
  sequence_ += std::min(info.lost, kMostLost);
  frame_.set_source_time_ns(info.source_time_ns);
  std::copy_n(pose.translations.front().data(), 3, frame_.mutable_root_position()->mutable_data());
  float* to = frame_.mutable_rotations()->mutable_data();
  for (const rig::Quat& rotation : pose.rotations)
    to = std::copy_n(rotation.coeffs().data(), 4, to);
  if (info.timecode != nullptr) {
    v1::Timecode& timecode = *frame_.mutable_timecode();
    timecode.set_hours(info.timecode->hours);
    timecode.set_minutes(info.timecode->minutes);
    timecode.set_seconds(info.timecode->seconds);
    timecode.set_frames(info.timecode->frames);
    timecode.set_rate(info.timecode->rate);
    timecode.set_drop_frame(info.timecode->drop_frame);
  }
  SetFace(info.face);
  const auto slot = out.Slot();
  const auto payload = slot.subspan(native::kHeaderSize);
  const std::size_t size = frame_.ByteSizeLong();
  if (size > native::kMaxPayloadSize) return;  // 256 joints are 5 kB: a translator's mistake
  frame_.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(payload.data()));
  out.Put(native::Encode({native::Kind::kSourceFrame, session_, sequence_++, payload.first(size)},
                         slot));
}

}  // namespace styled::source

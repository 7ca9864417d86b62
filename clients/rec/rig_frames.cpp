#include "clients/rec/rig_frames.h"

#include <algorithm>
#include <limits>

#include "clients/cpp/subscriber.h"
#include "model/base/crc32c.h"

namespace styled::rec {
namespace {

constexpr std::int64_t kBodyEvery_ns = 1'000'000'000;

}  // namespace

std::string IdOfTopic(const std::string& topic, const std::string& prefix) {
  if (!topic.starts_with(prefix) || !topic.ends_with('/') || topic.size() <= prefix.size()) {
    return "";
  }
  const std::string id = topic.substr(prefix.size(), topic.size() - prefix.size() - 1);
  return client::IsPerformerId(id) ? id : "";
}

void RigFrames::NoteBody(const std::string& topic, const std::string& payload) {
  const std::string id = IdOfTopic(topic, "body/");
  styled::v1::Body body;
  if (id.empty() || !body.ParseFromString(payload) || body.output() != styled::v1::OUTPUT_RIG) {
    return;
  }
  const std::uint64_t hash = body.hash();
  body.set_performer(id.substr(id.find('.') + 1));
  body.clear_hash();
  body.clear_output();
  // The daemon publishes rest rotations that its dialect defines. Only those that the rig sent are
  // sent again, so that the daemon binds the body as before.
  if (body.dialect() == "given") {
    body.clear_dialect();
  } else {
    body.clear_rest();
  }
  Body& known = bodies_[id][hash];
  known.payload = body.SerializeAsString();
  known.crc = Crc32c(std::as_bytes(std::span(known.payload)));
  known.joints = body.names_size();
}

void RigFrames::Note(const recording::Record& record) {
  if (record.published().topic().starts_with("body/")) {
    NoteBody(record.published().topic(), record.published().payload());
  }
}

void RigFrames::Apply(const recording::Record& record, const Send& send) {
  const std::string& topic = record.published().topic();
  if (topic.starts_with("body/")) return NoteBody(topic, record.published().payload());
  const std::string id = IdOfTopic(topic, "source/");
  if (id.empty() || !frame_.ParseFromString(record.published().payload())) return;
  // A stale frame repeats the last pose; the rig sent nothing.
  if ((frame_.flags() & styled::v1::FLAG_STALE) != 0) return;
  ApplyFrame(id, record.time_ns(), send);
}

void RigFrames::ApplyFrame(const std::string& id, std::int64_t time_ns, const Send& send) {
  const auto known = bodies_[id].find(frame_.body_hash());
  if (known == bodies_[id].end() || frame_.rotations_size() != 4 * known->second.joints) {
    ++without_body_;
    return;
  }
  const Body& body = known->second;
  const std::string source = id.substr(0, id.find('.'));
  Performer& performer = performers_[id];
  // Within a session a rig's sequence only increases.
  if (performer.session == 0 || frame_.epoch() != performer.epoch ||
      frame_.source_sequence() <= performer.source_sequence) {
    performer = {};
    performer.session = new_session_();
    performer.body_time_ns = std::numeric_limits<std::int64_t>::min() / 2;
  }
  performer.epoch = frame_.epoch();
  performer.source_sequence = frame_.source_sequence();
  if (performer.body_hash != frame_.body_hash() ||
      time_ns - performer.body_time_ns >= kBodyEvery_ns) {
    performer.body_hash = frame_.body_hash();
    performer.body_time_ns = time_ns;
    SendDatagram(native::Kind::kBody, performer, source, body.payload, send);
  }
  styled::v1::SourceFrame out;
  out.set_performer(id.substr(id.find('.') + 1));
  out.set_source_time_ns(frame_.source_time_ns());
  if (frame_.has_timecode()) *out.mutable_timecode() = frame_.timecode();
  *out.mutable_root_position() = frame_.root_position();
  *out.mutable_rotations() = frame_.rotations();
  for (const std::uint32_t joint : frame_.held_joints()) {
    if (joint >= static_cast<std::uint32_t>(body.joints)) continue;
    std::fill_n(out.mutable_rotations()->mutable_data() + std::size_t{4} * joint, 4,
                std::numeric_limits<float>::quiet_NaN());
  }
  out.set_body_crc(body.crc);
  SendDatagram(native::Kind::kSourceFrame, performer, source, out.SerializeAsString(), send);
  ++frames_;
}

void RigFrames::SendDatagram(native::Kind kind, Performer& performer, const std::string& source,
                             const std::string& payload, const Send& send) {
  const std::size_t size = native::Encode(
      {kind, performer.session, performer.sequence++, std::as_bytes(std::span(payload))}, buffer_);
  if (size > 0) send(source, std::span(buffer_).first(size));
}

}  // namespace styled::rec

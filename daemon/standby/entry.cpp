#include "daemon/standby/entry.h"

#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "proto/styled/timecode_message.h"

namespace styled::standby {
namespace {

std::string_view Text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::span<const std::byte> Bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

}  // namespace

void Write(const source::SourceFrame& frame, const Outcome& outcome, v1::Handled& entry) {
  entry.set_performer(frame.performer.data(), frame.performer.size());
  entry.set_machine(frame.machine.data(), sizeof frame.machine);
  entry.set_session(frame.session);
  entry.set_sequence(frame.sequence);
  entry.set_body_crc(frame.body_crc);
  entry.set_is_body(frame.is_body);
  if (frame.is_body) {
    if (frame.body != nullptr) {
      frame.body->SerializeToString(entry.mutable_body());
    } else {
      *entry.mutable_body() = Text(frame.body_bytes);
    }
    return;
  }
  entry.set_source_time_ns(frame.source_time_ns);
  if (frame.has_timecode) WriteTimecode(frame.timecode, *entry.mutable_timecode());
  *entry.mutable_root_position() = Text(frame.root_position);
  *entry.mutable_rotations() = Text(frame.rotations);
  *entry.mutable_face() = Text(frame.face);
  *entry.mutable_props() = Text(frame.props);
  entry.set_scene_props(frame.scene_props);
  entry.set_fate(outcome.fate);
  entry.set_late(outcome.late);
  entry.set_published(outcome.published);
  entry.set_styled_crc(outcome.styled_crc);
}

bool Read(const v1::Handled& entry, source::SourceFrame& frame, Outcome& outcome) {
  frame = source::SourceFrame();
  if (entry.machine().size() != sizeof frame.machine) return false;
  std::memcpy(frame.machine.data(), entry.machine().data(), sizeof frame.machine);
  frame.performer = entry.performer();
  frame.session = entry.session();
  frame.sequence = entry.sequence();
  frame.body_crc = entry.body_crc();
  frame.is_body = entry.is_body();
  if (frame.is_body) {
    frame.body_bytes = Bytes(entry.body());
    return true;
  }
  frame.source_time_ns = entry.source_time_ns();
  frame.has_timecode = entry.has_timecode();
  const v1::Timecode& from = entry.timecode();
  frame.timecode = {from.hours(),  from.minutes(), from.seconds(),
                    from.frames(), from.rate(),    from.drop_frame()};
  frame.root_position = Bytes(entry.root_position());
  frame.rotations = Bytes(entry.rotations());
  frame.face = Bytes(entry.face());
  frame.props = Bytes(entry.props());
  frame.scene_props = entry.scene_props();
  outcome = {entry.fate(), entry.late(), entry.published(), entry.styled_crc()};
  return true;
}

}  // namespace styled::standby

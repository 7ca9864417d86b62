#pragma once

#include <cstring>
#include <span>
#include <string>

#include "daemon/source/native_decoder.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

// Conversions between native datagrams and what a source passes to the pipeline.
namespace styled::support {

// Passes the datagrams to `receiver` as source 0 would. `senders`: one machine per datagram, or
// none.
inline void HandOn(std::span<const std::span<const std::byte>> datagrams,
                   std::span<const source::Machine> senders, runtime::Counters& counters,
                   source::Receiver& receiver) {
  source::NativeDecoder decoder(0, counters);
  decoder.HandOn(datagrams, senders, receiver);
}

// The message with the same content as the frame.
inline v1::SourceFrame AsMessage(const source::SourceFrame& frame) {
  v1::SourceFrame message;
  if (!frame.face.empty()) {
    message.MergeFromString(
        std::string(reinterpret_cast<const char*>(frame.face.data()), frame.face.size()));
  }
  if (!frame.props.empty()) {
    message.MergeFromString(
        std::string(reinterpret_cast<const char*>(frame.props.data()), frame.props.size()));
  }
  message.set_performer(std::string(frame.performer));
  message.set_source_time_ns(frame.source_time_ns);
  message.set_body_crc(frame.body_crc);
  const auto copy = [](std::span<const std::byte> bytes, auto& floats) {
    floats.Resize(static_cast<int>(bytes.size() / sizeof(float)), 0.0F);
    std::memcpy(floats.mutable_data(), bytes.data(), bytes.size());
  };
  copy(frame.root_position, *message.mutable_root_position());
  copy(frame.rotations, *message.mutable_rotations());
  if (frame.has_timecode) {
    v1::Timecode& timecode = *message.mutable_timecode();
    timecode.set_hours(frame.timecode.hours);
    timecode.set_minutes(frame.timecode.minutes);
    timecode.set_seconds(frame.timecode.seconds);
    timecode.set_frames(frame.timecode.frames);
    timecode.set_rate(frame.timecode.rate);
    timecode.set_drop_frame(frame.timecode.drop_frame);
  }
  return message;
}

}  // namespace styled::support

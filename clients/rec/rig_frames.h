#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "proto/recording/recording.pb.h"
#include "proto/rigs/native/datagram.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::rec {

// Reconstructs a rig's datagrams (proto/styled/v1/WIRE.md) from the daemon's messages about it on
// body/ and source/. With it, a recording of a publisher can be played into a daemon. Source times,
// poses and bodies are the rig's, and a joint that the daemon held is sent as unknown again. The
// styled output is therefore bit-identical to the recorded one. The exception is a jump of metres
// that the daemon held: only a recording of arrivals contains the original data. One thread;
// allocates.
class RigFrames {
 public:
  // Receives a datagram of the performer `source`.`name`.
  using Send = std::function<void(const std::string& source, std::span<const std::byte> datagram)>;
  // `new_session` returns session ids, nonzero and different on each call.
  explicit RigFrames(std::function<std::uint64_t()> new_session)
      : new_session_(std::move(new_session)) {}

  // Stores a body; sends nothing.
  void Note(const recording::Record& record);
  // Stores a body, or sends a frame. The body is sent before the frame if it has changed, and once
  // per second.
  void Apply(const recording::Record& record, const Send& send);
  // Starts a new session for every performer.
  void Restart() { performers_.clear(); }

  std::uint64_t frames() const { return frames_; }
  std::uint64_t without_body() const { return without_body_; }  // frames skipped

 private:
  struct Performer {
    std::uint64_t session = 0, sequence = 0;
    std::uint64_t epoch = 0, source_sequence = 0;  // of the last frame
    std::uint64_t body_hash = 0;                   // of the last sent body
    std::int64_t body_time_ns = 0;                 // when it was sent
  };
  struct Body {
    std::string payload;  // as the rig would send it
    std::uint32_t crc = 0;
    int joints = 0;
  };

  void NoteBody(const std::string& topic, const std::string& payload);
  void ApplyFrame(const std::string& id, std::int64_t time_ns, const Send& send);
  void SendDatagram(native::Kind kind, Performer& performer, const std::string& source,
                    const std::string& payload, const Send& send);

  std::function<std::uint64_t()> new_session_;
  std::map<std::string, std::map<std::uint64_t, Body>> bodies_;  // by id, by hash
  std::map<std::string, Performer> performers_;                  // by id
  styled::v1::Frame frame_;
  std::vector<std::byte> buffer_ = std::vector<std::byte>(native::kMaxDatagramSize);
  std::uint64_t frames_ = 0, without_body_ = 0;
};

// The performer's id in "source/<id>/" or "body/<id>/"; "" for any other topic.
std::string IdOfTopic(const std::string& topic, const std::string& prefix);

}  // namespace styled::rec

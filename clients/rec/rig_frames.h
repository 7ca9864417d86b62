#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "proto/recording/recording.pb.h"
#include "proto/rigs/native/datagram.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::rec {

// Makes a rig's own datagrams (proto/styled/v1/WIRE.md) of what the daemon published of it, body/
// and source/: so a recording of subscribers can be played into a daemon, too. Source times, poses
// and bodies are those of the rig, and a joint that the daemon held is sent as unknown again: what
// comes out styled is bit for bit what came out then. Not so where the daemon held a jump of
// metres; only a recording of arrivals has what was sent. One thread; allocates.
class RigFrames {
 public:
  // Takes a datagram of the performer `source`.`name`.
  using Send = std::function<void(const std::string& source, std::span<const std::byte> datagram)>;
  // `new_session`: session ids, not 0, each a new one.
  explicit RigFrames(std::function<std::uint64_t()> new_session)
      : new_session_(std::move(new_session)) {}

  // Notes a body; nothing is sent of it.
  void Note(const recording::Record& record);
  // Notes a body, or sends a frame: its body before it when it is another, and once a second.
  void Take(const recording::Record& record, const Send& send);
  // From now on every performer is in a new session.
  void Restart() { performers_.clear(); }

  std::uint64_t frames() const { return frames_; }
  std::uint64_t without_body() const { return without_body_; }  // frames left out

 private:
  struct Performer {
    std::uint64_t session = 0, sequence = 0;
    std::uint64_t epoch = 0, source_sequence = 0;  // of the last frame
    std::uint64_t body_hash = 0;                   // of the body sent last
    std::int64_t body_time_ns = 0;                 // when
  };
  struct Body {
    std::string payload;  // as the rig sends it
    std::uint32_t crc = 0;
    int joints = 0;
  };

  void NoteBody(const std::string& topic, const std::string& payload);
  void TakeFrame(const std::string& id, std::int64_t time_ns, const Send& send);
  void SendDatagram(native::Kind kind, Performer& performer, const std::string& source,
                    const std::string& payload, const Send& send);

  std::function<std::uint64_t()> new_session_;
  std::map<std::string, std::map<std::uint64_t, Body>> bodies_;  // by id, by hash
  std::map<std::string, Performer> performers_;                  // by id
  styled::v1::Frame frame_;
  std::vector<std::byte> buffer_ = std::vector<std::byte>(native::kMaxDatagramSize);
  std::uint64_t frames_ = 0, without_body_ = 0;
};

// The performer's id in "source/<id>/" or "body/<id>/"; "" where the topic has another shape.
std::string IdOfTopic(const std::string& topic, const std::string& prefix);

}  // namespace styled::rec

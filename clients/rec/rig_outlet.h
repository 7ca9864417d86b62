#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "clients/rec/outlet.h"
#include "clients/rec/rig_frames.h"
#include "clients/rec/steering.h"
#include "proto/rigs/native/stream_reader.h"
#include "sim/player/clock.h"
#include "sim/player/link.h"

namespace styled::rec {

struct RigOutletOptions {
  // Where to send what a source received: by the source's name, "" = all others. An url
  // "udp://HOST:PORT" or "tcp://HOST:PORT"; "original" = where it arrived when it was recorded, on
  // this machine where that was every address.
  std::map<std::string, std::string> to;
  bool as_recorded = false;     // keep the session ids of our own datagrams
  bool from_published = false;  // there are no arrivals: make them of what was published
  double start_wait_ms = 2000;  // for a TCP listener
};

struct RigOutletCounts {
  std::uint64_t datagrams = 0, bytes = 0;
  std::uint64_t elsewhere = 0;  // of sources that no `to` names
};

// Sends what arrived to where it should arrive again: from one socket, or connection, per sender
// that was recorded. Our own datagrams (proto/styled/v1/WIRE.md) get new session ids, or a daemon
// that has seen the recording before would take them for repetitions; all else goes as it came.
// What was recorded of a stream of ours is put together to whole datagrams first. Before a
// performer's new session there is silence as in the recording, up to 150 ms at any speed, which is
// what a daemon needs to believe it.
class RigOutlet final : public Outlet {
 public:
  // `steering` may be null; else it is told what is sent, and paces it.
  RigOutlet(RigOutletOptions options, player::Clock& clock, Steering* steering);

  void Note(const recording::Record& record) override;
  Status Take(const recording::Record& record) override;
  void Restart() override;

  const RigOutletCounts& counts() const { return counts_; }
  const RigFrames& rig_frames() const { return rig_frames_; }

 private:
  struct Sender {
    std::string source, listen, peer;
    friend auto operator<=>(const Sender&, const Sender&) = default;
  };
  struct Session {
    std::uint64_t id = 0;
    std::int64_t recorded_ns = 0, sent_ns = 0;  // of the last datagram
  };

  // A TCP connection of our own datagrams, as it was recorded.
  struct Stream {
    std::vector<std::byte> buffer = std::vector<std::byte>(2 * native::kMaxDatagramSize);
    native::StreamReader reader{buffer};
    bool broken = false;  // out of step: a daemon closes it there, and nothing follows
  };

  Status DeliverPiece(const Sender& sender, std::int64_t time_ns, std::span<const std::byte> piece);
  Status Deliver(const Sender& sender, std::int64_t time_ns, std::span<const std::byte> datagram);
  Status Begin();
  Result<player::Link*> LinkTo(const Sender& sender);
  void KeepSilence(const native::Datagram& datagram, const std::string& source,
                   std::int64_t time_ns);
  std::uint64_t Renewed(std::uint64_t session) const;

  RigOutletOptions options_;
  player::Clock& clock_;
  Steering* steering_;
  RigFrames rig_frames_;
  std::map<Sender, std::unique_ptr<player::Link>> links_;  // null: elsewhere
  std::map<Sender, Stream> streams_;
  std::map<std::pair<std::string, std::uint64_t>, std::string> performers_;  // source, session
  std::map<std::string, Session> sessions_;                                  // by performer's id
  // The last body of each performer before the part that is played.
  std::map<std::string, recording::Record> noted_;
  std::uint64_t salt_ = 0;  // makes new session ids of the recorded ones
  std::vector<std::byte> buffer_;
  RigOutletCounts counts_;
};

}  // namespace styled::rec

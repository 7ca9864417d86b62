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
  // Destination for the datagrams of each source, by the source's name; "" = all other sources. A
  // URL "udp://HOST:PORT" or "tcp://HOST:PORT", or "original" = the address where they arrived
  // during recording (this machine if it was a wildcard address).
  std::map<std::string, std::string> to;
  bool as_recorded = false;     // keep the session ids of native datagrams
  bool from_published = false;  // there are no arrivals: reconstruct them from the published
                                // messages
  double start_wait_ms = 2000;  // wait for a TCP listener
};

struct RigOutletCounts {
  std::uint64_t datagrams = 0, bytes = 0;
  std::uint64_t elsewhere = 0;  // from sources without an entry in `to`
};

// Sends recorded datagrams to the addresses where they should arrive again, from one socket or
// connection per recorded sender. Datagrams of the native protocol (proto/styled/v1/WIRE.md) get
// new session ids; otherwise a daemon that has seen the recording would drop them as repetitions.
// All others are sent unchanged. Pieces of a native TCP stream are first joined to whole datagrams.
// Before a performer's new session the outlet keeps the recorded silence, up to 150 ms at any
// speed, because the daemon accepts a new session only after such a pause.
class RigOutlet final : public Outlet {
 public:
  // `steering` may be null; otherwise it is notified of each datagram and limits the pace.
  RigOutlet(RigOutletOptions options, player::Clock& clock, Steering* steering);

  void Note(const recording::Record& record) override;
  Status Play(const recording::Record& record) override;
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

  // A recorded TCP connection of native datagrams.
  struct Stream {
    std::vector<std::byte> buffer = std::vector<std::byte>(2 * native::kMaxDatagramSize);
    native::StreamReader reader{buffer};
    // Lost synchronization: a daemon closes the connection there, and nothing follows.
    bool broken = false;
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
  std::map<Sender, std::unique_ptr<player::Link>> links_;  // null: not sent
  std::map<Sender, Stream> streams_;
  std::map<std::pair<std::string, std::uint64_t>, std::string> performers_;  // source, session
  std::map<std::string, Session> sessions_;                                  // by performer's id
  // The last body of each performer before the played part.
  std::map<std::string, recording::Record> noted_;
  std::uint64_t salt_ = 0;  // to derive new session ids from the recorded ones
  std::vector<std::byte> buffer_;
  RigOutletCounts counts_;
};

}  // namespace styled::rec

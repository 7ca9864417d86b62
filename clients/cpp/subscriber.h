#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/cpp/curve.h"
#include "model/base/status.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::client {

inline constexpr std::string_view kDefaultPublisher = "tcp://127.0.0.1:7001";

// What a performer is published as (proto/styled/v1/WIRE.md).
enum class Stream {
  kStyledRig,        // styled, on the rig's own skeleton
  kStyledCanonical,  // styled, on the canonical humanoid
  kSource,           // as received, on the rig's own skeleton
  kAvatar,           // styled, on an avatar of the daemon's configuration: an [[output]]
};

struct SubscriberOptions {
  // At least one; several daemons may be listened to at once (their performers' ids must differ).
  std::vector<std::string> endpoints = {std::string(kDefaultPublisher)};
  std::string performer;  // SOURCE.NAME; "" = all, those that come later too
  std::vector<Stream> streams = {Stream::kStyledRig};  // empty: bodies and statistics only
  // [A-Za-z0-9_-]{1,32}: the [[output]]s to listen to, each a further stream of kAvatar, which is
  // not named in `streams`.
  std::vector<std::string> avatars;
  bool statistics = false;     // Stats, once a second
  int queue_messages = 1000;   // waiting in this process before the newest are dropped; > 0
  std::optional<Curve> curve;  // for daemons that ask for keys; the same for all endpoints
};

// One thing that arrived.
struct Update {
  enum class Kind {
    kFrame,       // `frame`, `stream`, `body`, `missed`, `skipped`, `new_epoch`
    kBody,        // `body`: a skeleton not seen before; replays of a known one are dropped
    kStatistics,  // `statistics`
  };
  Kind kind = Kind::kFrame;
  Stream stream = Stream::kStyledRig;
  std::string avatar;  // of Stream::kAvatar: the [[output]]'s name; else ""
  v1::Frame frame;
  // The skeleton of `frame`, checked (client::Validate), never changed; null while it has not
  // arrived: the daemon sends it on subscription and once a second.
  std::shared_ptr<const v1::Body> body;
  std::uint64_t missed = 0;   // frames of this stream lost on the way just before this one
  std::uint64_t skipped = 0;  // ReceiveLatest only: older frames that this one superseded
  bool new_epoch = false;     // the daemon was restarted since the stream's last frame
  v1::Stats statistics;
};

// Since Connect. Nothing is ever reset.
struct SubscriberCounters {
  std::uint64_t frames = 0;           // accepted
  std::uint64_t missed = 0;           // lost by sequence, summed over streams
  std::uint64_t epochs = 0;           // restarts of the daemon, seen per stream
  std::uint64_t bodies = 0;           // new skeletons
  std::uint64_t replayed_bodies = 0;  // dropped: already known
  std::uint64_t repeated_frames = 0;  // dropped: sequence not above the last
  std::uint64_t malformed = 0;        // dropped: not of WIRE.md, not parseable, impossible body,
                                      // or a frame that does not fit its body
};

// Listens to one or several daemons. Connects in the background and reconnects by itself, for as
// long as it is read from (libzmq subscribes anew inside Receive); `connected` says how it stands.
// Frames come as they were published, in order per stream, gaps counted.
//
// One thread at a time. Allocates while receiving (libzmq does); an Update that is passed in again
// reuses its memory. Pinned by tests/unit/clients/subscriber_test.cpp.
class Subscriber {
 public:
  // Refuses: no endpoint, an endpoint that ZeroMQ cannot parse, a performer that is not
  // SOURCE.NAME, an avatar's name that is none, kAvatar among `streams`, queue_messages < 1, keys
  // that are none. That nobody listens there is no error.
  static Result<std::unique_ptr<Subscriber>> Connect(const SubscriberOptions& options);
  ~Subscriber();
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  // Every-frame mode: waits up to `timeout` (0 = only what is here already) for the next update.
  // False: nothing came, or a signal interrupted the wait; `out` is unspecified then.
  bool Receive(std::chrono::milliseconds timeout, Update& out);

  // Latest-wins mode, for a renderer: waits up to `timeout` for a first update, then reads all that
  // is waiting and keeps the newest frame of each performer and stream, and every body and the
  // newest statistics. Writes them to `out` (what it held is lost) and returns how many. A reader
  // that draws slower than 120 Hz so never lags behind. One that was stopped, or whose network was,
  // finds seconds of frames in the sockets on the way: while what comes is 50 ms later than usual
  // it reads on, for half a second at most.
  int ReceiveLatest(std::chrono::milliseconds timeout, std::vector<Update>& out);

  // Endpoints with a live connection. It says nothing about frames: a daemon without a rig is
  // silent.
  int connected();

  // Ids whose bodies have been seen, sorted, all modes. With a performer in the options: only that.
  std::vector<std::string> performers() const;

  const SubscriberCounters& counters() const;

 private:
  struct Impl;
  explicit Subscriber(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Whether `id` is SOURCE.NAME, each part [A-Za-z0-9_-]{1,32}.
bool IsPerformerId(std::string_view id) noexcept;

}  // namespace styled::client

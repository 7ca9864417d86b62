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

// The streams in which a performer is published (proto/styled/v1/WIRE.md).
enum class Stream {
  kStyledRig,        // styled, on the rig's own skeleton
  kStyledCanonical,  // styled, on the canonical humanoid
  kSource,           // as received, on the rig's own skeleton
  kAvatar,           // styled, retargeted to an avatar: an [[output]] of the daemon's configuration
};

struct SubscriberOptions {
  // At least one. With several daemons, the ids of their performers must differ. The exception is a
  // pair with a standby (daemon/standby/README.md): each frame is delivered once. One entry may
  // hold several, with commas.
  std::vector<std::string> endpoints = {std::string(kDefaultPublisher)};
  std::string performer;  // SOURCE.NAME; "" = all, including those that appear later
  std::vector<Stream> streams = {Stream::kStyledRig};  // empty: bodies and statistics only
  // The [[output]]s to listen to, by name ([A-Za-z0-9_-]{1,32}). Each is one more stream, of kind
  // kAvatar; kAvatar must not appear in `streams`.
  std::vector<std::string> avatars;
  bool every_avatar = false;  // also every [[output]] whose body arrives, named in `avatars` or not
  bool keep_bytes = false;    // Update::bytes, for programs that pass messages on
  // Frames of all performers in one message per cycle of the daemon (WIRE.md, "frames/"), for
  // clients that show many at once. `performer` must be "". Avatars' frames arrive as usual. Needs
  // a daemon that has these topics; an older one sends nothing.
  bool bundled = false;
  bool statistics = false;    // Stats, once per second
  int queue_messages = 1000;  // queue of this process; when it is full, the newest are dropped; > 0
  std::optional<Curve> curve;  // for daemons that require keys; the same for all endpoints
};

// One received message.
struct Update {
  enum class Kind {
    kFrame,       // `frame`, `stream`, `body`, `missed`, `skipped`, `new_epoch`
    kBody,        // `body`: a skeleton not seen before; repetitions of a known one are dropped
    kStatistics,  // `statistics`
  };
  Kind kind = Kind::kFrame;
  Stream stream = Stream::kStyledRig;
  std::string avatar;  // for Stream::kAvatar: the [[output]]'s name; else ""
  v1::Frame frame;
  // The skeleton of `frame`, checked by client::Validate, never modified. Null until it has
  // arrived; the daemon sends it on subscription and then once per second.
  std::shared_ptr<const v1::Body> body;
  std::uint64_t missed = 0;   // frames of this stream lost in transit directly before this one
  std::uint64_t skipped = 0;  // ReceiveLatest only: older frames that this one superseded
  bool new_epoch = false;     // the daemon restarted since the previous frame of this stream
  std::string bytes;  // the payload as received, for a bundle the frame alone; only with keep_bytes
  v1::Stats statistics;
};

// Totals since Connect; never reset.
struct SubscriberCounters {
  std::uint64_t frames = 0;           // accepted
  std::uint64_t missed = 0;           // lost in transit, by gaps in `sequence`, summed over streams
  std::uint64_t epochs = 0;           // restarts of the daemon, counted once per stream
  std::uint64_t bodies = 0;           // new skeletons
  std::uint64_t replayed_bodies = 0;  // dropped: already known
  std::uint64_t repeated_frames = 0;  // dropped: sequence not greater than the last
  std::uint64_t malformed = 0;  // dropped: not as in WIRE.md, not parseable, an invalid body, or a
                                // frame that does not fit its body
};

// Subscribes to one or several daemons. It connects in the background. It also reconnects by
// itself, but only while Receive is called, since libzmq renews subscriptions inside it;
// connected() returns the current state. Frames are delivered as published, in order per stream;
// gaps are counted.
//
// One thread at a time. libzmq allocates on every receive; an Update that is passed in again reuses
// its memory. Pinned by tests/unit/clients/subscriber_test.cpp.
class Subscriber {
 public:
  // Refuses: no endpoint, an endpoint that ZeroMQ cannot parse, a performer that is not
  // SOURCE.NAME, an invalid avatar name, kAvatar in `streams`, `bundled` with a performer,
  // queue_messages < 1, and invalid keys. A missing daemon is not an error.
  static Result<std::unique_ptr<Subscriber>> Connect(const SubscriberOptions& options);
  ~Subscriber();
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  // Every-frame mode: waits up to `timeout` for the next update; 0 returns only what has already
  // arrived. False: nothing arrived, or a signal interrupted the wait; `out` is unspecified then.
  bool Receive(std::chrono::milliseconds timeout, Update& out);

  // Latest-wins mode, for a renderer. Waits up to `timeout` for a first update, then reads all
  // waiting messages. Keeps the newest frame per performer and stream, every body, and the newest
  // statistics. Replaces the contents of `out` and returns the number of updates. A reader that
  // draws at less than 120 Hz therefore does not lag behind. After the process or its network was
  // suspended, seconds of frames are queued in the sockets: as long as messages arrive 50 ms later
  // than usual, this function keeps reading, for at most 0.5 s.
  int ReceiveLatest(std::chrono::milliseconds timeout, std::vector<Update>& out);

  // Number of endpoints with a live connection. It does not show whether frames arrive: a daemon
  // without a rig publishes none.
  int connected();

  // Ids of the performers whose bodies were seen, in any mode, sorted. If the options name a
  // performer, only that one.
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

#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "clients/cpp/control.h"
#include "clients/cpp/subscriber.h"
#include "clients/nats/commands.h"
#include "clients/nats/frame_queue.h"
#include "clients/nats/link.h"
#include "clients/nats/sender.h"
#include "clients/nats/state_store.h"
#include "model/base/status.h"

namespace styled::stylenats {

struct Options {
  std::string publisher = std::string(client::kDefaultPublisher);
  std::string control = std::string(client::kDefaultControl);
  std::optional<client::Curve> curve;  // for a daemon that requires keys
  std::string site;                    // 1 to kMaxSite bytes; the first token after "styled."
  std::string domain;                  // of JetStream; "": the account's own
  LinkOptions link;
};
inline constexpr std::size_t kMaxSite = 64;
Status CheckSite(const std::string& site);

// Totals since Open, a copy.
struct Totals {
  std::uint64_t sent = 0, audience = 0, bodies = 0;
  std::uint64_t replaced = 0, refused = 0, disconnected = 0, too_large = 0, failed = 0;
  std::uint64_t stalled = 0, longest_call_us = 0;
  std::uint64_t missed = 0;     // lost between daemon and this program
  std::uint64_t malformed = 0;  // invalid messages of the daemon
  std::uint64_t written = 0, unwritten = 0, unkept = 0;
  std::uint64_t requests = 0, unanswered = 0, unsent_replies = 0;
  bool operator==(const Totals&) const = default;
};

// Subscribes to all streams of a daemon, and passes each frame's bytes on to NATS as they are:
// "styled.SITE.PERFORMER.STREAM", the audience tier, bodies beside their frames and in the KV
// bucket, performers in the bucket, commands (README.md). The thread that calls Step reads ZeroMQ
// and never waits for the broker.
//
// One thread. Pinned by tests/e2e/nats.
class Bridge {
 public:
  // Errors: endpoints, keys and addresses that cannot be parsed, files that cannot be read. Neither
  // daemon nor broker need to be running.
  static Result<std::unique_ptr<Bridge>> Open(const Options& options);
  ~Bridge();

  // Waits up to `timeout` for messages of the daemon and passes on all that have arrived.
  void Step(std::chrono::milliseconds timeout);
  // Sends and flushes the waiting messages; takes up to `patience`, or until a call of libnats
  // returns (1 s).
  void Stop(std::chrono::milliseconds patience);

  Totals totals() const;
  Link& link() { return *link_; }
  FrameQueue& queue() { return queue_; }
  StateStore& store() { return *store_; }
  int connected() { return subscriber_->connected(); }  // daemons: 0 or 1
  // True once, after frames of an [[output]] with the audience tier's name arrived: it is not
  // passed on.
  bool NextRefusedOutput();

 private:
  explicit Bridge(std::string site) : site_(std::move(site)), queue_(site_) {}
  void Pass(const client::Update& update);
  void PassBody(const client::Update& update, std::string_view stream);
  void Keep(const client::Update& update);
  void KeepPerformers(const v1::Stats& statistics);

  std::string site_;
  FrameQueue queue_;
  AudienceTier tier_;
  BodyBeat beat_;
  std::uint64_t audience_ = 0;
  std::set<std::string> performers_;  // those in the bucket
  bool output_refused_ = false, refusal_taken_ = false;
  client::Update update_;
  std::unique_ptr<client::Subscriber> subscriber_;
  std::unique_ptr<Link> link_;  // the rest uses it, and ends before it
  std::unique_ptr<StateStore> store_;
  std::unique_ptr<Commands> commands_;
  std::unique_ptr<Sender> sender_;
};

// The part of a performer's statistics that is stored in the bucket: the description of the
// performer and the style, not values that change every second (rates, latencies, counts).
v1::PerformerStats Lasting(const v1::PerformerStats& performer);

}  // namespace styled::stylenats

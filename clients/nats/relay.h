#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "clients/cpp/control.h"
#include "clients/cpp/subscriber.h"
#include "clients/nats/demand.h"
#include "clients/nats/link.h"
#include "clients/nats/values.h"
#include "model/base/status.h"

namespace styled::stylenats {

struct RelayOptions {
  // The address to listen on, as a daemon would: tcp:// on a loopback address, or ipc://.
  std::string publish = std::string(client::kDefaultPublisher);
  std::string control = std::string(client::kDefaultControl);
  std::string site, domain;  // as in Options
  LinkOptions link;
};

// Totals since Open, a copy.
struct RelayTotals {
  std::uint64_t passed = 0;  // frames
  // Frames that were replaced by newer ones, or for which there was no room: this program was late.
  std::uint64_t replaced = 0;
  std::uint64_t odd = 0;  // messages that are not stylenats' own, and values beyond the bounds
  std::uint64_t requests = 0, unanswered = 0;
  bool operator==(const RelayTotals&) const = default;
};

// The bridge's other end: publishes the site's messages from NATS on this machine like a daemon, so
// that every program that reads a daemon can read it unchanged. Frames are the daemon's bytes;
// bodies come from the KV bucket and are repeated once a second; statistics are made from the
// bucket, without rates, latencies and counts. Commands go to "styledctl.SITE" and the replies
// back. Not available: source/ and the bundles frames/, which NATS does not carry.
//
// Only data with a local reader is requested from the broker (Demand). Memory is bounded for any
// input. One thread; libnats' threads and that of Values pass their data to it. Pinned by
// tests/e2e/nats/relay_test.cpp.
class Relay {
 public:
  // Errors name the option: a site, an endpoint that is not local or is in use, and those of
  // Link::Open. The broker need not be running.
  static Result<std::unique_ptr<Relay>> Open(const RelayOptions& options);
  ~Relay();
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  // Waits up to `timeout` for messages, and passes on all that have arrived.
  void Step(std::chrono::milliseconds timeout);

  RelayTotals totals() const;
  Link& link() { return *link_; }
  std::string NextError() { return values_->NextError(); }  // of the bucket
  std::size_t subjects() const { return subscriptions_.size(); }

 private:
  struct Inbox;
  struct Subscription;
  // A client that waits for a reply.
  struct Pending {
    std::vector<std::string> envelope;
    std::uint64_t id = 0;
    std::chrono::steady_clock::time_point until;
  };

  explicit Relay(const RelayOptions& options);
  Status Bind();
  std::unique_ptr<Subscription> Subscribe(const std::string& subject) const;
  void HandleSubscriptions();
  void Follow();
  void HandleRequests();
  void Ask(std::vector<std::string> envelope, const std::string& bytes);
  void HandleFrames();
  void HandleValues();
  void HandleReplies();
  void Answer(const std::vector<std::string>& envelope, const std::string& bytes);
  void Refuse(const std::vector<std::string>& envelope, std::uint64_t id, v1::Code code,
              const std::string& reason);
  void Repeat();
  void SendBodies(std::string_view topic);
  void Send(std::string_view topic, std::string_view payload);

  RelayOptions options_;
  RelayTotals totals_;
  zmq::context_t context_{1};
  zmq::socket_t publisher_, control_;
  Demand demand_;
  std::shared_ptr<Inbox> inbox_;
  std::map<std::string, std::string> values_of_;  // by key
  std::size_t value_bytes_ = 0;
  std::map<std::uint64_t, Pending> pending_;
  std::uint64_t asked_ = 0;
  std::string reply_to_;  // the prefix of the subjects of replies
  std::chrono::steady_clock::time_point next_repeat_;
  std::unique_ptr<Link> link_;
  std::unique_ptr<Subscription> replies_;
  std::map<std::string, std::unique_ptr<Subscription>> subscriptions_;  // by subject
  std::unique_ptr<Values> values_;
};

}  // namespace styled::stylenats

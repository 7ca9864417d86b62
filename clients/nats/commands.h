#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "clients/cpp/asker.h"
#include "clients/cpp/curve.h"
#include "clients/nats/link.h"
#include "model/base/status.h"

namespace styled::stylenats {

// Answers requests at "styledctl.SITE": the payload is a Request (proto/styled/v1/control.proto),
// the answer a Reply. Requests go to the daemon's control socket, with the given keys, and the
// daemon decides on them; NATS' permissions decide which users may send them. Requests without an
// answer of the daemon are answered here, with an error that names the failure: CODE_BUSY without
// an answer of the daemon, CODE_MALFORMED, CODE_TOO_LARGE for an answer above the broker's
// max_payload.
//
// Reads on a thread of its own; the requests run on the asker's threads.
class Commands {
 public:
  // Totals since the start; any thread.
  struct Counts {
    std::atomic<std::uint64_t> requests{0};
    std::atomic<std::uint64_t> left{0};        // to the bridge of the daemon that leads
    std::atomic<std::uint64_t> unanswered{0};  // by the daemon, in time
    std::atomic<std::uint64_t> too_large{0};   // answers above max_payload
    std::atomic<std::uint64_t> lost{0};        // answers that could not be sent
  };

  // Refuses a control endpoint that ZeroMQ cannot parse, and invalid keys.
  static Result<std::unique_ptr<Commands>> Start(Link& link, const std::string& site,
                                                 const std::string& control,
                                                 const std::optional<client::Curve>& curve);
  ~Commands();
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  const Counts& counts() const { return counts_; }

 private:
  explicit Commands(Link& link) : link_(link) {}
  bool Subscribed();
  void Loop(const std::stop_token& stop);
  void Ask(const std::string& reply_to, const char* bytes, int size);
  void Answer(const std::string& reply_to, const v1::Reply& reply);

  Link& link_;
  std::string subject_;
  Counts counts_;
  natsSubscription* subscription_ = nullptr;
  std::unique_ptr<client::Asker> asker_;
  std::jthread thread_;  // last: it ends before the rest
};

}  // namespace styled::stylenats

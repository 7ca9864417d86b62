#pragma once

#include <zmq.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/control/osc_socket.h"
#include "daemon/looks/mailboxes.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/zmq_socket.h"
#include "daemon/security/gatekeeper.h"
#include "model/base/status.h"

namespace styled::control {

inline constexpr std::size_t kMaxRequestBytes = 64 * 1024;
// The limit of a request that has a clip, a style or a checkpoint.
inline constexpr std::size_t kMaxFileRequestBytes = 8 * 1024 * 1024;

// The control socket, on its own thread. It parses requests, passes them to the pipeline between
// frames, and sends the pipeline's replies back. Malformed, oversized and unauthorized requests are
// answered here. It never waits for the pipeline.
class ControlSocket {
 public:
  // `osc` may be null (no OSC), and so may `access` (no keys required).
  ControlSocket(runtime::ZmqSocket socket, std::unique_ptr<OscSocket> osc, security::Access* access,
                pipeline::Mailboxes& mailboxes, runtime::Counters& counters);
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

  // Handles pending replies, requests and OSC datagrams, and returns how many there were.
  int DoWork();
  void Run();   // calls DoWork until Stop(), and sleeps while there is nothing to do
  void Stop();  // any thread

 private:
  // Receives one message into `parts_`; false when none is waiting.
  bool Receive();
  void Handle();
  // Whether the sender of the last message is (still) authorized.
  Status CheckSender();
  // Whether a request of `bytes` has an allowed size.
  static Status CheckSize(std::size_t bytes, bool has_file);
  void HandleOsc();
  // A design of OSC: a fader sends many, and only the newest values count.
  void Merge(std::unique_ptr<pipeline::Exchange> design);
  int PassDesigns();
  // Passes the exchange to the pipeline. False when too many are in flight: nothing is moved then,
  // and the exchange has its reply.
  bool Pass(std::unique_ptr<pipeline::Exchange>& exchange);
  void Busy(pipeline::Exchange& exchange, const std::string& why);
  void Refuse(const std::vector<std::vector<std::byte>>& envelope, const Status& status);
  void Send(const std::vector<std::vector<std::byte>>& envelope, const v1::Reply& reply);

  runtime::ZmqSocket socket_;
  std::unique_ptr<OscSocket> osc_;
  security::Access* access_;
  pipeline::Mailboxes& mailboxes_;
  runtime::Counters& counters_;
  zmq_msg_t message_;
  std::vector<std::vector<std::byte>> parts_;
  std::size_t part_count_ = 0;
  int in_flight_ = 0;
  std::vector<std::unique_ptr<pipeline::Exchange>> designs_;  // that wait; one of each performer
  bool designing_ = false;                                    // one of them is in flight
  std::atomic<bool> stop_{false};
};

// `keeper` admits only operators with a key; null admits every client that can reach the address.
Result<std::unique_ptr<ControlSocket>> MakeControlSocket(
    void* context, const config::Control& config, std::unique_ptr<OscSocket> osc,
    pipeline::Mailboxes& mailboxes, runtime::Counters& counters, std::string& endpoint,
    security::Gatekeeper* keeper = nullptr);

}  // namespace styled::control

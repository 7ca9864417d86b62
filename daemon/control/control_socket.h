#pragma once

#include <zmq.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/control/osc_socket.h"
#include "daemon/pipeline/mailboxes.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/zmq_socket.h"
#include "daemon/security/gatekeeper.h"
#include "model/base/status.h"

namespace styled::control {

inline constexpr std::size_t kMaxRequestBytes = 64 * 1024;

// The control socket, on its own thread: parses requests, sends them to the pipeline between frames
// and its replies back. What cannot be a request is answered here. Never waits for the pipeline.
class ControlSocket {
 public:
  // `osc` and `access` may be null.
  ControlSocket(runtime::ZmqSocket socket, std::unique_ptr<OscSocket> osc, security::Access* access,
                pipeline::Mailboxes& mailboxes, runtime::Counters& counters);
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

  int DoWork();
  void Run();   // DoWork until Stop(), waiting in between
  void Stop();  // any thread

 private:
  // One message, its parts in `parts_`; false when there is none.
  bool Receive();
  void Handle();
  // Why the sender of the last message may not ask (any more); "" = he may.
  std::string Unauthorized();
  void HandleOsc();
  // To the pipeline; false, and nothing is moved, where too much waits there already.
  bool Pass(std::unique_ptr<pipeline::Exchange>& exchange);
  void Refuse(const std::vector<std::vector<std::byte>>& envelope, v1::Code code,
              const std::string& reason);
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
  std::atomic<bool> stop_{false};
};

// `keeper`: lets in operators with keys alone; null: everybody who can reach the address.
Result<std::unique_ptr<ControlSocket>> MakeControlSocket(
    void* context, const config::Control& config, std::unique_ptr<OscSocket> osc,
    pipeline::Mailboxes& mailboxes, runtime::Counters& counters, std::string& endpoint,
    security::Gatekeeper* keeper = nullptr);

}  // namespace styled::control

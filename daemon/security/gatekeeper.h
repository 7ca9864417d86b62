#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/wakeup.h"
#include "daemon/runtime/zmq_socket.h"
#include "daemon/security/access.h"
#include "model/base/descriptor.h"
#include "model/base/status.h"
#include "proto/keys/key_file.h"

namespace styled::security {

// Answers libzmq's question during a handshake whether a client is allowed (ZAP), and follows the
// folder of keys, so that `stylectl allow` and `revoke` take effect at once. Runs on a thread of
// its own that the pipeline never waits for. Create it before the sockets that it guards are bound,
// and destroy it after them: without a ZAP handler libzmq admits every client.
class Gatekeeper {
 public:
  // Reads the folder, and creates the daemon's own key pair if there is none. Errors name the file.
  static Result<std::unique_ptr<Gatekeeper>> Open(void* context, const std::string& folder,
                                                  runtime::Counters& counters);
  ~Gatekeeper();
  Gatekeeper(const Gatekeeper&) = delete;
  Gatekeeper& operator=(const Gatekeeper&) = delete;

  // Configures `socket`, which must not be bound yet, to admit only clients with a key for `door`.
  Status Guard(runtime::ZmqSocket& socket, Door door);
  // The same for a socket between the two daemons: it admits operators' keys.
  Status GuardPeers(runtime::ZmqSocket& socket);
  // Configures `socket`, which must not be connected yet, to show this daemon's own key to the
  // daemon whose public key is `server_key`.
  Status Introduce(runtime::ZmqSocket& socket, const std::string& server_key) const;
  const std::string& public_key() const { return pair_.public_key; }
  Access& access() { return access_; }

  // Starts the loop on its own thread; the destructor ends it.
  void Start();
  // One turn of the loop, public for tests. Returns false when there was nothing to do.
  bool DoWork();

 private:
  Gatekeeper(void* context, const std::string& folder, runtime::Counters& counters,
             keys::KeyFile pair);
  Status Bind();
  Status Encrypt(runtime::ZmqSocket& socket, Door door) const;
  void Watch();
  void Run();
  bool Answer();
  bool CountFailures();
  bool FollowFolder();
  void Reread();
  void Tick(std::int64_t now_ns);
  bool Admit(const ZapRequest& request);
  void Reply(const std::string& id, const std::string& user);

  std::string folder_;
  runtime::Counters& counters_;
  keys::KeyFile pair_;
  Access access_;
  runtime::SystemClock clock_;
  runtime::ZmqSocket zap_;
  std::array<runtime::ZmqSocket, 2> failures_;  // libzmq's monitors of failed handshakes, by door
  Descriptor inotify_;
  int watch_ = -1;
  runtime::Wakeup wake_;
  std::vector<std::string> frames_;
  zmq_msg_t message_;
  std::vector<std::string> complaints_;
  std::string refusal_;  // the last refusal, not logged yet
  std::string logged_refusal_;
  std::int64_t next_tick_ns_ = 0, log_again_ns_ = 0;
  bool reread_ = false;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace styled::security

#pragma once

#include <chrono>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/curve.h"
#include "model/base/status.h"

namespace styled::client {

// The daemon's socket that the client connects to.
enum class Peer { kControl, kPublisher };

// The obstacle between a client and a daemon's socket.
enum class Obstacle {
  kNone,         // nothing: the handshake succeeds
  kBadEndpoint,  // the endpoint is malformed
  kUnknownHost,  // the host name does not resolve
  kUnreachable,  // no route, or the machine does not answer
  kNobody,       // the machine answers, but no program listens on that port
  kNoFile,       // ipc: the file does not exist
  kNoSocket,     // ipc: the file is not a socket
  kLeftBehind,   // ipc: the program that made the socket has ended
  kForbidden,    // ipc: the file's mode denies access to this user
  kNoEntry,      // ipc: a folder of the path denies access to this user
  kTurnedAway,   // connected, then closed by the peer during the handshake
  kAsksForKeys,  // the daemon requires CURVE, and no keys were given
  kAsksForNone,  // keys were given, but the daemon does not use CURVE
  kWrongKeys,    // the daemon's public key differs from the given one
  kNotLetIn,     // the daemon does not accept the client's key, or not in this role
  kOtherSocket,  // ZeroMQ, but another socket: the publisher instead of the control socket
  kNotZeroMq,    // a program listens that does not speak ZeroMQ, or sends nothing
};

struct Reach {
  Obstacle obstacle = Obstacle::kNone;
  std::string text;  // for display: "no program listens there (Connection refused)"; "" for kNone
};

// The endpoints of a list with commas; at least one, which may be "".
std::vector<std::string> SplitEndpoints(const std::string& endpoints);

// Checks the text of `endpoint`; does not connect. A tcp:// endpoint needs a host and a port:
// ZeroMQ silently reads "127.0.0.1:99999" and "127.0.0.1:22002x" as other ports. Endpoints of other
// transports are left for ZeroMQ to check. Any thread.
Status CheckEndpoint(const std::string& endpoint);

// Finds out why nothing arrived, by a new connection to `endpoint`. Takes at most `timeout`,
// usually a few milliseconds. The text names no command-line option; clients/cpp/key_options.h
// does. Any thread; blocks. Pinned by tests/unit/clients/reach_test.cpp.
Reach Examine(const std::string& endpoint, Peer peer, const std::optional<Curve>& curve,
              std::chrono::milliseconds timeout = std::chrono::milliseconds(500));

// Runs Examine() on a thread of its own, so that a caller that draws or serves does not wait. One
// thread at a time.
class Lookout {
 public:
  Lookout(std::string endpoint, Peer peer, std::optional<Curve> curve)
      : endpoint_(std::move(endpoint)), peer_(peer), curve_(std::move(curve)) {}

  // The last result. Call this repeatedly while there is no connection: the first examination
  // starts after 500 ms without one, further ones at most every 2 s.
  const Reach& Look();
  // Call this while there is a connection: it discards the last result.
  void Rest();
  const Reach& found() const { return found_; }  // the last result, without a new examination
  const std::string& endpoint() const { return endpoint_; }

 private:
  static constexpr std::chrono::milliseconds kPatience{500};  // connecting takes no longer, usually
  static constexpr std::chrono::seconds kAgain{2};  // limits how often the daemon logs a refusal
  std::string endpoint_;
  Peer peer_;
  std::optional<Curve> curve_;
  Reach found_;
  std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now() + kPatience;
  std::future<Reach> under_way_;  // its destructor waits, at most for Examine's timeout
};

}  // namespace styled::client

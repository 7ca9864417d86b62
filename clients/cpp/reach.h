#pragma once

#include <chrono>
#include <future>
#include <optional>
#include <string>

#include "clients/cpp/curve.h"
#include "model/base/status.h"

namespace styled::client {

// Which of a daemon's sockets was to be reached.
enum class Peer { kControl, kPublisher };

// What stands between a client and a daemon's socket.
enum class Obstacle {
  kNone,         // the handshake works: the daemon is there
  kBadEndpoint,  // the endpoint's text is wrong
  kUnknownHost,  // no such name
  kUnreachable,  // no route, or no answer from that machine at all
  kNobody,       // the machine answers, nobody listens at that port
  kNoFile,       // ipc: no such file
  kNoSocket,     // ipc: the file is no socket
  kLeftBehind,   // ipc: a socket whose program is gone
  kForbidden,    // ipc: the file's mode keeps this user out
  kNoEntry,      // ipc: a folder on the way to it keeps this user out
  kTurnedAway,   // connected, and closed during the handshake
  kAsksForKeys,  // it wants CURVE, and no keys were given
  kAsksForNone,  // keys were given, and it knows no CURVE
  kWrongKeys,    // the daemon's key is another than the one given
  kNotLetIn,     // the daemon does not let our key in, or not in this role
  kOtherSocket,  // ZeroMQ, but not that socket: the publisher instead of the control socket
  kNotZeroMq,    // something listens that does not speak ZeroMQ, or says nothing
};

struct Reach {
  Obstacle obstacle = Obstacle::kNone;
  std::string text;  // for people: "nobody listens there (Connection refused)"; "" for kNone
};

// Whether `endpoint` can be connected to at all, as far as its text tells: a tcp:// endpoint needs
// a host and a port. ZeroMQ takes "127.0.0.1:99999" and "127.0.0.1:22002x" for other ports, and
// silently. Of other transports ZeroMQ is the judge. Any thread.
Status CheckEndpoint(const std::string& endpoint);

// Finds out by connecting once more, after nothing came: takes at most `timeout`, mostly
// milliseconds. Names no option of a program: clients/cpp/key_options.h does. Any thread; blocks.
// Pinned by tests/unit/clients/reach_test.cpp.
Reach Examine(const std::string& endpoint, Peer peer, const std::optional<Curve>& curve,
              std::chrono::milliseconds timeout = std::chrono::milliseconds(500));

// Examines on a thread of its own, so that who draws or serves does not wait. One thread at a time.
class Lookout {
 public:
  Lookout(std::string endpoint, Peer peer, std::optional<Curve> curve)
      : endpoint_(std::move(endpoint)), peer_(peer), curve_(std::move(curve)) {}

  // What was found last. Call it now and again while there is no link: it examines once in two
  // seconds at most, first after half a second without a link.
  const Reach& Look();
  // There is a link: what was found before says nothing any more.
  void Rest();
  const Reach& found() const { return found_; }  // without examining
  const std::string& endpoint() const { return endpoint_; }

 private:
  static constexpr std::chrono::milliseconds kPatience{500};  // a link takes that long at most
  static constexpr std::chrono::seconds kAgain{2};            // a daemon may log each refusal
  std::string endpoint_;
  Peer peer_;
  std::optional<Curve> curve_;
  Reach found_;
  std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now() + kPatience;
  std::future<Reach> under_way_;  // its destructor waits, for Examine's timeout at most
};

}  // namespace styled::client

#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"
#include "model/body/pose.h"
#include "sim/player/link.h"
#include "sim/player/props.h"

namespace styled::rigs {

// The poses of all performers at one instant, as in the rig's software.
struct Frame {
  std::uint64_t index = 0;  // in this session
  double time_s = 0;        // since the session began
  // One per performer; canonical: right-handed, +Y up, +Z forward, +X left, metres. A NaN rotation:
  // not tracked.
  std::span<const body::Pose> poses;
  // The same without untracked joints, for sensors that do not depend on the parent's; empty:
  // unknown.
  std::span<const body::Pose> whole = {};
  // The positions of Options::props, in its order and in canonical axes; empty: not tracked.
  std::span<const std::optional<rig::Placed>> props = {};
};

// Sends a datagram; calls keep the order. The bytes are valid during the call.
using Send = std::function<void(std::span<const std::byte>)>;

struct Options {
  std::vector<std::string> performers{"sim"};  // names, one per pose
  double rate_hz = 60;
  std::uint64_t seed = 1;
  // Quirks by name, e.g. "t-first", "tcp", "lz4", "4.1". Each rig's header lists those it has;
  // Make() refuses others.
  std::vector<std::string> quirks;
  std::vector<player::PropSpec> props = {};
};

// The state of a TCP server for one of its clients, until the client leaves. One thread.
class Session {
 public:
  virtual ~Session() = default;
  // The client's bytes, cut anywhere. Answers go to that client. False: it is disconnected.
  virtual bool Receive(std::span<const std::byte> bytes, const Send& send) = 0;
  // Sends Encode's data for all clients on to this one, as far as it has requested it.
  virtual void Forward(std::span<const std::byte> bytes, const Send& send) = 0;
};

// Simulates the sending software of a rig: encodes poses of the canonical humanoid in the rig's
// protocol, with the habits of the real software. May allocate. One thread.
class Rig {
 public:
  Rig() = default;
  virtual ~Rig() = default;
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  // Sends all datagrams of one frame.
  virtual void Encode(const Frame& frame, const Send& send) = 0;
  // The software restarts; the next frame has index 0.
  virtual void Restart() {}
  // Handles a datagram received on the sender's socket (a handshake, a heartbeat). Replies go to
  // `send`, which in this call sends to the peer of that datagram.
  virtual void Receive(std::span<const std::byte> /*datagram*/, const Send& /*send*/) {}

  // The default destination of such a rig, "udp://127.0.0.1:9763". For a server, which sends to the
  // clients that connect, the address on which it listens.
  virtual std::string default_address() const = 0;
  virtual bool is_server() const { return false; }
  // For such a server over UDP.
  virtual player::Audience audience() const { return player::Audience::kAllWhoSpeak; }
  // For a server over TCP: a client has connected, and `send` sends to it. `others` are connected
  // already. Null: it is disconnected. (sim/rigs/stream_server.h calls this.)
  virtual std::unique_ptr<Session> Accept(std::size_t /*others*/, const Send& /*send*/) {
    return nullptr;
  }
};

// The words of all rigs, "native, mocopi, ...".
std::string Words();
// Makes the simulated rig of a type ("mvn", ...): Make<Name>() of its row in proto/rigs/types.h.
// Errors name the type and list the known ones. "native" has none (sim/player).
Result<std::unique_ptr<Rig>> Make(const std::string& type, const Options& options);

// For implementations of Rig: whether the options have a quirk.
bool HasQuirk(const Options& options, std::string_view quirk);
// Refuses quirks not in `quirks`, more performers than `max_performers`
// (0: unlimited), and more props than `max_props`.
Status CheckOptions(const std::string& type, const Options& options, int max_performers,
                    std::initializer_list<std::string_view> quirks, std::size_t max_props = 0);

}  // namespace styled::rigs

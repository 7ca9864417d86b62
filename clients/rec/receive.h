#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "proto/recording/writer.h"

namespace styled::rec {

// One port for a rig. `name` and `type` as in styled.toml's [[source]].
struct Port {
  std::string name = "rig", type = "udp";
  std::string listen;   // HOST:PORT to bind, numeric; port 0 is chosen by the system
  std::string forward;  // HOST:PORT; "" = do not forward
};

struct ReceiveCounts {
  std::uint64_t datagrams = 0, bytes = 0;
  std::uint64_t forwarded = 0;  // datagrams passed on to `forward`
  std::uint64_t answered = 0;   // datagrams from `forward`, passed back to the rig
  std::uint64_t dropped = 0;    // lost in the kernel because its buffer was full
};

// Receives a rig's datagrams instead of the daemon and records every one before anything can reject
// it. With `forward` it is between rig and daemon: each sender is forwarded from its own socket,
// and replies to that socket go back to the sender (they are not recorded). At most 64 senders are
// forwarded.
class Receiver {
 public:
  // Binds. Errors name the address.
  static Result<std::unique_ptr<Receiver>> Open(std::vector<Port> ports);
  ~Receiver();
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  // The bound address of each port, "udp://127.0.0.1:43211".
  std::vector<std::string> endpoints() const;

  // Records until `stop` is set or `seconds` (0: unlimited) have passed.
  Status Run(recording::FileWriter& writer, double seconds, const std::atomic<bool>& stop);
  const ReceiveCounts& counts() const { return counts_; }

 private:
  struct Socket;
  struct Peer;
  Receiver() = default;
  Status Bind(Port port);
  Status Drain(Socket& socket, recording::FileWriter& writer);
  void Forward(Socket& socket, std::size_t size);
  void PassBack(Peer& peer);

  std::vector<std::unique_ptr<Socket>> sockets_;
  std::vector<std::unique_ptr<Peer>> peers_;
  std::vector<char> buffer_ = std::vector<char>(65536);
  recording::Record record_;
  ReceiveCounts counts_;
};

}  // namespace styled::rec

#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"

namespace styled::player {

// A destination for datagrams. Calls may block. One thread.
class Link {
 public:
  virtual ~Link() = default;
  // Sends one whole datagram, or one record of a stream.
  virtual Status Send(std::span<const std::byte> datagram) = 0;
  // Reads one datagram sent back, if there is one. Returns its size, else 0. Never blocks.
  virtual std::size_t Receive(std::span<std::byte> /*datagram*/) { return 0; }
  // Number of datagrams reported as refused because no program listens on that port; 0 if unknown.
  virtual std::uint64_t refused() { return 0; }
  // Sends to the peer of the last received datagram.
  virtual Status Answer(std::span<const std::byte> datagram) { return Send(datagram); }
};

// Connects to "udp://HOST:PORT" or "tcp://HOST:PORT" (IPv6 hosts in brackets). A missing UDP
// receiver is not an error: if the other machine reports it, Link::refused() counts it and sending
// continues. TCP is retried for `start_wait_ms` if no program listens; when a connection is lost,
// Send() fails, and reconnects once a second. Errors name the address and the reason.
Result<std::unique_ptr<Link>> Connect(const std::string& url, double start_wait_ms);

// A rig that sends to several programs: each of `links`, at least one, gets every datagram. Replies
// are read from all of them. A link that fails does not keep the others from sending: `on_failure`
// is called with its address and the reason, and again only after it has sent in between. Send()
// fails if all links do.
struct NamedLink {
  std::string url;
  std::unique_ptr<Link> link;
};
using OnFailure = std::function<void(const std::string& url, const std::string& why)>;
std::unique_ptr<Link> ToAll(std::vector<NamedLink> links, OnFailure on_failure);

// The peers that a server sends to. kAllWhoSpeak: all that sent data within the last 5 s. kNewest:
// the last one that sent data, without end.
enum class Audience : std::uint8_t { kAllWhoSpeak, kNewest };

// A server's socket, bound to "udp://HOST:PORT" (port 0: any free port). Send() sends to the
// audience. `bound`, if not null, receives the actual address.
Result<std::unique_ptr<Link>> Listen(const std::string& url, std::string* bound = nullptr,
                                     Audience audience = Audience::kAllWhoSpeak);

// Checks the address for Connect(). With `lowest_port` 0, port 0 is valid, as for Listen().
Status CheckAddress(const std::string& url, int lowest_port = 1);

// Whether Connect() would use TCP for this address.
bool IsStream(const std::string& url);

}  // namespace styled::player

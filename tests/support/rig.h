#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/rigs/native/datagram.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::support {

using Bytes = std::vector<std::byte>;

// A sender of native datagrams: one performer on the canonical skeleton (dialect "canonical") that
// walks on the spot and waves. Each datagram increments the sequence; each frame advances the time.
class Rig {
 public:
  explicit Rig(std::string performer, std::uint64_t session_id = 7);

  Bytes Body();
  Bytes Frame();
  // The next frame; `change` modifies it before it is encoded.
  Bytes Frame(const std::function<void(v1::SourceFrame&)>& change);
  // The next datagram with this payload.
  Bytes Datagram(native::Kind kind, std::string_view payload);

  v1::Body MakeBody() const;
  v1::SourceFrame MakeFrame() const;  // for the next frame's time

  std::string performer;
  std::uint64_t session;
  std::uint64_t sequence = 0;
  std::uint64_t time_ns = 1'000'000'000;
  std::uint64_t period_ns = 1'000'000'000 / 120;
};

// Sends datagrams. `address` is HOST:PORT of a listening source.
class UdpLink {
 public:
  explicit UdpLink(const std::string& address);
  ~UdpLink();
  UdpLink(const UdpLink&) = delete;
  UdpLink& operator=(const UdpLink&) = delete;
  void Send(const Bytes& bytes) const;

 private:
  int fd_;
};

class TcpLink {
 public:
  explicit TcpLink(const std::string& address);
  ~TcpLink();
  TcpLink(const TcpLink&) = delete;
  TcpLink& operator=(const TcpLink&) = delete;
  void Send(const Bytes& bytes) const;
  void Send(std::string_view text) const;
  // Everything received until the other side closes, or sends nothing for 10 s.
  std::string ReadToEnd() const;
  // Whether the other side closes within `seconds`.
  bool Closed(double seconds) const;

 private:
  int fd_;
};

// Calls step(0) ... step(count-1) at `rate_hz`, by an absolute clock.
void Paced(int count, double rate_hz, const std::function<void(int)>& step);
void Sleep(double seconds);

}  // namespace styled::support

#pragma once

#include <cstddef>

#include "clients/doctor/sniff.h"
#include "clients/doctor/traffic.h"
#include "model/base/descriptor.h"

namespace styled::doctor {

// Larger than any datagram.
inline constexpr std::size_t kMaxReceived = 65536;

// The listeners' shared state: they write what they receive here.
struct Notebook {
  Sniffer sniffer;
  Traffic heard;  // received by a socket of this program
  Traffic seen;   // captured at an interface, before any firewall
  double now_s = 0;
  std::array<std::byte, kMaxReceived> buffer;
};

// A source of datagrams behind one file descriptor. No function blocks. One thread.
class Listener {
 public:
  virtual ~Listener() = default;
  virtual int fd() const = 0;
  // Call this when `fd` is readable. Receives at most kBatch datagrams.
  virtual void Listen(Notebook& notes) = 0;
  // Called about 20 times per second.
  virtual void Tick(double /*now_s*/) {}
};

inline constexpr int kBatch = 64;  // datagrams per call of Listen()

}  // namespace styled::doctor

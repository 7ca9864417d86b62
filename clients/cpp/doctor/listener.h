#pragma once

#include <unistd.h>

#include <cstddef>
#include <span>
#include <utility>

#include "clients/cpp/doctor/sniff.h"
#include "clients/cpp/doctor/traffic.h"

namespace styled::doctor {

// Owns a file descriptor; -1: none.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  int get() const { return fd_; }

 private:
  int fd_ = -1;
};

// Larger than any datagram.
inline constexpr std::size_t kMaxReceived = 65536;

// Where listeners write what they receive.
struct Notebook {
  Sniffer sniffer;
  Traffic heard;  // received by a socket of this program
  Traffic seen;   // captured at an interface, before any firewall
  double now_s = 0;
  std::array<std::byte, kMaxReceived> buffer;
};

// A source of datagrams behind one file descriptor. Nothing here blocks. One thread.
class Listener {
 public:
  virtual ~Listener() = default;
  virtual int fd() const = 0;
  // To be called when `fd` is readable. Receives a bounded number of datagrams.
  virtual void Listen(Notebook& notes) = 0;
  // About twenty times a second.
  virtual void Tick(double /*now_s*/) {}
};

inline constexpr int kBatch = 64;  // datagrams that a listener receives at once

}  // namespace styled::doctor

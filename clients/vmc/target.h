#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "model/base/status.h"

namespace styled::stylevmc {

// An application that listens for VMC, and the performer that it receives.
struct TargetSpec {
  std::string performer;  // SOURCE.NAME; "" = the one of --performer
  std::string host;       // name or address, IPv6 without brackets
  std::string port;       // 1 .. 65535
  std::string text;       // HOST:PORT as given, for messages
};

// Parses "HOST:PORT", "[IPV6]:PORT" or "PERFORMER=HOST:PORT". The error states what was expected.
Result<TargetSpec> ParseTarget(const std::string& text);

// A UDP socket for one target. One thread; Send does not block.
class Target {
 public:
  // Resolves the host once (this may block for seconds). If there are several addresses, an IPv4
  // one is preferred: most applications listen on IPv4 only, and `localhost` often resolves to
  // both. Broadcast addresses are allowed.
  static Result<std::unique_ptr<Target>> Open(const TargetSpec& spec);
  ~Target();
  Target(const Target&) = delete;
  Target& operator=(const Target&) = delete;

  // "" if the system accepted the datagram, else its error. That no program listens there is no
  // error: the application may start later.
  std::string Send(std::span<const std::byte> datagram);

  // Whether the machine answered one of the datagrams of the last kTellsFor before the newest that
  // no program listens there (ICMP, port unreachable). false proves nothing: a firewall may keep
  // the answer back.
  bool NoListener() const;
  static constexpr std::chrono::seconds kTellsFor{3};  // Linux answers a sender once a second

  const std::string& text() const;

 private:
  struct Impl;
  explicit Target(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace styled::stylevmc

#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "model/base/status.h"

namespace styled::stylevmc {

// One application that listens for VMC, and whom it is shown.
struct TargetSpec {
  std::string performer;  // SOURCE.NAME, "" = as the program's --performer says
  std::string host;       // name or address, IPv6 without its brackets
  std::string port;       // 1 .. 65535
  std::string text;       // HOST:PORT as given, for messages
};

// "HOST:PORT", "[IPV6]:PORT" or "PERFORMER=HOST:PORT". The error says what was expected.
Result<TargetSpec> ParseTarget(const std::string& text);

// A UDP socket of its own towards one target. UDP never tells that nobody listens there. One
// thread; Send does not block.
class Target {
 public:
  // Looks the host up, once (this may block for seconds). Of several addresses an IPv4 one is
  // taken where there is one: most applications listen on IPv4 alone, and `localhost` often is
  // both. Broadcast addresses are allowed.
  static Result<std::unique_ptr<Target>> Open(const TargetSpec& spec);
  ~Target();
  Target(const Target&) = delete;
  Target& operator=(const Target&) = delete;

  // "" where the system took it, else its reason.
  std::string Send(std::span<const std::byte> datagram);
  const std::string& text() const;

 private:
  struct Impl;
  explicit Target(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace styled::stylevmc

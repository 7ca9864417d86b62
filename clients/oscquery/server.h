#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "clients/oscquery/answers.h"
#include "model/base/status.h"

namespace styled::oscquery {

// Answers HTTP requests about one source (AnswerTo). Each connection carries one request, of at
// most 8 KiB, and is closed after `request_time` in any case. There are at most 32: a further one
// closes the oldest, so that slow clients cannot keep others out. One thread runs `io`; all
// functions must be called on it. Pinned by tests/unit/oscquery/server_test.cpp.
class Server {
 public:
  static constexpr std::size_t kMaxConnections = 32;

  // Listens at `address` (numeric), at the TCP port of the same number as the source's UDP port,
  // which a firewall's rule can name, or at any free one if that is in use.
  static Result<std::unique_ptr<Server>> Start(
      boost::asio::io_context& io, const std::string& address, Description description,
      std::chrono::milliseconds request_time = std::chrono::seconds(5));
  ~Server();  // closes all connections
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;
  void Rename(const std::string& name);  // Description::name

 private:
  struct Impl;
  explicit Server(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

}  // namespace styled::oscquery

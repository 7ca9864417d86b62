#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

namespace styled::support {

using Headers = std::map<std::string, std::string>;

struct HttpReply {
  int status = 0;  // 0: no reply
  std::string type, body;
};

// Sends one request to `address` ("http://127.0.0.1:7080"); returns its reply, within 10 s.
HttpReply Ask(const std::string& address, const std::string& target, const Headers& headers = {},
              const std::string& method = "GET");

struct Received {
  bool text = false;
  std::string topic;  // of a binary message; "" for a Reply
  std::string payload;
};

// A browser's WebSocket for tests: it reads only when Receive is called. One thread.
class BrowserLink {
 public:
  // `receive_buffer_bytes`: size of the socket's buffer; 0 = the system's default.
  explicit BrowserLink(const std::string& address, const std::string& target = "/ws",
                       const Headers& headers = {}, int receive_buffer_bytes = 0);
  ~BrowserLink();
  BrowserLink(const BrowserLink&) = delete;
  BrowserLink& operator=(const BrowserLink&) = delete;

  // 101 if open; the status of a refusal; 0 if there was no reply.
  int status() const;
  void SendText(const std::string& text);
  void SendBinary(const std::string& bytes);
  // The next message; empty if none arrives in time or the connection is closed.
  std::optional<Received> Receive(double seconds = 10);
  bool closed() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace styled::support

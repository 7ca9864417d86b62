#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "daemon/looks/mailboxes.h"
#include "model/base/descriptor.h"
#include "model/base/status.h"

namespace styled::control {

// Receives control messages as OSC over UDP. An OSC sender expects no reply, so only refusals are
// reported: to the sender as /styled/error with the address and the reason, and in the log at most
// once a second. Control thread only.
class OscSocket {
 public:
  // `listen`: numeric HOST:PORT. Errors name the address.
  static Result<std::unique_ptr<OscSocket>> Open(const std::string& listen);

  // Receives the next datagram; false when there is none.
  bool Receive();
  // The datagram's messages as requests, with the sender in the envelope. A message that is not a
  // valid request comes with its reply already set.
  std::vector<std::unique_ptr<pipeline::Exchange>> Read() const;
  // Sends /styled/error to the sender if the reply is a refusal, and logs it.
  void Answer(const pipeline::Exchange& exchange);

  int fd() const { return socket_.get(); }
  const std::string& endpoint() const { return endpoint_; }

 private:
  explicit OscSocket(Descriptor socket);
  std::unique_ptr<pipeline::Exchange> Refused(const std::string& address,
                                              const std::string& reason) const;

  Descriptor socket_;
  std::string endpoint_;
  std::vector<std::byte> buffer_;
  std::size_t size_ = 0;
  std::vector<std::byte> sender_;  // a sockaddr
  std::int64_t logged_s_ = 0;
};

}  // namespace styled::control

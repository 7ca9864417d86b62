#pragma once

#include <sys/types.h>
#include <zmq.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "model/base/descriptor.h"
#include "model/base/status.h"

namespace styled::runtime {

// Which users may connect to an ipc:// address.
struct IpcAccess {
  mode_t mode = 0600;        // of the socket's file
  std::vector<uid_t> users;  // empty: every user whom the mode permits
};

// Owns a ZeroMQ socket. One thread at a time may use it.
class ZmqSocket {
 public:
  ZmqSocket() = default;
  ZmqSocket(void* context, int type) : socket_(zmq_socket(context, type)) {}
  ~ZmqSocket() {
    if (socket_ != nullptr) zmq_close(socket_);
  }
  ZmqSocket(ZmqSocket&& other) noexcept
      : socket_(std::exchange(other.socket_, nullptr)), lock_(std::move(other.lock_)) {}
  ZmqSocket& operator=(ZmqSocket&& other) noexcept {
    std::swap(socket_, other.socket_);
    std::swap(lock_, other.lock_);
    return *this;
  }

  void* get() const { return socket_; }
  bool Set(int option, int value) {
    return zmq_setsockopt(socket_, option, &value, sizeof value) == 0;
  }
  bool Set(int option, std::int64_t value) {
    return zmq_setsockopt(socket_, option, &value, sizeof value) == 0;
  }
  // The value of the int option `option`; 0 on failure.
  int Get(int option) const {
    int value = 0;
    std::size_t size = sizeof value;
    zmq_getsockopt(socket_, option, &value, &size);
    return value;
  }

  // Binds `address` (port 0: any free one) and writes the bound address to `endpoint`. An ipc path
  // is locked first, because libzmq would silently take it away from a running daemon. The call
  // refuses a path that holds anything but a socket, or a socket at which another program listens,
  // and leaves it alone. It replaces a socket that a dead daemon left behind. Errors begin with
  // `key`. Call at start-up, while no other thread creates files: the process' umask changes for a
  // moment.
  Status Bind(const std::string& address, const std::string& key, std::string& endpoint,
              const IpcAccess& ipc = {});

 private:
  Status LockPath(const std::string& path, const std::string& place);
  bool BindIpc(const std::string& address, const IpcAccess& ipc);

  void* socket_ = nullptr;
  Descriptor lock_;
};

}  // namespace styled::runtime

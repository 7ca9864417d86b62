#include "daemon/runtime/zmq_socket.h"

#include <fcntl.h>
#include <sys/file.h>

#include <array>
#include <cerrno>

namespace styled::runtime {

Status ZmqSocket::Bind(const std::string& address, const std::string& key, std::string& endpoint) {
  const std::string place = key + ": " + address + ": ";
  if (socket_ == nullptr) return Status::Error(place + zmq_strerror(zmq_errno()));
  if (address.starts_with("ipc://")) {
    const std::string path = address.substr(6) + ".lock";
    lock_ = Descriptor(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
    if (lock_.get() < 0) return Status::Error(place + "cannot write its lock file " + path);
    if (flock(lock_.get(), LOCK_EX | LOCK_NB) != 0) {
      return Status::Error(place + "in use (another styled?)");
    }
  }
  std::string wanted = address;
  if (wanted.starts_with("tcp://") && wanted.ends_with(":0")) wanted.back() = '*';
  Set(ZMQ_IPV6, wanted.find('[') != std::string::npos ? 1 : 0);
  if (zmq_bind(socket_, wanted.c_str()) != 0) {
    const int error = zmq_errno();
    return Status::Error(place +
                         (error == EADDRINUSE ? "in use (another styled?)" : zmq_strerror(error)));
  }
  std::array<char, 256> bound{};
  std::size_t size = bound.size();
  zmq_getsockopt(socket_, ZMQ_LAST_ENDPOINT, bound.data(), &size);
  endpoint = bound.data();
  return Status::Ok();
}

}  // namespace styled::runtime

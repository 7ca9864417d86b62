#include "clients/web/upstream.h"

#include <array>
#include <boost/asio/post.hpp>
#include <cstdio>
#include <utility>

namespace styled::web {
namespace {

constexpr std::int64_t kMaxMessageBytes = 1 << 20;
constexpr int kQueue = 1000;  // messages queued while the loop is busy

}  // namespace

Upstream::Upstream(boost::asio::io_context& io, Handlers handlers)
    : io_(io),
      handlers_(std::move(handlers)),
      readable_(io),
      events_(io),
      self_(std::make_shared<Upstream*>(this)) {}

Upstream::~Upstream() {
  *self_ = nullptr;
  if (readable_.is_open()) readable_.release();  // libzmq closes its descriptors itself
  if (events_.is_open()) events_.release();
}

Result<std::unique_ptr<Upstream>> Upstream::Connect(boost::asio::io_context& io,
                                                    const std::string& endpoint,
                                                    const std::optional<client::Curve>& curve,
                                                    Handlers handlers) {
  std::optional<client::Curve> complete;
  if (curve) {
    auto checked = client::Complete(*curve);
    if (!checked.ok()) return checked.status();
    complete = std::move(checked.value());
  }
  std::unique_ptr<Upstream> upstream(new Upstream(io, std::move(handlers)));
  try {
    upstream->Open(endpoint, complete);
  } catch (const zmq::error_t& error) {
    return Status::Error("--publish " + endpoint + ": " + error.what() +
                         "; expected e.g. tcp://127.0.0.1:7001 or ipc://PATH");
  }
  upstream->Wait(upstream->readable_);
  upstream->Wait(upstream->events_);
  upstream->Soon();
  return upstream;
}

void Upstream::Open(const std::string& endpoint, const std::optional<client::Curve>& curve) {
  socket_ = zmq::socket_t(context_, zmq::socket_type::sub);
  socket_.set(zmq::sockopt::linger, 0);
  socket_.set(zmq::sockopt::rcvhwm, kQueue);
  socket_.set(zmq::sockopt::maxmsgsize, kMaxMessageBytes);
  socket_.set(zmq::sockopt::reconnect_ivl, 100);
  socket_.set(zmq::sockopt::reconnect_ivl_max, 1000);
  socket_.set(zmq::sockopt::handshake_ivl, 1000);
  socket_.set(zmq::sockopt::heartbeat_ivl, 1000);
  socket_.set(zmq::sockopt::heartbeat_timeout, 3000);
  if (curve) {
    socket_.set(zmq::sockopt::curve_serverkey, curve->server_key);
    socket_.set(zmq::sockopt::curve_publickey, curve->public_key);
    socket_.set(zmq::sockopt::curve_secretkey, curve->secret_key);
  }
  std::array<char, 64> name{};
  std::snprintf(name.data(), name.size(), "inproc://monitor-%p", static_cast<void*>(this));
  if (zmq_socket_monitor(socket_.handle(), name.data(), ZMQ_EVENT_DISCONNECTED) != 0) {
    throw zmq::error_t();
  }
  monitor_ = zmq::socket_t(context_, zmq::socket_type::pair);
  monitor_.set(zmq::sockopt::linger, 0);
  monitor_.connect(name.data());
  socket_.set(zmq::sockopt::ipv6, endpoint.find('[') != std::string::npos);
  socket_.connect(endpoint);
  readable_.assign(socket_.get(zmq::sockopt::fd));
  events_.assign(monitor_.get(zmq::sockopt::fd));
}

// ZMQ_FD is edge-triggered. After each event, and after each call on the socket, all waiting
// messages must be read.
void Upstream::Wait(boost::asio::posix::stream_descriptor& descriptor) {
  descriptor.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                        [self = self_, &descriptor](const boost::system::error_code& error) {
                          if (error || *self == nullptr) return;
                          (*self)->Drain();
                          (*self)->Wait(descriptor);
                        });
}

void Upstream::Soon() {
  if (std::exchange(drain_posted_, true)) return;
  boost::asio::post(io_, [self = self_] {
    if (*self == nullptr) return;
    (*self)->drain_posted_ = false;
    (*self)->Drain();
  });
}

// Handles one message per turn of the loop. Its writes are done before the next one is read, as far
// as sockets accept them. After a pause, a backlog is therefore sent completely, without superseded
// messages.
void Upstream::Drain() {
  ReadEvents();
  if (!ReadMessage()) return;
  handlers_.message({static_cast<const char*>(topic_.data()), topic_.size()},
                    {static_cast<const char*>(payload_.data()), payload_.size()});
  Soon();
}

bool Upstream::ReadMessage() {
  try {
    while (socket_.recv(topic_, zmq::recv_flags::dontwait)) {
      int parts = 1;
      while (socket_.get(zmq::sockopt::rcvmore)) {  // the parts of a message arrive together
        zmq::message_t& part = parts == 1 ? payload_ : topic_;
        if (!socket_.recv(part, zmq::recv_flags::none)) break;
        ++parts;
      }
      if (parts == 2) return true;
      ++malformed_;
    }
  } catch (const zmq::error_t&) {  // interrupted by a signal
    Soon();
  }
  return false;
}

void Upstream::ReadEvents() {
  bool broke = false;
  try {
    zmq::message_t part;
    while (monitor_.recv(part, zmq::recv_flags::dontwait)) {
      while (part.more() && monitor_.recv(part, zmq::recv_flags::none)) {
      }
      broke = true;
    }
  } catch (const zmq::error_t&) {
    Soon();
  }
  if (broke) handlers_.disconnected();
}

void Upstream::Subscribe(const std::string& topic) {
  socket_.set(zmq::sockopt::subscribe, topic);
  ++topics_;
  Soon();
}

void Upstream::Unsubscribe(const std::string& topic) {
  socket_.set(zmq::sockopt::unsubscribe, topic);
  --topics_;
  Soon();
}

}  // namespace styled::web

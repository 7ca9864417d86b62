#include "daemon/standby/channel.h"

#include <zmq.h>

#include <cerrno>

#include "daemon/runtime/zmq_socket.h"

namespace styled::standby {
namespace {

// Messages that wait for a daemon that does not read. Sixteen performers at 120 Hz, each in a
// message of its own of about 1.5 kB, fill it in 10 s and 30 MB. What exceeds it is lost, and the
// reader then fetches the whole state.
constexpr int kQueue = 20'000;

class ZmqChannel final : public Channel {
 public:
  ZmqChannel(runtime::ZmqSocket publisher, runtime::ZmqSocket subscriber, std::string peer)
      : publisher_(std::move(publisher)),
        subscriber_(std::move(subscriber)),
        peer_(std::move(peer)) {
    zmq_msg_init(&message_);
  }
  ~ZmqChannel() override { zmq_msg_close(&message_); }

  void Send(std::span<const std::byte> message) noexcept override {
    (void)zmq_send(publisher_.get(), message.data(), message.size(), ZMQ_DONTWAIT);
  }
  bool Receive(std::string& message) override {
    bool whole = true;
    while (zmq_msg_recv(&message_, subscriber_.get(), ZMQ_DONTWAIT) >= 0) {
      if (zmq_msg_more(&message_) != 0) {  // its other parts are there, too
        whole = false;
        continue;
      }
      // A journal's messages have one part. Another is handed on empty, which no entry is.
      message.assign(static_cast<const char*>(zmq_msg_data(&message_)),
                     whole ? zmq_msg_size(&message_) : 0);
      return true;
    }
    return false;
  }
  Subscription NextSubscription() override {
    if (zmq_msg_recv(&message_, publisher_.get(), ZMQ_DONTWAIT) < 0) return Subscription::kNone;
    const bool began =
        zmq_msg_size(&message_) > 0 && *static_cast<const char*>(zmq_msg_data(&message_)) == 1;
    return began ? Subscription::kBegan : Subscription::kEnded;
  }
  // By a topic on which nothing is ever published: to subscribe to everything anew would lose the
  // messages in between.
  void Ask() override {
    const std::string last = "ask " + std::to_string(asked_),
                      next = "ask " + std::to_string(++asked_);
    zmq_setsockopt(subscriber_.get(), ZMQ_SUBSCRIBE, next.data(), next.size());
    zmq_setsockopt(subscriber_.get(), ZMQ_UNSUBSCRIBE, last.data(), last.size());
  }

  // libzmq connects again to an address where nobody listens, or that is not ZeroMQ in time; but it
  // gives up one that breaks the protocol: another type of socket, too large a message, bytes.
  void Reconnect() override {
    (void)zmq_disconnect(subscriber_.get(), peer_.c_str());
    (void)zmq_connect(subscriber_.get(), peer_.c_str());
  }

 private:
  runtime::ZmqSocket publisher_, subscriber_;
  std::string peer_;
  zmq_msg_t message_;
  std::uint64_t asked_ = 0;
};

}  // namespace

Result<Opened> OpenZmqChannel(void* context, const config::Standby& config,
                              security::Gatekeeper* keeper) {
  runtime::ZmqSocket publisher(context, ZMQ_XPUB), subscriber(context, ZMQ_SUB);
  if (publisher.get() == nullptr || subscriber.get() == nullptr) {
    return Status::Error("standby: " + std::string(zmq_strerror(errno)));
  }
  publisher.Set(ZMQ_XPUB_VERBOSE, 1);
  publisher.Set(ZMQ_SNDHWM, kQueue);
  publisher.Set(ZMQ_LINGER, 100);
  publisher.Set(ZMQ_HANDSHAKE_IVL, 1000);
  publisher.Set(ZMQ_MAXMSGSIZE, std::int64_t{1024});  // of the other's subscriptions
  Opened opened;
  Status status = keeper == nullptr ? Status::Ok() : keeper->GuardPeers(publisher);
  if (status.ok() && keeper != nullptr) status = keeper->Introduce(subscriber, config.peer_key);
  if (!status.ok()) return Status::Error("standby: " + status.message());
  status = publisher.Bind(config.address, "standby.address", opened.endpoint);
  if (!status.ok()) return status;
  subscriber.Set(ZMQ_RCVHWM, kQueue);
  subscriber.Set(ZMQ_LINGER, 0);
  subscriber.Set(ZMQ_RECONNECT_IVL, 100);
  // What listens at the peer's address and says nothing is left, and tried again.
  subscriber.Set(ZMQ_HANDSHAKE_IVL, 1000);
  subscriber.Set(ZMQ_MAXMSGSIZE, static_cast<std::int64_t>(kMaxMessageBytes));
  // A machine that is gone without a word is noticed by its silence; its connection ends, too.
  subscriber.Set(ZMQ_HEARTBEAT_IVL, 1000);
  subscriber.Set(ZMQ_HEARTBEAT_TIMEOUT, 3000);
  subscriber.Set(ZMQ_IPV6, config.peer.find('[') != std::string::npos ? 1 : 0);
  zmq_setsockopt(subscriber.get(), ZMQ_SUBSCRIBE, "", 0);
  if (zmq_connect(subscriber.get(), config.peer.c_str()) != 0) {
    return Status::Error("standby.peer: " + config.peer + ": " + zmq_strerror(zmq_errno()));
  }
  opened.publish_fd = publisher.Get(ZMQ_FD);
  opened.subscribe_fd = subscriber.Get(ZMQ_FD);
  opened.channel =
      std::make_unique<ZmqChannel>(std::move(publisher), std::move(subscriber), config.peer);
  return opened;
}

}  // namespace styled::standby

#include "daemon/standby/channel.h"

#include <zmq.h>

#include <cerrno>

#include "daemon/runtime/zmq_socket.h"

namespace styled::standby {
namespace {

// Capacity, in messages, for a peer that does not read. Sixteen performers at 120 Hz, each in its
// own message of about 1.5 kB, fill it in 10 s with 30 MB. Messages beyond it are lost; the reader
// then fetches the whole state.
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
      // A journal's messages have one part. A message of several parts is returned empty, which is
      // not a valid entry.
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
  // Requests the state by a subscription to a topic on which nothing is ever published. To renew
  // the subscription to the journal instead would lose the messages in between.
  void Ask() override {
    const std::string last = "ask " + std::to_string(asked_),
                      next = "ask " + std::to_string(++asked_);
    zmq_setsockopt(subscriber_.get(), ZMQ_SUBSCRIBE, next.data(), next.size());
    zmq_setsockopt(subscriber_.get(), ZMQ_UNSUBSCRIBE, last.data(), last.size());
  }

  // libzmq itself connects again after a refused or silent connection. It gives up a peer that
  // violates the protocol: another socket type, a message that is too large, or arbitrary bytes.
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
  publisher.Set(ZMQ_MAXMSGSIZE, std::int64_t{1024});  // limits the peer's subscriptions
  Opened opened;
  Status status = keeper == nullptr ? Status::Ok() : keeper->GuardPeers(publisher);
  if (status.ok() && keeper != nullptr) status = keeper->Introduce(subscriber, config.peer_key);
  if (!status.ok()) return Status::Error("standby: " + status.message());
  status = publisher.Bind(config.address, "standby.address", opened.endpoint);
  if (!status.ok()) return status;
  subscriber.Set(ZMQ_RCVHWM, kQueue);
  subscriber.Set(ZMQ_LINGER, 0);
  subscriber.Set(ZMQ_RECONNECT_IVL, 100);
  // A program at the peer's address that does not complete the handshake is disconnected, and the
  // connection is tried again.
  subscriber.Set(ZMQ_HANDSHAKE_IVL, 1000);
  subscriber.Set(ZMQ_MAXMSGSIZE, static_cast<std::int64_t>(kMaxMessageBytes));
  // Heartbeats of the connection: a machine that vanished is detected by its silence.
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

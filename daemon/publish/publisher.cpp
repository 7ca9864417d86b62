#include "daemon/publish/publisher.h"

#include <algorithm>
#include <cerrno>

#include "daemon/publish/watch.h"
#include "daemon/runtime/zmq_socket.h"
#include "daemon/security/ipc.h"

namespace styled::publish {
namespace {

using runtime::Counter;

class ZmqPublisher final : public Publisher {
 public:
  // `access` may be null.
  ZmqPublisher(runtime::ZmqSocket socket, int room, security::Access* access,
               runtime::Counters& counters, std::unique_ptr<Watch> watch)
      : socket_(std::move(socket)),
        usual_room_(static_cast<std::size_t>(room)),
        room_(room),
        access_(access),
        counters_(counters),
        watch_(std::move(watch)) {
    zmq_msg_init(&message_);
  }
  ~ZmqPublisher() override { zmq_msg_close(&message_); }

  void Send(std::string_view topic, std::span<const std::byte> payload) noexcept override {
    if (zmq_send(socket_.get(), topic.data(), topic.size(), ZMQ_SNDMORE | ZMQ_DONTWAIT) < 0 ||
        zmq_send(socket_.get(), payload.data(), payload.size(), ZMQ_DONTWAIT) < 0) {
      counters_.Add(Counter::kPublishFailed);
      return;
    }
    counters_.Add(Counter::kPublishMessages);
    if (watch_->canary() != nullptr) watch_->canary()->NoteSent(topic);
  }

  // The length is never reduced again. libzmq's reader reports its progress to the writer once per
  // half queue, of the length at that time; a writer to a shorter queue would wait for that report
  // for ever.
  void MakeRoom(std::size_t messages) override {
    const int wanted =
        static_cast<int>(std::min(messages + usual_room_, std::size_t{config::kMostHighWaterMark}));
    if (wanted <= room_) return;
    if (socket_.Set(ZMQ_SNDHWM, wanted)) room_ = wanted;
  }

  bool NextSubscription(SubscriptionEvent& event) override {
    while ((socket_.Get(ZMQ_EVENTS) & ZMQ_POLLIN) != 0) {
      if (zmq_msg_recv(&message_, socket_.get(), ZMQ_DONTWAIT) < 0) return false;
      const auto* data = static_cast<const char*>(zmq_msg_data(&message_));
      const std::size_t size = zmq_msg_size(&message_);
      // libzmq also passes on other messages of a subscriber; none is expected.
      if (size == 0 || (data[0] != 0 && data[0] != 1) || zmq_msg_more(&message_) != 0) {
        counters_.Add(Counter::kPublishBadMessages);
        continue;
      }
      event.subscribe = data[0] == 1;
      if (event.subscribe && access_ != nullptr) NoteSubscriber();
      event.topic.assign(data + 1, size - 1);
      return true;
    }
    return false;
  }

  int fd() const override { return socket_.Get(ZMQ_FD); }

 private:
  // Notes the sender of the subscription and its connection; libzmq attaches both to the message.
  void NoteSubscriber() {
    const char* const key = zmq_msg_gets(&message_, "User-Id");
    const int connection = zmq_msg_get(&message_, ZMQ_SRCFD);
    if (key != nullptr && connection >= 0) access_->NoteSubscriber(key, connection);
  }

  runtime::ZmqSocket socket_;
  std::size_t usual_room_;  // messages in a subscriber's queue, high_water_mark
  int room_;                // the length after MakeRoom
  security::Access* access_;
  runtime::Counters& counters_;
  std::unique_ptr<Watch> watch_;
  zmq_msg_t message_;
};

}  // namespace

Result<std::unique_ptr<Publisher>> MakeZmqPublisher(void* context, const config::Publish& config,
                                                    runtime::Counters& counters,
                                                    std::string& endpoint,
                                                    security::Gatekeeper* keeper) {
  runtime::ZmqSocket socket(context, ZMQ_XPUB);
  if (socket.get() == nullptr) return Status::Error("publish: " + std::string(zmq_strerror(errno)));
  socket.Set(ZMQ_XPUB_VERBOSE, 1);
  socket.Set(ZMQ_SNDHWM, config.high_water_mark);
  socket.Set(ZMQ_SNDBUF, config.send_buffer_bytes);
  socket.Set(ZMQ_LINGER, 100);
  socket.Set(ZMQ_HANDSHAKE_IVL, 1000);
  // Limit of a subscriber's message, which is a subscription.
  socket.Set(ZMQ_MAXMSGSIZE, std::int64_t{1024});
  socket.Set(ZMQ_TCP_KEEPALIVE, 1);
  const auto ipc = security::ResolveIpc(config.ipc, "publish");
  if (!ipc.ok()) return ipc.status();
  if (keeper != nullptr) {
    const Status status = keeper->Guard(socket, security::Door::kPublish);
    if (!status.ok()) return status;
  }
  std::unique_ptr<Canary> canary;
  if (config.canary) {
    auto opened = Canary::Open(context, socket, config.high_water_mark);
    if (!opened.ok()) return opened.status();
    canary = std::move(opened.value());
  }
  const Status status = socket.Bind(config.address, "publish.address", endpoint, ipc.value());
  if (!status.ok()) return status;
  return std::unique_ptr<Publisher>(std::make_unique<ZmqPublisher>(
      std::move(socket), config.high_water_mark, keeper == nullptr ? nullptr : &keeper->access(),
      counters,
      std::make_unique<Watch>(std::move(canary), config.high_water_mark, endpoint, counters)));
}

}  // namespace styled::publish

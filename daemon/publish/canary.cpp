#include "daemon/publish/canary.h"

#include <zmq.h>

#include <array>
#include <cerrno>
#include <memory>

namespace styled::publish {

Result<std::unique_ptr<Canary>> Canary::Open(void* context, runtime::ZmqSocket& publisher,
                                             int high_water_mark) {
  static std::atomic<int> number{0};
  const std::string address = "inproc://canary-" + std::to_string(++number);
  const auto failed = [] { return Status::Error("publish: " + std::string(zmq_strerror(errno))); };
  runtime::ZmqSocket socket(context, ZMQ_SUB);
  // Within the process the queues of both ends are one, with the sum of both lengths.
  if (socket.get() == nullptr || !socket.Set(ZMQ_RCVHWM, high_water_mark) ||
      !socket.Set(ZMQ_LINGER, 0) || zmq_bind(publisher.get(), address.c_str()) != 0 ||
      zmq_connect(socket.get(), address.c_str()) != 0 ||
      zmq_setsockopt(socket.get(), ZMQ_SUBSCRIBE, kPrefix.data(), kPrefix.size()) != 0) {
    return failed();
  }
  // Removes the subscription from the stream, so that it is counted for no topic.
  constexpr int kPatience_ms = 1000;
  publisher.Set(ZMQ_RCVTIMEO, kPatience_ms);
  std::array<char, 8> subscription{};
  const int size = zmq_recv(publisher.get(), subscription.data(), subscription.size(), 0);
  publisher.Set(ZMQ_RCVTIMEO, -1);
  if (size != static_cast<int>(1 + kPrefix.size())) return failed();
  return std::unique_ptr<Canary>(new Canary(std::move(socket)));
}

std::uint64_t Canary::Drain(runtime::Counters& counters) noexcept {
  const std::uint64_t before = sent_.load(std::memory_order_acquire);
  std::uint64_t received = 0;
  std::array<char, 1> first{};  // the rest of a message is dropped
  while (zmq_recv(socket_.get(), first.data(), first.size(), ZMQ_DONTWAIT) >= 0) {
    if (socket_.Get(ZMQ_RCVMORE) == 0) ++received;
  }
  received_ += received;
  counters.Add(runtime::Counter::kPublishCanaryReceived, received);
  // The two numbers are comparable only while nothing is being sent.
  const std::uint64_t after = sent_.load(std::memory_order_acquire);
  if (before != after || after < received_ + missed_) return received;
  counters.Add(runtime::Counter::kPublishCanaryMissed, after - received_ - missed_);
  missed_ = after - received_;
  return received;
}

}  // namespace styled::publish

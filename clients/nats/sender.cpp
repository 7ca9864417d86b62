#include "clients/nats/sender.h"

#include <algorithm>
#include <string>

namespace styled::stylenats {
namespace {

constexpr std::chrono::milliseconds kWait(100);  // for a frame; the queue wakes at once

struct MessageDeleter {
  void operator()(natsMsg* message) const { natsMsg_Destroy(message); }
};

}  // namespace

Sender::Sender(FrameQueue& queue, Link& link)
    : queue_(queue), link_(link), thread_([this](const std::stop_token& stop) { Loop(stop); }) {}

void Sender::Stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void Sender::Loop(const std::stop_token& stop) {
  QueuedFrame frame;
  for (;;) {
    if (queue_.Take(frame, stop, kWait)) {
      Send(frame);
    } else if (stop.stop_requested()) {
      return;
    }
  }
}

void Sender::Send(const QueuedFrame& frame) {
  if (!link_.connected()) {
    ++counts_.disconnected;
    return;
  }
  natsMsg* raw = nullptr;
  natsStatus status = natsMsg_Create(&raw, frame.subject.c_str(), nullptr, frame.payload.data(),
                                     static_cast<int>(frame.payload.size()));
  const std::unique_ptr<natsMsg, MessageDeleter> message(raw);
  if (status == NATS_OK && !frame.body) {
    status = natsMsgHeader_Set(raw, "Styled-Epoch", std::to_string(frame.epoch).c_str());
  }
  if (status == NATS_OK && !frame.body) {
    status = natsMsgHeader_Set(raw, "Styled-Sequence", std::to_string(frame.sequence).c_str());
  }
  const auto begin = std::chrono::steady_clock::now();
  if (status == NATS_OK) status = natsConnection_PublishMsg(link_.get(), raw);
  const auto took = std::chrono::steady_clock::now() - begin;
  if (took > kStall) ++counts_.stalled;
  const auto took_us = static_cast<std::uint64_t>(took / std::chrono::microseconds(1));
  counts_.longest_call_us = std::max<std::uint64_t>(counts_.longest_call_us, took_us);
  if (status == NATS_OK) {
    ++(frame.body ? counts_.bodies : counts_.frames);
  } else if (status == NATS_MAX_PAYLOAD) {
    ++counts_.too_large;
  } else if (!link_.connected()) {
    ++counts_.disconnected;
  } else {
    ++counts_.failed;
  }
}

}  // namespace styled::stylenats

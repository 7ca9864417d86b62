#include "clients/nats/sender.h"

#include <algorithm>
#include <string>

namespace styled::stylenats {
namespace {

constexpr std::chrono::milliseconds kWait(100);  // for a frame; the queue wakes at once
// The most bytes that are written together: the buffer of libnats. Frames in it are not replaced by
// newer ones.
constexpr std::size_t kTogether = 32768;
constexpr std::int64_t kPong_ms = 1;  // for the broker's answer; the shortest that libnats accepts

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
    if (!queue_.Pop(frame, stop, kWait)) {
      if (stop.stop_requested()) return;
      continue;
    }
    std::size_t bytes = 0;
    unwritten_ = 0;
    do {
      Send(frame);
      bytes += frame.payload.size();
    } while (bytes < kTogether && queue_.Pop(frame, stop, std::chrono::milliseconds(0)));
    Write();
  }
}

// libnats has no call that writes its buffer and returns, so this one waits for the answer too, for
// kPong_ms at most. A broker on the same machine answers in 0.1 ms; frames that arrive meanwhile
// are written together.
void Sender::Write() {
  if (!link_.connected()) return;
  const natsStatus status =
      Timed([this] { return natsConnection_FlushTimeout(link_.get(), kPong_ms); });
  if (status == NATS_OK || status == NATS_TIMEOUT) return;
  counts_.frames -= unwritten_;  // the connection broke over them
  counts_.disconnected += unwritten_;
}

template <typename Call>
natsStatus Sender::Timed(const Call& call) {
  const auto begin = std::chrono::steady_clock::now();
  const natsStatus status = call();
  const auto took = std::chrono::steady_clock::now() - begin;
  if (took > kStall) ++counts_.stalled;
  const auto took_us = static_cast<std::uint64_t>(took / std::chrono::microseconds(1));
  counts_.longest_call_us = std::max<std::uint64_t>(counts_.longest_call_us, took_us);
  return status;
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
  if (status == NATS_OK) {
    status = Timed([&] { return natsConnection_PublishMsg(link_.get(), raw); });
  }
  if (status == NATS_OK) {
    ++(frame.body ? counts_.bodies : counts_.frames);
    unwritten_ += frame.body ? 0 : 1;
  } else if (status == NATS_MAX_PAYLOAD) {
    ++counts_.too_large;
  } else if (!link_.connected()) {
    ++counts_.disconnected;
  } else {
    ++counts_.failed;
  }
}

}  // namespace styled::stylenats

#include "clients/nats/frame_queue.h"

#include <algorithm>

#include "clients/nats/subject.h"

namespace styled::stylenats {

FrameQueue::Slot* FrameQueue::Find(std::string_view performer, std::string_view stream, bool body,
                                   Clock::time_point now) {
  const Key key(performer, stream, body);
  if (const auto known = slots_.find(key); known != slots_.end()) return &known->second;
  if (slots_.size() >= limits_.slots) {
    const auto free = std::find_if(slots_.begin(), slots_.end(), [&](const auto& row) {
      return row.second.waiting.empty() && now - row.second.used >= limits_.idle;
    });
    if (free == slots_.end()) return nullptr;
    slots_.erase(free);
  }
  Slot& slot = slots_[key];
  slot.subject =
      body ? BodySubject(site_, performer, stream) : FrameSubject(site_, performer, stream);
  slot.body = body;
  return &slot;
}

void FrameQueue::DropOldest(Slot& slot) {
  bytes_ -= slot.waiting.front().payload.size();
  slot.bytes -= slot.waiting.front().payload.size();
  slot.waiting.pop_front();
  order_.erase(std::find(order_.begin(), order_.end(), &slot));
  // A body that is replaced by the next second's does not count as lost.
  slot.replaced += slot.body ? 0 : 1;
  counts_.replaced += slot.body ? 0 : 1;
}

FrameQueue::Pushed FrameQueue::Add(std::string_view performer, std::string_view stream, bool body,
                                   Waiting message, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  ++counts_.pushed;
  Slot* const slot = Find(performer, stream, body, now);
  const std::size_t size = message.payload.size();
  if (slot == nullptr || bytes_ - slot->bytes + size > limits_.bytes) {
    ++counts_.refused;
    return Pushed::kRefused;
  }
  // The same body again: the waiting one leaves sooner.
  if (body && !slot->waiting.empty() && slot->waiting.back().payload == message.payload) {
    return Pushed::kReplaced;
  }
  // Of bodies two, or a frame between them would come without its own.
  const std::size_t depth = body ? 2 : limits_.depth;
  Pushed pushed = Pushed::kQueued;
  while (slot->waiting.size() >= depth || bytes_ + size > limits_.bytes) {
    DropOldest(*slot);
    pushed = Pushed::kReplaced;
  }
  bytes_ += size;
  slot->bytes += size;
  slot->used = now;
  slot->waiting.push_back(std::move(message));
  order_.push_back(slot);
  wake_.notify_one();
  return pushed;
}

FrameQueue::Pushed FrameQueue::Push(std::string_view performer, std::string_view stream,
                                    std::string_view payload, std::uint64_t epoch,
                                    std::uint64_t sequence, Clock::time_point now) {
  return Add(performer, stream, false, {std::string(payload), epoch, sequence}, now);
}

FrameQueue::Pushed FrameQueue::PushBody(std::string_view performer, std::string_view stream,
                                        std::string_view payload, Clock::time_point now) {
  return Add(performer, stream, true, {std::string(payload)}, now);
}

bool FrameQueue::Pop(QueuedFrame& out, const std::stop_token& stop,
                     std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  if (!wake_.wait_for(lock, stop, timeout, [this] { return !order_.empty(); })) return false;
  Slot& slot = *order_.front();
  order_.pop_front();
  Waiting& message = slot.waiting.front();
  bytes_ -= message.payload.size();
  slot.bytes -= message.payload.size();
  out.subject = slot.subject;
  out.body = slot.body;
  out.epoch = message.epoch;
  out.sequence = message.sequence;
  out.payload = std::move(message.payload);
  slot.waiting.pop_front();
  return true;
}

std::size_t FrameQueue::waiting() const {
  const std::scoped_lock lock(mutex_);
  return order_.size();
}

FrameQueue::Counts FrameQueue::counts() const {
  const std::scoped_lock lock(mutex_);
  return counts_;
}

std::vector<std::pair<std::string, std::uint64_t>> FrameQueue::replaced() const {
  std::vector<std::pair<std::string, std::uint64_t>> rows;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [key, slot] : slots_) {
      if (slot.replaced > 0) rows.emplace_back(slot.subject, slot.replaced);
    }
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  return rows;
}

bool AudienceTier::Picks(const std::string& performer) {
  if (counts_.size() >= kMaxPerformers && !counts_.contains(performer)) counts_.clear();
  return counts_[performer]++ % kStep == 0;
}

bool BodyBeat::IsDue(const std::string& performer, std::string_view stream, std::uint64_t hash,
                     Clock::time_point now) {
  const std::pair key(performer, std::string(stream));
  if (last_.size() >= kMaxStreams && !last_.contains(key)) last_.clear();
  const auto [known, added] = last_.try_emplace(key);
  if (!added && known->second.hash == hash && now < known->second.next) return false;
  known->second = {hash, now + kEvery};
  return true;
}

}  // namespace styled::stylenats

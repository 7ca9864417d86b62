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
      return !row.second.waits && now - row.second.used >= limits_.idle;
    });
    if (free == slots_.end()) return nullptr;
    slots_.erase(free);
  }
  Slot& slot = slots_[key];
  slot.frame.subject =
      body ? BodySubject(site_, performer, stream) : FrameSubject(site_, performer, stream);
  slot.frame.body = body;
  return &slot;
}

FrameQueue::Slot* FrameQueue::Fill(std::string_view performer, std::string_view stream, bool body,
                                   std::string_view payload, Clock::time_point now) {
  ++counts_.pushed;
  Slot* const slot = Find(performer, stream, body, now);
  const std::size_t freed = slot != nullptr && slot->waits ? slot->frame.payload.size() : 0;
  if (slot == nullptr || bytes_ - freed + payload.size() > limits_.bytes) {
    ++counts_.refused;
    return nullptr;
  }
  bytes_ += payload.size() - freed;
  slot->frame.payload.assign(payload);
  slot->used = now;
  return slot;
}

FrameQueue::Pushed FrameQueue::Queue(Slot& slot) {
  if (slot.waits) {
    // A body that gives way to the next second's is no loss.
    slot.replaced += slot.frame.body ? 0 : 1;
    counts_.replaced += slot.frame.body ? 0 : 1;
    return Pushed::kReplaced;
  }
  slot.waits = true;
  order_.push_back(&slot);
  wake_.notify_one();
  return Pushed::kQueued;
}

FrameQueue::Pushed FrameQueue::Push(std::string_view performer, std::string_view stream,
                                    std::string_view payload, std::uint64_t epoch,
                                    std::uint64_t sequence, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  Slot* const slot = Fill(performer, stream, false, payload, now);
  if (slot == nullptr) return Pushed::kRefused;
  slot->frame.epoch = epoch;
  slot->frame.sequence = sequence;
  return Queue(*slot);
}

FrameQueue::Pushed FrameQueue::PushBody(std::string_view performer, std::string_view stream,
                                        std::string_view payload, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  Slot* const slot = Fill(performer, stream, true, payload, now);
  return slot == nullptr ? Pushed::kRefused : Queue(*slot);
}

bool FrameQueue::Take(QueuedFrame& out, const std::stop_token& stop,
                      std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  if (!wake_.wait_for(lock, stop, timeout, [this] { return !order_.empty(); })) return false;
  Slot& slot = *order_.front();
  order_.pop_front();
  slot.waits = false;
  bytes_ -= slot.frame.payload.size();
  out.subject = slot.frame.subject;
  out.body = slot.frame.body;
  out.epoch = slot.frame.epoch;
  out.sequence = slot.frame.sequence;
  out.payload = std::exchange(slot.frame.payload, {});
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
      if (slot.replaced > 0) rows.emplace_back(slot.frame.subject, slot.replaced);
    }
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  return rows;
}

bool AudienceTier::Takes(const std::string& performer) {
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

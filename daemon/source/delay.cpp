#include "daemon/source/delay.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/runtime/histogram.h"
#include "daemon/runtime/schedule.h"
#include "daemon/source/frame_memory.h"

namespace styled::source {
namespace {

using runtime::kSecond_ns;

constexpr std::size_t kHeld = 1024;
constexpr std::size_t kUsualBytes = 4096;
// A frame later than this means that the sender's clock was set back.
constexpr std::int64_t kLost_ns = 5 * kSecond_ns;

// The schedule of one performer's frames.
struct Sender {
  std::uint64_t session = 0;
  std::string performer;
  runtime::Schedule schedule;
  std::uint64_t first_ns = 0;
  // The newest frame's values, and the distance between frames.
  std::uint64_t sequence = 0, time_ns = 0;
  std::int64_t due_ns = 0, period_ns = 0;

  // Records a frame unless it is older than the newest one.
  void Record(std::uint64_t the_sequence, std::uint64_t the_time_ns, std::int64_t the_due_ns) {
    if (the_sequence <= sequence && due_ns != 0) return;
    if (the_sequence == sequence + 1) period_ns = static_cast<std::int64_t>(the_time_ns - time_ns);
    sequence = the_sequence;
    time_ns = the_time_ns;
    due_ns = the_due_ns;
  }
  // A body is due a quarter of a period after the frame before it, which may still be in transit.
  std::int64_t BodyDue_ns(std::uint64_t the_sequence) const {
    const auto frames = static_cast<std::int64_t>(the_sequence - sequence) - 1;
    return due_ns + std::clamp<std::int64_t>(frames, -8, 8) * period_ns + period_ns / 4;
  }
};

class Delayed final : public Transport, private Receiver {
 public:
  Delayed(std::unique_ptr<Transport> inner, std::int64_t delay_ns, runtime::Clock& clock)
      : inner_(std::move(inner)), delay_ns_(delay_ns), clock_(clock), slots_(kHeld) {
    for (std::size_t i = 0; i < kHeld; ++i) free_.push_back(i);
    due_.reserve(kHeld);
  }

  int DoWork(Receiver& receiver) override {
    const std::int64_t now_ns = clock_.Now_ns();
    to_ = &receiver;
    int work = inner_->DoWork(*this);
    work += Release(now_ns, 0);
    if (now_ns - sampled_ns_ >= kSecond_ns) SampleLateness(now_ns);
    return work;
  }
  std::int64_t NextDeadline_ns() const override {
    const std::int64_t next_ns =
        due_.empty() ? std::numeric_limits<std::int64_t>::max() : slots_[due_.front()].due.due_ns;
    return std::min(inner_->NextDeadline_ns(), next_ns);
  }
  bool has_sensors() const override { return inner_->has_sensors(); }
  Status Calibrate(Calibration what, std::int64_t now_ns) override {
    return inner_->Calibrate(what, now_ns);
  }
  int fd() const override { return inner_->fd(); }
  const std::string& endpoint() const override { return inner_->endpoint(); }
  std::uint64_t received() const override { return inner_->received(); }
  Smoothing smoothing() const override { return shown_; }
  void Sample() override { inner_->Sample(); }
  std::uint64_t kernel_dropped() const override { return inner_->kernel_dropped(); }

 private:
  // When a frame or body leaves. `schedule_ns` is set for frames: when it would leave if it were in
  // time.
  struct Due {
    std::int64_t due_ns = 0;
    std::optional<std::int64_t> schedule_ns = {};
  };
  struct Slot {
    Due due;
    SourceFrame frame;
    FrameMemory memory{kUsualBytes};
  };

  void OnNote(int source, const std::string& text) override { to_->OnNote(source, text); }
  void OnNotice(int source, const std::string& text) override { to_->OnNotice(source, text); }
  STYLED_REALTIME void OnArrival(const Arrival& arrival) noexcept override {
    to_->OnArrival(arrival);
  }

  void OnFrames(int source, std::span<const SourceFrame> frames, bool /*more_waiting*/) override {
    source_ = source;
    const std::int64_t now_ns = clock_.Now_ns();
    for (const SourceFrame& frame : frames) {
      if (free_.empty()) Release(now_ns, 1);
      Slot& slot = slots_[free_.back()];
      slot.due = When(frame, now_ns);
      slot.frame = slot.memory.Keep(frame);
      // The delay itself is not the daemon's latency; waiting beyond it is.
      const std::int64_t arrival_ns = frame.arrival_ns == 0 ? now_ns : frame.arrival_ns;
      slot.frame.arrival_ns = std::max(arrival_ns, slot.due.schedule_ns.value_or(arrival_ns));
      // Sorted insert by due time; mostly at the end.
      const auto later = [this](std::int64_t due_ns, std::size_t held) {
        return due_ns < slots_[held].due.due_ns;
      };
      due_.insert(std::upper_bound(due_.begin(), due_.end(), slot.due.due_ns, later), free_.back());
      free_.pop_back();
    }
  }

  Due When(const SourceFrame& frame, std::int64_t now_ns) {
    if (frame.is_body) {
      const Sender* sender = Find(frame.session, frame.performer);
      if (sender == nullptr) return {now_ns};
      return {std::max(now_ns, sender->BodyDue_ns(frame.sequence))};
    }
    Sender& sender = Ensure(frame.session, frame.performer, frame.source_time_ns);
    const auto late = [&] {
      return sender.schedule.Lateness_ns(
          static_cast<std::int64_t>(frame.source_time_ns - sender.first_ns), now_ns);
    };
    std::int64_t late_ns = late();
    if (late_ns > kLost_ns) {
      sender.schedule = runtime::Schedule();
      late_ns = late();
    }
    arrived_.Add(late_ns);
    if (late_ns > delay_ns_) ++missed_;
    // now_ns - late_ns is when the frame would have arrived with the shortest transit.
    const std::int64_t schedule_ns = now_ns - late_ns + delay_ns_;
    sender.Record(frame.sequence, frame.source_time_ns, schedule_ns);
    return {std::max(now_ns, schedule_ns), schedule_ns};
  }

  Sender* Find(std::uint64_t session, std::string_view performer) {
    for (Sender& sender : senders_) {
      if (sender.session == session && sender.performer == performer) return &sender;
    }
    return nullptr;
  }
  // A performer's new session replaces its last one. When the table is full, the first entry is
  // replaced.
  Sender& Ensure(std::uint64_t session, std::string_view performer, std::uint64_t time_ns) {
    if (Sender* known = Find(session, performer)) return *known;
    constexpr std::size_t kMost = 256;
    auto place = std::find_if(senders_.begin(), senders_.end(),
                              [&](const Sender& s) { return s.performer == performer; });
    if (place == senders_.end() && senders_.size() >= kMost) place = senders_.begin();
    if (place == senders_.end()) place = senders_.emplace(senders_.end());
    *place = Sender();
    place->session = session;
    place->performer = performer;
    place->first_ns = time_ns;
    return *place;
  }

  // Passes on the frames that are due, and at least `least` frames.
  int Release(std::int64_t now_ns, std::size_t least) {
    std::array<SourceFrame, kBatch> batch;
    std::size_t count = 0;
    while (count < due_.size() && count < kBatch &&
           (count < least || slots_[due_[count]].due.due_ns <= now_ns)) {
      const Slot& slot = slots_[due_[count]];
      batch[count] = slot.frame;
      if (slot.due.schedule_ns)
        left_.Add(std::max<std::int64_t>(0, now_ns - *slot.due.schedule_ns));
      ++count;
    }
    if (count == 0) return 0;
    to_->OnFrames(source_, std::span(batch).first(count), count == kBatch);
    for (std::size_t i = 0; i < count; ++i) {
      slots_[due_[i]].frame.body.reset();
      free_.push_back(due_[i]);
    }
    due_.erase(due_.begin(), due_.begin() + static_cast<std::ptrdiff_t>(count));
    return static_cast<int>(count);
  }

  void SampleLateness(std::int64_t now_ns) {
    sampled_ns_ = now_ns;
    constexpr float kAlmostAll = 0.99F;
    shown_ = {static_cast<float>(delay_ns_) * 1e-6F, arrived_.Percentile_us(kAlmostAll) * 1e-3F,
              left_.Percentile_us(kAlmostAll) * 1e-3F, missed_};
    arrived_.Clear();
    left_.Clear();
  }

  std::unique_ptr<Transport> inner_;
  std::int64_t delay_ns_;
  runtime::Clock& clock_;
  Receiver* to_ = nullptr;
  int source_ = 0;
  std::vector<Slot> slots_;
  std::vector<std::size_t> free_, due_;  // indices of slots; due_ in the order in which they leave
  std::vector<Sender> senders_;
  runtime::Histogram arrived_, left_;  // lateness of frames at arrival and at leaving
  std::uint64_t missed_ = 0;
  std::int64_t sampled_ns_ = 0;
  Smoothing shown_;
};

}  // namespace

std::unique_ptr<Transport> MakeDelayed(std::unique_ptr<Transport> inner, float delay_s,
                                       runtime::Clock& clock) {
  return std::make_unique<Delayed>(std::move(inner), runtime::Nanoseconds(delay_s), clock);
}

}  // namespace styled::source

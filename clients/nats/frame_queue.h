#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace styled::stylenats {

// A frame, or a body, on its way to the broker.
struct QueuedFrame {
  std::string subject;
  std::string payload;  // the daemon's bytes
  bool body = false;
  std::uint64_t epoch = 0, sequence = 0;  // of a frame
};

// The queue between the thread that reads ZeroMQ and the one that publishes, which may block for
// seconds. It has a slot for each performer and stream, and one for the body of each. A slot holds
// the newest few frames, or the newest two bodies. When it is full, the oldest is replaced by the
// arriving one, and counted. Messages leave in the order of arrival, so a body precedes the frames
// that need it.
//
// Bounded by slots and by bytes, for any names of the daemon. When all slots are in use, one that
// was not used for `idle` is reassigned to the new stream; if there is none, the frame is refused
// and counted.
//
// Any thread. Allocates. Pinned by tests/unit/nats/frame_queue_test.cpp.
class FrameQueue {
 public:
  using Clock = std::chrono::steady_clock;
  struct Limits {
    // 128 performers with four streams and their bodies; a daemon has 64 at most by default.
    std::size_t slots = 1024;
    // Of all waiting frames. 16 performers with four streams of 3 kB need 192 kB.
    std::size_t bytes = std::size_t{64} << 20U;
    std::chrono::nanoseconds idle = std::chrono::seconds(10);
    // Frames of a slot. Four are 33 ms at 120 Hz: a virtual machine that stands still for 10 to
    // 30 ms loses none, and what is shown is hardly late.
    std::size_t depth = 4;
  };
  enum class Pushed { kQueued, kReplaced, kRefused };
  struct Counts {
    std::uint64_t pushed = 0;    // all calls of Push and PushBody
    std::uint64_t replaced = 0;  // frames that a newer one replaced before they were sent
    std::uint64_t refused = 0;   // frames for which there was no slot or no room
  };

  explicit FrameQueue(std::string site) : FrameQueue(std::move(site), Limits()) {}
  FrameQueue(std::string site, const Limits& limits) : site_(std::move(site)), limits_(limits) {}

  Pushed Push(std::string_view performer, std::string_view stream, std::string_view payload,
              std::uint64_t epoch, std::uint64_t sequence, Clock::time_point now = Clock::now());
  Pushed PushBody(std::string_view performer, std::string_view stream, std::string_view payload,
                  Clock::time_point now = Clock::now());

  // Waits for a message and removes the oldest. False when `stop` is requested and nothing waits,
  // or after `timeout`.
  bool Pop(QueuedFrame& out, const std::stop_token& stop, std::chrono::milliseconds timeout);

  std::size_t waiting() const;
  Counts counts() const;
  // The subjects with replaced frames, most first, with the number since their slot was made.
  std::vector<std::pair<std::string, std::uint64_t>> replaced() const;

 private:
  struct Waiting {
    std::string payload;
    std::uint64_t epoch = 0, sequence = 0;
  };
  struct Slot {
    std::string subject;
    bool body = false;
    std::deque<Waiting> waiting;
    std::size_t bytes = 0;  // of those
    std::uint64_t replaced = 0;
    Clock::time_point used;
  };
  using Key = std::tuple<std::string, std::string, bool>;  // performer, stream, whether a body
  Slot* Find(std::string_view performer, std::string_view stream, bool body, Clock::time_point now);
  void DropOldest(Slot& slot);
  Pushed Add(std::string_view performer, std::string_view stream, bool body, Waiting message,
             Clock::time_point now);

  const std::string site_;
  const Limits limits_;
  mutable std::mutex mutex_;
  std::condition_variable_any wake_;
  std::map<Key, Slot, std::less<>> slots_;  // its nodes do not move
  std::deque<Slot*> order_;                 // one entry for each message that waits
  std::size_t bytes_ = 0;                   // of those that wait
  Counts counts_;
};

// Picks the frames of the audience tier: of each performer's canonical frames, in order of arrival,
// the first and then every fourth; for a rig of 120 Hz that is 30 Hz. It counts frames, not time
// and not sequence numbers. One thread. Bounded: beyond kMaxPerformers all counts restart.
class AudienceTier {
 public:
  static constexpr std::uint32_t kStep = 4;
  static constexpr std::size_t kMaxPerformers = 1024;
  bool Picks(const std::string& performer);

 private:
  std::unordered_map<std::string, std::uint32_t> counts_;
};

// Decides when the body of a stream's frames is sent with them: before the first frame, when it
// changes, and once a second, as a daemon repeats it. A reader that starts anywhere therefore has a
// body within a second of frames. One thread. Bounded: beyond kMaxStreams all streams restart.
class BodyBeat {
 public:
  using Clock = FrameQueue::Clock;
  // A body of the canonical humanoid has 1.5 kB, a second of its frames 80 kB: 2 % more.
  static constexpr std::chrono::seconds kEvery{1};
  static constexpr std::size_t kMaxStreams = 1024;
  bool IsDue(const std::string& performer, std::string_view stream, std::uint64_t hash,
             Clock::time_point now = Clock::now());

 private:
  struct Last {
    std::uint64_t hash = 0;
    Clock::time_point next;
  };
  std::map<std::pair<std::string, std::string>, Last> last_;
};

}  // namespace styled::stylenats

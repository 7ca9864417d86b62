#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::faults {

std::int64_t Now_ns();  // monotonic

// Performers "p0", "p1", ... who send at 120 Hz, evenly out of step, on a thread of their own until
// Stop() or destruction.
class Feed {
 public:
  struct Sent {
    std::uint64_t datagrams = 0, frames = 0, withheld = 0;
  };
  // Before each frame is sent: may change the rig (its clock), or withhold the frame by returning
  // false: its sequence is used up.
  using Meddle = std::function<bool(support::Rig&)>;
  Feed(std::string udp, int performers, Meddle meddle = {});
  ~Feed();
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;
  Sent Stop();
  Sent so_far() const { return {datagrams_, frames_, withheld_}; }

 private:
  void Run();
  std::string udp_;
  int performers_;
  Meddle meddle_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> datagrams_{0}, frames_{0}, withheld_{0};
  std::thread thread_;
};

// A healthy subscriber who reads all that is styled, on a thread of its own, and only counts.
class Watcher {
 public:
  struct Seen {
    std::uint64_t frames = 0;
    std::uint64_t missing = 0;      // by the published sequence, within one epoch
    std::uint64_t longest_gap = 0;  // frames missing in one go
    std::uint64_t bad = 0;  // a frame with something non-finite, or a rotation not of length 1
    // Frames that left more than 1/120 s after their source time, where that is this machine's
    // monotonic clock.
    std::uint64_t over_period = 0;
    std::int64_t last_ns = 0;           // when the last frame came
    std::int64_t last_wall_ns = 0;      // Unix time by the daemon's clock, in that frame
    std::int64_t longest_pause_ns = 0;  // between two frames of any performer
    std::string style;                  // of the last frame, "" = none
    std::uint64_t epoch = 0;
  };
  explicit Watcher(const std::string& publish);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;
  Seen seen() const;
  // Whether a frame comes within `seconds` that was published after this call.
  bool Sees(double seconds) const;

 private:
  void Run();
  void Record(const std::string& payload);
  void *context_, *socket_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  Seen seen_;
  std::map<std::string, std::uint64_t> sequence_;
  std::thread thread_;
};

// Of /proc/PID/status and /proc/PID/fd.
std::uint64_t ResidentBytes(int pid);
int Descriptors(int pid);

}  // namespace styled::faults

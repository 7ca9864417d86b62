#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "daemon/looks/mailboxes.h"
#include "daemon/perform/roster.h"
#include "model/base/realtime.h"
#include "model/base/status.h"

namespace styled::pipeline {

// What performers show of a style for Like.learn_s: their own motion, before it is styled, sampled
// at the network's rate by the frames' source time. Pipeline thread only. Pinned by
// tests/e2e/like_test.cpp.
class Takes {
 public:
  // Begins a take; the request is checked, and the performer must be live. Otherwise leaves the
  // exchange. Makes room for all of it: allocates.
  Status Begin(std::unique_ptr<Exchange>& exchange, const Roster& roster, std::int64_t now_ns);
  bool empty() const { return takes_.empty(); }
  // Samples a performer's frame, which has just been styled.
  STYLED_REALTIME void OnFrame(const Performer& performer) noexcept;
  // The next request whose take is complete, or, with an error in its reply, was broken off; null
  // if there is none.
  std::unique_ptr<Exchange> Pop(std::int64_t now_ns);

 private:
  struct Take {
    std::unique_ptr<Exchange> exchange;
    std::string performer;  // its id
    double step_ns;         // of the network
    std::size_t wanted;     // poses
    std::int64_t due_ns;    // of the clock: without a frame until then it is broken off
    std::int64_t began_ns = 0, last_ns = 0;  // elapsed time of the session
    body::Pose last;
    bool started = false, broken = false;
  };
  STYLED_REALTIME static void Sample(const body::Pose& pose, std::int64_t elapsed_ns,
                                     Take& take) noexcept;

  std::vector<Take> takes_;
};

}  // namespace styled::pipeline

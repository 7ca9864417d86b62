#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string_view>

#include "daemon/runtime/clock.h"
#include "daemon/source/frame_memory.h"
#include "daemon/source/source_frame.h"

namespace styled::pipeline {

// Bodies whose binding waits for a later turn of the pipeline, and the frames behind them. Binding
// takes milliseconds: of many performers who begin at once, all in one turn would keep the frames
// of live performers waiting. Pipeline thread; allocates.
class Postponed {
 public:
  struct Frame {
    int source = 0;
    source::SourceFrame frame;
    source::FrameMemory memory{4096};
  };

  bool empty() const { return frames_.empty(); }
  // Whether something of the performer waits: what comes then waits behind it.
  bool Has(int source, std::string_view performer) const noexcept;
  // Keeps a copy. False: too much waits already, so that it is handled at once.
  bool Add(int source, const source::SourceFrame& frame);
  void Clear() { frames_.clear(); }

  // A turn begins.
  void BeginTurn() { binding_ns_ = 0; }
  void Spend(std::int64_t binding_ns) { binding_ns_ += binding_ns; }
  // Whether the time that a turn may bind bodies is used up.
  bool spent() const { return binding_ns_ > kBudget_ns; }
  // All that waits, oldest first; what is not handled goes back with PutBack.
  std::deque<std::unique_ptr<Frame>> Pop();
  // In front of what was added since Pop.
  void PutBack(std::deque<std::unique_ptr<Frame>> rest);

 private:
  // While a performer is live: half of a frame's period at 120 Hz. One took 2.3 ms beside three
  // builds.
  static constexpr std::int64_t kBudget_ns = runtime::kSecond_ns / 240;
  // Frames and bodies. 64 who begin at once are bound within 0.15 s, in which they send 576 frames
  // at 60 Hz.
  static constexpr std::size_t kMost = 1024;

  std::deque<std::unique_ptr<Frame>> frames_;
  std::int64_t binding_ns_ = 0;  // spent in this turn
};

}  // namespace styled::pipeline

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
// takes milliseconds: if many performers start together, binding all in one turn would delay the
// frames of live performers. Pipeline thread; allocates.
class Postponed {
 public:
  struct Frame {
    int source = 0;
    source::SourceFrame frame;
    source::FrameMemory memory{4096};
  };

  bool empty() const { return frames_.empty(); }
  // Whether data of the performer waits, so that later data must wait behind it.
  bool Has(int source, std::string_view performer) const noexcept;
  // Adds a copy. Returns false if too much waits already: the caller then processes the frame at
  // once.
  bool Add(int source, const source::SourceFrame& frame);
  void Clear() { frames_.clear(); }

  // A turn begins.
  void BeginTurn() { binding_ns_ = 0; }
  void Spend(std::int64_t binding_ns) { binding_ns_ += binding_ns; }
  // Whether the time that a turn may bind bodies is used up.
  bool spent() const { return binding_ns_ > kBudget_ns; }
  // Removes all waiting frames, oldest first. PutBack returns those that were not processed.
  std::deque<std::unique_ptr<Frame>> Pop();
  // Inserts frames in front of those added since Pop.
  void PutBack(std::deque<std::unique_ptr<Frame>> rest);

 private:
  // Time per turn while a performer is live: half of a frame's period at 120 Hz. One binding took
  // 2.3 ms on a machine with three builds running.
  static constexpr std::int64_t kBudget_ns = runtime::kSecond_ns / 240;
  // Frames and bodies. 64 performers that start together are bound within 0.15 s, in which they
  // send 576 frames at 60 Hz.
  static constexpr std::size_t kMost = 1024;

  std::deque<std::unique_ptr<Frame>> frames_;
  std::int64_t binding_ns_ = 0;  // spent in this turn
};

}  // namespace styled::pipeline

#pragma once

#include <cstdint>

namespace styled::pipeline {

// The work of a PipelineThread: the pipeline, or a benchmark's replacement.
class Worker {
 public:
  virtual ~Worker() = default;
  // Returns the amount of work; 0: nothing to do before NextDeadline_ns(), unless data arrives.
  // Bounded, never blocks.
  virtual int DoWork() = 0;
  virtual std::int64_t NextDeadline_ns() const = 0;
  // Whether a frame is about to arrive, so that a thread in hybrid mode polls.
  virtual bool Expects(std::int64_t now_ns) const = 0;
};

}  // namespace styled::pipeline

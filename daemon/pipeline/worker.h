#pragma once

#include <cstdint>

namespace styled::pipeline {

// What a PipelineThread turns over: the pipeline, or what a bench puts in its place.
class Worker {
 public:
  virtual ~Worker() = default;
  // How much was done; 0: nothing to do before NextDeadline_ns(), unless something arrives.
  // Bounded, never blocks.
  virtual int DoWork() = 0;
  virtual std::int64_t NextDeadline_ns() const = 0;
  // A frame is about to arrive: who waits in hybrid mode polls.
  virtual bool Expects(std::int64_t now_ns) const = 0;
};

}  // namespace styled::pipeline

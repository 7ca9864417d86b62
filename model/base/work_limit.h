#pragma once

#include <chrono>
#include <string>
#include <utility>

#include "model/base/status.h"
#include "model/base/text.h"

namespace styled {

// The deadline of one piece of work, such as reading a client's file. Long loops check it now and
// then and give up, so that no content keeps a thread busy for longer. Without a limit (the
// default) work may take any time. Immutable; any thread.
class WorkLimit {
 public:
  using Clock = std::chrono::steady_clock;

  WorkLimit() = default;
  // The deadline in `most` from now. `expected` ends the message: the content that would have been
  // read in time.
  static WorkLimit Within(std::chrono::milliseconds most, std::string expected) {
    return {Clock::now() + most, most, std::move(expected)};
  }

  bool exceeded() const { return due_ != Clock::time_point::max() && Clock::now() >= due_; }
  // The error of work that gave up: "FILE: took longer than 2 s, expected a clip of 60 s", or the
  // same without the file.
  Status Refusal(const std::string& file = "") const {
    const double most_s = std::chrono::duration<double>(most_).count();
    return Status::Error((file.empty() ? "" : file + ": ") + "took longer than " +
                         NumberText(most_s) + " s, expected " + expected_);
  }

 private:
  WorkLimit(Clock::time_point due, std::chrono::milliseconds most, std::string expected)
      : due_(due), most_(most), expected_(std::move(expected)) {}

  Clock::time_point due_ = Clock::time_point::max();
  std::chrono::milliseconds most_{0};
  std::string expected_;
};

}  // namespace styled

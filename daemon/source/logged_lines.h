#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/runtime/clock.h"

namespace styled::source {

// Remembers which lines about a rig's server were logged, so that each is logged once while the
// server is connected. Pipeline thread. Pinned by tests/unit/qtm and tests/unit/natnet,
// translator_test.cpp.
class LoggedLines {
 public:
  // Whether a line is new; remembers it. False if there are too many, because a server's text may
  // differ each time. Allocates.
  bool Add(const std::string& line) {
    if (lines_.size() >= kMost || std::ranges::find(lines_, line) != lines_.end()) return false;
    lines_.push_back(line);
    return true;
  }
  // Call when the server connects again: its complaints are logged again. For a server that
  // reconnects every minute this is limited, so that it does not fill a log. Frees memory.
  void Forget(std::int64_t now_ns) {
    if (!lines_.empty() && now_ns - forgot_ns_ < kPause_ns) return;
    forgot_ns_ = now_ns;
    lines_.clear();
  }

 private:
  static constexpr std::size_t kMost = 64;
  static constexpr std::int64_t kPause_ns = 60 * runtime::kSecond_ns;

  std::vector<std::string> lines_;
  std::int64_t forgot_ns_ = -kPause_ns;
};

}  // namespace styled::source

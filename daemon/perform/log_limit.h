#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string_view>

#include "daemon/source/transport.h"

namespace styled::pipeline {

// Limits the pipeline's log lines, so that no sender fills the log or hides another's lines. The
// limit applies per kind of line and subject (a performer): the first line passes, the next one a
// second later, then after 2, 4, ... 64 s; after twice that time without a line it starts again.
// Lines of new subjects pass 16 in succession and 2 a second per sending machine, and 64 in
// succession and 8 a second in total, so invented names cannot exceed that or hide lines of another
// machine. Bounded, no allocation; pipeline thread. Pinned by
// tests/unit/daemon/perform/log_limit_test.cpp.
class LogLimit {
 public:
  enum class Kind : std::uint8_t {
    kBodyRefused,
    kBodyBound,
    kForgotten,
    kCue,
    kCueRefused,
    kFacing,
    kFace,
    kStray,
    kFingers,
    kStandby,
    kOverload,
    kCount
  };

  // Whether the line may pass. If it may, `held_back` receives how many lines of this kind and
  // subject were held back since the last one. `sender`: the machine that caused the line; all
  // zeros: none.
  bool Admit(Kind kind, const source::Machine& sender, std::string_view subject,
             std::int64_t now_ns, std::uint64_t& held_back) noexcept {
    const std::size_t hash = std::hash<std::string_view>()(subject);
    Row* row = Find(kind, hash);
    if (row == nullptr) {
      if (!Spend(sender, now_ns)) return false;
      row = Free(now_ns);
      *row = {kind, true, hash, now_ns, now_ns, kFirstWait_ns, 0};
      held_back = 0;
      return true;
    }
    const bool quiet = now_ns - row->asked_ns > 2 * row->wait_ns;
    row->asked_ns = now_ns;
    if (now_ns - row->logged_ns < row->wait_ns) {
      ++row->held_back;
      return false;
    }
    row->logged_ns = now_ns;
    row->wait_ns = quiet ? kFirstWait_ns : std::min(2 * row->wait_ns, kLongestWait_ns);
    held_back = row->held_back;
    row->held_back = 0;
    return true;
  }

 private:
  static constexpr std::int64_t kFirstWait_ns = 1'000'000'000;
  static constexpr std::int64_t kLongestWait_ns = 64 * kFirstWait_ns;
  static constexpr std::size_t kRows = 256;
  static constexpr std::size_t kMachines = 32;
  static constexpr double kBurst = 16, kPerSecond = 2, kBurstOfAll = 64, kPerSecondOfAll = 8;

  struct Row {
    Kind kind = Kind::kBodyRefused;
    bool used = false;
    std::size_t hash = 0;
    std::int64_t logged_ns = 0, asked_ns = 0, wait_ns = 0;
    std::uint64_t held_back = 0;
  };
  struct Bucket {
    source::Machine machine{};
    double tokens = kBurst;
    std::int64_t last_ns = std::numeric_limits<std::int64_t>::min() / 2;

    bool Fill(std::int64_t now_ns, double most, double per_second) noexcept {
      const double passed_s = static_cast<double>(now_ns - last_ns) * 1e-9;
      tokens = std::min(most, tokens + std::max(0.0, passed_s) * per_second);
      last_ns = now_ns;
      return tokens >= 1;
    }
  };

  Row* Find(Kind kind, std::size_t hash) noexcept {
    for (Row& row : rows_) {
      if (row.used && row.kind == kind && row.hash == hash) return &row;
    }
    return nullptr;
  }
  // A free row, or the one that was quiet for longest.
  Row* Free(std::int64_t now_ns) noexcept {
    Row* best = rows_.data();
    std::int64_t quietest_ns = std::numeric_limits<std::int64_t>::min();
    for (Row& row : rows_) {
      if (!row.used) return &row;
      const std::int64_t quiet_ns = now_ns - row.asked_ns;
      if (quiet_ns > quietest_ns) {
        quietest_ns = quiet_ns;
        best = &row;
      }
    }
    return best;
  }
  // A new machine replaces the one that was quiet for longest.
  bool Spend(const source::Machine& sender, std::int64_t now_ns) noexcept {
    Bucket* mine = machines_.data();
    for (Bucket& bucket : machines_) {
      if (bucket.machine == sender) {
        mine = &bucket;
        break;
      }
      if (bucket.last_ns < mine->last_ns) mine = &bucket;
    }
    if (mine->machine != sender) *mine = {sender};
    if (!mine->Fill(now_ns, kBurst, kPerSecond)) return false;
    if (!all_.Fill(now_ns, kBurstOfAll, kPerSecondOfAll)) return false;
    mine->tokens -= 1;
    all_.tokens -= 1;
    return true;
  }

  std::array<Row, kRows> rows_;
  std::array<Bucket, kMachines> machines_;
  Bucket all_;
};

}  // namespace styled::pipeline

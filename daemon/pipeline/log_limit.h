#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string_view>

namespace styled::pipeline {

// Which of the pipeline's lines reach the log, so that no sender fills it and none hides another's.
// The limit is of one kind of line about one subject (a performer): the first line passes, the next
// one a second later, then after 2, 4, ... 64 s; who was quiet for twice as long begins anew. New
// subjects of a kind pass 16 at once and 2 a second, so that invented names cost no more than that.
// Bounded, no allocation; pipeline thread. Pinned by tests/unit/daemon/log_limit_test.cpp.
class LogLimit {
 public:
  enum class Kind : std::uint8_t { kBodyRefused, kBodyBound, kForgotten, kCue, kFacing, kCount };

  // Whether the line may pass. `held_back`: how many of the kind about the subject did not since
  // its last one; only where it may.
  bool Admit(Kind kind, std::string_view subject, std::int64_t now_ns,
             std::uint64_t& held_back) noexcept {
    const std::size_t hash = std::hash<std::string_view>()(subject);
    Row* row = Find(kind, hash);
    if (row == nullptr) {
      if (!Spend(kind, now_ns)) return false;
      row = Free(now_ns);
      *row = {kind, true, hash, now_ns, now_ns, kFirstWait_ns, 0};
      held_back = 0;
      return true;
    }
    const bool quiet = now_ns - row->heard_ns > 2 * row->wait_ns;
    row->heard_ns = now_ns;
    if (now_ns - row->said_ns < row->wait_ns) {
      ++row->held_back;
      return false;
    }
    row->said_ns = now_ns;
    row->wait_ns = quiet ? kFirstWait_ns : std::min(2 * row->wait_ns, kLongestWait_ns);
    held_back = row->held_back;
    row->held_back = 0;
    return true;
  }

 private:
  static constexpr std::int64_t kFirstWait_ns = 1'000'000'000;
  static constexpr std::int64_t kLongestWait_ns = 64 * kFirstWait_ns;
  static constexpr std::size_t kRows = 256;
  static constexpr double kBurst = 16, kPerSecond = 2;

  struct Row {
    Kind kind = Kind::kBodyRefused;
    bool used = false;
    std::size_t hash = 0;
    std::int64_t said_ns = 0, heard_ns = 0, wait_ns = 0;
    std::uint64_t held_back = 0;
  };
  struct Bucket {
    double tokens = kBurst;
    std::int64_t last_ns = 0;
  };

  Row* Find(Kind kind, std::size_t hash) noexcept {
    for (Row& row : rows_) {
      if (row.used && row.kind == kind && row.hash == hash) return &row;
    }
    return nullptr;
  }
  // One that is free, or the longest quiet one.
  Row* Free(std::int64_t now_ns) noexcept {
    Row* best = rows_.data();
    std::int64_t quietest_ns = std::numeric_limits<std::int64_t>::min();
    for (Row& row : rows_) {
      if (!row.used) return &row;
      const std::int64_t quiet_ns = now_ns - row.heard_ns;
      if (quiet_ns > quietest_ns) {
        quietest_ns = quiet_ns;
        best = &row;
      }
    }
    return best;
  }
  bool Spend(Kind kind, std::int64_t now_ns) noexcept {
    Bucket& bucket = buckets_[static_cast<std::size_t>(kind)];
    const double passed_s = static_cast<double>(now_ns - bucket.last_ns) * 1e-9;
    bucket.tokens = std::min(kBurst, bucket.tokens + std::max(0.0, passed_s) * kPerSecond);
    bucket.last_ns = now_ns;
    if (bucket.tokens < 1) return false;
    bucket.tokens -= 1;
    return true;
  }

  std::array<Row, kRows> rows_;
  std::array<Bucket, static_cast<std::size_t>(Kind::kCount)> buckets_;
};

}  // namespace styled::pipeline

#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "model/base/realtime.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::pipeline {

// Measures where a frame's time is spent between the arrival of its datagram and the last zmq_send,
// summed over a second. One thread.
class Stages {
 public:
  enum Stage : std::uint8_t { kTake, kStyle, kSerialize, kSend, kCount };

  // Adds a time spent in one stage. For kTake only the time of a whole batch may be known.
  STYLED_REALTIME void Add(Stage stage, std::int64_t ns) noexcept {
    Sum& sum = sums_[stage];
    sum.ns += ns;
    sum.longest_ns = std::max(sum.longest_ns, ns);
  }
  STYLED_REALTIME void AddFrames(std::size_t count) noexcept { frames_ += count; }
  // Time spent in all stages but kTake so far. The difference over a batch is not kTake's.
  STYLED_REALTIME std::int64_t Elsewhere_ns() const noexcept {
    return sums_[kStyle].ns + sums_[kSerialize].ns + sums_[kSend].ns;
  }
  STYLED_REALTIME std::int64_t Spent_ns(Stage stage) const noexcept { return sums_[stage].ns; }

  // Call once a second: fixes the values for Describe.
  void Sample() noexcept {
    sampled_ = sums_;
    sampled_frames_ = frames_;
    sums_ = {};
    frames_ = 0;
  }
  // Allocates.
  void Describe(v1::Stats& stats) const {
    if (sampled_frames_ == 0) return;
    constexpr std::array<std::string_view, kCount> kNames{"take", "style", "serialize", "send"};
    for (std::size_t i = 0; i < kCount; ++i) {
      auto& row = *stats.add_stages();
      row.set_name(kNames[i].data(), kNames[i].size());
      row.set_mean_us(static_cast<float>(static_cast<double>(sampled_[i].ns) * 1e-3 /
                                         static_cast<double>(sampled_frames_)));
      row.set_max_us(static_cast<float>(sampled_[i].longest_ns) * 1e-3F);
    }
  }

 private:
  struct Sum {
    std::int64_t ns = 0, longest_ns = 0;
  };
  std::array<Sum, kCount> sums_{}, sampled_{};
  std::uint64_t frames_ = 0, sampled_frames_ = 0;
};

}  // namespace styled::pipeline

#pragma once

#include <netinet/in.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "daemon/source/transport.h"
#include "model/base/realtime.h"

namespace styled::source {

// Limits the datagrams per second of one address, whatever its ports. Each address has a token
// bucket that holds a quarter of a second's datagrams and is filled evenly. The table is bounded. A
// new address replaces one that was silent for a second; if there is none, it shares one bucket
// with all other addresses without a row. A sender that forges addresses therefore takes nothing
// from known senders. One per socket; pipeline thread. Does not allocate.
class RateLimiter {
 public:
  // `limit_hz` 0 admits everything. `seed` decides which addresses share a row of the table; it
  // should be unknown to senders.
  RateLimiter(int limit_hz, std::uint64_t seed);
  explicit RateLimiter(int limit_hz);

  // Whether the datagram from `from` that arrived at `now_ns` is admitted. `now_ns` must not go
  // back.
  STYLED_REALTIME bool Admit(const sockaddr_storage& from, std::int64_t now_ns) noexcept;

 private:
  static constexpr std::size_t kRows = 128, kWays = 4;
  struct Bucket {
    Machine address{};
    std::int64_t last_ns = 0;
    double tokens = 0;
    bool used = false;
  };
  Bucket& Find(const Machine& address, std::int64_t now_ns) noexcept;

  double per_ns_, most_;
  std::uint64_t seed_;
  std::array<std::array<Bucket, kWays>, kRows> table_{};
  Bucket strangers_;
};

}  // namespace styled::source

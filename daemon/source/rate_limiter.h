#pragma once

#include <netinet/in.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "daemon/source/transport.h"
#include "model/base/realtime.h"

namespace styled::source {

// How many datagrams a second one address may send, whatever its ports: a bucket for each address
// that holds a quarter of a second's and is filled evenly. The table is bounded. An address that is
// not in it takes the place of one that was silent for a second; where there is none, it shares one
// bucket with all others like it, so that who forges addresses takes nothing from those known.
// One per socket; pipeline thread. Does not allocate.
class RateLimiter {
 public:
  // `limit_hz` 0: everything is admitted. `seed` decides which addresses share a row of the table;
  // it should not be known outside.
  RateLimiter(int limit_hz, std::uint64_t seed);
  explicit RateLimiter(int limit_hz);

  // Whether the datagram from there that arrived at `now_ns` may be looked at; `now_ns` never goes
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

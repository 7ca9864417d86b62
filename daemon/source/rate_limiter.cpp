#include "daemon/source/rate_limiter.h"

#include <algorithm>

#include "daemon/runtime/clock.h"
#include "model/base/random_id.h"

namespace styled::source {
namespace {

constexpr std::int64_t kSilence_ns = runtime::kSecond_ns;
constexpr double kLeast = 32;  // a batch is admitted whatever the limit

// The finisher of SplitMix64.
std::uint64_t Mix(std::uint64_t x) noexcept {
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

}  // namespace

RateLimiter::RateLimiter(int limit_hz, std::uint64_t seed)
    : per_ns_(limit_hz / static_cast<double>(runtime::kSecond_ns)),
      most_(limit_hz / 4.0 + kLeast),
      seed_(seed) {
  strangers_.tokens = most_;
}

RateLimiter::RateLimiter(int limit_hz) : RateLimiter(limit_hz, RandomId()) {}

// Each row is a set of kWays buckets. An unknown address gets an unused bucket, or the one that was
// silent for longest.
RateLimiter::Bucket& RateLimiter::Find(const Machine& address, std::int64_t now_ns) noexcept {
  auto& row = table_[Mix(Mix(address[0] ^ seed_) ^ address[1]) % kRows];
  Bucket* oldest = row.data();
  for (Bucket& bucket : row) {
    if (bucket.used && bucket.address == address) return bucket;
    if (!bucket.used || (oldest->used && bucket.last_ns < oldest->last_ns)) oldest = &bucket;
  }
  if (oldest->used && now_ns - oldest->last_ns < kSilence_ns) return strangers_;
  *oldest = {address, now_ns, most_, true};
  return *oldest;
}

bool RateLimiter::Admit(const sockaddr_storage& from, std::int64_t now_ns) noexcept {
  if (per_ns_ <= 0) return true;
  Bucket& bucket = Find(MachineOf(from), now_ns);
  const auto passed_ns = static_cast<double>(now_ns - bucket.last_ns);
  bucket.tokens = std::min(most_, bucket.tokens + std::max(0.0, passed_ns) * per_ns_);
  bucket.last_ns = now_ns;
  if (bucket.tokens < 1) return false;
  bucket.tokens -= 1;
  return true;
}

}  // namespace styled::source

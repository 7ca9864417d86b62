#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

#include "model/base/status.h"

// Seeded faults between a rig and the daemon. A frame suffers at most one of them, and bodies none,
// so that a test can compare a receiver's counters with these counts exactly. One thread.
// Pinned by tests/unit/sim/faults_test.cpp.
namespace styled::faults {

enum class Fault : std::uint8_t {
  kNone,
  kLoss,       // not sent
  kDuplicate,  // sent twice
  kReorder,    // sent behind the next frame, which is then left alone
  kCorrupt,    // one bit flipped behind the header's length field: a wrong checksum
  kTruncate,   // cut somewhere behind the header (UDP only: it would tear a TCP stream)
  kNan,        // one joint's rotation is NaN, infinite or zero
  kOversized,  // nearly 64 KiB, valid, with thousands of joints
  kRestart,  // the sender dies: silence of Spec::restart_pause_ms, then a new session from frame 0
  kLate,     // sent Spec::late_ms after its time, behind newer frames
  kCount
};

// "loss", "duplicate", ...: the words of Parse().
std::string_view Name(Fault fault) noexcept;

struct Spec {
  std::array<double, static_cast<std::size_t>(Fault::kCount)> probability{};  // per frame; sum <= 1
  std::uint64_t seed = 1;
  double late_ms = 100;           // 0 .. 60000
  double restart_pause_ms = 150;  // 0 .. 60000; a receiver takes over a sender silent for 100 ms

  bool any() const noexcept;
};

// "loss=0.1,duplicate=0.01,seed=7,late-ms=50"; "" is no fault. Errors name the word and what was
// expected.
Result<Spec> Parse(std::string_view text);

using Counts = std::array<std::uint64_t, static_cast<std::size_t>(Fault::kCount)>;

// What happens to the frames of one performer, in their order.
class Faults {
 public:
  // `stream` tells apart the performers that share a spec.
  explicit Faults(const Spec& spec, std::uint64_t stream = 0);

  // The next frame's fault, already counted. The frame behind a reordered one has none.
  Fault Draw() noexcept;

  // Damages a whole datagram as Draw() said; kTruncate returns the smaller size, all others
  // `size`. `datagram` is at least one byte longer than a header.
  std::size_t Damage(Fault fault, std::byte* datagram, std::size_t size) noexcept;

  // A number in [0, below) from the same seed, for the choice of a joint or a value. below > 0.
  std::uint32_t Choose(std::uint32_t below) noexcept;

  const Spec& spec() const noexcept { return spec_; }
  const Counts& counts() const noexcept { return counts_; }

 private:
  double Uniform() noexcept;

  Spec spec_;
  std::mt19937_64 random_;
  Counts counts_{};
  bool spare_next_ = false;
};

}  // namespace styled::faults

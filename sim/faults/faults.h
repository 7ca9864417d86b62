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
  kBurst,    // held back with those behind it, Spec::burst_frames in all, which leave at once; they
             // are left alone
  kStep,     // the rig's clock jumps by Spec::step_s before the frame
  kOcclude,  // one joint, not the root, is unseen (NaN) in Spec::occlude_frames frames from this
             // one
  kCount
};

// "loss", "duplicate", ...: the words of Parse().
std::string_view Name(Fault fault) noexcept;

struct Spec {
  std::array<double, static_cast<std::size_t>(Fault::kCount)> probability{};  // per frame; sum <= 1
  std::uint64_t seed = 1;
  double late_ms = 100;           // 0 .. 60000
  double restart_pause_ms = 150;  // 0 .. 60000; a receiver takes over a sender silent for 100 ms
  double burst_frames = 5;        // 2 .. 1000, whole
  double step_s = 1;              // -86400 .. 86400
  double occlude_frames = 30;     // 1 .. 100000, whole

  // Not per frame and not counted:
  double jitter_ms = 0;  // 0 .. 1000; each frame leaves so much late at most, behind older ones
  double drift_ppm = 0;  // -100000 .. 100000; how much too fast the rig's clock runs

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

  // The next frame's fault, already counted. The frame behind a reordered one has none, nor have
  // those of a burst behind its first.
  Fault Draw() noexcept;

  // How long after its time the next frame leaves, uniform in [0, Spec::jitter_ms]. Drawn apart:
  // Draw() gives the same with it and without.
  double DrawJitter_s() noexcept;

  // How far the rig's clock is ahead at `true_s` of a session, by its drift and its steps so far.
  // `fault` is that of the frame. Not below -true_s: a step back ends at 0, where clocks begin.
  double ClockError_s(double true_s, Fault fault) noexcept;
  // A new session's clock begins anew.
  void ResetClock() noexcept { stepped_s_ = 0; }

  // Damages a whole datagram as Draw() said; kTruncate returns the smaller size, all others
  // `size`. `datagram` is at least one byte longer than a header.
  std::size_t Damage(Fault fault, std::byte* datagram, std::size_t size) noexcept;

  // A number in [0, below) from the same seed, for the choice of a joint or a value. below > 0.
  std::uint32_t Choose(std::uint32_t below) noexcept;

  const Spec& spec() const noexcept { return spec_; }
  const Counts& counts() const noexcept { return counts_; }

 private:
  Spec spec_;
  std::mt19937_64 random_, jitter_random_;
  Counts counts_{};
  std::uint32_t spare_ = 0;  // frames to be left alone
  double stepped_s_ = 0;
};

}  // namespace styled::faults

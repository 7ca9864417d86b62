#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string_view>

#include "model/base/status.h"

// Injects seeded faults between a rig and the daemon. A frame has at most one fault and a body has
// none, so that a test can compare a receiver's counters with these counts exactly. One thread.
// Pinned by tests/unit/sim/faults_test.cpp.
namespace styled::faults {

enum class Fault : std::uint8_t {
  kNone,
  kLoss,       // not sent
  kDuplicate,  // sent twice
  kReorder,    // sent after the next frame, which has no fault of its own
  kCorrupt,    // one bit flipped behind the header's length field, so that the checksum is wrong
  // Cut at a random place behind the header (UDP only: it would desynchronize a TCP stream)
  kTruncate,
  kNan,        // one joint's rotation is NaN, infinite or zero
  kOversized,  // valid, nearly 64 KiB, with thousands of joints
  kRestart,    // the sender stops for Spec::restart_pause_ms, then starts a new session at frame 0
  kLate,       // sent Spec::late_ms late, after newer frames
  // Held back with the frames after it, Spec::burst_frames in total, and sent at once; the others
  // of the burst have no fault of their own.
  kBurst,
  kStep,  // the rig's clock jumps by Spec::step_s before this frame
  // A joint, not the root, is not tracked (NaN) for Spec::occlude_frames frames from here.
  kOcclude,
  kCount
};

// "loss", "duplicate", ...: the names that Parse() accepts.
std::string_view Name(Fault fault) noexcept;

struct Spec {
  std::array<double, static_cast<std::size_t>(Fault::kCount)> probability{};  // per frame; sum <= 1
  std::uint64_t seed = 1;
  double late_ms = 100;  // 0 .. 60000
  // 0 .. 60000; a receiver accepts a new session after 100 ms of silence.
  double restart_pause_ms = 150;
  double burst_frames = 5;     // 2 .. 1000, integer
  double step_s = 1;           // -86400 .. 86400
  double occlude_frames = 30;  // 1 .. 100000, integer

  // Applied to all frames, not counted:
  double jitter_ms = 0;  // 0 .. 1000; maximum random delay per frame; the order stays
  double drift_ppm = 0;  // -100000 .. 100000; positive: the rig's clock runs fast

  bool any() const noexcept;
};

// Parses "loss=0.1,duplicate=0.01,seed=7,late-ms=50"; "" means no faults. Errors name the word and
// what was expected.
Result<Spec> Parse(std::string_view text);

using Counts = std::array<std::uint64_t, static_cast<std::size_t>(Fault::kCount)>;

// Chooses the faults for the frames of one performer, in order.
class Faults {
 public:
  // `stream` makes the random sequences of performers with the same spec different.
  explicit Faults(const Spec& spec, std::uint64_t stream = 0);

  // Draws and counts the next frame's fault. kNone for the frame after a reordered one, and for the
  // frames of a burst after its first.
  Fault Draw() noexcept;

  // The delay of the next frame in seconds, uniform in [0, Spec::jitter_ms]. It has a random
  // generator of its own, so that Draw() returns the same faults with and without jitter.
  double DrawJitter_s() noexcept;

  // The error of the rig's clock at `true_s` of a session, from its drift and its steps so far.
  // `fault` is the fault of this frame. Never below -true_s: a step back ends at time 0.
  double ClockError_s(double true_s, Fault fault) noexcept;
  // A new session starts with a clock without steps.
  void ResetClock() noexcept { stepped_s_ = 0; }

  // Damages a whole datagram according to `fault`. kTruncate returns the smaller size, all others
  // `size`. `datagram` must be at least one byte longer than a header.
  std::size_t Damage(Fault fault, std::byte* datagram, std::size_t size) noexcept;

  // A number in [0, below) from the same seed, to choose a joint or a value. below > 0.
  std::uint32_t Choose(std::uint32_t below) noexcept;

  const Spec& spec() const noexcept { return spec_; }
  const Counts& counts() const noexcept { return counts_; }

 private:
  Spec spec_;
  std::mt19937_64 random_, jitter_random_;
  Counts counts_{};
  std::uint32_t spare_ = 0;  // frames that must have no fault
  double stepped_s_ = 0;
};

}  // namespace styled::faults

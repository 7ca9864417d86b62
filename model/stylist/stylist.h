#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "model/base/realtime.h"
#include "model/net/stylizer.h"
#include "model/rig/binding.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

enum Flag : std::uint32_t {  // the bits of styled.v1.Flag that the stylist decides
  kConcealed = 1,
  kOutOfDomain = 8,
  kHeld = 16,
  kBypass = 32,
  kNewSession = 64,
  kFading = 128,
  kFailed = 256,  // with kBypass: the styled pose was no pose, see Process
};

// What one frame costs at most, whatever the source's clock does: steps of the network. 60 bridge a
// gap of 0.25 s at 240 Hz.
inline constexpr int kMaxStepsPerFrame = 64;
// And n frames in a row: kMaxStepsPerFrame + n times this. A steady stream needs 7.5 at 4 Hz, the
// slowest rate that is bridged at all (with a network of 30 Hz), and 1 from 30 Hz on.
inline constexpr int kMeanStepsPerFrame = 8;

// One styled frame. Sized at construction for the binding's skeleton; owned by the caller.
struct Output {
  body::Pose canonical;
  body::Pose canonical_input;  // the bound input, before styling
  rig::RigPose rig;            // the same on the source skeleton; in bypass the input, bit for bit
  rig::RigPose source;         // the input on the source skeleton, bad joints held
  std::bitset<256> held;       // source joints whose input was bad and is held
  std::uint32_t flags = 0;
  std::uint32_t contacts = 0;  // bit 0 left, bit 1 right: the performer's own foot is planted
  std::array<net::StyleWeight, net::kMaxActive> in_force;  // styles and weights of this frame
  int in_force_count = 0;
  int steps = 0;                 // of the network that this frame took, at most kMaxStepsPerFrame
  float reconstruction_rad = 0;  // rms joint angle between reconstruction and input, toes apart

  explicit Output(const rig::Skeleton& skeleton) : rig(skeleton), source(skeleton) {}
};

// One performer, frame after frame: bind, features, network, apply, unbind, feet. The daemon,
// `stylize` and `styleeval` run this very code. Source time drives everything, so a replay is
// deterministic. Construction allocates; Process and Set do not, do not lock, log or throw.
// One thread at a time. Mathematics: style-ERD section "live" in model/stylist/README.md.
class Stylist {
 public:
  Stylist(std::shared_ptr<const net::Stylizer> network, std::shared_ptr<const rig::Binding> binding,
          const Options& options);
  ~Stylist();
  Stylist(Stylist&&) noexcept;
  Stylist& operator=(Stylist&&) noexcept;

  // From the next frame on; `settings` must pass Validate. Fades from the weights now in force.
  STYLED_REALTIME void Set(const Settings& settings) noexcept;
  const Settings& settings() const;

  // Clears recurrent state, holds and filters; keeps the settings. The style in force is not faded.
  STYLED_REALTIME void Reset() noexcept;

  // Styles one frame. `time_ns` is source time and must be greater than the last frame's (the
  // caller drops the others). `in` has the skeleton's joint count; non-finite or zero-length values
  // are held per joint. Writes all of `out`, finite and with unit rotations whatever the weights
  // and the input are: where the styled pose would not be (model/stylist/guard.h), the frame is the
  // performer's own, kFailed, and the styling starts anew.
  STYLED_REALTIME void Process(std::int64_t time_ns, const rig::RigPose& in, Output& out) noexcept;

  // The same for several performers whose frames are here together, bit for bit, in less time:
  // those who share a network share the reading of its weights. No stylist or output twice.
  struct Job {
    Stylist* stylist = nullptr;
    std::int64_t time_ns = 0;
    const rig::RigPose* in = nullptr;
    Output* out = nullptr;
  };
  static constexpr std::size_t kTogether = 8;  // more are taken so many at a time
  STYLED_REALTIME static void ProcessTogether(std::span<const Job> jobs) noexcept;

 private:
  template <std::size_t Most>
  static void ProcessSome(std::span<const Job> jobs) noexcept;
  friend class Rehearsal;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Brings what a stylist's next Process runs and reads into the caches: between two frames of 120 Hz
// everything else on the machine pushes it out. It is a second stylist of the same network and
// skeleton, with streams of its own, that takes the first one's last pose once more; what the first
// one makes of its frames does not change by it. For who runs live: offline nothing is gained.
// Construction allocates. One thread at a time, the stylist's.
class Rehearsal {
 public:
  // As the stylist was made.
  Rehearsal(std::shared_ptr<const net::Stylizer> network,
            std::shared_ptr<const rig::Binding> binding, const Options& options);
  ~Rehearsal();
  Rehearsal(Rehearsal&&) noexcept;
  Rehearsal& operator=(Rehearsal&&) noexcept;

  // Costs a frame.
  STYLED_REALTIME void Prewarm(const Stylist& stylist) noexcept;

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace styled::stylist

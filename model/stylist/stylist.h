#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <memory>
#include <span>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/feet/travel.h"
#include "model/net/stylizer.h"
#include "model/neutral/neutral.h"
#include "model/rig/binding.h"
#include "model/stylist/limb_gate.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

enum Flag : std::uint32_t {  // the bits of styled.v1.Flag that the stylist decides
  kConcealed = 1,
  kOutOfDomain = 8,
  kHeld = 16,
  kBypass = 32,
  kNewSession = 64,
  kFading = 128,
  kFailed = 256,  // with kBypass: the styled pose was not sound, see Process
};

// Why a frame is kFailed: which pose was not sound. The numbers are those of styled.v1.Failure.
enum class Failure : std::uint8_t {
  kNone,
  kPrediction,  // the network's prediction, in this frame or in the last one that had a step
  kCanonical,   // the styled pose on the canonical body
  kRig,         // the styled pose on the rig's skeleton
};

// Limit of network steps in one frame, whatever the source's clock does. 60 bridge a gap of 0.25 s
// at 240 Hz.
inline constexpr int kMaxStepsPerFrame = 64;
// n frames in a row take at most kMaxStepsPerFrame + n * kMeanStepsPerFrame steps. A steady stream
// needs 7.5 per frame at 4 Hz, the slowest rate that is bridged (with a network of 30 Hz), and 1
// from 30 Hz on.
inline constexpr int kMeanStepsPerFrame = 8;

// One styled frame. Sized at construction for the binding's skeleton; owned by the caller.
struct Output {
  body::Pose canonical;
  body::Pose canonical_input;  // the bound input, before the style
  // The styled pose on the source skeleton; in bypass the input, bit for bit, except for the hips'
  // place after a Root::kStride.
  rig::RigPose rig;
  rig::RigPose source;    // the input on the source skeleton, with bad joints held
  std::bitset<256> held;  // source joints whose input was bad
  std::uint32_t flags = 0;
  Failure failure = Failure::kNone;  // with kFailed
  // Steps that the style takes in the time of one of the performer's, smoothed: the caller must let
  // time pass faster by this factor. 1 without Options::own_cadence, and while the performer
  // stands.
  float cadence = 1;
  feet::Travel travel;  // offset of the styled hips from the performer's, and the difference of
                        // their steps
  std::uint32_t contacts = 0;  // bit 0 left, bit 1 right: the performer's own foot is planted
  std::array<net::StyleWeight, net::kMaxActive> in_force;  // styles and weights in this frame
  int in_force_count = 0;
  int steps = 0;                 // network steps of this frame, at most kMaxStepsPerFrame
  float reconstruction_rad = 0;  // rms joint angle between reconstruction and input, without toes
  // The angle by which the style turns a joint of the canonical body relative to its parent, mean
  // of all joints, rad; before planted feet are held. 0 in bypass.
  float turned_rad = 0;
  // Per limb: the reconstruction's distance from the input, m, and the resulting share of the style
  // that the limb shows, 0 .. 1 (limb_gate.h).
  PerLimb limb_errors_m{}, limb_weights{1, 1, 1, 1, 1};

  explicit Output(const rig::Skeleton& skeleton) : rig(skeleton), source(skeleton) {}
};

// Styles one performer's stream, frame by frame: bind, features, network, apply, unbind, feet. The
// daemon, `stylize` and `styleeval` all run this code. Source time drives everything, so a replay
// is deterministic. Construction allocates; Process and Set do not allocate, lock, log or throw.
// One thread at a time. Mathematics: model/README.md.
class Stylist {
 public:
  Stylist(std::shared_ptr<const net::Stylizer> network, std::shared_ptr<const rig::Binding> binding,
          const Options& options);
  ~Stylist();
  Stylist(Stylist&&) noexcept;
  Stylist& operator=(Stylist&&) noexcept;

  // Takes effect from the next frame on, fading from the weights now in effect. `settings` must
  // pass Validate.
  STYLED_REALTIME void Set(const Settings& settings) noexcept;
  const Settings& settings() const;
  // Whether the style is in effect, is faded in or out, or is the performer's own.
  bool Names(int style) const noexcept;
  // The performer's neutral: its learned state, to be stored; and the state with which this stylist
  // starts, from an earlier one or a whole clip. Empty for a network without a reference, and
  // without Options::neutral.
  bool has_neutral() const;
  const neutral::Neutral& neutral() const;
  STYLED_REALTIME neutral::Known Tell() const noexcept;
  STYLED_REALTIME void Know(const neutral::Known& known) noexcept;
  // As in neutral::Neutral.
  STYLED_REALTIME void CalibrateNeutral(float seconds) noexcept;
  STYLED_REALTIME void ForgetNeutral() noexcept;
  // While resting, the stylist runs no step of the network once nothing is styled any more; set
  // settings without a style, too. Otherwise the network follows the performer in bypass, so that a
  // style sets in smoothly; after a rest it restarts. Not part of Carry.
  STYLED_REALTIME void Rest(bool rests) noexcept;
  // Whether subsequent frames are the performer's own motion, initially true. The neutral is not
  // learned from other ones, such as those of a body that moves by itself while its rig is silent.
  // Not part of Carry.
  STYLED_REALTIME void SetMeasured(bool measured) noexcept;

  // Continues with a network that shares streams with this one (net::Stylizer::SharesStreams): its
  // list of styles may differ, and the motion continues. Set may then name its styles.
  void Adopt(std::shared_ptr<const net::Stylizer> network) noexcept;

  // Clears recurrent state, held values, filters and the offset of Root::kStride; keeps the
  // settings, the style weights in effect and the performer's neutral.
  STYLED_REALTIME void Reset() noexcept;

  // The following frames are those of the same performer with left and right exchanged: a Reset in
  // which everything that is kept is exchanged, too, the change of style that was applied last
  // included. So the first frame shows the style as its mirror image, and from there it fades to
  // what the network finds. The settings stay.
  STYLED_REALTIME void Mirror() noexcept;

  // Carries the whole state, settings included (model/base/checkpoint.h), to a stylist of the same
  // network, skeleton and options. Refuses streams of another family, size or list of styles; the
  // caller must detect other weights of the same shape. After a refused reading the stylist must be
  // constructed again.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;

  // Styles one frame. `time_ns` is source time and must be greater than the last frame's (the
  // caller drops other frames). `in` has the skeleton's joint count; a joint with non-finite values
  // or a rotation of length 0 is held. Writes all of `out`, finite and with unit rotations whatever
  // the weights and the input are: if the styled pose would not be sound (model/stylist/guard.h),
  // the frame is the performer's own with kFailed, and the styling restarts.
  STYLED_REALTIME void Process(std::int64_t time_ns, const rig::RigPose& in, Output& out) noexcept;

  // The same for several performers whose frames arrived together, with the same results bit for
  // bit, in less time: performers that share a network share the reading of its weights. No stylist
  // and no output may appear twice.
  struct Job {
    Stylist* stylist = nullptr;
    std::int64_t time_ns = 0;
    const rig::RigPose* in = nullptr;
    Output* out = nullptr;
  };
  static constexpr std::size_t kTogether = net::kTogether;  // jobs processed at a time
  STYLED_REALTIME static void ProcessTogether(std::span<const Job> jobs) noexcept;

 private:
  template <std::size_t Most>
  static void ProcessSome(std::span<const Job> jobs) noexcept;
  friend class Rehearsal;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Brings the code and data of a stylist's next Process into the caches, because between two frames
// of 120 Hz everything else on the machine evicts them. It is a second stylist of the same network
// and skeleton, with streams of its own, that processes the first one's last pose again. The first
// one's results do not change. Only useful live. Construction allocates as much as a stylist, half
// a megabyte to two, so the stylists of a thread share one if their skeletons have as many joints.
// Must be used on the stylists' thread. Pinned by tests/unit/stylist/stylist_test.cpp.
class Rehearsal {
 public:
  // The one for this thread's stylists with this network and number of joints, made with `options`
  // if there is none yet: other options need the same code and data.
  static std::shared_ptr<Rehearsal> Shared(const std::shared_ptr<const net::Stylizer>& network,
                                           const std::shared_ptr<const rig::Binding>& binding,
                                           const Options& options);
  // The arguments of the stylist's constructor.
  Rehearsal(std::shared_ptr<const net::Stylizer> network,
            const std::shared_ptr<const rig::Binding>& binding, const Options& options);
  ~Rehearsal();
  Rehearsal(Rehearsal&&) noexcept;
  Rehearsal& operator=(Rehearsal&&) noexcept;

  // As the stylist's.
  void Adopt(std::shared_ptr<const net::Stylizer> network) noexcept;
  // Costs as much as one frame.
  STYLED_REALTIME void Prewarm(const Stylist& stylist) noexcept;

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace styled::stylist

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/net/gate_bounds.h"
#include "model/net/style_space.h"
#include "model/net/styles.h"
#include "model/neutral/neutral.h"

// The interface of every style network to the rest of the program. Input: poses of the canonical
// humanoid; output: rotations, at the network's own rate. Features, filters and recurrent state
// belong to the family. Nothing above model/net names a family. How to add one: CONTRIBUTING.md.
namespace styled::net {

// The common keys of a weights file, whatever its family (FORMAT.md).
struct Model {
  std::string family;  // "style-erd", "constant-offset"
  Styles styles;
  Contents contents;      // those that the network takes as input; empty: it takes none
  float rate_hz = 30.0F;  // the rate at which every stream is stepped; > 0
  // The performers that it was trained on, for the performer's neutral. Absent in files before
  // version 3 and in families that do not need them.
  std::optional<neutral::Reference> reference;
  GateBounds gate;
  std::string licence;
  std::string training;  // JSON text; informative
};

// One pose as a network decodes it. Rotations are local unit quaternions of either sign; the hips'
// rotation is relative to a frame rotated about +Y by Prediction::heading_rad.
struct Decoded {
  std::array<body::Quat, body::kJointCount> rotations;
  // Velocities of the joints in the same frame; 0 if a family does not decode them. They are not
  // part of the pose. They reveal a non-finite state, which a normalized rotation would hide.
  std::array<float, 3 * static_cast<std::size_t>(body::kJointCount)> velocities_m_s;
  // Height of the hips; the input's in both poses of a prediction if a family does not decode it.
  // The stylist uses the difference of the two.
  float hips_height_m;
};

// The result of one step. The style change, reconstruction⁻¹ · styled per joint, does not depend on
// the heading, so no family has to rotate its output back to the world.
struct Prediction {
  Decoded reconstruction;  // the input as the network reproduces it, without a style change
  Decoded styled;          // the input in the requested styles; none: neutral
  float heading_rad = 0;   // rad; 0: the frame is the world
};

// The recurrent state of one stream of poses and the scratch memory of its steps, opaque to all but
// its family. Made at binding; its size never changes. One thread at a time.
class Stream {
 public:
  virtual ~Stream() = default;
  // The memory that a step reads and writes, so that the caller can prefetch it.
  virtual std::span<const std::byte> memory() const noexcept = 0;

 protected:
  Stream() = default;
  Stream(const Stream&) = default;
  Stream& operator=(const Stream&) = default;
};

// A variation of the styles in effect, 1 .. kVariations, and its weight.
struct VariationWeight {
  std::uint16_t variation = 0;
  float weight = 0;
};

// How many streams a network steps together, and so how many performers' frames the stylist
// processes at a time. The weights of a wide network are larger than the second-level cache and are
// read once for all of them: of 16 a step takes 0.9 of the time of 8 each, of 32 0.86. Intermediate
// results (8 kB each) fit into that cache beside a layer's weights.
inline constexpr std::size_t kTogether = 16;

// The performer of a stream, for families that follow their gait. Owns nothing.
struct Performer {
  const body::Pose* own = nullptr;            // the pose as bound, with the performer's carriage
  const neutral::Neutral* neutral = nullptr;  // followed up to `own`
  const neutral::Reference* reference = nullptr;  // of `neutral`; it has gaits
  // The time from `own` to the frame that shows the step's result: the delay of the stylist's
  // filters. A gait's phase can be predicted over it.
  float delay_s = 0;
  double time_s = 0;  // of `own`; source time, from any moment on
};

// One stream's step. Owns nothing; `stream` must come from the same Stylizer.
struct StepJob {
  const body::Pose* pose = nullptr;     // canonical, finite, unit rotations
  int input_style = 0;                  // the style that the performer moves in; 0: neutral
  std::span<const StyleWeight> styles;  // the requested styles; see Stylizer::Step
  Stream* stream = nullptr;
  Prediction* out = nullptr;
  // The requested styles are shown in these variations; empty: the styles themselves.
  std::span<const VariationWeight> variations = {};
  const Performer* performer = nullptr;  // null: not known
  // The content of the motion: a number of Model::contents, kContentRecognized or kContentUnknown.
  // Networks without contents ignore it.
  int content = kContentRecognized;
};

// A network with its weights. Immutable; shared by all performers and threads.
class Stylizer {
 public:
  virtual ~Stylizer() = default;
  Stylizer(const Stylizer&) = delete;
  Stylizer& operator=(const Stylizer&) = delete;

  virtual const Model& model() const noexcept = 0;

  // The space of styles of a network that has one; null: it has only the styles of its list.
  virtual const StyleSpace* space() const noexcept { return nullptr; }
  // A copy of the network with the style `code` of space() as the style `number`: a new one, or a
  // replacement of one that With has added. Null without a space. Allocates.
  virtual std::shared_ptr<const Stylizer> With(int number, const StyleInfo& style,
                                               const StyleCode& code) const;
  // A copy of the network in which the style `number`, added by With, can no longer be selected.
  // Null without a space. Allocates.
  virtual std::shared_ptr<const Stylizer> Retired(int number) const;
  // Whether a stream of `other` is valid for this network, too: they differ only in styles of With.
  virtual bool SharesStreams(const Stylizer& other) const noexcept { return this == &other; }

  // Makes a stream in its initial state. Allocates.
  virtual std::unique_ptr<Stream> MakeStream() const = 0;

  // Returns a stream to its initial state. Noexcept, no allocation, no lock.
  STYLED_REALTIME virtual void Start(Stream& stream) const noexcept = 0;

  // Passes the state that a stream's next steps depend on (model/base/checkpoint.h), between a
  // stream of this network and one of the same weights. Families that cannot do it refuse.
  // Noexcept, no allocation.
  STYLED_REALTIME virtual void Carry(Stream& stream, Checkpoint& c) const noexcept;

  // Advances each job's stream by one period of model().rate_hz and writes its prediction; one call
  // for all performers that share the network. A stream's result does not depend on the other jobs,
  // bit for bit. No stream and no output may appear twice. `styles` may contain style 0 and weight
  // 0; the weights of a style given twice are added. Weights are clamped to [0, kMaxStrength]; NaN
  // counts as 0. Ignored: styles that the network lacks, and styles after the first kMaxActive. No
  // input leaves a non-finite state behind. Noexcept, no allocation, no lock. If the network has
  // variations (StyleInfo::varies), each style s is shown as s + Σ weight (variation of s - s).
  // Their weights are clamped like those of styles, and scaled down if they sum to more than
  // kMaxStrength; numbers outside 1 .. kVariations and those after the first kVariations are
  // ignored. Other networks ignore all of them.
  STYLED_REALTIME virtual void Step(std::span<const StepJob> jobs) const noexcept = 0;

 protected:
  Stylizer() = default;
};

inline std::shared_ptr<const Stylizer> Stylizer::With(int /*number*/, const StyleInfo& /*style*/,
                                                      const StyleCode& /*code*/) const {
  return nullptr;
}
inline std::shared_ptr<const Stylizer> Stylizer::Retired(int /*number*/) const { return nullptr; }
inline void Stylizer::Carry(Stream& /*stream*/, Checkpoint& c) const noexcept { c.Refuse(); }

}  // namespace styled::net

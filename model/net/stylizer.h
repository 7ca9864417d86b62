#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/net/styles.h"

// What every network that styles is to the rest of the program: poses of the canonical humanoid go
// in, rotations come out, at the network's own rate. Features, filters and recurrent state are the
// family's own. Nothing above model/net names a family. How to add one: CONTRIBUTING.md.
namespace styled::net {

// What a weights file says, whatever its family (FORMAT.md).
struct Model {
  std::string family;  // "style-erd", "constant-offset"
  Styles styles;
  float rate_hz = 30.0F;  // at which every stream is stepped; > 0
  std::string licence;
  std::string training;  // JSON text; informative
};

// One pose as a network decodes it. Rotations are local, of length 1, of either sign; the hips' are
// relative to a frame that is turned about +Y by Prediction::heading_rad.
struct Decoded {
  std::array<body::Quat, body::kJointCount> rotations;
  // What else it decodes, in the same frame, 0 where a family decodes no such thing. It is not part
  // of the pose, but shows when a state is not finite: a rotation does not, once it is normalized.
  std::array<float, 3 * static_cast<std::size_t>(body::kJointCount)> velocities_m_s;
  float hips_height_m;
};

// What one step gives. The change of style, reconstruction⁻¹ · styled per joint, does not depend on
// the heading: no family need turn its output back to the world.
struct Prediction {
  Decoded reconstruction;  // what the network makes of the input without a change of style
  Decoded styled;          // in the styles asked for; none: neutral
  float heading_rad = 0;   // 0: the frame is the world
};

// The memory of one stream of poses: opaque to all but its family. Made at binding, of a size that
// never changes; one thread at a time.
class Stream {
 public:
  virtual ~Stream() = default;
  // What a step reads and writes of it, so that it can be brought into the caches beforehand.
  virtual std::span<const std::byte> memory() const noexcept = 0;

 protected:
  Stream() = default;
  Stream(const Stream&) = default;
  Stream& operator=(const Stream&) = default;
};

// One stream's step. Nothing here is owned; `stream` is of the same Stylizer.
struct StepJob {
  const body::Pose* pose = nullptr;     // canonical, finite, rotations of length 1
  int input_style = 0;                  // the style that the performer moves in; 0 = neutral
  std::span<const StyleWeight> styles;  // to be in force; see Stylizer::Step
  Stream* stream = nullptr;
  Prediction* out = nullptr;
};

// A network with its weights. Immutable: shared by all performers and threads.
class Stylizer {
 public:
  virtual ~Stylizer() = default;
  Stylizer(const Stylizer&) = delete;
  Stylizer& operator=(const Stylizer&) = delete;

  virtual const Model& model() const noexcept = 0;

  // A stream in its initial state. Allocates.
  virtual std::unique_ptr<Stream> MakeStream() const = 0;

  // Puts a stream back into its initial state. Noexcept, no allocation, no lock.
  STYLED_REALTIME virtual void Start(Stream& stream) const noexcept = 0;

  // Advances each job's stream by one period of model().rate_hz and writes its prediction: one call
  // for all performers who share the network. A stream's result does not depend on the others, bit
  // for bit. No stream and no output appears twice. Style 0 in `styles` and weight 0 are allowed, a
  // style named twice has the sum; weights are clamped to [0, kMaxStrength], not a number counts as
  // 0. Ignored: styles that the network lacks, and those after the first kMaxActive. Whatever the
  // input is, no state that is not finite stays behind. Noexcept, no allocation, no lock.
  STYLED_REALTIME virtual void Step(std::span<const StepJob> jobs) const noexcept = 0;

 protected:
  Stylizer() = default;
};

}  // namespace styled::net

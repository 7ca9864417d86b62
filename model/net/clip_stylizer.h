#pragma once

#include <memory>

#include "model/body/pose.h"
#include "model/net/style_space.h"
#include "model/net/stylizer.h"

// The interface of networks that need the frames after the one that they style, ideally whole
// clips, and that know a space of styles instead of a list. They are not for live streams. It is a
// separate interface because a Stylizer's Step returns its result at once. Its output is the same
// Prediction as Stylizer's: stylist/clip_stylist.h plays predictions to the stylist frame by frame,
// so that every later stage is the same code. Start-up and offline code: everything here allocates.
// Each object: any thread for const functions; a ClipStream one thread at a time.
namespace styled::net {

// The frames over which the network normalizes.
enum class Extent {
  kByLength,  // the whole clip up to 20 s, else overlapping windows
  kWhole,     // the whole clip; memory grows with it
  kWindows,   // overlapping windows, blended: memory is bounded
};

// One stream of poses to be styled. Predictions come out in the order of the poses, later than
// they went in, exactly one for each.
class ClipStream {
 public:
  virtual ~ClipStream() = default;
  ClipStream(const ClipStream&) = delete;
  ClipStream& operator=(const ClipStream&) = delete;

  // The next pose, 1 / Model::rate_hz after the last: canonical, finite, unit rotations.
  virtual void Add(const body::Pose& pose) = 0;
  // Call after the last pose: Pop then returns the remaining predictions.
  virtual void End() = 0;
  // Writes the next prediction; false if it needs more poses, or all are taken. If the weights
  // compute something that is not finite, so are its rotations.
  virtual bool Pop(Prediction& out) = 0;

 protected:
  ClipStream() = default;
};

// A network with its weights. Immutable; shared.
class ClipStylizer : public StyleSpace {
 public:
  virtual const Model& model() const noexcept = 0;

  // A stream whose predictions' `styled` is in the style of `code` and whose `reconstruction` is in
  // the performer's own style, `input_style` (0: neutral). A stream of fewer poses than
  // least_frames() is extended with its last pose.
  virtual std::unique_ptr<ClipStream> MakeStream(const StyleCode& code, int input_style,
                                                 Extent extent) const = 0;
};

}  // namespace styled::net

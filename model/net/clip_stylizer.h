#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/body/pose.h"
#include "model/net/stylizer.h"

// The interface of networks that need the frames after the one that they style, whole clips at
// best, and that know a space of styles instead of a list. They are not for live streams. It is an
// interface of its own because a Stylizer's Step answers at once. It ends at the Prediction, the
// same as Stylizer's: stylist/clip_stylist.h plays predictions to the stylist frame by frame, so
// that every later stage is the same code. Start-up and offline code: everything here allocates.
// Each object: any thread for const functions; a ClipStream one thread at a time.
namespace styled::net {

// A style as the network's decoder takes it; its meaning is the family's.
using StyleCode = std::vector<float>;

// One ingredient of a style.
struct StyleSource {
  // From Model::styles: its mean; with a seed, a variation of it; with a reference, that as an
  // example of this style. Or -1: from `reference` alone.
  int style = -1;
  std::optional<std::uint64_t> seed;
  // An example of the style, at Model::rate_hz; not empty where style is -1. More than one example
  // makes a mean: StyleRequest weights them. Not together with a seed.
  std::span<const body::Pose> reference;
  float weight = 1;
};

// What a style is made of: neutral + strength Σ weight (source - neutral).
struct StyleRequest {
  std::vector<StyleSource> sources;
  float amount = 1;    // of variation: mean + amount (varied - mean)
  float strength = 1;  // 0: neutral
};

// How far a code lies from what the network was trained on.
struct NearestStyle {
  int style = 0;       // the one with the nearest mean
  float distance = 0;  // to it, over the mean distance between styles; 0 if there is only one
};

// Over how many frames the network normalizes.
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
  // No pose follows: Take then gives the predictions that are left.
  virtual void End() = 0;
  // Writes the next prediction; false if it needs more poses, or all are taken. If the weights
  // compute something that is not finite, so are its rotations.
  virtual bool Take(Prediction& out) = 0;

 protected:
  ClipStream() = default;
};

// A network with its weights. Immutable; shared.
class ClipStylizer {
 public:
  virtual ~ClipStylizer() = default;
  ClipStylizer(const ClipStylizer&) = delete;
  ClipStylizer& operator=(const ClipStylizer&) = delete;

  virtual const Model& model() const noexcept = 0;

  // The fewest poses that make a clip. A stream of fewer is filled up with its last.
  virtual int least_frames() const noexcept = 0;

  // Styles must be within Model::styles; weights, amount and strength finite.
  virtual StyleCode MakeCode(const StyleRequest& request) const = 0;
  virtual NearestStyle Nearest(const StyleCode& code) const = 0;

  // A stream whose predictions' `styled` is in the style of `code` and whose `reconstruction` is in
  // the performer's own, as one who moves in `input_style` (0: neutral).
  virtual std::unique_ptr<ClipStream> MakeStream(const StyleCode& code, int input_style,
                                                 Extent extent) const = 0;

 protected:
  ClipStylizer() = default;
};

}  // namespace styled::net

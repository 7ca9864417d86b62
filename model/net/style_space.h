#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "model/body/pose.h"

// The space of styles of a network that knows more than a list of them. Every point of it, a code,
// is a style: from an example, random, or between others.
namespace styled::net {

// A style in the form that the network's decoder uses; only the family knows its meaning.
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

// The recipe of a style: neutral + strength Σ weight (source - neutral).
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

// Immutable; any thread. Allocates: not for the real-time thread.
class StyleSpace {
 public:
  virtual ~StyleSpace() = default;
  StyleSpace(const StyleSpace&) = delete;
  StyleSpace& operator=(const StyleSpace&) = delete;

  // The fewest poses of an example, or of a clip that is styled as a whole.
  virtual int least_frames() const noexcept = 0;

  // Whether `code` has a size that the network accepts.
  virtual bool IsCode(const StyleCode& code) const;
  // Styles must be within those of the weights file; weights, amount and strength finite.
  virtual StyleCode MakeCode(const StyleRequest& request) const = 0;
  // The neutral style plus the difference between `code` and `from`. With an example of a style,
  // and one of the same performer without it, the result is the style alone. Limited. Both codes
  // belong to this network.
  virtual StyleCode Difference(const StyleCode& code, const StyleCode& from) const;
  virtual NearestStyle Nearest(const StyleCode& code) const = 0;
  // The code, or one nearer to the known styles if this one is so far from them that the body would
  // be torn apart. MakeCode's sources are already limited.
  virtual StyleCode Limited(const StyleCode& code) const { return code; }

 protected:
  StyleSpace() = default;
};

}  // namespace styled::net

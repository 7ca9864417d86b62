#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/body/pose.h"
#include "model/net/sliders.h"

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
  // With several networks that take examples (several.h), the one that gets the style, by its
  // name or family; "": chosen by what the examples show.
  std::string network;
  float amount = 1;    // of variation: mean + amount (varied - mean)
  float strength = 1;  // 0: neutral
};

// How far a code lies from what the network was trained on.
struct NearestStyle {
  int style = 0;       // the one with the nearest mean
  float distance = 0;  // to it, over the mean distance between styles; 0 if there is only one
};

// Findings in an example, and its weaknesses: lines of text, most important first.
struct Findings {
  std::vector<std::string> found, weak;
};

// kAlone: this network gets the style although the example shows little, because no other
// network could make more of it.
enum class Suitable { kNo, kYes, kAlone };

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
  // The mean of two codes of which `b` has the share `share`, 0 .. 1. Parts of motion that only one
  // of them has, one gait for instance, are its own. Empty: the two have no mean.
  virtual StyleCode Mean(const StyleCode& a, const StyleCode& b, float share) const;
  // A style by hand. The sliders, designs to begin with, and the style of a code with other values
  // of its sliders: those that are not named keep theirs. A code of {} is a performer who is
  // neutral. Errors name the slider and what was expected.
  virtual std::span<const Slider> sliders() const { return {}; }
  virtual std::span<const Preset> presets() const { return {}; }
  virtual Result<StyleCode> Design(const StyleCode& code, const SliderValues& values) const;
  // The values of a code's sliders that are not the usual ones.
  virtual SliderValues SlidersOf(const StyleCode& /*code*/) const { return {}; }
  // The part of a code that does not depend on the weights, only on the family; empty: none of it.
  virtual StyleCode Portable(const StyleCode& /*code*/) const { return {}; }
  virtual NearestStyle Nearest(const StyleCode& code) const = 0;
  // The findings in the example that the code was made from, in the words of a user.
  virtual Findings Describe(const StyleCode& code) const;
  // Whether the example of a code showed what this network makes styles from.
  virtual Suitable Suits(const StyleCode& /*code*/) const { return Suitable::kYes; }
  // The code, or one nearer to the known styles if this one is so far from them that the body would
  // be torn apart. MakeCode's sources are already limited.
  virtual StyleCode Limited(const StyleCode& code) const { return code; }

 protected:
  StyleSpace() = default;
};

}  // namespace styled::net

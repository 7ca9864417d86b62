#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "model/net/style_space.h"
#include "model/train/judge/data.h"
#include "model/train/judge/stream.h"

namespace styled::judge {

// The target of a clip: a style of the manifest, from clips of it (`references`, poses at
// kJudgeRate_hz), or at random (`noise`, a seed), or, with neither, as the family defines the
// style's mean. Not both.
struct Target {
  int style = 0;
  std::vector<std::span<const body::Pose>> references = {};
  bool labelled = true;  // whether the network gets the style's label
  // A neutral clip of the references' performer, if there is one: then only the difference to it is
  // used.
  std::span<const body::Pose> neutral = {};
  std::optional<std::uint64_t> noise = {};
};

// A target's request to a network's space of styles. `style_of`: manifest style to network style.
net::StyleRequest RequestOf(const Target& target, std::span<const int> style_of);

// A network that restyles whole clips, which a frame-by-frame stylist cannot run, or that accepts
// styles outside its list. The judges use only this interface.
class Restyler {
 public:
  virtual ~Restyler() = default;
  // Whether it can make this style of the manifest.
  virtual bool Has(int style) const = 0;
  // The rate of its input and output clips: kStreamRate_hz or kJudgeRate_hz.
  virtual double rate_hz() const = 0;
  // `clip` and the result are canonical poses at rate_hz(), frame for frame, as they would be
  // published.
  virtual Poses Restyle(std::span<const body::Pose> clip, const Target& target) const = 0;
};

// Every input in every style of `restyler` but neutral, each with `target(input, style)`. Outputs
// are converted to kStreamRate_hz; spans in the result point into `data`.
std::vector<Transferred> Restyle(const Data& data, const Restyler& restyler,
                                 const std::function<Target(int input, int style)>& target);

// Targets for Restyle: each style's mean; a noise of its own for each input and style; a clip of
// the style as the example, drawn from those of `data.validation` that have 64 frames or more, or
// from all if none has. Deterministic. The result refers to `data`.
enum class CodeFrom { kMean, kNoise, kReference };
std::function<Target(int input, int style)> TargetsOf(const Data& data, CodeFrom from,
                                                      std::uint64_t seed = 1);
// The same, but the network does not get the label of the references' style.
std::function<Target(int input, int style)> Unlabelled(
    std::function<Target(int input, int style)> targets);
// The same with the longest neutral clip of `data.validation` of the example's content.
std::function<Target(int input, int style)> WithNeutral(
    const Data& data, std::function<Target(int input, int style)> targets);

}  // namespace styled::judge

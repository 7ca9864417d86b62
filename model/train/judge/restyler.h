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

// What a clip is to become: a style of the manifest, as clips of it show it (`references`, poses at
// kJudgeRate_hz), or as chance gives it (`noise`, a seed), or, with neither, as the family defines
// the style's mean. Not both.
struct Target {
  int style = 0;
  std::vector<std::span<const body::Pose>> references = {};
  bool labelled = true;  // whether the network is told the references' style
  // A neutral clip of the references' performer, if there is one: what they differ by counts alone.
  std::span<const body::Pose> neutral = {};
  std::optional<std::uint64_t> noise = {};
};

// What a target asks of a network's space of styles. `style_of`: manifest style to network style.
net::StyleRequest RequestOf(const Target& target, std::span<const int> style_of);

// A network that restyles whole clips, which a stylist, frame by frame, cannot run, or that takes
// styles that are not of its list. The judges see it through this alone.
class Restyler {
 public:
  virtual ~Restyler() = default;
  // Whether it can make this style of the manifest.
  virtual bool Has(int style) const = 0;
  // The rate of the clips that it takes and makes: kStreamRate_hz or kJudgeRate_hz.
  virtual double rate_hz() const = 0;
  // `clip` and the result are canonical poses at rate_hz(), frame for frame, as they would be
  // published.
  virtual Poses Restyle(std::span<const body::Pose> clip, const Target& target) const = 0;
};

// Every input in every style that `restyler` has, but neutral, each as `target(input, style)` says.
// Outputs are converted to kStreamRate_hz; spans in the result point into `data`.
std::vector<Transferred> Restyle(const Data& data, const Restyler& restyler,
                                 const std::function<Target(int input, int style)>& target);

// Targets for Restyle: each style's mean; a noise of its own for each input and style; a clip of
// the style as the example, drawn from those of `data.validation` that have 64 frames or more, or
// from all where none has. Deterministic. The result refers to `data`.
enum class CodeFrom { kMean, kNoise, kReference };
std::function<Target(int input, int style)> TargetsOf(const Data& data, CodeFrom from,
                                                      std::uint64_t seed = 1);
// The same, but the network is not told the references' style.
std::function<Target(int input, int style)> Unlabelled(
    std::function<Target(int input, int style)> targets);
// The same with the longest neutral clip of `data.validation` of the example's content.
std::function<Target(int input, int style)> WithNeutral(
    const Data& data, std::function<Target(int input, int style)> targets);

}  // namespace styled::judge

#include "model/train/judge/restyler.h"

#include <utility>

#include "model/base/hash.h"
#include "model/clip/clip.h"

namespace styled::judge {
namespace {

constexpr std::size_t kReferenceFrames = 64;  // of an example, where there are enough

}  // namespace

net::StyleRequest RequestOf(const Target& target, std::span<const int> style_of) {
  net::StyleRequest request;
  const int style = style_of[static_cast<std::size_t>(target.style)];
  for (const std::span<const body::Pose> reference : target.references) {
    request.sources.push_back({.style = target.labelled ? style : -1,
                               .seed = {},
                               .reference = reference,
                               .weight = 1.0F / static_cast<float>(target.references.size())});
  }
  if (request.sources.empty()) {
    request.sources.push_back({.style = style, .seed = target.noise, .reference = {}, .weight = 1});
  }
  return request;
}

std::function<Target(int input, int style)> Unlabelled(
    std::function<Target(int input, int style)> targets) {
  return [targets = std::move(targets)](int input, int style) {
    Target target = targets(input, style);
    target.labelled = false;
    return target;
  };
}

std::function<Target(int input, int style)> WithNeutral(
    const Data& data, std::function<Target(int input, int style)> targets) {
  return [&data, targets = std::move(targets)](int input, int style) {
    Target target = targets(input, style);
    if (target.references.empty()) return target;
    int content = -1;
    for (const train::TrainingClip& clip : data.validation) {
      if (clip.poses.data() == target.references[0].data()) content = clip.content;
    }
    for (const train::TrainingClip& clip : data.validation) {
      const bool fits = clip.style == 0 && clip.content == content;
      if (fits && clip.poses.size() > target.neutral.size()) target.neutral = clip.poses;
    }
    return target;
  };
}

std::vector<Transferred> Restyle(const Data& data, const Restyler& restyler,
                                 const std::function<Target(int input, int style)>& target) {
  std::vector<Transferred> out;
  for (std::size_t i = 0; i < data.inputs.size(); ++i) {
    const int input = static_cast<int>(i);
    const bool streams = restyler.rate_hz() == kStreamRate_hz;
    const Poses clip = streams ? data.inputs[i] : Thin(data.inputs[i]);
    for (int style = 1; style < static_cast<int>(data.manifest.styles.size()); ++style) {
      if (!restyler.Has(style)) continue;
      Poses output = restyler.Restyle(clip, target(input, style));
      if (!streams) output = clip::ResamplePoses(output, kJudgeRate_hz, kStreamRate_hz);
      output.resize(data.inputs[i].size(), output.back());  // the last period may be missing
      out.push_back({input, style, data.contents[i], data.inputs[i], std::move(output)});
    }
  }
  return out;
}

std::function<Target(int input, int style)> TargetsOf(const Data& data, CodeFrom from,
                                                      std::uint64_t seed) {
  // One number for each input and style, independent of other requests.
  const auto number = [seed](int input, int style) {
    Fnv1a hash;
    for (const int value : {static_cast<int>(seed), input, style}) hash.Number(value);
    return hash.value();
  };
  if (from == CodeFrom::kMean) return [](int, int style) { return Target{.style = style}; };
  if (from == CodeFrom::kNoise) {
    return [number](int input, int style) {
      return Target{.style = style, .noise = number(input, style)};
    };
  }
  std::vector<std::vector<std::span<const body::Pose>>> examples(data.manifest.styles.size());
  for (const std::size_t least : {kReferenceFrames, std::size_t{1}}) {
    std::vector<bool> served(examples.size());
    for (std::size_t style = 0; style < examples.size(); ++style) {
      served[style] = !examples[style].empty();
    }
    for (const train::TrainingClip& clip : data.validation) {
      const auto style = static_cast<std::size_t>(clip.style);
      if (!served[style] && clip.poses.size() >= least) examples[style].push_back(clip.poses);
    }
  }
  return [number, examples](int input, int style) {
    const auto& of_style = examples[static_cast<std::size_t>(style)];
    Target target{.style = style};
    if (!of_style.empty()) {
      target.references = {of_style[number(input, style) % of_style.size()]};
    }
    return target;
  };
}

}  // namespace styled::judge

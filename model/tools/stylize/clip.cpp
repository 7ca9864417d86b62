// The arguments of stylize for networks that know a space of styles: styles from examples,
// variations and mixes of both.
#include "model/clip/clip.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "model/base/text.h"
#include "model/clip/any_clip.h"
#include "model/net/load.h"
#include "model/net/shipped_weights.h"
#include "model/tools/stylize/report.h"
#include "model/tools/stylize/stylize.h"

namespace styled::stylize {
namespace {

// Parses "CLIP=A" or "CLIP". A file that exists may have an equals sign in its name.
Result<Example> ParseExample(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || std::filesystem::exists(text)) return Example{text, {}, {}};
  const auto weight = ParseWeight(text.substr(equals + 1), "--like", text);
  if (!weight.ok()) return weight.status();
  return Example{text.substr(0, equals), weight.value(), {}};
}

// The number of poses of a clip at the network's rate.
std::size_t NetworkFrames(const clip::Clip& clip, float rate_hz) {
  const double duration_s = static_cast<double>(clip.frames.size() - 1) / clip.rate_hz;
  return static_cast<std::size_t>(duration_s * static_cast<double>(rate_hz) + 1e-6) + 1;
}

// The poses of a clip at the network's rate; `option` named it.
Result<std::vector<body::Pose>> ReadExample(const std::string& file, const char* option,
                                            const clip::BindOptions& binding,
                                            const net::Model& model, const net::StyleSpace& space) {
  const auto error = [option](const std::string& what) {
    return Status::Error(std::string(option) + ": " + what);
  };
  const auto read =
      clip::ReadAnyClip(file, {.longest_s = clip::kLongestExample_s, .work = {}}, binding.joints);
  if (!read.ok()) return error(read.status().message());
  const clip::Clip& clip = read.value().clip;
  const std::string named = std::string(option) + " " + file;
  Warn(named, clip.remark);
  const auto bound = clip::BindAnyClip(read.value(), binding);
  if (!bound.ok()) {
    return error(file + ": " + bound.status().message() + " (by hand: --like-joints)");
  }
  Warn(named, bound.value().remark);
  const Status length = CheckLength(clip, file, model, space);
  if (!length.ok()) return error(length.message());
  return clip::ResamplePoses(clip::ToCanonical(clip, bound.value().binding), clip.rate_hz,
                             static_cast<double>(model.rate_hz));
}

// "sneaky", or "stoop=28,energy=0.6".
Result<net::SliderValues> ParseDesign(const std::string& text, const net::StyleSpace& space) {
  for (const net::Preset& preset : space.presets()) {
    if (text == preset.name) return preset.values;
  }
  net::SliderValues values;
  for (const std::string& part : CLI::detail::split(text, ',')) {
    const std::size_t equals = part.find('=');
    double value = 0;
    if (equals == std::string::npos || !CLI::detail::lexical_cast(part.substr(equals + 1), value)) {
      std::string names;
      for (const net::Preset& preset : space.presets()) names.append(preset.name).append(", ");
      std::string error = "--design: \"" + part + "\": expected ";
      return Status::Error(error.append(names).append("or SLIDER=NUMBER, e.g. stoop=28"));
    }
    values.push_back({part.substr(0, equals), static_cast<float>(value)});
  }
  return values;
}

// Reports how near an example is to the training data.
void PrintDistance(const Example& example, const net::Styles& styles,
                   const net::StyleSpace& space) {
  constexpr float kFar = 1;  // the mean distance between styles
  net::StyleRequest alone;
  alone.sources.push_back({-1, {}, example.poses, 1});
  const net::StyleCode code = space.MakeCode(alone);
  const net::NearestStyle nearest = space.Nearest(code);
  const auto& style = styles[static_cast<std::size_t>(nearest.style)];
  const net::Findings findings = space.Describe(code);
  const bool far = nearest.distance > kFar && findings.found.empty();
  std::fprintf(stderr, "stylize: %s: nearest to %s, at %s of the mean distance between styles%s\n",
               example.file.c_str(), style.name.c_str(), NumberText(nearest.distance, 2).c_str(),
               far ? ": unlike all styles that these weights know" : "");
  for (const std::string& found : findings.found) {
    std::fprintf(stderr, "stylize: %s: found %s\n", example.file.c_str(), found.c_str());
  }
  for (const std::string& weak : findings.weak) {
    std::fprintf(stderr, "stylize: %s: weak: %s\n", example.file.c_str(), weak.c_str());
  }
}

// The recipe of the style, with the given weight, if any.
struct Ingredient {
  net::StyleSource source;
  std::optional<float> weight;
};

// The named styles of the arguments, each once.
Status AddNamed(const Arguments& arguments, const net::Styles& styles,
                std::vector<Ingredient>& ingredients) {
  std::vector<std::pair<const char*, std::string>> named;
  if (!arguments.style.empty()) named.emplace_back("--style", arguments.style);
  for (const std::string& one : arguments.mix) named.emplace_back("--mix", one);
  if (named.size() > net::kMaxMix) {
    return Status::Error("--mix: more than " + std::to_string(net::kMaxMix) + " styles");
  }
  if (named.empty() && arguments.vary) {
    return Status::Error(
        "--vary: expected --style or --mix, found none: a variation is of a style");
  }
  std::set<int> known;
  for (const auto& [option, text] : named) {
    const auto found = FindWeighted(styles, text, option);
    if (!found.ok()) return found.status();
    const auto [style, weight] = found.value();
    if (!known.insert(style).second) {
      return Status::Error(Explain(stylist::SettingsError::kDuplicateStyle));
    }
    ingredients.push_back({{style, arguments.vary, {}, 1}, weight});
  }
  return Status::Ok();
}

// Ingredients without a weight share the rest of 1 equally.
Status ShareRest(const Arguments& arguments, std::vector<Ingredient>& ingredients) {
  float rest = 1;
  int without = 0;
  for (const Ingredient& one : ingredients) {
    rest -= one.weight.value_or(0);
    if (!one.weight) ++without;
  }
  if (without > 0 && rest <= 0) {
    return Status::Error(WeightsText(arguments) + ": the weights given sum to " +
                         NumberText(1 - rest, 3) +
                         ", expected less than 1: the others share the rest");
  }
  const float share = rest / static_cast<float>(std::max(1, without));
  for (Ingredient& one : ingredients) one.source.weight = one.weight.value_or(share);
  return Status::Ok();
}

// The total weight of all sources.
Result<float> CheckWeights(const Arguments& arguments, std::span<const net::StyleSource> sources) {
  const float strength = arguments.strength;
  if (!(strength >= 0 && strength <= net::kMaxStrength)) {
    return Status::Error(Explain(stylist::SettingsError::kStrength));
  }
  float sum = 0;
  for (const net::StyleSource& source : sources) sum += source.weight;
  constexpr float kRounding = 1e-5F;  // of shares like 1/3
  const float most = sum * std::max(1.0F, strength);
  if (most > net::kMaxStrength + kRounding) return TooMuch(arguments, most);
  return std::min(sum * strength, net::kMaxStrength);
}

}  // namespace

Status CheckLength(const clip::Clip& clip, const std::string& file, const net::Model& model,
                   const net::StyleSpace& space) {
  const float rate_hz = model.rate_hz;
  const std::size_t frames = NetworkFrames(clip, rate_hz);
  const auto least = static_cast<std::size_t>(space.least_frames());
  if (frames >= least) return Status::Ok();
  return Status::Error(file + ": found " + std::to_string(frames) + " frames at " +
                       NumberText(rate_hz) + " Hz, expected at least " + std::to_string(least));
}

Status CheckExampleWeights(const Arguments& arguments) {
  for (const std::string& text : arguments.like) {
    const auto example = ParseExample(text);
    if (!example.ok()) return example.status();
  }
  return Status::Ok();
}

Result<std::filesystem::path> FindWeightsFor(const Arguments& arguments) {
  const bool measured = !arguments.like.empty() || !arguments.design.empty();
  const bool chosen = !arguments.weights.empty() || std::getenv("STYLED_WEIGHTS") != nullptr;
  return net::FindWeights(measured && !chosen ? "open" : arguments.weights);
}

Result<Examples> ReadExamples(const Arguments& arguments, const net::Model& model,
                              const net::StyleSpace* space) {
  Examples examples;
  if (space == nullptr) return examples;
  auto joints = rig::ParseJoints("--like-joints", arguments.like_joints);
  if (!joints.ok()) return joints.status();
  const clip::BindOptions binding{arguments.rig, {}, std::move(joints.value()), {}};
  for (const std::string& text : arguments.like) {
    auto example = ParseExample(text);
    if (!example.ok()) return example.status();
    auto poses = ReadExample(example.value().file, "--like", binding, model, *space);
    if (!poses.ok()) return poses.status();
    example.value().poses = std::move(poses.value());
    examples.styled.push_back(std::move(example.value()));
  }
  if (!arguments.like_neutral.empty()) {
    auto neutral = ReadExample(arguments.like_neutral, "--like-neutral", binding, model, *space);
    if (!neutral.ok()) return neutral.status();
    examples.neutral = std::move(neutral.value());
  }
  return examples;
}

void PrintNearest(const Examples& examples, const net::Styles& styles,
                  const net::StyleSpace& space) {
  for (const Example& example : examples.styled) PrintDistance(example, styles, space);
}

Result<stylist::ClipStyle> ParseClipStyle(const Arguments& arguments, const Examples& examples,
                                          const net::ClipStylizer& network) {
  const net::Styles& styles = network.model().styles;
  if (arguments.root != "follow") {
    return Status::Error(
        "--root stride: weights that need whole clips leave the body at the performer's place; "
        "expected weights that run live");
  }
  if (arguments.cadence) {
    return Status::Error(
        "--cadence: weights that need whole clips leave steps at the performer's pace; expected "
        "weights that run live");
  }
  stylist::ClipStyle style;
  style.absolute = arguments.absolute;
  const auto parts = FindParts(arguments);
  if (!parts.ok()) return parts.status();
  style.parts = parts.value();
  const auto input_style = FindInputStyle(arguments, styles);
  if (!input_style.ok()) return input_style.status();
  style.input_style = input_style.value();
  const auto content = FindInputContent(arguments, network.model());  // of none: refuses all
  if (!content.ok()) return content.status();
  for (const Window& window : kWindows) {
    if (arguments.window == window.word) style.extent = window.extent;
  }

  auto blend = MakeBlend(arguments, examples, network.model(), network, style.input_style);
  if (!blend.ok()) return blend.status();
  style.weight = blend.value().weight;
  style.code = std::move(blend.value().code);
  return style;
}

Result<Blend> MakeBlend(const Arguments& arguments, const Examples& examples,
                        const net::Model& model, const net::StyleSpace& space, int input_style) {
  net::StyleRequest request;
  request.strength = arguments.strength;
  request.amount = arguments.amount;
  std::vector<Ingredient> ingredients;
  const Status named = AddNamed(arguments, model.styles, ingredients);
  if (!named.ok()) return named;
  for (const Example& example : examples.styled) {
    ingredients.push_back({{-1, {}, example.poses, 1}, example.weight});
  }
  const Status shared = ShareRest(arguments, ingredients);
  if (!shared.ok()) return shared;
  for (const Ingredient& one : ingredients) {
    // Neutral requests nothing, unless the performer's own style is removed.
    const bool nothing = one.source.style == 0 && input_style == 0 && !one.source.seed;
    if (!nothing) request.sources.push_back(one.source);
  }
  const auto weight = CheckWeights(arguments, request.sources);
  if (!weight.ok()) return weight.status();
  // A style that is measured is a change of this performer, of which any share can be shown; the
  // strength of other codes is a place among the styles that the network knows.
  Blend blend{{}, weight.value(), 1};
  const bool measured = !space.Portable(space.MakeCode({.sources = {{.style = 0}}})).empty();
  if (measured) {
    blend.strength = std::exchange(request.strength, 1.0F);
    float sum = 0;
    for (const net::StyleSource& source : request.sources) sum += source.weight;
    const bool weighted = !request.sources.empty();  // a design alone is not
    if (sum < 1 && weighted) blend.strength *= sum;
    for (net::StyleSource& source : request.sources) {
      source.weight = sum > 0 ? source.weight / sum : 1;
    }
  }
  if (!request.sources.empty() || arguments.design.empty()) blend.code = space.MakeCode(request);
  if (!examples.neutral.empty()) {
    blend.code =
        space.Difference(blend.code, space.MakeCode({.sources = {{-1, {}, examples.neutral, 1}}}));
  }
  if (arguments.design.empty()) return blend;
  const auto sliders = ParseDesign(arguments.design, space);
  if (!sliders.ok()) return sliders.status();
  auto designed = space.Design(blend.code, sliders.value());
  if (!designed.ok()) return Status::Error("--design: " + designed.status().message());
  blend.code = std::move(designed.value());
  return blend;
}

Status RefuseClipArguments(const Arguments& arguments, const net::Stylizer& network) {
  const auto refusal = [&network](const std::string& option, const std::string& what,
                                  const std::string& families) {
    return Status::Error(option + ": the weights of family \"" + network.model().family +
                         "\" have no " + what + "; expected weights of family " + families);
  };
  if (!arguments.design.empty() && network.space() == nullptr) {
    return refusal("--design", "sliders", "phase");
  }
  if (!arguments.like.empty() && network.space() == nullptr) {
    return refusal("--like", "style encoder", net::SpaceFamilyNames());
  }
  if (arguments.vary && network.space() == nullptr) {
    return refusal("--vary", "variations of a style", net::SpaceFamilyNames());
  }
  if (arguments.window != kWindows[0].word) {
    return refusal("--window", "windows", net::ClipFamilyNames());
  }
  return Status::Ok();
}

}  // namespace styled::stylize

// stylize: restyles a BVH clip with the stylist that the daemon runs.

#include "model/tools/stylize.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/base/text.h"
#include "model/clip/avatar.h"
#include "model/clip/clip.h"
#include "model/clip/write.h"
#include "model/net/load.h"
#include "model/net/shipped_weights.h"
#include "model/rig/dialects.h"
#include "model/stylist/avatar.h"
#include "model/stylist/clip_stylist.h"
#include "model/stylist/stylist.h"
#include "model/tools/command_line.h"
#include "model/trial/trial.h"

namespace {

using styled::Result;
using styled::Status;
using styled::stylize::Arguments;

constexpr int kSomeFailed = 3;      // written, but some frames are not styled
constexpr double kSlowest_hz = 30;  // slower clips get frames in between; the network's own rate

int Fail(const Status& status) {
  std::fprintf(stderr, "stylize: %s\n", status.message().c_str());
  return 1;
}

// Adds the style that `text` names to the mix. Neutral adds no entry unless the input style is
// another.
Status AddStyle(const styled::net::Styles& styles, const std::string& text, const char* option,
                styled::stylist::Settings& settings) {
  const auto found = styled::stylize::FindWeighted(styles, text, option);
  if (!found.ok()) return found.status();
  if (found.value().style == 0 && settings.input_style == 0) return Status::Ok();
  for (styled::net::StyleWeight& entry : settings.mix) {
    if (entry.style < 0) {
      entry = {found.value().style, found.value().weight.value_or(1.0F)};
      return Status::Ok();
    }
  }
  return Status::Error(std::string(option) + ": more than " + std::to_string(styled::net::kMaxMix) +
                       " styles");
}

Result<styled::stylist::Settings> ParseSettings(const Arguments& arguments,
                                                const styled::net::Styles& styles) {
  styled::stylist::Settings settings;
  settings.strength = arguments.strength;
  settings.transition_s = 0;
  settings.absolute = arguments.absolute;
  if (arguments.root == "stride") settings.root = styled::stylist::Root::kStride;
  const auto parts = styled::stylize::FindParts(arguments);
  if (!parts.ok()) return parts.status();
  settings.parts = parts.value();
  const auto input_style = styled::stylize::FindInputStyle(arguments, styles);
  if (!input_style.ok()) return input_style.status();
  settings.input_style = input_style.value();
  if (!arguments.style.empty()) {
    const Status status = AddStyle(styles, arguments.style, "--style", settings);
    if (!status.ok()) return status;
  }
  for (const std::string& entry : arguments.mix) {
    const Status status = AddStyle(styles, entry, "--mix", settings);
    if (!status.ok()) return status;
  }
  const Status known = styled::stylize::CheckGait(arguments, styles, settings);
  if (!known.ok()) return known;
  const auto error = styled::stylist::Validate(settings, static_cast<int>(styles.size()));
  if (error == styled::stylist::SettingsError::kSum) {
    float sum = 0;
    for (const styled::net::StyleWeight& entry : settings.mix) {
      if (entry.style >= 0) sum += entry.weight;
    }
    return styled::stylize::TooMuch(arguments, sum * std::max(1.0F, settings.strength));
  }
  if (error != styled::stylist::SettingsError::kNone) {
    return Status::Error(styled::stylize::Explain(error));
  }
  return settings;
}

// Binds and unbinds every frame: shows what the canonical humanoid alone does to a clip.
void BindOnly(const styled::rig::Binding& binding, styled::clip::Clip& clip) {
  styled::body::Pose pose;
  styled::rig::RigPose out(clip.skeleton);
  for (styled::rig::RigPose& frame : clip.frames) {
    binding.Bind(frame, pose);
    binding.Unbind(pose, frame, out);
    std::swap(frame, out);
  }
}

Result<styled::net::AnyStylizer> LoadNetwork(const Arguments& arguments) {
  auto weights = styled::net::FindWeights(arguments.weights);
  if (!weights.ok()) return weights.status();
  return styled::trial::LoadAny(weights.value());
}

// The skeleton that the styled motion is written to: the clip's own, or an avatar's.
class Wardrobe {
 public:
  Wardrobe(const styled::clip::AvatarSkeleton* avatar,
           const std::shared_ptr<const styled::rig::Binding>& performer,
           const styled::stylist::Options& options) {
    if (avatar != nullptr) {
      worn_.emplace(performer, avatar->binding, avatar->rest, options, avatar->tail);
    }
  }
  // Returns false if the frame is the performer's own, because the styled pose was not sound.
  bool Process(std::int64_t time_ns, const styled::stylist::Output& out) {
    const bool styled = (out.flags & styled::stylist::kFailed) == 0;
    return (!worn_ || worn_->Process(time_ns, out)) && styled;
  }
  const styled::rig::RigPose& Pose(const styled::stylist::Output& out) const {
    return worn_ ? worn_->pose() : out.rig;
  }

 private:
  std::optional<styled::stylist::Avatar> worn_;
};

// A clip's frames as they are styled. A live stream does not show the motion between two distant
// frames; a clip allows a smooth curve, so a slow one has `steps` - 1 frames in between.
struct Frames {
  explicit Frames(const styled::clip::Clip& the_clip)
      : clip(the_clip),
        steps(static_cast<std::size_t>(std::ceil(kSlowest_hz / clip.rate_hz - 1e-6))),
        rate_hz(clip.rate_hz * static_cast<double>(steps)),
        count((clip.frames.size() - 1) * steps + 1),
        between(steps > 1 ? styled::clip::Resample(clip, rate_hz) : styled::clip::Clip()) {}
  bool Given(std::size_t i) const { return i % steps == 0; }
  const styled::rig::RigPose& At(std::size_t i) const {
    return Given(i) ? clip.frames[i / steps] : between.frames[i];
  }
  std::int64_t Time_ns(std::size_t i) const {
    return static_cast<std::int64_t>(static_cast<double>(i) / rate_hz * 1e9);
  }

  const styled::clip::Clip& clip;
  std::size_t steps;
  double rate_hz;
  std::size_t count;
  styled::clip::Clip between;
};

// Puts what the arguments blend in place of the styles of `settings`, as one more style of the
// network.
Status AddBlend(const Arguments& arguments, styled::stylist::Settings& settings,
                std::shared_ptr<const styled::net::Stylizer>& stylizer) {
  if (arguments.root != "follow" || arguments.cadence) {
    return Status::Error(
        std::string(arguments.cadence ? "--cadence" : "--root stride") +
        ": how fast an example or a variation goes is not known; expected --style and --mix alone");
  }
  auto blend = styled::stylize::MakeBlend(arguments, stylizer->model(), *stylizer->space(),
                                          settings.input_style);
  if (!blend.ok()) return blend.status();
  const auto number = static_cast<int>(stylizer->model().styles.size());
  stylizer = stylizer->With(number, {.name = "blend"}, blend.value().code);
  settings.mix = {};
  settings.mix[0] = {number, 1};
  settings.strength = 1;  // the code has it
  return Status::Ok();
}

// Writes the next frame's styled pose.
using StyleNext = std::function<void(std::size_t i, styled::stylist::Output& out)>;

// The styling of `frames` as the arguments and the network's kind ask for.
Result<StyleNext> MakeStyling(const Arguments& arguments, const styled::net::AnyStylizer& network,
                              std::shared_ptr<const styled::rig::Binding> binding,
                              const styled::stylist::Options& options, const Frames& frames) {
  if (network.clips) {
    const Status length = styled::stylize::CheckLength(frames.clip, arguments.in,
                                                       network.clips->model(), *network.clips);
    if (!length.ok()) return length;
    auto style = styled::stylize::ParseClipStyle(arguments, *network.clips);
    if (!style.ok()) return style.status();
    auto stylist = std::make_shared<styled::stylist::ClipStylist>(
        network.clips, std::move(style.value()), std::move(binding), options,
        styled::stylist::ClipFrames{
            frames.count, frames.rate_hz,
            [&frames](std::size_t i) -> const styled::rig::RigPose& { return frames.At(i); }});
    return StyleNext([stylist](std::size_t, styled::stylist::Output& out) { stylist->Next(out); });
  }
  const styled::net::Model& model = network.model();
  const Status refused = styled::stylize::RefuseClipArguments(arguments, *network.frames);
  if (!refused.ok()) return refused;
  auto settings = ParseSettings(arguments, model.styles);
  if (!settings.ok()) return settings.status();
  auto stylizer = network.frames;
  if (!arguments.like.empty() || arguments.vary) {
    const auto added = AddBlend(arguments, settings.value(), stylizer);
    if (!added.ok()) return added;
  }
  auto stylist =
      std::make_shared<styled::stylist::Stylist>(std::move(stylizer), std::move(binding), options);
  stylist->Set(settings.value());
  return StyleNext([stylist, &frames](std::size_t i, styled::stylist::Output& out) {
    stylist->Process(frames.Time_ns(i), frames.At(i), out);
  });
}

// What came of a clip's frames.
struct Styled {
  std::size_t failed = 0;       // how many could not be styled and are the performer's own
  std::vector<double> times_s;  // of each frame, where time passes at the style's cadence
};

Result<Styled> Restyle(const Arguments& arguments,
                       const std::shared_ptr<const styled::rig::Binding>& binding,
                       const styled::clip::AvatarSkeleton* avatar, styled::clip::Clip& clip) {
  auto network = LoadNetwork(arguments);
  if (!network.ok()) return network.status();
  styled::stylist::Options options;
  options.bypass = !arguments.no_bypass;
  options.feet = arguments.feet;
  options.own_cadence = arguments.cadence;
  const Frames frames(clip);
  const auto style_next = MakeStyling(arguments, network.value(), binding, options, frames);
  if (!style_next.ok()) return style_next.status();
  Wardrobe wardrobe(avatar, binding, options);
  styled::stylist::Output out(clip.skeleton);
  Styled result;
  double time_s = 0;
  for (std::size_t i = 0; i < frames.count; ++i) {
    style_next.value()(i, out);
    const bool styled = wardrobe.Process(frames.Time_ns(i), out);
    if (i > 0) time_s += 1 / (frames.rate_hz * static_cast<double>(out.cadence));
    if (!frames.Given(i)) continue;
    if (!styled) ++result.failed;
    result.times_s.push_back(time_s);
    clip.frames[i / frames.steps] = wardrobe.Pose(out);  // nothing reads the input's any more
  }
  return result;
}

// `binding`: that of the skeleton that is written.
Status Write(const Arguments& arguments, const styled::rig::Binding& binding, bool in_metres,
             styled::clip::Clip clip) {
  styled::clip::Motion motion;
  static_cast<styled::clip::Clip&>(motion) = std::move(clip);
  motion.rest = binding.spec().rest_rotations;
  motion.canonical_from_source = binding.spec().canonical_from_source;
  // A BVH does not state its unit: scale the body to the humanoid's height.
  motion.metres_per_unit = in_metres ? 1 : binding.scale();
  return styled::clip::Write(arguments.out, motion);
}

// Prints the styles of the weights, and on standard error which other weights there are.
int List(const Arguments& arguments) {
  auto network = LoadNetwork(arguments);
  if (!network.ok()) return Fail(network.status());
  std::printf("%s\n", styled::stylize::StyleNames(network.value().model().styles).c_str());
  const auto file = styled::net::FindWeights(arguments.weights);
  for (const auto& other : styled::net::OtherShippedWeights(file.value())) {
    std::fprintf(stderr, "other weights: --weights %s\n", other.stem().c_str());
  }
  return 0;
}

int Run(const Arguments& arguments) {
  if (arguments.list) return List(arguments);
  auto clip = styled::clip::ReadBvh(arguments.in);
  if (!clip.ok()) return Fail(clip.status());
  auto bound = styled::rig::BindDialect(clip.value().skeleton, arguments.rig);
  if (!bound.ok()) return Fail(Status::Error(arguments.in + ": " + bound.status().message()));
  const auto binding = std::make_shared<const styled::rig::Binding>(std::move(bound.value()));
  std::optional<styled::clip::AvatarSkeleton> avatar;
  if (!arguments.avatar.empty()) {
    auto read = styled::clip::ReadAvatar(arguments.avatar, "auto", {});
    if (!read.ok()) return Fail(Status::Error("--avatar " + read.status().message()));
    avatar = std::move(read.value());
  }
  const auto* const onto = avatar ? &*avatar : nullptr;
  const std::size_t frames = clip.value().frames.size();
  Styled done;
  if (arguments.bind_only) {
    BindOnly(*binding, clip.value());
  } else {
    auto result = Restyle(arguments, binding, onto, clip.value());
    if (!result.ok()) return Fail(result.status());
    done = std::move(result.value());
  }
  const bool in_metres = avatar && avatar->metres_per_unit > 0;
  const auto& written_on = avatar ? *avatar->binding : *binding;
  if (avatar) {
    clip.value().skeleton = written_on.skeleton();
    clip.value().channels.clear();
    clip.value().end_sites.clear();
  }
  if (arguments.cadence) styled::stylize::TakeTimes(arguments.out, done.times_s, clip.value());
  const Status written = Write(arguments, written_on, in_metres, std::move(clip.value()));
  if (!written.ok()) return Fail(written);
  if (done.failed == 0) return 0;
  std::fprintf(
      stderr,
      "stylize: %s: %zu of %zu frames are the performer's own: expected a finite pose with "
      "unit rotations from the network, found none\n",
      arguments.out.c_str(), done.failed, frames);
  return kSomeFailed;
}

}  // namespace

namespace styled::stylize {

std::string StyleNames(const net::Styles& styles) {
  std::string names;
  for (const net::StyleInfo& style : styles) names += (names.empty() ? "" : ", ") + style.name;
  return names;
}

Result<float> ParseWeight(const std::string& number, const char* option, const std::string& text) {
  char* end = nullptr;
  const float weight = std::strtof(number.c_str(), &end);
  if (!number.empty() && *end == '\0' && weight >= 0 && weight <= net::kMaxStrength) return weight;
  return Status::Error(std::string(option) + ": '" + text +
                       "': expected behind '=' a weight from 0 to " +
                       NumberText(net::kMaxStrength));
}

std::string WeightsText(const Arguments& arguments) {
  std::string named;
  const auto add = [&named](const char* option, const std::string& text) {
    named += (named.empty() ? "" : ", ") + std::string(option) + " " + text;
  };
  if (!arguments.style.empty()) add("--style", arguments.style);
  for (const std::string& text : arguments.mix) add("--mix", text);
  for (const std::string& text : arguments.like) add("--like", text);
  if (arguments.strength != 1) add("--strength", NumberText(arguments.strength));
  return named;
}

Status TooMuch(const Arguments& arguments, float sum) {
  return Status::Error(WeightsText(arguments) + ": the weights times the strength sum to " +
                       NumberText(sum, 3) + ", expected at most " + NumberText(net::kMaxStrength));
}

Result<Weighted> FindWeighted(const net::Styles& styles, const std::string& text,
                              const char* option) {
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  std::optional<float> weight;
  if (equals != std::string::npos) {
    const auto parsed = ParseWeight(text.substr(equals + 1), option, text);
    if (!parsed.ok()) return parsed.status();
    weight = parsed.value();
  }
  const int style = net::FindStyle(styles, name);
  if (style >= 0) return Weighted{style, weight};
  return Status::Error(std::string(option) + ": unknown style '" + name + "'; expected one of " +
                       StyleNames(styles));
}

Result<int> FindInputStyle(const Arguments& arguments, const net::Styles& styles) {
  if (arguments.input_style.empty()) return 0;
  const int style = net::FindStyle(styles, arguments.input_style);
  if (style >= 0) return style;
  return Status::Error("--input-style: unknown style '" + arguments.input_style +
                       "'; expected one of " + StyleNames(styles));
}

Result<body::Parts> FindParts(const Arguments& arguments) {
  const auto parts = body::FindParts(arguments.parts);
  if (parts) return *parts;
  return Status::Error("--parts " + arguments.parts + ": expected, separated by commas, some of " +
                       std::string(body::kPartWords));
}

const char* Explain(stylist::SettingsError error) {
  using Error = stylist::SettingsError;
  switch (error) {
    case Error::kDuplicateStyle:
      return "a style is named twice";
    case Error::kStrength:
      return "--strength is outside 0 to 1.5";
    default:
      return "the style settings are not valid";
  }
}

}  // namespace styled::stylize

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(
      "Restyles a BVH clip, on its own skeleton or on an avatar's: same rate and, but for "
      "--cadence, same frame count.",
      "stylize");
  styled::stylize::AddOptions(app, arguments);
  if (const auto ended = styled::Parse(app, argc, argv)) return *ended;
  const Status together = styled::stylize::CheckTogether(app, arguments);
  if (!together.ok()) {
    Fail(together);
    return styled::kBadArguments;
  }
  return Run(arguments);
}

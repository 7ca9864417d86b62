// stylize: restyles a BVH clip with the stylist that the daemon runs.

#include "model/tools/stylize.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/clip/avatar.h"
#include "model/clip/clip.h"
#include "model/clip/write.h"
#include "model/net/load.h"
#include "model/net/shipped_weights.h"
#include "model/rig/dialects.h"
#include "model/stylist/avatar.h"
#include "model/stylist/clip_stylist.h"
#include "model/stylist/stylist.h"
#include "model/tools/number.h"
#include "model/trial/trial.h"

namespace {

using styled::Result;
using styled::Status;
using styled::stylize::Arguments;

constexpr int kBadArguments = 2;
constexpr int kSomeFailed = 3;      // written, but some frames are not styled
constexpr double kMaxAmount = 3;    // of a variation: beyond, codes are nothing like trained ones
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
      entry = found.value();
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
  const auto error = styled::stylist::Validate(settings, static_cast<int>(styles.size()));
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
    if (avatar != nullptr) worn_.emplace(performer, avatar->binding, avatar->rest, options);
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

// Writes the next frame's styled pose.
using StyleNext = std::function<void(std::size_t i, styled::stylist::Output& out)>;

// The styling of `frames` as the arguments and the network's kind ask for.
Result<StyleNext> MakeStyling(const Arguments& arguments, const styled::net::AnyStylizer& network,
                              std::shared_ptr<const styled::rig::Binding> binding,
                              const styled::stylist::Options& options, const Frames& frames) {
  if (network.clips) {
    const Status length = styled::stylize::CheckLength(frames.clip, arguments.in, *network.clips);
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
  const Status refused = styled::stylize::RefuseClipArguments(arguments, model.family);
  if (!refused.ok()) return refused;
  auto settings = ParseSettings(arguments, model.styles);
  if (!settings.ok()) return settings.status();
  auto stylist =
      std::make_shared<styled::stylist::Stylist>(network.frames, std::move(binding), options);
  stylist->Set(settings.value());
  return StyleNext([stylist, &frames](std::size_t i, styled::stylist::Output& out) {
    stylist->Process(frames.Time_ns(i), frames.At(i), out);
  });
}

// `failed`: the number of frames that could not be styled and are the performer's own.
Status Restyle(const Arguments& arguments,
               const std::shared_ptr<const styled::rig::Binding>& binding,
               const styled::clip::AvatarSkeleton* avatar, styled::clip::Clip& clip,
               std::size_t& failed) {
  auto network = LoadNetwork(arguments);
  if (!network.ok()) return network.status();
  styled::stylist::Options options;
  options.bypass = !arguments.no_bypass;
  options.feet = arguments.feet;
  const Frames frames(clip);
  const auto style_next = MakeStyling(arguments, network.value(), binding, options, frames);
  if (!style_next.ok()) return style_next.status();
  Wardrobe wardrobe(avatar, binding, options);
  styled::stylist::Output out(clip.skeleton);
  for (std::size_t i = 0; i < frames.count; ++i) {
    style_next.value()(i, out);
    const bool styled = wardrobe.Process(frames.Time_ns(i), out);
    if (!frames.Given(i)) continue;
    if (!styled) ++failed;
    clip.frames[i / frames.steps] = wardrobe.Pose(out);  // nothing reads the input's any more
  }
  return Status::Ok();
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

int Run(const Arguments& arguments) {
  if (arguments.list) {
    auto network = LoadNetwork(arguments);
    if (!network.ok()) return Fail(network.status());
    std::printf("%s\n", styled::stylize::StyleNames(network.value().model().styles).c_str());
    return 0;
  }
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
  std::size_t failed = 0;
  if (arguments.bind_only) {
    BindOnly(*binding, clip.value());
  } else {
    const Status status = Restyle(arguments, binding, onto, clip.value(), failed);
    if (!status.ok()) return Fail(status);
  }
  const bool in_metres = avatar && avatar->metres_per_unit > 0;
  const auto& written_on = avatar ? *avatar->binding : *binding;
  if (avatar) {
    clip.value().skeleton = written_on.skeleton();
    clip.value().channels.clear();
    clip.value().end_sites.clear();
  }
  const Status written = Write(arguments, written_on, in_metres, std::move(clip.value()));
  if (!written.ok()) return Fail(written);
  if (failed == 0) return 0;
  std::fprintf(
      stderr,
      "stylize: %s: %zu of %zu frames are the performer's own: expected a finite pose with "
      "unit rotations from the network, found none\n",
      arguments.out.c_str(), failed, frames);
  return kSomeFailed;
}

}  // namespace

namespace styled::stylize {

std::string StyleNames(const net::Styles& styles) {
  std::string names;
  for (const net::StyleInfo& style : styles) names += (names.empty() ? "" : ", ") + style.name;
  return names;
}

Result<net::StyleWeight> FindWeighted(const net::Styles& styles, const std::string& text,
                                      const char* option) {
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  float weight = 1.0F;
  if (equals != std::string::npos) {
    const std::string number = text.substr(equals + 1);
    char* end = nullptr;
    weight = std::strtof(number.c_str(), &end);
    if (number.empty() || *end != '\0') {
      return Status::Error(std::string(option) + ": '" + text + "': expected STYLE=WEIGHT");
    }
  }
  const int style = net::FindStyle(styles, name);
  if (style >= 0) return net::StyleWeight{style, weight};
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
    case Error::kWeight:
      return "a weight is outside 0 to 1.5";
    case Error::kSum:
      return "the weights times the strength sum to more than 1.5";
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
      "Restyles a BVH clip: same frame count and rate, on its own skeleton or on an avatar's.",
      "stylize");
  app.add_option("-s,--style", arguments.style, "target style, STYLE or STYLE=WEIGHT");
  app.add_option("-a,--strength", arguments.strength, "0 to 1.5; 0 gives the input back")
      ->capture_default_str();
  app.add_option("-m,--mix", arguments.mix, "a further style, STYLE=WEIGHT; at most 4 in all")
      ->take_all()
      ->allow_extra_args(false);  // one value per --mix: the next word may be the input
  app.add_option(
         "-l,--like", arguments.like,
         "an example of the target style, CLIP.bvh or CLIP.bvh=WEIGHT; several are averaged "
         "(weights of family st-gcn)")
      ->take_all()
      ->allow_extra_args(false);
  CLI::Option* const vary =
      app.add_option("--vary", arguments.vary,
                     "a variation of each style named, by this number (weights of family st-gcn)");
  app.add_option("--amount", arguments.amount, "of the variation: 0 none, 1 as in training")
      ->check(styled::Number(0, kMaxAmount))
      ->capture_default_str()
      ->needs(vary);
  app.add_option("--window", arguments.window,
                 "frames that are normalized together (weights of family st-gcn): auto, the whole "
                 "clip up to 20 s; whole; or overlapping windows of 8.5 s")
      ->check(CLI::IsMember({"auto", "whole", "overlapping"}))
      ->capture_default_str();
  app.add_flag("--absolute", arguments.absolute,
               "the paper's output instead of the detail-preserving one");
  app.add_option("--parts,--only", arguments.parts,
                 "style these parts of the body alone, comma-separated")
      ->capture_default_str();
  app.add_option("--input-style,--from", arguments.input_style,
                 "the style that the performer moves in, which is removed");
  app.add_flag("--no-bypass", arguments.no_bypass,
               "without a style, still go through bind, network and unbind");
  app.add_flag("--feet,!--no-feet", arguments.feet,
               "hold feet that the performer plants where they are (default: --feet)");
  app.add_flag("--bind-only", arguments.bind_only,
               "only bind to the canonical humanoid and back, without the network")
      ->excludes("--style")
      ->excludes("--mix")
      ->excludes("--like");
  app.add_option("-w,--weights", arguments.weights, "weights file (default: the shipped one)");
  app.add_option("--rig", arguments.rig, "rig dialect, e.g. bandai-namco, cmu")
      ->capture_default_str();
  app.add_option("--avatar", arguments.avatar,
                 "put the motion onto this skeleton: .vrm, .glb, .gltf or .bvh")
      ->excludes("--bind-only");
  app.add_flag("--list", arguments.list, "print the styles of the weights");
  CLI::Option* in = app.add_option("in", arguments.in, "input BVH");
  CLI::Option* out =
      app.add_option("out", arguments.out, "output file: " + styled::clip::FormatNames())
          ->check([](const std::string& file) {
            return styled::clip::FindFormat(file).status().message();
          });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kBadArguments;
  }
  if (!arguments.list && (in->empty() || out->empty())) {
    std::fprintf(stderr, "stylize: expected an input and an output file; see --help\n");
    return kBadArguments;
  }
  return Run(arguments);
}

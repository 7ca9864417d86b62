// stylize: restyles a BVH clip with the stylist that the daemon runs.

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "model/clip/avatar.h"
#include "model/clip/clip.h"
#include "model/clip/write.h"
#include "model/net/shipped_weights.h"
#include "model/net/stylizer.h"
#include "model/rig/dialects.h"
#include "model/stylist/avatar.h"
#include "model/stylist/stylist.h"
#include "model/trial/trial.h"

namespace {

using styled::Result;
using styled::Status;

constexpr int kBadArguments = 2;
constexpr int kSomeFailed = 3;      // written, but some frames are not styled
constexpr double kSlowest_hz = 30;  // slower clips get frames in between; the network's own rate

struct Arguments {
  std::string style;
  float strength = 1.0F;
  std::vector<std::string> mix;
  std::string parts = "all";  // parts of the body to style
  std::string input_style;    // the style that the performer moves in
  bool absolute = false, no_bypass = false, feet = true, bind_only = false, list = false;
  std::string weights, rig = "auto", avatar, in, out;
};

int Fail(const Status& status) {
  std::fprintf(stderr, "stylize: %s\n", status.message().c_str());
  return 1;
}

std::string StyleNames(const styled::net::Styles& styles) {
  std::string names;
  for (const styled::net::StyleInfo& style : styles) {
    names += (names.empty() ? "" : ", ") + style.name;
  }
  return names;
}

// Parses "S=A" or "S" into a style index and a weight. Neutral adds no entry unless the input style
// is another.
Status AddStyle(const styled::net::Styles& styles, const std::string& text, const char* option,
                styled::stylist::Settings& settings) {
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
  const int style = styled::net::FindStyle(styles, name);
  if (style < 0) {
    return Status::Error(std::string(option) + ": unknown style '" + name + "'; expected one of " +
                         StyleNames(styles));
  }
  if (style == 0 && settings.input_style == 0) return Status::Ok();
  for (styled::net::StyleWeight& entry : settings.mix) {
    if (entry.style < 0) {
      entry = {style, weight};
      return Status::Ok();
    }
  }
  return Status::Error(std::string(option) + ": more than " + std::to_string(styled::net::kMaxMix) +
                       " styles");
}

const char* Explain(styled::stylist::SettingsError error) {
  using Error = styled::stylist::SettingsError;
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

Result<styled::stylist::Settings> ParseSettings(const Arguments& arguments,
                                                const styled::net::Styles& styles) {
  styled::stylist::Settings settings;
  settings.strength = arguments.strength;
  settings.transition_s = 0;
  settings.absolute = arguments.absolute;
  const auto parts = styled::body::FindParts(arguments.parts);
  if (!parts) {
    return Status::Error("--parts " + arguments.parts +
                         ": expected, separated by commas, some of " +
                         std::string(styled::body::kPartWords));
  }
  settings.parts = *parts;
  if (!arguments.input_style.empty()) {
    settings.input_style = styled::net::FindStyle(styles, arguments.input_style);
    if (settings.input_style < 0) {
      return Status::Error("--input-style: unknown style '" + arguments.input_style +
                           "'; expected one of " + StyleNames(styles));
    }
  }
  if (!arguments.style.empty()) {
    const Status status = AddStyle(styles, arguments.style, "--style", settings);
    if (!status.ok()) return status;
  }
  for (const std::string& entry : arguments.mix) {
    const Status status = AddStyle(styles, entry, "--mix", settings);
    if (!status.ok()) return status;
  }
  const auto error = styled::stylist::Validate(settings, static_cast<int>(styles.size()));
  if (error != styled::stylist::SettingsError::kNone) return Status::Error(Explain(error));
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

Result<std::shared_ptr<const styled::net::Stylizer>> LoadNetwork(const Arguments& arguments) {
  auto weights = styled::net::FindWeights(arguments.weights);
  if (!weights.ok()) return weights.status();
  return styled::trial::Load(weights.value());
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

// `failed`: the number of frames that could not be styled and are the performer's own.
Status Restyle(const Arguments& arguments, std::shared_ptr<const styled::rig::Binding> binding,
               const styled::clip::AvatarSkeleton* avatar, styled::clip::Clip& clip,
               std::size_t& failed) {
  auto network = LoadNetwork(arguments);
  if (!network.ok()) return network.status();
  auto settings = ParseSettings(arguments, network.value()->model().styles);
  if (!settings.ok()) return settings.status();
  styled::stylist::Options options;
  options.bypass = !arguments.no_bypass;
  options.feet = arguments.feet;
  Wardrobe wardrobe(avatar, binding, options);
  styled::stylist::Stylist stylist(network.value(), std::move(binding), options);
  stylist.Set(settings.value());
  styled::stylist::Output out(clip.skeleton);
  // A live stream does not show the motion between two distant frames; a clip allows a smooth
  // curve.
  const auto steps = static_cast<std::size_t>(std::ceil(kSlowest_hz / clip.rate_hz - 1e-6));
  const double rate_hz = clip.rate_hz * static_cast<double>(steps);
  const auto between = steps > 1 ? styled::clip::Resample(clip, rate_hz) : styled::clip::Clip();
  const std::size_t count = (clip.frames.size() - 1) * steps + 1;
  for (std::size_t i = 0; i < count; ++i) {
    const bool given = i % steps == 0;
    const auto time_ns = static_cast<std::int64_t>(static_cast<double>(i) / rate_hz * 1e9);
    stylist.Process(time_ns, given ? clip.frames[i / steps] : between.frames[i], out);
    const bool styled = wardrobe.Process(time_ns, out);
    if (given && !styled) ++failed;
    if (given) clip.frames[i / steps] = wardrobe.Pose(out);
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
    std::printf("%s\n", StyleNames(network.value()->model().styles).c_str());
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
      ->excludes("--mix");
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

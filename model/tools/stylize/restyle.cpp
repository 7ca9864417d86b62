// The styling of one clip: how each kind of network runs, and the figures of its frames.
#include "model/tools/stylize/restyle.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "model/base/text.h"
#include "model/body/pose.h"
#include "model/feet/tuning.h"
#include "model/net/safetensors.h"
#include "model/net/shipped_weights.h"
#include "model/net/weights_file.h"
#include "model/offline/frames.h"
#include "model/offline/learn_neutral.h"
#include "model/stylist/avatar.h"
#include "model/stylist/clip_stylist.h"
#include "model/stylist/stylist.h"
#include "model/stylist/tuning.h"
#include "model/trial/trial.h"

namespace styled::stylize {
namespace {

// For an error about a style that these weights lack: shipped weights that have it, else "".
std::string Elsewhere(const std::string& style) {
  const auto shipped = net::FindWeights("");
  if (!shipped.ok()) return "";
  std::vector<std::filesystem::path> names = net::OtherShippedWeights(shipped.value());
  names.push_back(shipped.value().filename());
  for (const std::filesystem::path& name : names) {
    const std::filesystem::path file = shipped.value().parent_path() / name;
    const auto bytes = net::ReadFile(file);
    if (!bytes.ok()) continue;
    const auto weights = net::ParseWeights(bytes.value(), file.string());
    if (weights.ok() && net::FindStyle(weights.value().model.styles, style) >= 0) {
      return "; with --weights " + name.stem().string() + " there is one";
    }
  }
  return "";
}

// Adds the style that `text` names to the mix. Neutral adds no entry unless the input style is
// another.
Status AddStyle(const net::Styles& styles, const std::string& text, const char* option,
                stylist::Settings& settings) {
  const auto found = FindWeighted(styles, text, option);
  if (!found.ok()) return found.status();
  if (found.value().style == 0 && settings.input_style == 0) return Status::Ok();
  for (net::StyleWeight& entry : settings.mix) {
    if (entry.style < 0) {
      entry = {found.value().style, found.value().weight.value_or(1.0F)};
      return Status::Ok();
    }
  }
  return Status::Error(std::string(option) + ": more than " + std::to_string(net::kMaxMix) +
                       " styles");
}

Result<stylist::Settings> ParseSettings(const Arguments& arguments, const net::Model& model) {
  const net::Styles& styles = model.styles;
  stylist::Settings settings;
  settings.strength = arguments.strength;
  settings.transition_s = 0;
  settings.absolute = arguments.absolute;
  if (arguments.root == "stride") settings.root = stylist::Root::kStride;
  const auto parts = FindParts(arguments);
  if (!parts.ok()) return parts.status();
  settings.parts = parts.value();
  const auto input_style = FindInputStyle(arguments, styles);
  if (!input_style.ok()) return input_style.status();
  settings.input_style = input_style.value();
  const auto input_content = FindInputContent(arguments, model);
  if (!input_content.ok()) return input_content.status();
  settings.input_content = input_content.value();
  if (!arguments.style.empty()) {
    const Status status = AddStyle(styles, arguments.style, "--style", settings);
    if (!status.ok()) return status;
  }
  for (const std::string& entry : arguments.mix) {
    const Status status = AddStyle(styles, entry, "--mix", settings);
    if (!status.ok()) return status;
  }
  const Status known = CheckGait(arguments, styles, settings);
  if (!known.ok()) return known;
  const auto error = stylist::Validate(settings, static_cast<int>(styles.size()),
                                       static_cast<int>(model.contents.size()));
  if (error == stylist::SettingsError::kSum) {
    float sum = 0;
    for (const net::StyleWeight& entry : settings.mix) {
      if (entry.style >= 0) sum += entry.weight;
    }
    return TooMuch(arguments, sum * std::max(1.0F, settings.strength));
  }
  if (error != stylist::SettingsError::kNone) {
    return Status::Error(Explain(error));
  }
  return settings;
}

// The skeleton that the styled motion is written to: the clip's own, or an avatar's.
class Wardrobe {
 public:
  Wardrobe(const clip::AvatarSkeleton* avatar, const std::shared_ptr<const rig::Binding>& performer,
           const stylist::Options& options) {
    if (avatar != nullptr)
      worn_.emplace(performer, avatar->binding, avatar->rest, options, avatar->tail);
  }
  // Returns false if the frame is the performer's own, because the styled pose was not sound.
  bool Process(std::int64_t time_ns, const stylist::Output& out) {
    const bool styled = (out.flags & stylist::kFailed) == 0;
    return (!worn_ || worn_->Process(time_ns, out)) && styled;
  }
  const rig::RigPose& Pose(const stylist::Output& out) const {
    return worn_ ? worn_->pose() : out.rig;
  }

 private:
  std::optional<stylist::Avatar> worn_;
};

// Replaces the styles of `settings` by the blend of the arguments, as one more style of the
// network.
Status AddBlend(const Arguments& arguments, const Examples& examples, stylist::Settings& settings,
                std::shared_ptr<const net::Stylizer>& stylizer) {
  auto blend =
      MakeBlend(arguments, examples, stylizer->model(), *stylizer->space(), settings.input_style);
  if (!blend.ok()) return blend.status();
  const auto number = static_cast<int>(stylizer->model().styles.size());
  stylizer = stylizer->With(number, {.name = "blend"}, blend.value().code);
  const net::StyleInfo& style = stylizer->model().styles.back();
  if ((arguments.root != "follow" || arguments.cadence) && style.walk_mps + style.run_mps <= 0) {
    return Status::Error(
        std::string(arguments.cadence ? "--cadence" : "--root stride") +
        ": the speed of this style is not known; expected --style, --mix, or an example that walks "
        "or runs over the floor with weights of the family phase");
  }
  settings.mix = {};
  settings.mix[0] = {number, 1};
  settings.strength = blend.value().strength;
  return Status::Ok();
}

// Writes the next frame's styled pose.
using StyleNext = std::function<void(std::size_t i, stylist::Output& out)>;

// How far planted feet slide over the floor, styled and in the input: from frame to frame the
// smaller displacement of ankle and toes. A foot counts by the stylist's own contacts (the judges'
// skate has others) and only while the performer's own is slower than the limit of a planted one:
// the contacts are smooth, and hold on to a foot that lifts off for some 50 ms, in which it reaches
// the speed of a swing.
class Slide {
 public:
  void Add(const stylist::Output& out, double input_dt_s, double dt_s) {
    body::ForwardKinematics(out.canonical_input, input_.world);
    body::ForwardKinematics(out.canonical, styled_.world);
    for (int side = 0; side < 2; ++side) {
      const std::uint32_t bit = 1U << static_cast<unsigned>(side);
      if ((out.contacts & before_ & bit) == 0) continue;
      const double way_m = input_.Way_m(side);
      if (way_m > kPlanted_mps * input_dt_s) continue;
      input_.way_m += way_m;
      input_.time_s += input_dt_s;
      styled_.way_m += styled_.Way_m(side);
      styled_.time_s += dt_s;
    }
    before_ = out.contacts;
    input_.last = input_.world;
    styled_.last = styled_.world;
  }
  double Cm_s() const { return styled_.Cm_s(); }
  double Input_cm_s() const { return input_.Cm_s(); }

 private:
  static constexpr double kPlanted_mps = feet::tuning::kContactSlow_mps;
  struct Feet {
    double Way_m(int side) const {
      return std::min(Way_m(side == 0 ? body::kLeftFoot : body::kRightFoot),
                      Way_m(side == 0 ? body::kLeftToes : body::kRightToes));
    }
    double Way_m(body::Joint joint) const {
      const body::Vec3 way = world.positions_m[joint] - last.positions_m[joint];
      return std::hypot(static_cast<double>(way.x()), static_cast<double>(way.z()));
    }
    double Cm_s() const { return time_s > 0 ? 100 * way_m / time_s : 0; }
    body::WorldPose world, last;
    double way_m = 0, time_s = 0;
  };
  Feet input_, styled_;
  std::uint32_t before_ = 0;
};

// How much of the style is visible in the frames.
class Effect {
 public:
  // A frame of this moment of the input.
  void Add(const stylist::Output& out, double time_s) {
    if (in_second_ > 0 && time_s >= seconds_ + 1) EndSecond();
    const stylist::Moved moved_m = stylist::MovedBy(out.canonical_input, out.canonical);
    for (std::size_t limb = 0; limb < moved_m.size(); ++limb) {
      second_m_[limb] += moved_m[limb];
      moved_m_[limb] += static_cast<double>(moved_m[limb]);
    }
    ++in_second_;
    turned_rad_ += static_cast<double>(out.turned_rad);
    for (std::size_t limb = 0; limb < shown_.size(); ++limb) {
      shown_[limb] += static_cast<double>(out.limb_weights[limb]);
    }
    ++frames_;
  }
  // The last second may be a part of one.
  void EndSecond() {
    if (in_second_ == 0) return;
    for (float& sum : second_m_) sum /= static_cast<float>(in_second_);
    unseen_s_ += stylist::IsUnseen(second_m_) ? 1 : 0;
    ++seconds_;
    second_m_ = {};
    in_second_ = 0;
  }
  int seconds() const { return seconds_; }
  int unseen_s() const { return unseen_s_; }
  std::array<double, stylist::kVisibleLimbs.size()> Moved_cm() const {
    auto mean = moved_m_;
    for (double& sum : mean) sum *= 100 / frames_;
    return mean;
  }
  double Turned_deg() const { return turned_rad_ / frames_ * 180 / std::numbers::pi; }
  std::array<double, stylist::kLimbCount> Shown() const {
    auto mean = shown_;
    for (double& share : mean) share /= frames_;
    return mean;
  }

 private:
  double turned_rad_ = 0, frames_ = 0;
  std::array<double, stylist::kLimbCount> shown_{};
  std::array<double, stylist::kVisibleLimbs.size()> moved_m_{};
  stylist::Moved second_m_{};  // sums in the second under way
  int in_second_ = 0, seconds_ = 0, unseen_s_ = 0;
};

}  // namespace

Result<net::AnyStylizer> LoadNetwork(const Arguments& arguments) {
  auto weights = FindWeightsFor(arguments);
  if (!weights.ok()) return weights.status();
  return trial::LoadAny(weights.value());
}

const net::StyleSpace* SpaceOf(const net::AnyStylizer& network) {
  if (network.clips) return network.clips.get();
  return network.frames->space();
}

Result<Restyler> Restyler::Make(const Arguments& arguments, const Examples& examples,
                                const std::optional<neutral::Known>& neutral,
                                const net::AnyStylizer& network) {
  Restyler restyler;
  restyler.neutral_of_clip_ = arguments.neutral == kNeutralOfClip && arguments.input_style.empty();
  restyler.neutral_ = neutral;
  restyler.options_.neutral = arguments.neutral != kNoNeutral;
  restyler.options_.posture = arguments.posture;
  restyler.network_ = network;
  restyler.options_.bypass = !arguments.no_bypass;
  restyler.options_.feet = arguments.feet;
  restyler.options_.own_cadence = arguments.cadence;
  if (network.clips) {
    auto style = ParseClipStyle(arguments, examples, *network.clips);
    if (!style.ok()) return style.status();
    restyler.clip_style_ = std::move(style.value());
    return restyler;
  }
  const Status refused = RefuseClipArguments(arguments, *network.frames);
  if (!refused.ok()) return refused;
  auto settings = ParseSettings(arguments, network.model());
  if (!settings.ok()) return settings.status();
  if (!arguments.like.empty() || !arguments.design.empty() || arguments.vary) {
    const auto added = AddBlend(arguments, examples, settings.value(), restyler.network_.frames);
    if (!added.ok()) return added;
  }
  restyler.settings_ = settings.value();
  Arguments stride = arguments;
  stride.cadence = false;
  settings.value().root = stylist::Root::kStride;
  restyler.can_stride_ = arguments.root == "follow" &&
                         CheckGait(stride, restyler.network_.model().styles, settings.value()).ok();
  return restyler;
}

std::optional<neutral::Known> Restyler::NeutralOf(const clip::Clip& clip,
                                                  const rig::Binding& binding) const {
  const auto& reference = network_.model().reference;
  if (neutral_of_clip_ && reference) return offline::LearnNeutral(clip, binding, *reference);
  return neutral_;
}

bool Restyler::RequestsVisibleStyle() const {
  if (network_.clips) {
    return clip_style_.weight >= stylist::tuning::kVisibleRequest &&
           clip_style_.parts == body::kAllParts;
  }
  return stylist::RequestsVisibleStyle(settings_);
}

Result<Styled> Restyler::Run(const std::string& file,
                             const std::shared_ptr<const rig::Binding>& binding,
                             const clip::AvatarSkeleton* avatar, const Progress& progress,
                             clip::Clip& clip) const {
  const offline::Frames frames(clip);
  const auto neutral = NeutralOf(clip, *binding);
  StyleNext style_next;
  if (network_.clips) {
    const Status length = CheckLength(clip, file, network_.clips->model(), *network_.clips);
    if (!length.ok()) return length;
    auto stylist = std::make_shared<stylist::ClipStylist>(
        network_.clips, clip_style_, binding, options_,
        stylist::ClipFrames{
            frames.count, frames.rate_hz,
            [&frames](std::size_t i) -> const rig::RigPose& { return frames.At(i); }});
    if (neutral) stylist->Know(*neutral);
    style_next = [stylist](std::size_t, stylist::Output& out) { stylist->Next(out); };
  } else {
    auto stylist = std::make_shared<stylist::Stylist>(network_.frames, binding, options_);
    stylist->Set(settings_);
    if (neutral) stylist->Know(*neutral);
    style_next = [stylist, &frames](std::size_t i, stylist::Output& out) {
      stylist->Process(frames.Time_ns(i), frames.At(i), out);
    };
  }
  Wardrobe wardrobe(avatar, binding, options_);
  stylist::Output out(clip.skeleton);
  Styled result;
  Slide slide;
  Effect effect;
  double time_s = 0;
  for (std::size_t i = 0; i < frames.count; ++i) {
    style_next(i, out);
    const bool styled = wardrobe.Process(frames.Time_ns(i), out);
    const double dt_s = 1 / (frames.rate_hz * static_cast<double>(out.cadence));
    if (i > 0) time_s += dt_s;
    slide.Add(out, 1 / frames.rate_hz, dt_s);
    if (!frames.Given(i)) continue;
    effect.Add(out, static_cast<double>(i) / frames.rate_hz);
    if (!styled) ++result.failed;
    if (out.contacts != 0) ++result.planted;
    if ((out.flags & stylist::kOutOfDomain) != 0) ++result.out_of_domain;
    result.times_s.push_back(time_s);
    clip.frames[i / frames.steps] = wardrobe.Pose(out);  // the input's data is no longer read
    if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(frames.count));
  }
  result.slide_cm_s = slide.Cm_s();
  result.input_slide_cm_s = slide.Input_cm_s();
  effect.EndSecond();
  result.turned_deg = effect.Turned_deg();
  result.moved_cm = effect.Moved_cm();
  result.seconds = effect.seconds();
  if (RequestsVisibleStyle()) result.unseen_s = effect.unseen_s();
  result.shown = effect.Shown();
  result.can_stride = can_stride_;
  return result;
}

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
                       "': expected after '=' a weight from 0 to " + NumberText(net::kMaxStrength));
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
                       StyleNames(styles) + Elsewhere(name));
}

Result<int> FindInputStyle(const Arguments& arguments, const net::Styles& styles) {
  if (arguments.input_style.empty()) return 0;
  const int style = net::FindStyle(styles, arguments.input_style);
  if (style >= 0) return style;
  return Status::Error("--input-style: unknown style '" + arguments.input_style +
                       "'; expected one of " + StyleNames(styles));
}

Result<int> FindInputContent(const Arguments& arguments, const net::Model& model) {
  auto content = net::FindContent(model.contents, arguments.content);
  if (content.ok()) return content;
  return Status::Error("--content: " + content.status().message());
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

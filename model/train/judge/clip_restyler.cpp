#include "model/train/judge/clip_restyler.h"

#include <algorithm>
#include <cassert>

#include "model/feet/legs.h"
#include "model/stylist/clip_stylist.h"
#include "model/trial/trial.h"

namespace styled::judge {

ClipRestyler::ClipRestyler(std::shared_ptr<const net::ClipStylizer> network,
                           std::vector<int> style_of, const stylist::Options& options,
                           const ClipForm& form)
    : network_(std::move(network)),
      style_of_(std::move(style_of)),
      options_(options),
      form_(form),
      binding_(std::make_shared<const rig::Binding>(feet::HumanoidBinding())) {
  assert(network_->model().rate_hz == static_cast<float>(kJudgeRate_hz));  // of the references
}

bool ClipRestyler::Has(int style) const {
  return style_of_[static_cast<std::size_t>(style)] != kAbsent;
}

net::StyleCode ClipRestyler::CodeOf(const Target& target) const {
  return network_->MakeCode(RequestOf(target, style_of_));
}

Poses ClipRestyler::RestyleBy(std::span<const body::Pose> clip, const net::StyleCode& code) const {
  rig::RigPose source(binding_->skeleton());
  const stylist::ClipFrames frames{
      clip.size(), form_.rate_hz, [&](std::size_t i) -> const rig::RigPose& {
        source.translations[0] = clip[i].hips_position_m;
        std::copy(clip[i].rotations.begin(), clip[i].rotations.end(), source.rotations.begin());
        return source;
      }};
  stylist::ClipStyle style;
  style.code = code;
  style.absolute = form_.absolute;
  stylist::ClipStylist stylist(network_, style, binding_, options_, frames);
  stylist::Output output(binding_->skeleton());
  Poses styled;
  for (std::size_t i = 0; i < clip.size(); ++i) {
    stylist.Next(output);
    styled.push_back(output.canonical);
  }
  return styled;
}

Poses ClipRestyler::Restyle(std::span<const body::Pose> clip, const Target& target) const {
  return RestyleBy(clip, CodeOf(target));
}

Result<AnyStyler> LoadAnyStyler(const std::filesystem::path& weights,
                                const clip::Manifest& manifest, const stylist::Options& options,
                                const ClipForm& form, net::Precision precision) {
  auto network = trial::LoadAny(weights, precision);
  if (!network.ok()) return network.status();
  auto style_of = StylesOf(network.value().model().styles, manifest);
  // Live networks make unknown styles from examples.
  const bool examples = network.value().frames && network.value().frames->space() != nullptr;
  if (!style_of.ok() && examples) style_of = std::vector<int>(manifest.styles.size(), kAbsent);
  if (!style_of.ok()) return Status::Error(weights.string() + ": " + style_of.status().message());
  AnyStyler styler;
  if (network.value().clips) {
    styler.clips = std::make_unique<ClipRestyler>(network.value().clips,
                                                  std::move(style_of.value()), options, form);
  } else {
    styler.frames = Styler{network.value().frames,
                           std::make_shared<const rig::Binding>(feet::HumanoidBinding()),
                           std::move(style_of.value()), 0};
  }
  return styler;
}

}  // namespace styled::judge

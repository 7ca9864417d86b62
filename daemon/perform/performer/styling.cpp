#include "daemon/perform/performer/styling.h"

#include <array>
#include <numbers>
#include <utility>

#include "daemon/looks/profile.h"

namespace styled::pipeline {

using runtime::Counter;

namespace {

// Fast, because frames are late meanwhile; the style returns more slowly.
constexpr float kReliefFade_s = 0.1F;
constexpr float kReturnFade_s = 0.5F;
// Every kMeasuredOf-th pose is measured, because the effect of a style changes little in between.
// This saves computing two bodies in the other frames.
constexpr int kMeasuredOf = 4;

}  // namespace

Styling::Styling(const BoundBody& body, const RuntimeConfig& config, runtime::Counters& counters)
    : binding_(body.binding),
      left_handed_(body.left_handed),
      counters_(counters),
      stylist_(config.network, body.binding, config.stylist),
      rehearsal_(stylist::Rehearsal::Shared(config.network, body.binding, config.stylist)),
      in_(body.binding->skeleton()),
      out_(body.binding->skeleton()) {}

std::vector<std::string> Styling::ApplyLook(const Profile& profile, const RuntimeConfig& config) {
  std::vector<std::string> unknown;
  const net::Styles& styles = config.network->model().styles;
  const auto settings = Resolve(profile.look, styles, unknown, profile.id);
  const auto error = stylist::Validate(settings, static_cast<int>(styles.size()));
  if (error == stylist::SettingsError::kNone) {
    settings_ = settings;
    if (!relieved_) stylist_.Set(settings);
  }
  return unknown;
}

void Styling::Relieve(bool relieved) noexcept {
  if (relieved_ == relieved) return;
  relieved_ = relieved;
  stylist_.Rest(relieved);
  stylist::Settings settings = settings_;
  settings.transition_s = relieved ? kReliefFade_s : kReturnFade_s;
  if (relieved) settings.mix = stylist::Settings().mix;
  stylist_.Set(settings);
}

void Styling::Rebuild(const BoundBody& body, const RuntimeConfig& config) {
  const bool known = stylist_.has_neutral();
  const neutral::Known neutral = stylist_.Tell();
  stylist_ = stylist::Stylist(config.network, body.binding, config.stylist);
  if (known) stylist_.Know(neutral);
  stylist_.Rest(relieved_);
  rehearsal_ = stylist::Rehearsal::Shared(config.network, body.binding, config.stylist);
  has_output_ = false;
}

void Styling::Adopt(const RuntimeConfig& config) {
  stylist_.Adopt(config.network);
  rehearsal_->Adopt(config.network);
}

void Styling::SetInput(rig::RigPose& received) noexcept {
  std::swap(in_, received);  // both have the skeleton's size
  if (!left_handed_) return;
  // The rig sends joint 0's position alone; the other translations are the mirrored skeleton's
  // offsets already.
  in_.translations.front() = rig::Mirrored(in_.translations.front());
  for (rig::Quat& rotation : in_.rotations) rotation = rig::Mirrored(rotation);
}

void Styling::Finish(std::uint32_t extra_flags) noexcept {
  rig_root_ = binding_->RootPosition(out_.rig);
  if (left_handed_) {
    rig::Mirror(out_.rig);
    rig::Mirror(out_.source);
    rig_root_ = rig::Mirrored(rig_root_);
  }
  has_output_ = true;
  CountFlags(out_.flags | extra_flags);
  counters_.Add(Counter::kStylistSteps, static_cast<std::uint64_t>(out_.steps));
  if ((out_.flags & stylist::kBypass) != 0) return;
  for (std::size_t limb = 0; limb < shown_.sum.size(); ++limb) {
    shown_.sum[limb] += out_.limb_weights[limb];
  }
  shown_.turned_rad += out_.turned_rad;
  if (shown_.poses++ % kMeasuredOf != 0) return;
  const stylist::Moved moved_m = stylist::MovedBy(out_.canonical_input, out_.canonical);
  for (std::size_t limb = 0; limb < moved_m.size(); ++limb) {
    shown_.moved_m[limb] += moved_m[limb];
  }
  ++shown_.measured;
}

void Styling::Sample() noexcept { shown_last_ = std::exchange(shown_, {}); }

void Styling::Describe(v1::PerformerStats& stats) const {
  if (stylist_.has_neutral()) {
    const neutral::Neutral& neutral = stylist_.neutral();
    v1::NeutralStats& told = *stats.mutable_neutral();
    told.set_learned(neutral.learned());
    told.set_body_s(neutral.body_s());
    told.set_arms_s(neutral.arms_s());
    told.set_calibrated(neutral.calibrated());
    told.set_calibrates_s(neutral.calibrates_s());
  }
  if (shown_last_.poses == 0) return;
  const auto mean = [this](stylist::Limb limb) {
    return shown_last_.sum[static_cast<std::size_t>(limb)] / static_cast<float>(shown_last_.poses);
  };
  v1::LimbShares& shown = *stats.mutable_shown();
  shown.set_left_arm(mean(stylist::Limb::kLeftArm));
  shown.set_right_arm(mean(stylist::Limb::kRightArm));
  shown.set_trunk(mean(stylist::Limb::kTrunk));
  shown.set_left_leg(mean(stylist::Limb::kLeftLeg));
  shown.set_right_leg(mean(stylist::Limb::kRightLeg));
  stats.set_turned_deg(shown_last_.turned_rad / static_cast<float>(shown_last_.poses) * 180 /
                       std::numbers::pi_v<float>);
  stylist::Moved moved_m = shown_last_.moved_m;
  for (float& of_limb : moved_m) of_limb /= static_cast<float>(shown_last_.measured);
  v1::MovedLimbs& moved = *stats.mutable_moved();
  moved.set_head(100 * moved_m[0]);
  moved.set_hands(100 * moved_m[1]);
  moved.set_elbows(100 * moved_m[2]);
  moved.set_knees(100 * moved_m[3]);
  moved.set_feet(100 * moved_m[4]);
  stats.set_hardly_styled(stylist::RequestsVisibleStyle(settings_) && stylist::IsUnseen(moved_m));
}

void Styling::CountFlags(std::uint32_t flags) noexcept {
  constexpr std::array<std::pair<std::uint32_t, Counter>, 6> kCounted{{
      {stylist::kConcealed, Counter::kStylistConcealed},
      {stylist::kHeld, Counter::kStylistHeld},
      {stylist::kOutOfDomain, Counter::kStylistOutOfDomain},
      {stylist::kFading, Counter::kStylistFading},
      {stylist::kNewSession, Counter::kStylistNewSession},
      {stylist::kFailed, Counter::kStylistFailed},
  }};
  for (const auto& [flag, counter] : kCounted) {
    if ((flags & flag) != 0) counters_.Add(counter);
  }
}

}  // namespace styled::pipeline

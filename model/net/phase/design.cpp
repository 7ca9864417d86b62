#include "model/net/phase/design.h"

#include <algorithm>
#include <cctype>

#include "model/base/text.h"

namespace styled::phase {
namespace {

using body::Joint;
using gait::Series;

constexpr float kDegree = 0.017453293F;

// The rows of a series, as in gait::TermsAt: cos k phase and sin k phase.
constexpr int Cos(int k) { return k; }
constexpr int Sin(int k) { return gait::kHarmonics + k; }

// The parts of a design: what a posture has, and what only a gait has.
struct Tables {
  Series posture = Series::Zero(), gait = Series::Zero();

  // Adds a rotation vector of a joint, degrees, after the joint's own rotation. On the humanoid's
  // axes: x bends forward, the left arm's y backward and z up.
  void Pose(Joint joint, float x, float y, float z) { Add(posture, 0, joint, x, y, z); }
  void Wave(int row, Joint joint, float x, float y, float z) { Add(gait, row, joint, x, y, z); }

 private:
  static void Add(Series& to, int row, Joint joint, float x, float y, float z) {
    to.col(row).segment<3>(3 * joint) += kDegree * body::Vec3(x, y, z);
  }
};

// One side of the body; `sign` is 1 for the left and -1 for the right.
struct Side {
  float sign;
  Joint shoulder, upper_arm, lower_arm, upper_leg, lower_leg, foot;
};
constexpr std::array<Side, 2> kSides{
    {{1, body::kLeftShoulder, body::kLeftUpperArm, body::kLeftLowerArm, body::kLeftUpperLeg,
      body::kLeftLowerLeg, body::kLeftFoot},
     {-1, body::kRightShoulder, body::kRightUpperArm, body::kRightLowerArm, body::kRightUpperLeg,
      body::kRightLowerLeg, body::kRightFoot}}};

using Values = std::array<float, kSliderNumbers>;

void AddTrunk(const Values& v, Tables& to) {
  // A stoop is shared by the back, and the head mostly keeps looking ahead.
  to.Pose(body::kSpine, 0.45F * v[kStoop], 0, 0);
  to.Pose(body::kChest, 0.40F * v[kStoop], 0, 0);
  to.Pose(body::kNeck, 0.15F * v[kStoop] - 0.25F * v[kChin], 0, 0);
  to.Pose(body::kHead, -0.75F * v[kStoop] - v[kChin], 0, 0);
  // A lean tilts the trunk at the hips; the legs stay.
  to.Pose(body::kSpine, v[kLean], 0, 0);
  to.Pose(body::kHead, -0.6F * v[kLean], 0, 0);
  // The pelvis turns with the leg in front, the chest against it.
  const float twist = v[kTwist];
  to.Wave(Cos(1), body::kHips, 0, -0.5F * twist, 0);
  to.Wave(Cos(1), body::kSpine, 0, 0.5F * twist, 0);
  to.Wave(Cos(1), body::kChest, 0, 0.5F * twist, 0);
  to.Wave(Cos(1), body::kHead, 0, -0.5F * twist, 0);
  // The trunk leans over the standing foot: the right one stands where sin phase < 0.
  const float sway = v[kSway];
  to.Wave(Sin(1), body::kHips, 0, 0, 0.4F * sway);
  to.Wave(Sin(1), body::kSpine, 0, 0, -0.9F * sway);
  to.Wave(Sin(1), body::kChest, 0, 0, -0.3F * sway);
  to.Wave(Sin(1), body::kHead, 0, 0, 0.6F * sway);
}

void AddArm(const Values& v, const Side& side, Tables& to) {
  const float s = side.sign;
  to.Pose(side.shoulder, 0, 0, s * v[kShrug]);
  to.Pose(side.upper_arm, v[kArmsAcross], -s * v[kArmsForward], s * v[kArmsOut]);
  to.Pose(side.lower_arm, 0, -s * v[kElbows], 0);
  // An arm swings against its own leg; the elbow bends a little more in front.
  const float swing = v[kArmSwing];
  to.Wave(Cos(1), side.upper_arm, 0, swing, 0);
  to.Wave(Cos(1), side.lower_arm, 0, 0.35F * swing, 0);
}

void AddLeg(const Values& v, const Side& side, Tables& to) {
  const float s = side.sign;
  const float crouch = v[kCrouch];
  to.Pose(side.upper_leg, -crouch, s * v[kToesOut], s * v[kStepWidth]);
  to.Pose(side.lower_leg, 2 * crouch, 0, 0);
  to.Pose(side.foot, -crouch, 0, -s * v[kStepWidth]);
  // A bounce bends the legs twice a stride, most while the feet are far apart.
  const float bounce = 0.5F * v[kBounce];
  for (const int row : {0, Cos(2)}) {
    to.Wave(row, side.upper_leg, -bounce, 0, 0);
    to.Wave(row, side.lower_leg, 2 * bounce, 0, 0);
    to.Wave(row, side.foot, -bounce, 0, 0);
  }
  // ((1 - sin phase) / 2)^2 is 1 in the middle of the left leg's swing.
  const float lift = v[kKneeLift];
  for (const auto& [row, share] : {std::pair{0, 0.375F}, {Sin(1), -0.5F * s}, {Cos(2), -0.125F}}) {
    to.Wave(row, side.upper_leg, -lift * share, 0, 0);
    to.Wave(row, side.lower_leg, 1.3F * lift * share, 0, 0);
  }
}

Tables TablesOf(const Values& values) {
  Tables tables;
  AddTrunk(values, tables);
  for (const Side& side : kSides) {
    AddArm(values, side, tables);
    AddLeg(values, side, tables);
  }
  return tables;
}

// The design as a style of its own: a difference, of a walk (which runs show, too).
Style StyleOf(const Values& values) {
  const Tables tables = TablesOf(values);
  Style style;
  style.difference = true;
  gait::Gait& walk = style.walk.emplace();
  walk.curve.series = tables.posture + tables.gait;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    style.posture[j] = body::Exp(tables.posture.col(0).segment<3>(3 * joint));
  }
  style.standing = style.posture;
  return style;
}

std::string Lower(std::string text) {
  for (char& c : text) {
    c = c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return text;
}

Status SetSlider(const net::SliderValue& wanted, Values& values) {
  const auto& sliders = Sliders();
  const std::string name = Lower(wanted.name);
  const auto found = std::ranges::find_if(
      sliders, [&name](const net::Slider& slider) { return name == slider.name; });
  if (found == sliders.end()) {
    std::string names;
    for (const net::Slider& slider : sliders) names += std::string(" ") + slider.name;
    return Status::Error("slider \"" + Printable(wanted.name, 40) + "\": expected one of" + names);
  }
  if (!(wanted.value >= found->least && wanted.value <= found->most)) {
    return Status::Error(std::string(found->name) + ": found " + NumberText(wanted.value) +
                         ", expected " + NumberText(found->least) + " to " +
                         NumberText(found->most) +
                         (*found->unit == '\0' ? "" : std::string(" ") + found->unit));
  }
  values[static_cast<std::size_t>(found - sliders.begin())] = wanted.value - found->usual;
  return Status::Ok();
}

}  // namespace

const std::array<net::Slider, kSliderCount>& Sliders() {
  static constexpr std::array<net::Slider, kSliderCount> kSliders{{
      {"stoop", "Stoop", "Posture", "degrees", -30, 60, 0, "Rounds the back; negative: arches it."},
      {"lean", "Lean", "Posture", "degrees", -25, 40, 0, "Tilts the trunk forward at the hips."},
      {"chin", "Chin", "Posture", "degrees", -40, 40, 0, "Lifts the chin; negative: drops it."},
      {"shrug", "Shoulders", "Posture", "degrees", -15, 30, 0, "Raises the shoulders."},
      {"arms_out", "Arms out", "Arms", "degrees", -20, 80, 0, "Lifts the arms to the sides."},
      {"arms_forward", "Arms forward", "Arms", "degrees", -45, 90, 0, "Lifts the arms forward."},
      {"elbows", "Elbows", "Arms", "degrees", -20, 110, 0, "Bends the elbows."},
      {"arms_across", "Arms across", "Arms", "degrees", -40, 80, 0,
       "Turns bent forearms across the body."},
      {"arm_swing", "Arm swing", "Arms", "degrees", -30, 50, 0,
       "Swings the arms more; negative: less, or with the leg of their own side."},
      {"crouch", "Crouch", "Legs", "degrees", 0, 50, 0, "Bends hips and knees."},
      {"knee_lift", "Knee lift", "Legs", "degrees", -10, 70, 0, "Lifts each knee in its swing."},
      {"step_width", "Step width", "Legs", "degrees", -8, 20, 0, "Sets the feet apart."},
      {"toes_out", "Toes out", "Legs", "degrees", -25, 40, 0, "Turns the feet out."},
      {"bounce", "Bounce", "Walk", "degrees", -10, 30, 0, "Bounces with each step."},
      {"sway", "Sway", "Walk", "degrees", -20, 20, 0, "Leans over the foot that stands."},
      {"twist", "Twist", "Walk", "degrees", -20, 25, 0,
       "Turns the hips with the leg in front and the chest against it; negative: less."},
      {"energy", "Energy", "Character", "", 0, 2, 1,
       "The size of all movements of trunk, head and arms: 0 stiff, 1 the performer's."},
      {"lag", "Lag", "Character", "s", 0, 0.5F, 0, "Head and arms follow late, and overshoot."},
      {"tremor", "Tremor", "Character", "degrees", 0, 8, 0, "Hands, arms and head shake."},
      {"wander", "Wander", "Character", "degrees", 0, 15, 0, "Trunk and arms drift about slowly."},
      {"hold", "Hold and snap", "Character", "s", 0, 1, 0,
       "Head and arms hold still for this time, then snap to the next pose."},
  }};
  return kSliders;
}

std::span<const net::Preset> Presets() {
  static const std::array<net::Preset, 6> kPresets{{
      {"sneaky",
       {{"stoop", 28},
        {"chin", 16},
        {"crouch", 26},
        {"knee_lift", 34},
        {"elbows", 55},
        {"arms_out", 6},
        {"arms_forward", 22},
        {"arm_swing", -8},
        {"twist", -6},
        {"energy", 0.6F},
        {"shrug", 10}}},
      {"drunk",
       {{"stoop", 8},
        {"chin", -10},
        {"sway", 11},
        {"wander", 6},
        {"lag", 0.16F},
        {"energy", 1.2F},
        {"step_width", 7},
        {"arms_out", 16},
        {"elbows", 14},
        {"crouch", 9},
        {"toes_out", 12}}},
      {"robot",
       {{"chin", 2},
        {"elbows", 62},
        {"arms_across", 20},
        {"arm_swing", 20},
        {"twist", 8},
        {"energy", 0.5F},
        {"arms_out", 8},
        {"knee_lift", 10},
        {"step_width", 3},
        {"hold", 0.3F}}},
      {"proud",
       {{"stoop", -16},
        {"chin", 8},
        {"arms_out", 12},
        {"arm_swing", 12},
        {"elbows", 8},
        {"twist", 8},
        {"bounce", 8},
        {"energy", 1.1F},
        {"toes_out", 8},
        {"shrug", -3}}},
      {"scared",
       {{"stoop", 18},
        {"chin", -4},
        {"shrug", 18},
        {"elbows", 85},
        {"arms_across", 40},
        {"arms_forward", 18},
        {"arms_out", -6},
        {"crouch", 12},
        {"arm_swing", -12},
        {"step_width", -2},
        {"energy", 0.6F},
        {"tremor", 2},
        {"toes_out", -6}}},
      {"cold",
       {{"stoop", 20},
        {"chin", -12},
        {"shrug", 22},
        {"elbows", 75},
        {"arms_across", 65},
        {"arms_forward", 12},
        {"arms_out", -10},
        {"arm_swing", -16},
        {"crouch", 6},
        {"step_width", -4},
        {"energy", 0.5F},
        {"tremor", 3},
        {"toes_out", -8}}},
  }};
  return kPresets;
}

Result<Style> WithSliders(const Style& style, std::span<const net::SliderValue> values) {
  Style designed = WithoutDifference(style, StyleOf(style.sliders));
  for (const net::SliderValue& value : values) {
    if (Status status = SetSlider(value, designed.sliders); !status.ok()) return status;
  }
  return WithDifference(designed, StyleOf(designed.sliders));
}

}  // namespace styled::phase

#include "model/feet/feet.h"

#include <algorithm>
#include <cmath>

#include "model/base/smooth.h"
#include "model/feet/tuning.h"

namespace styled::feet {
namespace {

Vec3 Flat(const Vec3& v) { return {v.x(), 0, v.z()}; }

// The rotation of a foot (`foot`: ankle to toes) about the horizontal axis across it that raises
// the toes by about `rise_m` relative to the ankle. The exact angle would be the rise over the
// cosine of the foot's slope, which grows without bound for a foot on its tip. So the angle fades
// to 0 there, and early, because a toe-off passes this range in few frames.
Quat Pitch(const Vec3& foot, const Vec3& across, float rise_m) {
  const float level = Flat(across).norm();  // 0: lies on its side
  const float length = foot.norm();
  if (length < 1e-4F || level < 1e-2F) return Quat::Identity();
  const Vec3 axis = Flat(across) / level;
  // cosine of the slope; 1: level
  const float ahead = std::max(0.0F, foot.dot(axis.cross(Vec3::UnitY())) / length);
  const float turn = level * rise_m / length * ahead * (3 - 2 * ahead);
  return Quat(
      Eigen::AngleAxisf(-std::clamp(turn, -tuning::kMostPitch_rad, tuning::kMostPitch_rad), axis));
}

// How far a part at `height_m` must be lifted to stay above the floor. The lift begins at the top
// of a cushion above the floor, or at the performer's own height if that is lower (a rounded
// minimum of the two), so that an unstyled pose is never changed. The cushion is thicker while the
// performer's foot is high, because a foot in mid-swing comes down fast.
float Push(float floor_m, float performer_m, float height_m) {
  const float cushion = tuning::kCushion_m +
                        (tuning::kHighCushion_m - tuning::kCushion_m) *
                            SmoothStep(performer_m - floor_m, tuning::kCushion_m, tuning::kSwing_m);
  const float top = floor_m + cushion;
  const float support = top - SoftExcess(top - performer_m + cushion, cushion);
  return SoftExcess(support - height_m, cushion);
}

// The turn of a knee that is bent by `bend_rad`, limited so that the knee does not go beyond
// straight, or not farther beyond than it is. A turn that bends it is unchanged.
float KeptForwards(float bend_rad, float turn_rad) {
  const float farthest_rad = std::min(0.0F, bend_rad);
  const auto lacks = [](float above_rad) {
    return SoftPositive(above_rad, tuning::kKneeCorner_rad) - above_rad;
  };
  const float now_rad = bend_rad - farthest_rad;
  return turn_rad + std::max(0.0F, lacks(now_rad + turn_rad) - lacks(now_rad));
}

}  // namespace

Feet::Feet(const rig::Binding& input, const rig::Binding& output, const Options& options)
    : in_legs_(input),
      legs_(output),
      options_(options),
      in_(in_legs_.joints().size()),
      out_(legs_.joints().size()) {}

void Feet::Reset() noexcept {
  contacts_.Reset();
  state_.fill(Leg());
  level_m_.Reset();
  level_frames_ = 0;
  drop_m_.Reset();
  last_across_.setZero();
  own_own_ = own_styled_ = tuning::kFitBegin_m2_s2;
  low_m_ = 0;
}

void Feet::Process(float dt_s, float weight, const PoseView& input, const MutablePoseView& styled,
                   const Travel& travel) noexcept {
  if (dt_s >= tuning::kHole_s) dt_s = 0;  // over a hole, locks keep their state
  // 1 Contacts, from the performer's own feet.
  in_legs_.Place(input, in_);
  contacts_.Process(dt_s, in_legs_, in_, options_);
  if (weight <= 0) {
    state_.fill(Leg());
    level_m_.Reset();
    level_frames_ = 0;
    drop_m_.Reset();
    last_across_.setZero();
    own_own_ = own_styled_ = tuning::kFitBegin_m2_s2;
    low_m_ = 0;
    return;
  }
  TurnWithPerformer();
  // 2 The target of each foot: the length of steps, heights, then the lock.
  legs_.Place(styled, out_);
  FitSteps(dt_s, travel);
  for (int side = 0; side < kLegs; ++side) {
    if (Resolved(side)) PlaceFoot(side, dt_s, weight, travel);
  }
  // 3 The hips' height, from the legs that stand. 4 The legs' IK.
  MoveHips(dt_s, styled);
  for (int side = 0; side < kLegs; ++side) {
    if (Resolved(side)) Reach(side, dt_s, styled);
  }
}

// The gait's centre belongs to the performer: it is rotated with the line through the performer's
// hips.
void Feet::TurnWithPerformer() noexcept {
  const Vec3 across = Flat(in_[static_cast<std::size_t>(in_legs_.leg(0).upper)].position_m -
                           in_[static_cast<std::size_t>(in_legs_.leg(1).upper)].position_m);
  const float length = across.norm();
  if (length < 0.01F) return;  // lying on one side
  const Vec3 now = across / length;
  if (!last_across_.isZero()) {
    const float cosine = last_across_.dot(now);
    const float sine = last_across_.cross(now).y();
    for (Leg& leg : state_) {
      const Vec3 was = leg.centre_m;
      leg.centre_m.x() = cosine * was.x() + sine * was.z();
      leg.centre_m.z() = cosine * was.z() - sine * was.x();
    }
  }
  last_across_ = now;
}

// A style's step may be longer or shorter than the performer's while both bodies move equally far,
// so that a standing foot would slide. Therefore the foot's place along the path is scaled, about
// the hips, by the ratio of the speeds at which standing feet move back under them.
void Feet::FitSteps(float dt_s, const Travel& travel) noexcept {
  const auto ankle_m = [](const Legs& legs, const std::vector<Placed>& placed, int side) -> Vec3 {
    return placed[static_cast<std::size_t>(legs.leg(side).foot)].position_m -
           placed[static_cast<std::size_t>(legs.hips())].position_m;
  };
  for (int side = 0; side < kLegs; ++side) {
    if (!Resolved(side)) continue;
    Leg& state = state_[static_cast<std::size_t>(side)];
    const Contacts::Foot& contact = contacts_.foot(side);
    const Vec3 own_m = ankle_m(in_legs_, in_, side), styled_m = ankle_m(legs_, out_, side);
    if (state.frames > 0 && dt_s > 0) {
      const float own_mps = travel.along.dot(own_m - state.last_own_m) / dt_s;
      const float styled_mps = travel.along.dot(styled_m - state.last_styled_m) / dt_s;
      const float stands = std::max(contact.heel, contact.toes) * travel.along.norm();
      const float share = stands * DecayShare(dt_s, tuning::kFit_s);
      own_own_ += share * (own_mps * own_mps - own_own_);
      own_styled_ += share * (own_mps * styled_mps - own_styled_);
    }
    state.last_own_m = own_m;
    state.last_styled_m = styled_m;
    const float fits =
        (1 + travel.longer) * own_own_ / std::max(own_styled_, tuning::kFitLeast * own_own_);
    const float longer =
        std::exp(tuning::kFitBound * std::tanh(std::log(fits) / tuning::kFitBound));
    state.longer = longer;
    state.fit_m = (longer - 1) * travel.along.dot(styled_m) * travel.along;
  }
}

Feet::Sole Feet::InputFoot(int side) const noexcept {
  const Legs::Leg& from = in_legs_.leg(side);
  const Legs::Leg& to = legs_.leg(side);
  const Contacts::Foot& contact = contacts_.foot(side);
  const auto at = [this](int joint) { return in_[static_cast<std::size_t>(joint)].position_m; };
  Sole sole{at(from.foot), at(from.toes >= 0 ? from.toes : from.foot), contact.heel,
            from.toes >= 0 ? contact.toes : contact.heel};
  sole.heel_m.y() += to.ankle_above_toes_m - from.ankle_above_toes_m;
  if (to.toes < 0) {
    sole.toes_m = sole.heel_m;
    sole.toes = sole.heel;
  }
  return sole;
}

void Feet::PlaceFoot(int side, float dt_s, float weight, const Travel& travel) noexcept {
  const Legs::Leg& leg = legs_.leg(side);
  const Sole input = InputFoot(side);
  Leg& state = state_[static_cast<std::size_t>(side)];
  const bool has_toes = leg.toes >= 0;
  const auto at = [](const std::vector<Placed>& placed, int joint) -> const Vec3& {
    return placed[static_cast<std::size_t>(joint)].position_m;
  };
  const Vec3& in_heel = input.heel_m;
  const Vec3& in_toes = input.toes_m;
  const Vec3& heel = at(out_, leg.foot);
  const Vec3& toes = has_toes ? at(out_, leg.toes) : heel;

  // Heights: a planted end is placed at the performer's height; a free end moves with the planted
  // one.
  const float off_toes = in_toes.y() - toes.y();
  const float off_heel = in_heel.y() - heel.y();
  // A foot that the style holds high in the air is not pulled down.
  const float high = has_toes ? -off_toes : -off_heel;
  state.yields =
      SmoothStep(high, tuning::kHigh * options_.reach_m, 2 * tuning::kHigh * options_.reach_m);
  const float c_heel = (1 - state.yields) * input.heel;
  const float c_toes = (1 - state.yields) * input.toes;
  const float want_toes = c_toes * off_toes + (1 - c_toes) * c_heel * off_heel;
  const float want_heel = c_heel * off_heel + (1 - c_heel) * c_toes * off_toes;
  if (state.frames == 1 && dt_s > 0) {  // the session may begin in mid-stride
    const auto start = [dt_s](CriticallyDamped& lift, float want) {
      const float speed = (want - lift.value()) / dt_s;
      lift.Start(lift.value(),
                 std::clamp(speed, -tuning::kFastestLift_mps, tuning::kFastestLift_mps));
    };
    start(state.lift_toes, want_toes);
    start(state.lift_heel, want_heel);
  }
  float lift_toes = state.lift_toes.Follow(want_toes, dt_s, tuning::kLift_s);
  float lift_heel = state.lift_heel.Follow(want_heel, dt_s, tuning::kLift_s);
  // No part sinks below the performer's floor, or below the performer's own foot.
  const float floor_m = contacts_.floor_m();
  const float push_toes = Push(floor_m, in_toes.y(), toes.y() + lift_toes);
  const float push_heel = Push(floor_m + leg.ankle_above_toes_m, in_heel.y(), heel.y() + lift_heel);
  // The push at one end also lifts the other: lifting one end after the other would be a jolt.
  lift_toes = weight * (lift_toes + std::hypot(push_toes, tuning::kLiftShared * push_heel));
  lift_heel = weight * (lift_heel + std::hypot(push_heel, tuning::kLiftShared * push_toes));
  if (!has_toes) lift_toes = lift_heel;

  const Vec3 foot = toes - heel;
  const Placed& ankle = out_[static_cast<std::size_t>(leg.foot)];
  state.pitch = Quat::Identity();
  if (has_toes) state.pitch = Pitch(foot, ankle.rotation * leg.across_foot, lift_toes - lift_heel);
  const Vec3 pitched_heel = toes - state.pitch * foot;
  Lock(side, dt_s, input, toes + state.fit_m, pitched_heel + state.fit_m, travel);
  state.ankle_m = pitched_heel + weight * (state.fit_m + state.offset_m);
  state.ankle_m.y() += lift_toes;

  MeasureLeg(side, weight * std::max(c_toes, c_heel));
}

// The height that the leg needs the hips to have.
void Feet::MeasureLeg(int side, float carries) noexcept {
  const Legs::Leg& leg = legs_.leg(side);
  Leg& state = state_[static_cast<std::size_t>(side)];
  const auto at = [this](int joint) -> const Vec3& {
    return out_[static_cast<std::size_t>(joint)].position_m;
  };
  const Vec3& hip = at(leg.upper);
  const Vec3& knee = at(leg.lower);
  const Vec3& ankle = at(leg.foot);
  const float length = (knee - hip).norm() + (ankle - knee).norm();
  // A leg may be as long as it is styled, else `stretch` limits it.
  const float own = (ankle - hip).norm();
  const float reach = std::max(own, options_.stretch * length);
  const float across2 = Flat(state.ankle_m - hip).squaredNorm();
  const auto above_m = [across2](float apart) {  // of a hip so far away from the ankle's target
    return std::sqrt(std::max(apart * apart - across2, 1e-4F));
  };
  state.carries = carries;
  const float rise_m = state.ankle_m.y() + above_m(own) - hip.y();
  // At most kHipsRise_m, by a rounded corner.
  state.rise_m =
      std::max(-options_.hips_drop_m,
               rise_m - SoftExcess(rise_m - tuning::kHipsRise_m / 2, tuning::kHipsRise_m / 2));
  state.beyond_m = hip.y() - state.ankle_m.y() - above_m(reach);
}

// The lock is an integral. In each frame the published foot moves by `hold` times the performer's
// own step plus (1 - hold) times the styled step, so it never jumps, however the contacts change.
void Feet::Lock(int side, float dt_s, const Sole& input, const Vec3& toes, const Vec3& heel,
                const Travel& travel) noexcept {
  Leg& state = state_[static_cast<std::size_t>(side)];
  const Vec3& in_heel = input.heel_m;
  const Vec3& in_toes = input.toes_m;
  // The style's change of the foot's place, compared with a performer who travels like the style.
  const Vec3 ahead = Flat(in_toes - in_[static_cast<std::size_t>(in_legs_.hips())].position_m);
  const Vec3 step_out = travel.longer * travel.along.dot(ahead) * travel.along;
  const Vec3 change = Flat(toes - in_toes) - travel.moved_m - step_out;
  const float reach_m = options_.reach_m + step_out.norm();  // the part of it that comes from the
                                                             // longer step

  if (state.frames == 0) {
    state.centre_m = change;
  } else if (dt_s > 0) {
    // A styled gait puts the foot as far ahead of the performer's at landing as behind it at
    // take-off, about the mean `centre`. A free foot aims at that mean, which it can keep while it
    // is held.
    state.centre_m += DecayShare(dt_s, options_.centre_s) * (change - state.centre_m);
    Vec3 wish = options_.centre * (state.centre_m - change);
    wish *= std::min(1.0F, reach_m / std::max(wish.norm(), 1e-6F));

    const Vec3 toe_step = Flat((in_toes - state.last_in_toes_m) - (toes - state.last_toes_m));
    const Vec3 heel_step = Flat((in_heel - state.last_in_heel_m) - (heel - state.last_heel_m));
    // A style sets its feet down, and lifts them, at other moments. A foot that it swings is not
    // held, because it would be torn off the floor at its release.
    const auto stands = [dt_s](CriticallyDamped& filter, const Vec3& step) {
      const float swings =
          SmoothStep(step.norm() / dt_s, tuning::kStandsBelow_mps, tuning::kSwingsAbove_mps);
      return filter.Follow(1 - swings, dt_s, tuning::kStands_s);
    };
    const float heel_hold = (1 - state.yields) * input.heel * stands(state.heel_stands, heel_step);
    const float toe_hold = (1 - state.yields) * input.toes * stands(state.toes_stand, toe_step);
    // Either end holds the foot; `by_toes` is the share of the toes.
    const float hold = 1 - (1 - toe_hold) * (1 - heel_hold);
    const float by_toes = hold > 0 ? toe_hold / hold : 1.0F;
    Vec3 step = hold * (by_toes * toe_step + (1 - by_toes) * heel_step);
    // Near the longest reach the lock yields: the part of the step that points outwards is dropped.
    const float far = state.offset_m.norm();
    if (far > 0) {
      const Vec3 outwards = state.offset_m / far;
      const float give = SmoothStep(far, tuning::kLetGo * reach_m, reach_m);
      step -= give * std::max(0.0F, step.dot(outwards)) * outwards;
    }
    state.offset_m += step;
    // A step that is longer or shorter must be at its landing place before it lands, or the foot
    // slides.
    const float scaled = std::min(1.0F, std::abs(travel.longer) / tuning::kStrideScaled);
    const float landing = SmoothStep(travel.along.dot(ahead), 0, tuning::kStrideAhead_m);
    const float return_s = options_.return_s * (1 - (1 - tuning::kStrideReturn) * scaled * landing);
    state.offset_m += (1 - hold) * DecayShare(dt_s, return_s) * (wish - state.offset_m);
  }
  if (state.frames == 0 || dt_s > 0) state.frames = std::min(state.frames + 1, 2);
  state.last_in_toes_m = in_toes;
  state.last_in_heel_m = in_heel;
  state.last_toes_m = toes;
  state.last_heel_m = heel;
}

// The hips rise or fall so that the legs that stand keep the lengths, and the knees the angles,
// that the style gives them; a leg that then is too short still draws the hips down.
void Feet::MoveHips(float dt_s, const MutablePoseView& styled) noexcept {
  const Leg& left = state_[0];
  const Leg& right = state_[1];
  float rise_m = (left.carries * left.rise_m + right.carries * right.rise_m) /
                 std::max(1.0F, left.carries + right.carries);
  // A longer step would lower the hips while both feet stand and raise them in between, onto
  // straight legs. Instead the hips stay low, and the knees bent, as in the style.
  const float low_s = rise_m < low_m_ ? tuning::kLowFall_s : tuning::kLowRise_s;
  low_m_ += DecayShare(dt_s, low_s) * (rise_m - low_m_);
  const float longer = std::max(left.longer, right.longer) - 1;
  rise_m += std::clamp(longer / tuning::kLowLonger, 0.0F, 1.0F) * std::min(0.0F, low_m_ - rise_m);
  if (level_frames_ == 1 && dt_s > 0) {  // the session may begin in mid-stride
    const float speed = (rise_m - level_m_.value()) / dt_s;
    level_m_.Start(level_m_.value(),
                   std::clamp(speed, -tuning::kFastestLift_mps, tuning::kFastestLift_mps));
  }
  if (level_frames_ == 0 || dt_s > 0) level_frames_ = std::min(level_frames_ + 1, 2);
  const float level_m = level_m_.Follow(rise_m, dt_s, tuning::kLevel_s);
  const auto need = [level_m](const Leg& leg) {
    return leg.carries * SoftExcess(leg.beyond_m + level_m, tuning::kDropCorner_m);
  };
  const float need_m = std::hypot(need(left), need(right));
  const float drop_m =
      drop_m_.Follow(std::min(need_m, options_.hips_drop_m), dt_s, options_.hips_tau_s);
  const Vec3 up(0, level_m - drop_m, 0);
  if (up.isZero(0)) return;
  // A free foot may be lifted; lowered it would sink.
  for (Leg& leg : state_) leg.ankle_m.y() += (1 - leg.carries) * std::max(0.0F, up.y());
  const auto hips = static_cast<std::size_t>(legs_.hips());
  styled.translations[static_cast<std::size_t>(legs_.joints()[hips])] +=
      legs_.ParentRotation(legs_.hips(), out_).conjugate() * (up / legs_.metres_per_unit());
  for (std::size_t i = hips; i < out_.size(); ++i) out_[i].position_m += up;
}

void Feet::Reach(int side, float dt_s, const MutablePoseView& styled) noexcept {
  const Legs::Leg& leg = legs_.leg(side);
  Leg& state = state_[static_cast<std::size_t>(side)];
  const auto at = [this](int joint) -> const Placed& {
    return out_[static_cast<std::size_t>(joint)];
  };
  const Placed& upper = at(leg.upper);
  const TwoBones limb{upper.position_m, at(leg.lower).position_m, at(leg.foot).position_m,
                      upper.rotation * leg.hinge_in_upper};
  // A foot at its styled place leaves the leg unchanged.
  const float length = (limb.knee - limb.hip).norm() + (limb.ankle - limb.knee).norm();
  const float corner = tuning::kStraightCorner * length;
  const float now = (limb.ankle - limb.hip).norm();
  const float now_soft = SoftReach(now, length, corner);
  const Vec3 wish = state.ankle_m - limb.hip;
  const float wanted = std::max(wish.norm(), 1e-6F);
  const float soft = SoftReach(wanted, length, corner);
  const float room = std::min(1.0F, (length - soft) / (length - now_soft));
  const float reach = soft + room * (now - now_soft);
  // A knee near straight turns far for a little reach. Its turn is smoothed, which costs next to no
  // reach there.
  const KneeTurn knee = KneeFor(limb, reach);
  const float turn_rad =
      KeptForwards(knee.bend_rad, state.knee.Follow(knee.turn_rad, dt_s, tuning::kKnee_s));
  const TwoBoneTurns turns = Turn(limb, knee.axis, turn_rad, limb.hip + (reach / wanted) * wish);

  const auto set = [&](int joint, const Quat& parent_world, const Quat& world) {
    Quat& local =
        styled.rotations[static_cast<std::size_t>(legs_.joints()[static_cast<std::size_t>(joint)])];
    Quat turned = (parent_world.conjugate() * world).normalized();
    if (turned.dot(local) < 0) turned.coeffs() = -turned.coeffs();
    local = turned;
  };
  const Quat shank = turns.upper * turns.lower;
  const Quat lower_parent = turns.upper * legs_.ParentRotation(leg.lower, out_);
  const Quat foot_parent = shank * legs_.ParentRotation(leg.foot, out_);
  set(leg.upper, legs_.ParentRotation(leg.upper, out_), turns.upper * upper.rotation);
  set(leg.lower, lower_parent, shank * at(leg.lower).rotation);
  set(leg.foot, foot_parent, state.pitch * at(leg.foot).rotation);
}

}  // namespace styled::feet

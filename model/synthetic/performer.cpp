#include "model/synthetic/performer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "model/synthetic/feet.h"
#include "model/synthetic/motion_tables.h"
#include "model/synthetic/synthesis.h"

namespace styled::synthetic {
namespace {

using Kind = synthetic::Motion;
using Eigen::Vector2d;

constexpr double kTick_s = 1.0 / 240;
constexpr double kTurnRate_rad = 0.85;  // of a walking turn, per second
constexpr double kBlend_s = 0.11;       // time constant of each of a follower's three stages
constexpr double kHomeRadius_m = 5;     // in random order: beyond this it turns back
constexpr double kPauseBetweenRaises_s = 0.1;
constexpr double kRaise_s = 2.1;  // one raise and the pause after it
constexpr double kPi = std::numbers::pi;

bool IsTurn(Kind kind) { return kind == Kind::kTurnLeft || kind == Kind::kTurnRight; }
bool IsGait(Kind kind) { return kind == Kind::kWalk || kind == Kind::kRun || IsTurn(kind); }
bool IsWave(Kind kind) { return kind >= Kind::kWaveLeft && kind <= Kind::kWaveBoth; }
bool IsRaise(Kind kind) { return kind >= Kind::kRaiseLeft && kind <= Kind::kRaiseBoth; }

const Gesture& GestureOf(Kind kind) {
  if (IsWave(kind)) return kind == Kind::kWaveBoth ? kWaveBoth : kWaveOne;
  return kind == Kind::kRaiseBoth ? kRaiseBoth : kRaiseOne;
}
bool IsRight(Kind kind) { return kind == Kind::kWaveRight || kind == Kind::kRaiseRight; }

// A low-pass of three stages: the target may jump at any time, the value is C2.
struct Follower {
  double first = 0, second = 0, value = 0;

  void Advance(double target, double dt_s) {
    const double share = 1 - std::exp(-dt_s / kBlend_s);
    first += share * (target - first);
    second += share * (first - second);
    value += share * (second - value);
  }
};

// The current gesture, if any.
struct GestureState {
  Kind kind = Kind::kStand;
  bool active = false;
  GestureTime time;
  double tempo = 1, size = 1;
  double hold_until_s = 0;  // time since the rise began at which the fall begins
};

// The whole moving state; copied to compute a pose between two ticks.
struct Core {
  double time_s = 0;
  ScriptItem item;
  double item_s = 0;        // time since the item began
  std::uint64_t items = 0;  // items begun so far
  std::uint64_t draws = 0;
  Follower walk, run, turn_rate;
  double phase = 0, heading_rad = 0;
  Vector2d path_m = Vector2d::Zero();
  bool walked = false;
  GestureState gesture;
  double rested_s = 1;  // time since the last gesture ended
  FeetState feet;
};

}  // namespace

struct Performer::State {
  explicit State(Options o) : options(std::move(o)) {
    options.speed = std::clamp(options.speed, 0.7, 1.4);
    BeginItem(core);
  }

  double Draw(Core& core) const {
    return Unit(Mix(options.seed) ^ (0xD1B54A32D192ED03ULL * ++core.draws));
  }
  double Wanders(int which, double time_s, double around_hz) const {
    return Wander(Mix(options.seed + 77) + static_cast<std::uint64_t>(which), time_s, around_hz);
  }

  // --- choice of the next motion ---
  void BeginItem(Core& core) const {
    const Kind last = core.items == 0 ? Kind::kStand : core.item.motion;
    core.item = options.script.empty() ? Choose(core, last)
                                       : options.script[core.items % options.script.size()];
    ++core.items;
  }

  ScriptItem Choose(Core& core, Kind last) const {
    const auto between = [&](double from, double to) { return from + (to - from) * Draw(core); };
    const Vector2d home = -core.path_m;
    const double away = home.norm();
    const double error = std::remainder(std::atan2(home.x(), home.y()) - core.heading_rad, 2 * kPi);
    if (IsGait(last) && away > kHomeRadius_m) {
      if (std::abs(error) > 0.6) {
        return {error > 0 ? Kind::kTurnLeft : Kind::kTurnRight,
                0.4 + std::abs(error) / kTurnRate_rad};
      }
      return {away > 10 && last == Kind::kWalk && Draw(core) < 0.5 ? Kind::kRun : Kind::kWalk,
              between(3, 5)};
    }
    const double draw = Draw(core);
    if (core.items == 0) return {Kind::kStand, between(1, 2)};
    if (IsGait(last)) {
      if (draw < 0.3) return {draw < 0.15 ? Kind::kTurnLeft : Kind::kTurnRight, between(1.5, 3.5)};
      if (draw < 0.5 && last != Kind::kRun) return {Kind::kRun, between(3, 4.5)};
      if (draw < 0.7 && last != Kind::kWalk) return {Kind::kWalk, between(3, 6)};
      return {Kind::kStand, between(1.5, 3)};
    }
    if (draw < 0.45) return {Kind::kWalk, between(4, 8)};
    if (draw < 0.70) {
      return {
          static_cast<Kind>(static_cast<int>(Kind::kWaveLeft) + static_cast<int>(3 * Draw(core))),
          between(4.5, 7)};
    }
    return {
        static_cast<Kind>(static_cast<int>(Kind::kRaiseLeft) + static_cast<int>(3 * Draw(core))),
        (Draw(core) < 0.6 ? 1 : 2) * between(2.0, 2.3)};
  }

  // --- gestures ---
  void BeginGesture(Core& core) const {
    GestureState& gesture = core.gesture;
    gesture = {};
    gesture.kind = core.item.motion;
    gesture.active = true;
    gesture.tempo = 0.95 + 0.1 * Draw(core);
    gesture.size = 0.96 + 0.08 * Draw(core);
    gesture.time.cycle = Draw(core);
    double left_s = core.item.seconds - core.item_s;
    if (IsRaise(gesture.kind)) {
      // Raise the hands as often as fits into the item; the hold fills the rest.
      const double times = std::max(1.0, std::round(left_s / kRaise_s));
      left_s = std::clamp(left_s / times - kPauseBetweenRaises_s, 0.0, kRaise_s + 0.35);
    }
    gesture.hold_until_s =
        std::max(kRise_s + (IsWave(gesture.kind) ? 0.5 : 0.0), gesture.tempo * left_s - kFall_s);
  }

  void AdvanceGesture(Core& core, double dt_s) const {
    GestureState& gesture = core.gesture;
    if (!gesture.active) {
      core.rested_s += dt_s;
      const Kind kind = core.item.motion;
      const bool still = core.walk.value + core.run.value < 0.25;
      // The first raise begins at once, a further one only if it fits.
      const bool fits =
          core.item.seconds - core.item_s > 0.8 * kRaise_s || core.rested_s > core.item_s;
      if ((IsWave(kind) || IsRaise(kind)) && still && fits &&
          core.rested_s > kPauseBetweenRaises_s) {
        BeginGesture(core);
      }
      return;
    }
    GestureTime& time = gesture.time;
    time.since_rise_s += gesture.tempo * dt_s;
    time.cycle += GestureOf(gesture.kind).cycle_hz * gesture.tempo * dt_s;
    if (time.since_fall_s >= 0) {
      time.since_fall_s += gesture.tempo * dt_s;
    } else {
      const bool left = core.item.motion != gesture.kind && time.since_rise_s >= kRise_s;
      if (left || time.since_rise_s >= gesture.hold_until_s) time.since_fall_s = 0;
    }
    if (time.since_fall_s >= kFall_s) {
      gesture.active = false;
      core.rested_s = 0;
    }
  }

  // --- gait ---
  double Amplitude(double time_s) const { return 1 + 0.035 * Wanders(0, time_s, 0.12); }

  void AdvanceGait(Core& core, double dt_s) const {
    const Kind kind = core.item.motion;
    // Wait while a hand is still high or a foot takes a small step.
    const bool waits = (core.gesture.active && core.gesture.time.since_fall_s < 0.4) ||
                       core.feet.feet[0].stepping || core.feet.feet[1].stepping;
    const double was = core.walk.value + core.run.value;
    core.walk.Advance(!waits && (kind == Kind::kWalk || IsTurn(kind)) ? 1 : 0, dt_s);
    core.run.Advance(!waits && kind == Kind::kRun ? 1 : 0, dt_s);
    const double turn = !IsTurn(kind) || waits ? 0 : kind == Kind::kTurnLeft ? 1 : -1;
    core.turn_rate.Advance(turn * kTurnRate_rad * options.speed, dt_s);
    if (was < 1e-5 && core.walk.value + core.run.value > 0) {
      // The first step is a swing, of the left foot (lifts at kWalkGait.lift) or of the right one.
      core.phase = core.walked ? kWalkGait.lift + (Draw(core) < 0.5 ? 0.0 : 0.5) : options.phase;
      core.walked = true;
    }
    const double walk = core.walk.value, run = core.run.value, moving = walk + run;
    if (moving < 1e-6) return;
    const double hz = (walk * kWalkGait.cycles_hz + run * kRunGait.cycles_hz) / moving *
                      options.speed * (1 + 0.02 * Wanders(1, core.time_s, 0.1));
    const double turn_rad = core.turn_rate.value * std::min(1.0, moving);
    const double stride_m =
        walk * (kWalkGait.stride_m - kTurnShortens_m * std::abs(turn_rad) * options.speed) +
        run * kRunGait.stride_m;
    const double forward_m = Amplitude(core.time_s) * stride_m * hz;
    const double left_m = walk * (kWalkDrift_m * options.speed + kTurnDrift_m * turn_rad);
    core.phase += hz * dt_s;
    core.heading_rad += turn_rad * dt_s;
    const double sine = std::sin(core.heading_rad), cosine = std::cos(core.heading_rad);
    core.path_m +=
        dt_s * Vector2d(forward_m * sine + left_m * cosine, forward_m * cosine - left_m * sine);
  }

  // --- the pose ---
  void Synthesize(const Core& core, Channels& channels) const {
    const double walk = core.walk.value, run = core.run.value;
    const double stand = std::max(0.0, 1 - walk - run);
    for (int i = 0; i < kChannelCount; ++i) {
      channels[i] = static_cast<float>(1 - walk - run) * kStand[i];
    }
    const double amplitude = Amplitude(core.time_s);
    AddSeries(kWalk, core.phase, walk, amplitude, channels);
    AddSeries(kWalkTurn, core.phase, walk * core.turn_rate.value, amplitude, channels);
    AddSeries(kRun, core.phase, run, amplitude, channels);
    if (core.gesture.active) {
      const GestureState& gesture = core.gesture;
      AddGesture(GestureOf(gesture.kind), IsRight(gesture.kind), gesture.time, gesture.size,
                 channels);
    }
    AddLife(core.time_s, stand, channels);
  }

  // Breathing, shifting the weight from one leg to the other, looking around.
  void AddLife(double time_s, double stand, Channels& channels) const {
    const auto add = [&channels](int joint, int axis, double value) {
      channels[3 * joint + axis] += static_cast<float>(value);
    };
    const double breath = std::sin(2 * kPi * (0.26 * time_s + Unit(options.seed)));
    add(body::kChest, 0, -0.012 * breath);
    add(body::kLeftShoulder, 2, 0.012 * breath);
    add(body::kRightShoulder, 2, -0.012 * breath);
    const double sway = stand * Wanders(2, time_s, 0.14);
    channels[kSideways] += static_cast<float>(0.014 * sway);
    add(body::kHips, 2, -0.012 * sway);
    add(body::kSpine, 2, 0.016 * sway);
    channels[kForward] += static_cast<float>(0.006 * stand * Wanders(3, time_s, 0.2));
    add(body::kHead, 1, (0.05 + 0.05 * stand) * Wanders(4, time_s, 0.11));
    add(body::kHead, 0, 0.025 * Wanders(5, time_s, 0.13));
    add(body::kLeftLowerArm, 1, -0.03 * Wanders(6, time_s, 0.12));
    add(body::kRightLowerArm, 1, 0.03 * Wanders(7, time_s, 0.12));
  }

  FeetInput Feet(const Core& core) const {
    FeetInput input;
    input.path_m = core.path_m;
    const double walk = core.walk.value, run = core.run.value, moving = walk + run;
    const double swings = SmootherStep(moving / 0.3);  // lower steps do not leave the floor
    for (int side = 0; side < 2; ++side) {
      const double contact = moving < 1e-9 ? 1
                                           : (walk * Contact(kWalkGait, core.phase, side == 1) +
                                              run * Contact(kRunGait, core.phase, side == 1)) /
                                                 moving;
      input.contact[side] = 1 - swings * (1 - contact);
    }
    input.standing = 1 - moving;
    return input;
  }

  void Advance(Core& core, double dt_s) const {
    core.time_s += dt_s;
    core.item_s += dt_s;
    if (core.item_s >= core.item.seconds) {
      core.item_s -= core.item.seconds;
      BeginItem(core);
    }
    AdvanceGait(core, dt_s);
    AdvanceGesture(core, dt_s);
    body::Pose pose;
    body::WorldPose world;
    Pose(core, pose, world);
    AdvanceFeet(Feet(core), world, dt_s, core.feet);
  }

  // The motion's own pose, rotated to its heading, at the path's origin.
  void Pose(const Core& core, body::Pose& pose, body::WorldPose& world) const {
    Channels channels;
    Synthesize(core, channels);
    ToPose(channels, core.heading_rad, pose);
    body::ForwardKinematics(pose, world);
  }

  Options options;
  Core core;
  std::uint64_t ticks = 0;
};

Performer::Performer(Options options) : state_(std::make_unique<State>(std::move(options))) {}
Performer::~Performer() = default;
Performer::Performer(Performer&&) noexcept = default;
Performer& Performer::operator=(Performer&&) noexcept = default;

void Performer::Pose(double time_s, body::Pose& pose) noexcept {
  const auto whole = static_cast<std::uint64_t>(std::max(0.0, time_s) / kTick_s + 1e-6);
  // Always one tick ahead, so that the first pose already stands on its feet.
  for (; state_->ticks <= whole; ++state_->ticks) state_->Advance(state_->core, kTick_s);
  // A time between two ticks is a shorter tick on a copy of the state.
  Core core = state_->core;
  const double rest_s = time_s - static_cast<double>(state_->ticks - 1) * kTick_s;
  if (rest_s > 1e-6) state_->Advance(core, rest_s);
  body::WorldPose world;
  state_->Pose(core, pose, world);
  ApplyFeet(state_->Feet(core), core.feet, world, pose);
  pose.hips_position_m.x() += static_cast<float>(core.path_m.x());
  pose.hips_position_m.z() += static_cast<float>(core.path_m.y());
}

synthetic::Motion Performer::motion() const noexcept { return state_->core.item.motion; }

std::array<double, 2> Performer::contacts() const noexcept {
  FeetInput input = state_->Feet(state_->core);
  for (int side = 0; side < 2; ++side) {
    if (state_->core.feet.feet[side].stepping) input.contact[side] = 0;
  }
  return input.contact;
}

Options Vary(std::uint64_t seed, std::uint64_t k, std::vector<ScriptItem> script) {
  const std::uint64_t own = Mix(seed * 1000003 + k);
  return {own, 0.92 + 0.16 * Unit(own + 1), Unit(own + 2), std::move(script)};
}

Proportions VaryProportions(std::uint64_t seed, std::uint64_t k) {
  const std::uint64_t own = Mix(seed * 1000003 + k);
  const auto between = [own](std::uint64_t which, double from, double to) {
    return static_cast<float>(from + (to - from) * Unit(own + which));
  };
  return {between(11, 0.92, 1.08), between(12, 0.95, 1.05), between(13, 0.95, 1.05)};
}

rig::Skeleton MakeSkeleton(const Proportions& proportions) {
  rig::Skeleton skeleton;
  const auto clamped = [](float share) { return std::clamp(share, 0.8F, 1.25F); };
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    float scale = clamped(proportions.height);
    if (joint >= body::kSpine && joint <= body::kNeck) scale *= clamped(proportions.torso);
    const bool arm = joint >= body::kLeftShoulder && joint <= body::kRightHand;
    if (arm) scale *= clamped(proportions.arms);
    skeleton.names.emplace_back(body::kHumanoid[joint].name);
    skeleton.parents.push_back(body::kHumanoid[joint].parent);
    skeleton.offsets.push_back(scale * body::Offset(joint));
  }
  return skeleton;
}

}  // namespace styled::synthetic

#pragma once

#include "model/feet/tuning.h"

// The constants that decide how a styled stream looks: value, unit, the trade-off of a larger
// value, and the figure that picked it. The figures are from styleeval on the validation clips of
// set 2 with the weights named, unless said otherwise (v0 and v1 came before v2: the same network,
// narrower; no longer in the tree). "Jerk" is the output's over the input's; "another rig" means
// the clips of Xia et al. (model/weights/README.md, RESULTS.md). "No measurement on record" means
// that the constant was not varied, or the effect not noted.
namespace styled::stylist::tuning {

// Style delta (change_filter.h, low_pass.h)

// Delay of the low-pass on the style delta, s. Larger: calmer, later. v2 learned to be 0.08 s
// ahead. v2 on set 2 at 0.050, 0.080 and 0.100: jerk, mean of the clips' ratios, 1.48, 1.34, 1.30;
// in the first quarter second 1.45, 1.20, 1.17; movement alone recognized in 0.74, 0.71, 0.69.
inline constexpr float kChangeTau_s = 0.08F;
// Reconstruction error (rms over joints, rad) above which the delay grows, and the span over which
// it grows. v1 reconstructs its own domain with an error of 4 to 8 degrees (0.07 to 0.14), another
// rig with 16 to 35 degrees: the growth begins in the first range and is complete in the second.
inline constexpr float kSlowerBegin_rad = 0.12F;
inline constexpr float kSlowerSpan_rad = 0.4F;
// The growth, as a multiple of the delay. Larger: calmer on other rigs, later there. 2 came with
// jerk on another rig 2.2 -> 1.52 and 4 with 1.43 -> 1.30, each among other changes.
inline constexpr float kSlowerBy = 4.0F;
// The growth after a restart of the recurrent states, which ends kStart_s later, s. Larger: calmer,
// and what the states first believed stays longer. v1, jerk of the first quarter second and of the
// whole clip, means of the clips' ratios: at 0 2.62 and 1.39, at 1 1.31 and 1.27, at 2 1.13
// and 1.26.
inline constexpr float kSlowerAtStart = 2.0F;
inline constexpr float kStart_s = 0.5F;
// Time constant of the smoothing of that reconstruction error, s. No measurement on record.
inline constexpr float kReconstruction_s = 0.1F;
// A delta below these is set to zero, so that bypass is reached: rad (0.01 degrees), rad/s. Chosen
// as invisible; no measurement on record.
inline constexpr float kSettled_rad = 2e-4F;
inline constexpr float kSettled_rad_s = 2e-2F;

// Switch of styles (change_filter.h)

// Acceleration limit of a limb during a switch, m/s^2: the delay is at least sqrt(displacement /
// limit). Larger: sooner, harder. With it and a fade of 0.1 s, 1 of 70 switches has an acceleration
// that neither style has by itself, and the new style is recognized after 0.50 s; with a fade of
// 0.4 s and no limit, 8 of 70 and 0.87 to 0.90 s (by a judge of longer windows; 0.83 s now).
// Neighbouring values were not recorded.
inline constexpr float kSwitchAcceleration_mps2 = 40.0F;
// Time constant in which that delay shrinks, s. 0.2: 2 of 70 switches with such an acceleration;
// 0.5: 0 of 70, seen as soon (0.47 to 0.50 s).
inline constexpr float kSwitchHold_s = 0.5F;
// Time after the end of its fade at which a switch is over, s. No measurement on record.
inline constexpr float kSwitchTail_s = 0.6F;
// The shortest time in which a style's variation changes to the next, s: the whole body changes. No
// measurement on record.
inline constexpr float kFastestDrift_s = 0.5F;
// How far the body extends beyond joints without a child (hands, toes, crown), m. The length of a
// hand; no measurement on record.
inline constexpr float kEndReach_m = 0.1F;

// Out of domain (domain.h)

// Reconstruction error at which the style begins to fade out and at which it is gone, rad. Larger:
// more rigs are styled, and more poses that the network does not know. At 0.35 and 0.6 the style
// faded on another rig and on set 1; at 0.7 and 1.1 on neither.
inline constexpr float kOutOfDomainBegin_rad = 0.7F;
inline constexpr float kOutOfDomainEnd_rad = 1.1F;
// Time constant of that fade, s. No measurement on record.
inline constexpr float kOutOfDomainFade_s = 0.3F;
// Tilt of the hips off upright, rad: 52 and 74 degrees. Larger: more of a bow is styled, and more
// of a fall. Without it a style pushed a lying body up to 29 cm through the floor; with it, at most
// 4.0 cm on the way down. Neighbouring values were not recorded. kTiltFade_s is the time constant
// of that fade, s. A cartwheel passes both bounds within some frames, and legs in their style jerk
// by 1.9 times the input's at 0.001, by 1.13 at 0.03, 1.12 at 0.06 and 0.1. Larger: a falling
// performer is styled for longer.
inline constexpr float kTiltFade_s = 0.03F;
inline constexpr float kTiltBegin_rad = 0.9F;
inline constexpr float kTiltEnd_rad = 1.3F;

// Limbs that the network does not know (limb_gate.h). Figures: styleacts, all styles of v1, on set
// 1's punches, kicks, slashes and dance: 1,995 gestures, mean 16 and worst 96 degrees off without
// the gate, 2.6 and 18.5 with it. "Shown": the mean share of the style left to the right arm in
// another actor's ordinary walk (100STYLE).

// The bounds of net::GateBounds. Larger: more of the style in rough acts and on other rigs, and
// more of it in acts that it spoils. v1's arms are off by 0.03 on clips of its own kind (95th
// percentile 0.07, largest 0.13), by 0.2 to 0.6 in punches and slashes, by 0.08 to 0.11 (0.17) in
// another rig's walk; legs by 0.03 (0.06), 0.1 to 0.3, 0.05 (0.14). v2 is off by more in waves, and
// leaves acts that no style was recorded in as they are: with arms at 0.10 to 0.22 a wave with both
// hands shows 0.89 of its style in the right arm, at 0.14 to 0.28 more than 0.95, and set 1's acts
// are off by 11.8 degrees at worst. v1, legs 0.14 to 0.28: kicks 0.90. v2, legs 0.12 to 0.26 and
// 0.3 to 0.6, in which its file has them: ten walks of ACCAD's two strangers show 0.78 and 0.98 of
// a style in the legs, three runs 0.43 and 0.80; eleven of their kicks are as high, 1.00 and 1.00.

// The most that the trunk loses when an arm loses all of its style. At 0 a bent back turned a slash
// by 29 degrees though its arm was the performer's own; at 0.4 by 17, at 0.5 by 14, and the trunk
// shows less on other rigs.
inline constexpr float kGateTrunkWithArms = 0.4F;
// The errors that are usual for a performer (arms and trunk): a low quantile of a limb's errors, as
// a share of frames; the speed at which it is learnt, m/s (up at a tenth of it, down at nine
// tenths); the error that every performer has, m; and the most above that which does not count, m.
// Larger: more style on other rigs, and more in rough acts that last. At 0.015, 0.03 and 0.04 m/s
// set 1's acts are 20.5, 24.8 and 32.9 degrees off at worst (18.5 without), the last with 0.08 m
// known at once; Xia's strutting walk then shows 0.29 of the style in the left arm at its end
// instead of 0.01.
inline constexpr float kGateQuantile = 0.1F;
inline constexpr float kGateLearn_m_s = 0.015F;
inline constexpr float kGateKnown_m = 0.04F;
inline constexpr float kGateMostUsual_m = 0.08F;
// A limb's error must fall by this before its style returns, m. Larger: calmer, and less style
// after an act. 0.02, 0.04 and 0.06 differ by 0.1 degrees in the mean.
inline constexpr float kGateBand_m = 0.02F;
// Time constant of the fade out, s. Larger: calmer, and more of a sudden act is spoilt. With an
// earlier filter 0.02, 0.03 and 0.05 made the worst clip's jerk 1.29, 1.16 and 1.09 times the
// input's.
inline constexpr float kGateClose_s = 0.05F;
// Of the return, s. Larger: fewer returns between two punches, and less style after one. 0.5: worst
// 29 degrees, shown 0.75; 0.8: 18.5, 0.71; 1.0: 18.5, 0.69, and kicks 0.01 higher.
inline constexpr float kGateOpen_s = 1.0F;

// Posture (posture.h)

// Time constant of the mean of the posture that the network shows, s. Larger: an act is longer
// without it, and steps and gestures move it less. No measurement on record.
inline constexpr float kPostureMean_s = 0.5F;
// With which it sets in, s. No measurement on record.
inline constexpr float kPostureFade_s = 0.5F;
// Time constant with which it ends when the body lies or crouches, s. A fall takes half a second.
// No measurement on record.
inline constexpr float kPostureStands_s = 0.06F;
// A network that shows this share of a posture lacks nothing. Larger: the posture is also added to
// what the network shows well.
inline constexpr float kPostureShown = 0.8F;
// Postures of less than this, all joints together, count as none, because a ratio to them would be
// meaningless.
inline constexpr float kNoPosture_rad = 0.01F;
// Cosine of the tilt of the line from the hips to the neck: none of the posture is added below the
// first (70 degrees), all above the second (45).
inline constexpr float kPostureLies = 0.34F, kPostureUpright = 0.71F;
// Height of the hips over the lower foot, canonical metres: nothing is added below the first, a
// deep crouch; everything above the second, a person on a low chair. 0.96 with straight legs.
inline constexpr float kPostureCrouches_m = 0.25F, kPostureSits_m = 0.4F;

// Visibility of a style (visible.h)

// Mean displacement of a limb below which a style is not visible, m. Larger: more seconds count as
// hardly styled. Chosen by eye on strips of strangers; no measurement on record.
inline constexpr float kUnseen_m = 0.015F;
// Sum of weights times strength from which a style is expected to be visible.
inline constexpr float kVisibleRequest = 0.5F;

// Time (interleaver.h, stylist.cpp)

// A hole in source time beyond this restarts the recurrent state, s; the same value as the feet's.
inline constexpr float kGapReset_s = feet::tuning::kHole_s;
// Cross-fade over a restart, s. Larger: softer, later. No measurement on record.
inline constexpr float kRestartFade_s = 0.2F;
// A frame is flagged as concealing lost ones if it comes after more than this many usual intervals.
// Between 1 (jitter flags everything) and 2 (one lost frame is missed); no measurement on record.
inline constexpr double kGapFactor = 1.5;
// The distance between a frame and a tick within which the frame is used for the tick, as a share
// of the tick's period. Larger: poses are interpolated less often, and network steps are less even.
// No measurement on record.
inline constexpr double kSnap = 0.2;
// The largest number of recurrent states: serves 240 Hz with a network of 30 Hz.
inline constexpr int kMaxInterleaved = 8;
// The number of frame intervals whose median is the stream's rate, and the number measured before
// more than one state is used. At 1 (not 7) one uneven first interval decided the rate.
inline constexpr int kRateHistory = 9;
inline constexpr int kRateDecide = 7;

// Root jumps and bad values (input_guard.h)

// A root step beyond kJump_m (canonical metres) and beyond kRunningFast_mps is held for
// kJumpAcceptFrames frames. Sprinters reach 12 m/s. A larger frame count follows a real jump of the
// rig's origin later. No measurement on record.
inline constexpr float kJump_m = 1.0F;
inline constexpr float kRunningFast_mps = 12.0F;
inline constexpr int kJumpAcceptFrames = 10;
// A coordinate beyond this is an error, whatever its unit.
inline constexpr float kLargestCoordinate = 1e9F;
// A rotation of a smaller squared length has no direction, and is held.
inline constexpr float kLeastLength2 = 1e-6F;
// Tolerances of a rotation's squared length: input within the first is rigs' rounding and is passed
// on bit for bit; the second is for output, and must be wider.
inline constexpr float kInputUnitTolerance = 5e-4F;
inline constexpr float kOutputUnitTolerance = 2e-3F;
// The largest distance between the styled pose and the performer's own, canonical metres. A style
// bends and lowers a body, which moves its hips by a leg's length at most; five times as much is an
// error.
inline constexpr float kFarthest_m = 5.0F;
// Added to that, as a share of the distance from the origin: the rounding of floats far out.
inline constexpr float kFarRounding = 1e-4F;

// Height of the body (grounding.h)

// Width of the soft minimum over feet and toes, m. A hard minimum had kinks: with the soft one and
// its smoothing (0.03 s then) v0's jitter at 120 Hz fell from 2.6 to 1.2 times the input's.
inline constexpr float kSoftLowest_m = 0.01F;
// Time constant of the vertical shift, s. Larger: calmer; a foot may sink longer. 0.05 came with
// jerk 1.17 -> 1.13, 0.1 with 1.13 -> 1.12, each among other changes; crouching and falling sank 1
// cm deeper with the last.
inline constexpr float kGroundTau_s = 0.1F;
// A smaller shift counts as none, m. Chosen as invisible; no measurement on record.
inline constexpr float kSettled_m = 2e-4F;

// Knees (knees.h)

// Width of the rounded corner that keeps a knee from bending backwards, rad. Larger: softer, and a
// straight leg is bent more. A straight leg styled 30 degrees backwards leaves at about 10.
// Without the bound it was by up to 20 degrees on another rig, and the feet stage then snapped the
// knee through: most of the jerk there. Neighbouring values were not recorded.
inline constexpr float kKneeCorner_rad = 0.3F;
// A knee styled beyond this in either direction is not bounded: its side is not certain there. No
// measurement on record.
inline constexpr float kKneeBroken_rad = 2.0F;

// Stride (stride.h)

// Time constant of the average of the performer's velocity, s. It must be longer than a step, in
// which the hips' speed and direction sway, and shorter than the start of a walk.
inline constexpr float kStrideSpeed_s = 0.2F;
// Time constant with which the factor is followed, s, beside half the delay of the style delta. The
// factor of the cadence has the same, so that the speed in warped time is that of the stride; it is
// shorter than a step (0.3 to 0.6 s), so that the steps of a walk's beginning are warped, too.
inline constexpr float kStrideFactor_s = 0.1F;
// A smaller logarithm of the factor counts as none: 0.1 mm per metre. Chosen as invisible.
inline constexpr float kStrideSettled = 1e-4F;
// Shares of the walking speed: below the first the performer stands, and no way is scaled; from the
// second on their way is scaled as in a walk. Shifts of weight reach 0.2 m/s, the slowest walks of
// set 2 are above 0.5 of the mean walk.
inline constexpr float kStrideStands = 0.15F, kStrideWalks = 0.5F;
// Shares of the interval from walking to running speed in which the walk's factor changes to the
// run's. Neutral walks of set 2 are up to 0.07, runs down to 0.73.
inline constexpr float kStrideRunBegins = 0.3F, kStrideRuns = 0.7F;
// A style's run is at least this much faster than its walk, so that the two can be distinguished.
inline constexpr float kStrideLeastRun = 1.2F;
// A style has a speed of its own, for any performer: over three parts of the takes of each style of
// set 2 (first, middle and last third, which need not be the three actors) the logarithm of its
// speed correlates with that of neutral's by 0.18 in walks and by -0.33 in runs (18 pairs each). So
// this share of the performer's deviation from the usual speed (logarithms) is taken back, up to
// the factor kStrideUnusual: a slow performer is slowed less. Larger: nearer to the style's own
// speed, and less of the performer's control over it. 0: the ratio of mean speeds alone. Set 2, v1:
// with 0.5 the slowest runs are 11 % (exhausted) below the real style's, with 0.75 9 %.
inline constexpr float kStrideOwnSpeed = 0.75F;
inline constexpr float kStrideUnusual = 1.4F;
// Below this speed the direction of a stride is uncertain, m/s: the speed of shifts of weight.
inline constexpr float kStrideStanding_mps = 0.2F;
// Bounds of the factor. Set 2 has 0.48 (elderly, run) to 1.29 (active, walk), set 1 0.40 (not
// confident) to 1.6 (angry); weights up to 1.5 reach 0.25 and 2.0.
inline constexpr float kLeastStride = 0.25F, kMostStride = 2.0F;
// Bounds of the factor of the cadence. Set 2 has 0.90 (masculine, run) to 1.21 (active, walk), set
// 1 0.65 (sad, walk) to 1.37 (angry, walk); weights up to 1.5 reach 0.53 and 1.60.
inline constexpr float kLeastCadence = 0.5F, kMostCadence = 2.0F;

// Feet (stylist.cpp)

// Weight of the style above which feet are held in full. Smaller: the stage sets in harder as a
// style fades in. No measurement on record.
inline constexpr float kFeetFull = 0.25F;
// Below this weight of the style no foot is held; bypass waits for it. No measurement on record.
inline constexpr float kNoStyle = 2e-3F;

}  // namespace styled::stylist::tuning

#pragma once

// The constants of the feet stage: value, unit, the trade-off of a larger value, and the figure
// that picked it. The figures are from styleeval over 240 clips (40 neutral ones of set 2, six
// styles) unless said otherwise (model/weights/RESULTS.md, "The feet stage"); v1 came before v2 and
// is no longer in the tree. A clip is "to blame" on the stage if its output accelerates harder than
// 1.5 times the input's p99.9 while the pose without the stage does not. "No measurement on record"
// means that the constant was not varied, or the effect not noted.
namespace styled::feet::tuning {

// Contacts (contacts.h)

// Time constant of the smoothing of heel and toe speeds, s, against sensor noise. No measurement on
// record.
inline constexpr float kSpeed_s = 0.012F;
// Options::contact_*: the bounds between which a part of the foot is planted or free, m above the
// floor and m/s. Larger: more slides are stopped, and more of a step is dragged. No measurement on
// record.
inline constexpr float kContactLow_m = 0.03F, kContactHigh_m = 0.06F;
inline constexpr float kContactSlow_mps = 0.4F, kContactFast_mps = 0.9F;
// Options::blend_*: time constants of the begin and end of a contact, s. Larger: softer, and a foot
// slides longer. 0.045 (0.03 before) came with 1.2 % of clips to blame, among other changes; 0.015
// has no measurement on record.
inline constexpr float kBlendIn_s = 0.015F, kBlendOut_s = 0.045F;

// Floor (floor.h)

// Time constants with which the floor falls to lower contacts and rises to higher ones, s. No
// measurement on record.
inline constexpr float kFloorFall_s = 0.1F, kFloorRise_s = 2.0F;
// A step of the floor's height counts as this much at most, m, so that one wild frame moves the
// floor by millimetres. No measurement on record.
inline constexpr float kFloorStep_m = 0.05F;
// Speed of the lowest part, m/s: below the first it is full evidence of the floor's height, above
// the second none. No measurement on record.
inline constexpr float kFloorResting_mps = 0.15F, kFloorMoving_mps = 0.6F;

// Time

// A hole in source time at least this long, s, leaves the locks as they are. The stylist bridges
// holes up to the same length. A hole of 0.25 s takes 60 network steps at 240 Hz. No measurement on
// record.
inline constexpr float kHole_s = 0.25F;

// The lock (feet.h)

// Options::reach_m: the distance from the styled foot at which a lock has released, m.
// Options::return_s: time constant of the way back. Options::centre_s, centre: the gait's mean.
// 0.16, 0.07, 0.4 against 0.12, 0.1, 0.6: less slide (then 11.5 -> 3.2 cm/s by the whole stage with
// the first values; input 2.7). return_s 0.09 instead of 0.07 came with 1.2 % of clips to blame,
// among other changes; longer ones do not help.
inline constexpr float kReach_m = 0.16F;
inline constexpr float kReturn_s = 0.09F;
inline constexpr float kCentre_s = 0.4F;
inline constexpr float kCentre = 1.0F;
// The share of return_s with which a foot that is ahead of the hips returns where a stride makes
// its steps longer or shorter (travel.h): in full from a scale of 1 +- kStrideScaled and from
// kStrideAhead_m ahead of the hips on, m. Smaller: the foot slides less where it lands, and the leg
// swings less as the style's. Neutral walks, runs and turns of set 2 with v1 and a stride, 1 and
// 0.33: slide 9.35 and 8.88 cm/s (input 8.40, without a stride 9.11), legs by pose 0.90 and 0.90,
// by movement 0.67 and 0.67, jerk 1.19 and 1.20. 0.33 behind the hips, too: 8.82, 0.88, 0.65, 1.20.
inline constexpr float kStrideReturn = 0.33F;
inline constexpr float kStrideScaled = 0.1F;
inline constexpr float kStrideAhead_m = 0.2F;
// Share of the reach at which a lock begins to yield. No measurement on record.
inline constexpr float kLetGo = 0.6F;
// Share of the reach: a foot this far above the performer's is pulled down less, one twice as far
// not at all. No measurement on record.
inline constexpr float kHigh = 0.4F;

// The speed over the floor, m/s, of a foot that the performer has planted: below the first the
// style has it planted, too, above the second it swings it; and the time constant of that, s.
// Without it an active walk's largest jerk was 2.6 (4.9 in one clip) instead of 1.7 (2.2), and its
// feet slid 12.7 cm/s instead of 13.3. With 2 m/s instead of 3: the same jerk, feet 13.8.
inline constexpr float kStandsBelow_mps = 0.5F, kSwingsAbove_mps = 3.0F;
inline constexpr float kStands_s = 0.01F;

// The fit of steps (feet.h)

// The figures of the fit, of feet that a style swings and of the knees are of styleacts on six
// neutral clips of set 2's training split (three walks, two runs, a turn) in six styles: the
// largest jerk of a clip over the input's, the least bend of the knees, degrees, and the speed of
// feet on the floor, cm/s. Input 1, 2.0, 8.1; without the feet stage 1.03, 7.4, 36.8; before these
// constants 2.01, 12.7, 10.4; with all 1.23, 7.9, 9.4.

// Time constant of the ratio of steps, s of feet that stand. Larger: steadier, and later. No other
// value was measured.
inline constexpr float kFit_s = 1.0F;
// The initial value: steps that agree, as if seen at this speed, m^2/s^2. A walk has 1.2.
inline constexpr float kFitBegin_m2_s2 = 1.0F;
// The least share of the performer's speed that a styled foot may have in it.
inline constexpr float kFitLeast = 0.1F;
// The bound of the scale, as a logarithm, which it is rounded towards: 0.6 to 1.6. An elderly walk
// asks for 1.8, a run in it for 1.6, others for 0.85 to 1.25. Elderly with 0.01, 0.25, 0.4, 0.6:
// feet on the floor 18.6, 11.7, 10.2, 9.4 cm/s, largest jerk 1.08, 1.09, 1.12, 1.17.
inline constexpr float kFitBound = 0.5F;

// Heights (feet.h)

// Height above the floor at which a free foot begins to be held up, m. Larger: softer landings,
// deeper feet. 0.01: 4 clips to blame, 0.8 cm deepest; 0.015: 1 clip, 1.2 cm, which is more than
// the 1 cm allowed. 0.03 while the performer's own foot is high (in full from kSwing_m on): 3
// clips; with the rest of the table 0, 0.7 cm. A foot in swing comes down at 1.6 m/s. 0.009 since
// the knee's turn is smoothed, which is late by some tenths of a millimetre.
inline constexpr float kCushion_m = 0.009F;
inline constexpr float kHighCushion_m = 0.03F;
inline constexpr float kSwing_m = 0.06F;
// The share of a lift at one end of the foot that is added to the other end. 0: toe and heel were
// held up one after the other, a jolt. No measurement of the value on record.
inline constexpr float kLiftShared = 0.7F;
// Time constant of the lift to the performer's height, s. Slower ones do not reduce the clips to
// blame.
inline constexpr float kLift_s = 0.03F;
// The fastest lift with which a session's first two frames may begin, m/s, because their times may
// jitter. Starting with a speed, not from rest: 2 clips to blame, not 3.
inline constexpr float kFastestLift_mps = 3.0F;
// The largest pitch of a foot, rad. No measurement on record.
inline constexpr float kMostPitch_rad = 0.6F;

// Legs and hips (feet.h)

// Options::stretch: the share of the leg's length beyond which the hips come down.
// Options::hips_drop_m: the most that they do. No measurement on record.
inline constexpr float kStretch = 0.975F;
inline constexpr float kHipsDrop_m = 0.10F;
// Options::hips_tau_s: time constant of the drop, s. 0.1 instead of 0.04 came with 1.2 % of clips
// to blame, among other changes.
inline constexpr float kHipsTau_s = 0.1F;
// Rounding of the corner at which the hips begin to come down, m. No measurement on record.
inline constexpr float kDropCorner_m = 0.005F;
// Rounding of a leg's reach near straight, as a share of its length. Larger: a leg that is never
// quite straight. 0.02, 0.01, 0.005, 0.0025, before a knee's turn was smoothed over 0.02 s: least
// bend 10.0, about 8.5, 7.2, 7.1; largest jerk 1.21, 1.22, 1.25, 1.32.
inline constexpr float kStraightCorner = 0.005F;
// Time constant with which the turn of a knee is smoothed, s. Larger: calmer, and a foot that lands
// sinks deeper. 0, 0.015, 0.02, 0.025: largest jerk 1.7, 1.29, 1.23, 1.22, least bend 11.8 (with
// other corners), 7.5, 7.9, 7.8, deepest under the floor in tests/unit/feet 1.00, 1.03, 1.05, 1.13
// cm with a cushion of 1 cm.
inline constexpr float kKnee_s = 0.02F;
// Rounding of the corner at which a turn stops before it bends the knee backwards, rad: 2 degrees.
// 4 and 8 degrees bend knees by 1 and 2 degrees more.
inline constexpr float kKneeCorner_rad = 0.035F;

// The most that the hips rise so that a leg that stands keeps its styled length, m. No measurement
// on record.
inline constexpr float kHipsRise_m = 0.05F;
// Time constant of that rise or fall, s. Larger: calmer, but late: a leg may then be too short for
// hips that are still up. 0.03: largest jerk as with 0.02, least bend 7.3 instead of 7.9.
inline constexpr float kLevel_s = 0.02F;

// Where a step is made longer than the style's the hips stay low: time constants with which they
// follow down, and up again, s, and the scale less 1 from which on they do so in full. Elderly
// walks of set 2's validation, without and with, real in brackets: least bend of the knees 6.4
// and 20.9 degrees (21.7), rise and fall of the hips 6.9 and 3.3 cm (2.6), legs recognized by pose
// 0.70 and 0.77, by movement 0.34 and 0.57. Up again with 0.5 s: between.
inline constexpr float kLowFall_s = 0.05F, kLowRise_s = 1.5F;
inline constexpr float kLowLonger = 0.3F;

// Two-bone IK (two_bone_ik.h)

// sin(bend) below which the knee's anatomical axis is blended into the axis of the bend. Larger:
// the side of the knee is surer, the turn less exact. A wider blend of hyperextended knees was
// worse.
inline constexpr float kNearlyStraight = 0.35F;
// The longest reach of a limb, as a share of its length.
inline constexpr float kOutermost = 0.9999F;

}  // namespace styled::feet::tuning

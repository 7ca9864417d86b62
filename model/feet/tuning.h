#pragma once

// The constants of the feet stage: value, unit, what a larger value trades for what, and the figure
// that picked it. The figures are from styleeval over 240 clips (40 neutral ones of set 2, six
// styles) unless said otherwise (model/weights/RESULTS.md, "The feet stage"); v1 came before v2 and
// is no longer in the tree. A clip is "to blame" on the stage if its output accelerates harder
// than 1.5 times the input's p99.9 while the pose without the stage does not. "No measurement on
// record" means that nobody varied the constant and noted the effect.
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
// Options::blend_*: time constants with which a contact takes hold and lets go, s. Larger: softer,
// and a foot slides longer. 0.045 (0.03 before) came with 1.2 % of clips to blame, among other
// changes; 0.015 has no measurement on record.
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

// Heights (feet.h)

// Height above the floor at which a free foot begins to be held up, m. Larger: softer landings,
// deeper feet. 0.01: 4 clips to blame, 0.8 cm deepest; 0.015: 1 clip, 1.2 cm, which is more than
// the 1 cm allowed. 0.03 while the performer's own foot is high (in full from kSwing_m on): 3
// clips; with the rest of the table 0, 0.7 cm. A foot in swing comes down at 1.6 m/s.
inline constexpr float kCushion_m = 0.01F;
inline constexpr float kHighCushion_m = 0.03F;
inline constexpr float kSwing_m = 0.06F;
// The share of a lift at one end of the foot that is added to the other end. 0: toe and heel were
// held up one after the other, a jolt. No measurement of the value on record.
inline constexpr float kTakenAlong = 0.7F;
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
// Rounding of a leg's reach near straight, as a share of its length. Larger: a calmer knee, and a
// leg that is never quite straight. Before the hips followed the legs 0.04 was needed: it removed
// most of what the stage added to the jerk. Now, with kAsStyled 0 and v1, 0.04 and 0.0125:
// jerk 1.28 and 1.29, legs by pose 0.78 and 0.82, least bend of a walk 20.6 and 13.9 degrees (real
// styles 11), clips to blame 0.0 and 1.3 %.
inline constexpr float kStraightCorner = 0.02F;
// A foot moved by less than kNear_m keeps the leg as straight as it is styled, smoothed with the
// time constant kStraighten_s. Without it 4.2 % of clips to blame, with it 0.8 (one set of
// weights).
inline constexpr float kNear_m = 0.02F;
inline constexpr float kStraighten_s = 0.05F;

// The most that the hips rise so that a leg that stands keeps its styled length, m. No measurement
// on record.
inline constexpr float kHipsRise_m = 0.05F;
// Time constant of that rise or fall, s. Larger: calmer, but late: a leg may then be too short for
// hips that are still up. 0.02, 0.05, 0.1 (with other values of kAsStyled): jerk after the first
// second 1.21, 1.20, 1.20, legs by pose 0.83, 0.82, 0.81; but from 0.03 on a knee snaps straight
// where a style bounces a standing body by 20 cm (tests/unit/feet).
inline constexpr float kLevel_s = 0.02F;
// The share of its styled straightness that a leg keeps whose foot is moved farther than kNear_m.
// Larger: truer knees, harder. v1, with kStraightCorner 0.02: 0.5, 0.7 and 1 give a least bend of a
// walk that is 5.6, 5.1 and 4.4 degrees off the real styles', and 0.0, 0.8 and 2.5 % of clips to
// blame.
inline constexpr float kAsStyled = 0.5F;

// Two-bone IK (two_bone_ik.h)

// sin(bend) below which the knee's anatomical axis is blended into the axis of the bend. Larger:
// the side of the knee is surer, the turn less exact. A wider blend of hyperextended knees was
// worse.
inline constexpr float kNearlyStraight = 0.35F;
// The longest reach of a limb, as a share of its length.
inline constexpr float kOutermost = 0.9999F;

}  // namespace styled::feet::tuning

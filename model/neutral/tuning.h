#pragma once

// The constants of learning the performer's neutral (neutral.h): value, unit, the trade-off of a
// larger value, and the figure that picked it.
namespace styled::neutral::tuning {

// The weight of the prior before the first frame, as seconds of a performer with the reference's
// carriage. Larger: a new performer's style sets in later; smaller: half a step may be mistaken for
// a carriage. Walks of ACCAD's two performers, 4 to 6 s from nothing, v2: the real styles' change
// is shown to 0.84 at 0.5, 0.88 at 0.25, 0.90 at 0.1; on Xia's walker 1.05 at each.
inline constexpr float kBelieved_s = 0.25F;
// The most seconds that are remembered. Larger: the learned neutral is more stable, and a changed
// calibration is followed more slowly. No measurement on record.
inline constexpr float kRemembered_s = 30.0F;
// The least standing and walking that a calibration needs, s: one step. It is half of the shortest
// calibration that can be requested, so that its performer need not hold still all the time.
inline constexpr float kEnough_s = 0.5F;
// The weight of the prior of a performer's own gait, as seconds of it: of the pattern about the
// mean, and of the mean itself, which the carriage already has.
inline constexpr float kPattern_s = 1.5F, kPatternMean_s = 0.25F;
// Time constant with which a walk turns into a run and back, s: about a step.
inline constexpr float kRunFade_s = 0.15F;
// A gait is learned from samples this far apart, s, and its curve is found again after this time,
// s.
inline constexpr float kSample_s = 0.03F, kSolved_s = 0.25F;
// A longer time between two frames counts as this, s, because the motion in between is unknown.
inline constexpr float kLongest_s = 0.1F;
// Time constant with which a change of the neutral takes effect, s. Larger: a calibration and the
// first steps change the style more softly, and later. No measurement on record.
inline constexpr float kFade_s = 0.2F;

// Shares of the mean walking speed below which a performer stands, and above which they walk; in
// between, the two carriages are mixed. As for a stride.
inline constexpr float kStands = 0.15F, kWalks = 0.5F;
// Shares of the interval from walking to running speed between which a walk becomes a run; runs are
// at least this many times as fast as walks. As for a stride.
inline constexpr float kRunBegins = 0.3F, kRuns = 0.7F, kLeastRun = 1.2F;
// Cosine of the tilt of the line from the hips to the neck: above the second everything is learned,
// below the first nothing. 50 and 35 degrees; no measurement on record.
inline constexpr float kBowed = 0.64F, kUpright = 0.82F;
// Height of the hips over the lower foot, canonical metres, of 0.96 with straight legs: below the
// first nothing is learned (crouches, sitting), from the second on all. No measurement on record.
inline constexpr float kCrouches_m = 0.75F, kStandsUp_m = 0.85F;
// Distance of the ankles over the floor while standing, canonical metres: below the first
// everything is learned, above the second, a stance, nothing. With it, and with forearms that must
// hang, v2 turns the joints of ACCAD's fighters by 0.3 degrees, not 0.6, and of set 1's by 3.0, not
// 3.8.
inline constexpr float kTogether_m = 0.35F, kApart_m = 0.5F;
// Fall of a part of an arm, as the sine of its angle below the horizontal: above the second
// everything is learned, below the first nothing. No measurement on record.
inline constexpr float kArmLifted = 0.2F, kArmHangs = 0.6F;
// The largest turn that counts as a carriage, rad. Means of persons and rigs are 20 to 25 degrees
// apart (rms of joints), collars 40 to 45, hips up to 35. No measurement on record.
inline constexpr float kMostCollar_rad = 1.05F, kMostTrunk_rad = 0.61F, kMostArm_rad = 0.79F,
                       kMostLeg_rad = 0.61F;

}  // namespace styled::neutral::tuning

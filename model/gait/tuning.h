#pragma once

#include <numbers>

// The constants of the gait phase (tracker.h) and of the analysis of a clip (analysis.h): value,
// unit, the trade-off of a larger value, and the figure that picked it.
namespace styled::gait::tuning {

// Time constant of the slow mean of the feet's distance, s. A limp has a mean that is not 0.
inline constexpr float kMean_s = 1.5F;
// Time constant of the smoothing of the feet's relative speed, s. Larger: less noise of the rig in
// the phase, and more delay.
inline constexpr float kDerivative_s = 0.03F;
// Natural frequency, rad/s, and damping of the phase-locked loop, in a gait and while there is
// none. Larger locks sooner and follows more of the harmonics of the feet's distance. Searching
// with 5 locks half of the runs only after 1.03 s instead of 0.8, with 8.5 kicks have a confidence
// above 0.25.
inline constexpr float kLoop_rad_s = 5.0F, kSearch_rad_s = 8.0F, kDamping = 0.8F;
// Strides per second, as rad/s: at the start, the least and the most. An elderly walk has 0.7
// strides a second, a sprint 2.
inline constexpr float kTurn_rad = 2 * std::numbers::pi_v<float>;
inline constexpr float kUsual_rad_s = kTurn_rad * 1.1F, kLeast_rad_s = kTurn_rad * 0.35F,
                       kMost_rad_s = kTurn_rad * 2.2F;
// Distance of the feet, canonical metres, from which the loop follows fully: standing feet have no
// phase. And the share of it below which the rate returns to the usual one, within 1 s.
inline constexpr float kFollowed_m = 0.1F, kIdle = 0.3F, kIdle_s = 1.0F;
// Amplitude of the feet's distance between which a gait is believed, canonical metres. Walks have
// 0.25 to 0.5, elderly ones 0.12. By the feet's speed it is that over at least this rate, rad/s:
// feet that have stopped draw the loop to its least rate.
inline constexpr float kNoStep_m = 0.05F, kStep_m = 0.11F, kSlow_rad_s = kTurn_rad * 0.6F;
// Mean cosine of the phase error between which a gait is believed. 0.85 and 0.97 give kicks a
// confidence of 0.30 instead of 0.24.
inline constexpr float kUnlocked = 0.92F, kLocked = 0.98F;
// Mean product of the feet's difference in height, m, and of their relative speed, m/s: positive if
// the foot that moves forward is the higher one, so that steps backward are no gait.
inline constexpr float kBackward = -0.017F, kForward = 0.017F;
// Time constant of these means, s; that of the mean square of the speed, which is 0 soon after a
// foot has stopped in front (0.2 releases some walks only after 1 s); and those with which the
// confidence rises and falls, s.
inline constexpr float kMeans_s = 0.18F, kSpeed_s = 0.1F, kRise_s = 0.18F, kFall_s = 0.1F;
// Speed over the floor, m/s, between which its direction is believed; and the cosine of the angle
// between heading and direction between which steps are sideways or straight. Walks and runs have
// 0.99 and more in 95 of 100 frames, walking turns 0.97, side steps (16 to 51 degrees) 0.86 in the
// median. The direction is a mean over a step, s: hips sway by 0.3 m/s in halting gaits.
inline constexpr float kDirected_mps = 0.15F, kSurely_mps = 0.35F;
inline constexpr float kSideways = 0.87F, kStraight = 0.95F;
inline constexpr float kWay_s = 0.5F;
// Time constants, s, of the hips' mean height and of their bounce; and the bounces, m, between
// which a walk becomes a run. Walks have -0.024 to 0 in 95 of 100 frames, runs 0.003 to 0.034.
inline constexpr float kHips_s = 0.5F, kBounce_s = 0.4F, kSinks_m = -0.001F, kBounces_m = 0.005F;
// Speeds over the floor, m/s, up to which a gait is a walk and beyond which it is a run, whatever
// the bounce: a stroll sways like a run, and sprints are flat. Below the last it is on the spot.
inline constexpr float kSurelyWalk_mps = 0.9F, kMayRun_mps = 1.3F, kMayWalk_mps = 2.3F,
                       kSurelyRun_mps = 2.8F, kOnTheSpot_mps = 0.3F;
// A longer time between two frames counts as this for the means, s; after a hole the tracker starts
// again, s; and a frame that follows sooner, s, has no speed and is left out.
inline constexpr float kLongest_s = 0.1F, kHole_s = 0.5F, kShortest_s = 1e-4F;
// Distance of the feet, canonical metres, that no performer has: such a frame starts again.
inline constexpr float kFarthest_m = 4.0F;

// The analysis of a clip. Least confidence of a frame that counts as a gait; least strides of a
// gait; and the ridge, per frame and square of the harmonic: little motion must not be explained by
// large harmonics.
inline constexpr float kConfident = 0.5F, kLeastStrides = 1.5F, kRidge = 0.002F;
// Time constant of the average of the hips' velocity, s; and the speed beyond which a step is a
// jump of the rig's origin, m/s. As for a stride (model/stylist/tuning.h).
inline constexpr float kVelocity_s = 0.2F, kFastest_mps = 12.0F;
// Half the window over which a frame's bounce is averaged: a step, s.
inline constexpr float kStepWindow_s = 0.5F;
// A performer stands at confidences and speeds below these.
inline constexpr float kStands = 0.2F, kStands_mps = 0.2F;
// Least time of standing in a clip that gives a mean, s.
inline constexpr float kLeastStanding_s = 0.5F;
// Spread of the joints, rms rad, below which a clip is a pose: 2 degrees.
inline constexpr float kPose_rad = 0.035F;

}  // namespace styled::gait::tuning

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/train/flags.h"

namespace styled::train::style_erd {

// The flags of styletrain that only Style-ERD has; the defaults are those of the first
// weights (v0, no longer in the tree).
// Figures behind them are in model/weights/RESULTS.md ("Table 1" and the sections after it).
struct Config {
  // Weights to start from (a .safetensors file); empty: random ones. Styles are matched by name.
  std::filesystem::path init;
  // Weights whose changes of style are imitated (knowledge distillation, Hinton et al. 2015), each
  // as FILE or FILE:LESSON,LESSON: all styles that it has by name, or those of the lessons. A
  // lesson is STYLE[/CONTENT][*GAIN]: only in windows of that content, and with GAIN (0, 10] times
  // the change to the style. Of several for one style and content the last counts.
  std::vector<std::string> teachers;
  // The lead over a teacher that sees whole clips, s: its change so much later is taught. The
  // stylist's low-pass delays the change of style: a student that is ahead by its delay is on time
  // when published.
  double teacher_lead_s = 0.0;
  // The share [0, 1) of neutral windows that are idle: one frame with both feet and the hands down,
  // held for seconds, because no data set has long idle postures. Their target is the mean of the
  // teacher's changes in windows of the content `idle_as`. Needs a teacher.
  double idle = 0.0;
  std::string idle_as = "walk";
  // Contents in which performers idle: their neutral windows are taught like idle ones.
  std::vector<std::string> idle_contents;
  // Contents in which a style changes nothing: acts that no style was recorded in, for which a
  // teacher can only guess and the performer's own motion is better.
  std::vector<std::string> kept_contents;
  // The names of styles that are added to `init`, everything else frozen (the paper's future work,
  // C.1). The manifest must have only neutral and these styles; the exported weights have all other
  // styles of init, bit for bit, and the new ones.
  std::vector<std::string> add_styles;
  bool replace = false;  // they may be among init's, and are then trained from there

  // The content label C of the encoder and an initial state of the neutral branch per content, with
  // a causal recognizer for streams without a label.
  bool content_input = false;
  // Of the windows, the shares that are given their label and nothing; the others are given what
  // the recognizer finds, as a live stream is.
  double content_label = 0.25, content_unknown = 0.1;
  // Seconds in which a recognized content becomes certain by 1 - 1/e: a frame does not show it.
  double content_rise_s = 0.3;

  // The wide shape of model/net/erd/shape.h instead of the paper's. Weights to start from bring
  // their own.
  bool wide = false;

  // The data.
  double rate_hz = 30.0;  // of the network; clips are resampled to it
  double heading_tau_s =
      0.25;         // time constant of the heading filter; the runtime's must be the same
  int window = 24;  // judged frames, at least 4; the generator runs over one more
  // Above 0: a batch is so many pairs of a neutral and a styled window (sampler.h), the paper's
  // way. They carry no states, and per_style does not apply.
  int pairs = 0;
  int per_style = 3;   // a batch has so many neutral and as many styled windows per style, >= 1
  double carry = 0.5;  // share of windows that start from the states at the end of the slot's last
  double session_start = 0.25;  // share of the others that begin as a new session
  // Share of neutral windows of any content, also of those in which their target was not recorded
  // (sampler.h). Of a manifest with many contents of neutral clips alone more is learnt with more.
  double unpaired = 0.1;
  double miscalibrated = 0.0;  // share whose input has wrong rest poses and a wrong floor
  // Disturbance of the input, in deviations of each feature: a constant of each window, and noise
  // of each frame, both up to this size. The targets are undisturbed. More makes the output calmer
  // on rigs that no data set has, and farther from the style (0.3, 1.5 for set 1; 0.2, 0.7 for v1).
  double offset = 0.0, noise = 0.0;

  // The optimizers (Adam) and their schedule.
  double generator_rate = 8e-4, critic_rate = 4e-4;
  double beta1 = 0.9, beta2 = 0.999;
  double decay_from = 0.67, decay_to = 0.2;  // rates fall linearly from that share of the run on
  double ema = 0.999;  // per iteration, of the running mean of the weights, which is exported

  // Weights of the losses. With `summed` the reconstruction is eq. 3 as it stands, summed over
  // joints and frames as in eq. 8 with velocities in m/s, and w_rotation, w_position, w_velocity
  // are 1, 1/2 and 1.
  bool summed = false;
  double w_rotation = 0.05;  // eq. 2, summed over joints and frames, as in the authors' code
  double w_position = 5.0;  // mean squared distance, m²: ½ in eq. 3, here balanced with the above
  double w_velocity = 0.05, w_height = 0.05;  // mean squares of the heads, standardized
  // Without the adversarial loss FMD is three times as large; without the perceptual one it is
  // smaller (RESULTS.md, Table 1), and content stays recognized.
  double w_adversarial = 1.0, w_perceptual = 0.1;
  double w_penalty = 128.0;  // gradient penalty of the critic, eq. 6
  double w_moments = 0.0;  // distance of each style's mean effect from the clips' (moments.h), m²
  // Distance from the teachers' changes of style: eq. 2 of the rotations; mean squares of the
  // positions that follow, hips' rise included, m², and of their velocities, (m/s)².
  double w_teacher = 0.5, w_teacher_position = 0.0, w_teacher_velocity = 0.0;
  // Second difference of the change of style: less jerk of the output, less expression.
  double w_smooth = 10.0;
  double smooth_from = 0.2, smooth_full = 0.3;  // shares of the run between which it is ramped in

  // The parts that the paper's ablations leave out (besides losses, by their weights).
  bool attention = true;        // false: a plain multi-class discriminator
  bool learned_states = true;   // false: recurrent states start at zero
  bool judge_published = true;  // critic and classifier see the detail-preserving output

  int penalty_every = 1;  // iterations between gradient penalties, which are as much stronger
  int critic_first = 0;   // iterations in which only the critic learns, for a run with `init`
  int classifier_iterations = 1500;
};

// The settings of Tao et al. 2022: 60 Hz, pairs of windows, the content label, the losses and rates
// of section 3.2 and the supplement, the absolute output before the judges, and nothing beside.
void AsInThePaper(Config& config);

// A flag for each member of `config`, which must outlive the rows.
std::vector<FlagGroup> FlagsOf(Config& config);

// Refuses values outside their ranges and flags that need others. Errors name the flag.
Status Check(const Config& config);

}  // namespace styled::train::style_erd

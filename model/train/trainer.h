#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"

namespace styled::train {

// Everything a run depends on besides its data. Every field is a flag of styletrain; the defaults
// are those that v0 was trained with.
struct TrainConfig {
  std::filesystem::path manifest, data, out;
  std::filesystem::path init;  // weights to start from (a .safetensors file); empty: random ones
  // Weights whose changes of style are imitated (knowledge distillation, Hinton et al. 2015), each
  // as FILE or FILE:LESSON,LESSON: for all styles that it has by name, or for what the lessons say.
  // A lesson is STYLE[/CONTENT][*GAIN]: only in windows of that content; changes to the style made
  // so many times as large. Later ones win.
  std::vector<std::string> teachers;
  // The share of neutral windows in which the performer just stands, which no data set shows for
  // long: a frame in which he has both feet down, and his hands, held for seconds. There is taught
  // the mean of what a teacher does in windows of the content `idle_as`.
  double idle = 0.0;
  std::string idle_as = "walk";
  // The names of styles that are added to `init`, everything else frozen (the paper's future work,
  // C.1). The manifest then has neutral and these styles alone; the weights that are written have
  // all of init's other styles, bit for bit, and them.
  std::vector<std::string> add_styles;
  bool replace = false;  // they may be among init's, and are learned anew from there
  std::string command;   // recorded in the weights' metadata
  double minutes = 0;    // length of the run in wall time, over all resumes; 0: by iterations
  int64_t iterations = 0;
  int64_t stop_at = 0;  // end this session at that iteration, the run's length unchanged; 0: no
  uint64_t seed = 1;
  bool resume = false;
  std::string device = "auto";  // "auto", "cpu" or "cuda"
  int threads = 1;

  double rate_hz = 30.0;
  double heading_tau_s = 0.25;
  int window = 24;     // frames that are judged; the generator runs over one more
  int per_style = 3;   // windows per batch: per style so many styled ones, and as many neutral ones
  double carry = 0.5;  // share of windows that start from states carried over from the slot's last
  double session_start = 0.25;  // share of the others that begin like a new session
  double miscalibrated = 0.0;  // share that the generator sees as a badly calibrated rig shows them

  // What the generator sees is off by up to these, in deviations: by a constant of each window, by
  // noise. What is wanted of it stays the same.
  double offset = 0.0, noise = 0.0;

  double generator_rate = 8e-4, critic_rate = 4e-4;
  double beta1 = 0.9, beta2 = 0.999;
  double decay_from = 0.67, decay_to = 0.2;  // learning rates fall linearly over the last third
  double ema = 0.999;                        // running mean of the weights, which is what is saved

  double w_rotation = 0.05;  // eq. 2, summed over joints and frames, as in the authors' code
  double w_position = 5.0;  // mean squared distance, m²; ½ in eq. 3, here in balance with the above
  double w_velocity = 0.05, w_height = 0.05;  // mean squares of the heads, standardized
  double w_adversarial = 1.0, w_perceptual = 0.1, w_penalty = 128.0;
  double w_moments = 0.0;                       // what each style does on average (moments.h), m²
  double w_teacher = 0.5;                       // distance from `teacher`'s changes of style
  double w_smooth = 10.0;                       // second difference of the change of style
  double smooth_from = 0.2, smooth_full = 0.3;  // share of the run over which it is ramped in
  // What the paper's ablations leave out (besides losses, by their weights).
  bool attention = true;        // false: a plain multi-class discriminator
  bool learned_states = true;   // false: recurrent states start at zero
  bool judge_published = true;  // judges see the detail-preserving output; false: the absolute one
  bool judge_root = true;       // velocities that judges see include the path of the hips

  int penalty_every =
      1;                 // the critic's gradient penalty every so many iterations, as much stronger
  int critic_first = 0;  // iterations in which only the critic learns, for a run with `init`

  int classifier_iterations = 1500;
  double checkpoint_minutes = 5.0;
  int log_every = 100, monitor_every = 500;
  double validate_minutes = 10.0;  // between validations, if there are any
  int patience = 0;  // the run ends after so many validations without a better score; 0: never
};

// Named figures of a weights file; the first is the score, higher is better.
using Validate = std::function<Result<std::vector<std::pair<std::string, double>>>(
    const std::filesystem::path& weights)>;

// Trains until minutes or iterations are over. Writes into `out`: checkpoint.pt (replaced
// atomically), weights.safetensors (running mean, at every checkpoint), log.csv, monitor.csv.
// With `validate`, also validation.csv and its picture curve.svg, and best.safetensors, the weights
// of the best score so far.
// A resumed run continues bit for bit where the checkpoint was made, given the same flags.
Status Train(const TrainConfig& config, const Validate& validate = nullptr);

// Writes the weights of a run's checkpoint (model/net/erd/FORMAT.md).
Status ExportRun(const std::filesystem::path& run, const std::filesystem::path& file);

}  // namespace styled::train

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/train/flags.h"

namespace styled::train::st_gcn_causal {

// The flags of styletrain that only this family has. Defaults are for minutes on one CPU core.
struct Config {
  std::filesystem::path init;  // weights of family st-gcn: the teacher, and where a run starts

  // The data.
  int hop = 4;           // frames between the starts of two windows of a clip
  bool mirror = true;    // half of all windows are mirror images
  double neutral = 0.5;  // share of the sources that is neutral, beyond those by chance
  // Share of the sources of any content; the others have one in which the target was recorded.
  double unpaired = 0.5;
  // Share of the targets whose strength is drawn from 0 to the most that is allowed live, 1.5; that
  // of the others is 1.
  double varied = 0.2;
  // Share of the targets that are single examples or noises of their style instead of its mean; and
  // how many of each style these are drawn from.
  double single = 0.5;
  int single_codes = 128;

  // The targets' relation to the teacher's change of style: so much later, because the stylist's
  // low-pass publishes late, and larger by this factor, because averaging by the student and the
  // low-pass both reduce it.
  double lead_s = 0;
  double gain = 1;

  // The order of work.
  std::string precision = "auto";  // of activations: "fp32", "bf16", or bf16 where it is fast
  int batch = 8;
  int start_windows = 512;  // that the start of the statistics is measured on; 0: mean 0, square 1

  // The optimizer (Adam), whose rate falls quadratically to decay_to of its start.
  double generator_rate = 4e-4;
  double beta1 = 0.9, beta2 = 0.99;
  double decay_to = 0.1;
  double ema = 0.999;  // of the weights that are exported, per iteration; 0: those of the moment

  // Weights of the losses: of the differences from frame to frame, relative to 1 for the distance
  // to the teacher's output; and of a window's first 8 frames, relative to 1 for the others.
  double w_velocity = 3;
  double w_first = 0.5;
  double w_smooth = 0;  // of the squared second difference of the student's change of style
};

// A flag for each member of `config`, which must outlive the rows.
std::vector<FlagGroup> FlagsOf(Config& config);

// Refuses values outside their ranges, and a run without --init. Errors name the flag.
Status Check(const Config& config);

}  // namespace styled::train::st_gcn_causal

#include "model/train/stgcn_causal/config.h"

namespace styled::train::st_gcn_causal {

std::vector<FlagGroup> FlagsOf(Config& c) {
  using enum Range;
  return {
      {"Start",
       {
           {"--init", &c.init, kAny, "Weights of family st-gcn to learn from"},
           {"--start-windows", &c.start_windows, kAtLeast0,
            "Windows that the start of the statistics is measured on; 0: mean 0, square 1"},
       }},
      {"Data",
       {
           {"--hop", &c.hop, kAtLeast1, "Frames between the starts of two windows of a clip"},
           {"--mirror", &c.mirror, kAny, "1: half of the windows are mirror images"},
           {"--neutral", &c.neutral, k0To1,
            "Share of the sources that is neutral, beyond those by chance"},
           {"--unpaired", &c.unpaired, k0To1,
            "Share of sources of any content, recorded in their target style or not"},
           {"--varied", &c.varied, k0To1, "Share of targets of a strength from 0 to 1.5, not 1"},
           {"--single", &c.single, k0To1,
            "Share of targets that are a single example or noise, not their style's mean"},
           {"--single-codes", &c.single_codes, kAtLeast1,
            "Examples and noises of each style that those are drawn from"},
           {"--lead", &c.lead_s, kAny,
            "Seconds that the target's change of style is later, as the low-pass is late"},
           {"--gain", &c.gain, kAtLeast0,
            "How many times as large as the teacher's that change is"},
       }},
      {"Network",
       {
           {"--precision",
            &c.precision,
            kAny,
            "Of activations; auto: bf16 where it is fast",
            {"auto", "fp32", "bf16"}},
       }},
      {"Schedule",
       {
           {"--batch", &c.batch, kAtLeast1, "Windows in a batch"},
           {"--generator-rate", &c.generator_rate, kAtLeast0, "Learning rate at the start (Adam)"},
           {"--beta1", &c.beta1, k0To1, "Adam's decay of the mean gradient, per iteration"},
           {"--beta2", &c.beta2, k0To1, "Adam's decay of the squared gradient, per iteration"},
           {"--decay-to", &c.decay_to, k0To1,
            "Share of the learning rate that is left at the end; it falls quadratically"},
           {"--ema", &c.ema, k0To1,
            "Share of the running mean of the weights, which is exported, that an iteration keeps; "
            "0: the weights of the moment"},
       }},
      {"Losses",
       {
           {"--w-velocity", &c.w_velocity, kAtLeast0,
            "Of differences from frame to frame, beside 1 of the features"},
           {"--w-first", &c.w_first, k0To1,
            "Of the first 8 frames of a window, beside 1 of the others"},
           {"--w-smooth", &c.w_smooth, kAtLeast0,
            "Of the squared second difference of the change of style"},
       }},
  };
}

Status Check(const Config& config) {
  if (config.init.empty()) {
    return Status::Error("--init is needed, the weights of family st-gcn to learn from");
  }
  constexpr double kMostLead_s = 0.5;  // the student sees no later frames
  if (!(config.lead_s >= 0 && config.lead_s <= kMostLead_s)) {
    return RefuseNumber("--lead", config.lead_s, "seconds from 0 to 0.5");
  }
  Config copy = config;
  return CheckRanges(FlagsOf(copy));
}

}  // namespace styled::train::st_gcn_causal

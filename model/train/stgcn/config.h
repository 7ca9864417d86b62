#pragma once

#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/train/flags.h"

namespace styled::train::st_gcn {

// The flags of styletrain that only this family has. Defaults are for hours on one CPU core;
// AsInThePaper has the authors' own. Figures behind them are in model/train/README.md.
struct Config {
  // The data.
  double heading_tau_s = 0.25;   // time constant of the heading filter; the runtime's is the same
  int hop = 4;                   // frames between the starts of two windows of a clip
  bool mirror = true;            // half of all windows are mirror images
  int fewest_frames = 32;        // of a clip; the rest of a window repeats its ends
  bool floor_deviations = true;  // ComputeStatistics
  bool even_contents = true;     // within a domain; otherwise all its windows are as likely
  // Source and target domain share the source's content, so that the critic compares motions of one
  // kind; otherwise contents are drawn independently. `unpaired`: the share of sources that may
  // have any content nevertheless, which the critic does not see.
  bool shared_contents = true;
  double unpaired = 0.1;

  // The networks.
  int width = 32;  // channels of the finest level; a multiple of 16 up to 96
  bool node_bias = true;
  std::string normalization = "neighbours";  // of a graph convolution, or "subset": stgcn/graph.h
  bool content_critic = true;      // the critic also says whether the content is the source's
  bool critic_layer = false;       // a last layer of the critic, from domains to domains
  bool scaled_heads = true;        // smaller first outputs, else the critic wins at once
  std::string precision = "auto";  // of activations: "fp32", "bf16", or bf16 where it is fast

  // The order of work.
  int batch = 8;
  int warm_up = 1000;       // iterations of identity alone at the start of a run
  bool both_turns = false;  // noise and references in every iteration, else in turn
  bool encoder_learns_from_references = true;  // in their turn; else from noise's alone
  bool same_clip = true;  // identity and cycle take the code of another window of the clip

  // The optimizers (Adam), whose rates fall quadratically to decay_to of their start.
  double generator_rate = 6e-4, critic_rate = 6e-4, encoder_rate = 3e-4, mapping_rate = 2e-4;
  double warm_up_rate = 2e-3;
  double beta1 = 0.5, beta2 = 0.99, weight_decay = 1e-4;
  double decay_to = 0.2;
  double ema = 0.999;  // of the weights that are exported, per iteration; 0: those of the moment

  // The losses of a window that was made see it as published, and not as decoded: rotations of
  // length 1, and the positions that follow from them. Identity always sees it as decoded.
  bool judge_published = true;

  // Weights of the losses.
  double w_adversarial = 1, w_cycle = 1, w_identity = 1, w_style = 1;
  double w_penalty = 1;    // R1
  int penalty_every = 4;   // iterations; as much stronger
  double w_diversity = 1;  // at first
  // Mean joint distance between two outputs of a source and domain that the weight of diversity is
  // steered to, separately for noise and references; 0: the weight is constant.
  double diversity_target_cm = 3;
  double w_fk = 1;    // of the positions' distance to those that follow from the rotations
  double w_free = 1;  // of the head for windows without a label
  bool free_head_teaches = true;  // its gradient reaches the layers below
  double w_smooth = 0;            // of the third difference of the change of style, cm per frame³
  // Of the mean pose over a window: in the turn of references its target is the target's cell of
  // this content, plus the reference's own deviation (postures.h).
  double w_posture = 0;
  // Of learning postures from examples without a label: another window of the source's clip is
  // shifted to a random new posture, and the source should be decoded in that posture.
  double w_read = 0;
};

// The settings of Park et al. 2021, and where the paper has none, those of their published code.
// model/net/stgcn/FORMAT.md lists every difference, also those that remain.
void AsInThePaper(Config& config);

// A flag for each member of `config`, which must outlive the rows.
std::vector<FlagGroup> FlagsOf(Config& config);

// Refuses values outside their ranges. Errors name the flag.
Status Check(const Config& config);

}  // namespace styled::train::st_gcn

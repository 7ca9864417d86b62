#include "model/train/stgcn/config.h"

#include "model/net/stgcn/network.h"

namespace styled::train::st_gcn {

void AsInThePaper(Config& config) {
  config.hop = 32;
  config.fewest_frames = 8;
  config.floor_deviations = config.even_contents = config.shared_contents = false;
  config.width = 64;
  config.normalization = "subset";
  config.critic_layer = true;
  config.node_bias = config.content_critic = config.scaled_heads = false;
  config.judge_published = false;
  config.precision = "fp32";
  config.warm_up = 0;
  config.both_turns = true;
  config.encoder_learns_from_references = config.same_clip = config.free_head_teaches = false;
  config.generator_rate = 1e-4;
  config.critic_rate = config.encoder_rate = 1e-6;
  config.mapping_rate = 1e-5;
  config.beta1 = 0.9;
  config.decay_to = 1;
  config.ema = 0;
  config.penalty_every = 1;
  config.w_adversarial = config.w_cycle = config.w_identity = config.w_style = 1;
  config.w_penalty = config.w_diversity = 1;
  config.diversity_target_cm = config.w_fk = config.w_smooth = 0;
  config.w_posture = config.w_read = 0;
}

std::vector<FlagGroup> FlagsOf(Config& c) {
  using enum Range;
  return {
      {"Data",
       {
           {"--heading-tau", &c.heading_tau_s, kAtLeast0, "Time constant of the heading filter, s"},
           {"--hop", &c.hop, kAtLeast1, "Frames between the starts of two windows of a clip"},
           {"--mirror", &c.mirror, kAny, "1: half of the windows are mirror images"},
           {"--fewest-frames", &c.fewest_frames, kAtLeast1,
            "Frames of the shortest clip; the rest of a window repeats its ends"},
           {"--floor-deviations", &c.floor_deviations, kAny,
            "1: features are standardized by 2 cm or 0.05 at least"},
           {"--even-contents", &c.even_contents, kAny,
            "1: contents of a domain are drawn alike; 0: its windows are"},
           {"--shared-contents", &c.shared_contents, kAny,
            "1: sources have a content in which the target domain was recorded"},
           {"--unpaired", &c.unpaired, k0To1,
            "Share of sources of any content, which the critic does not see"},
       }},
      {"Network",
       {
           {"--width", &c.width, kAny, "Channels of the finest level, a multiple of 16 up to 96"},
           {"--node-bias", &c.node_bias, kAny, "1: every joint has a bias of its own"},
           {"--normalization",
            &c.normalization,
            kAny,
            "Divisor of a graph convolution: the number of neighbours, or of those in a subset",
            {"neighbours", "subset"}},
           {"--critic-layer", &c.critic_layer, kAny,
            "1: the critic ends in a layer from all domains' outputs to as many"},
           {"--content-critic", &c.content_critic, kAny,
            "1: the critic also says whether the content is the source's"},
           {"--scaled-heads", &c.scaled_heads, kAny,
            "1: smaller outputs at first, else the critic wins at once"},
           {"--precision",
            &c.precision,
            kAny,
            "Of activations; auto: bf16 where it is fast",
            {"auto", "fp32", "bf16"}},
       }},
      {"Schedule",
       {
           {"--batch", &c.batch, kAtLeast1, "Windows in a batch"},
           {"--warm-up", &c.warm_up, kAtLeast0, "Iterations of identity alone"},
           {"--both-turns", &c.both_turns, kAny,
            "1: noise and references in every iteration, 0: in turn"},
           {"--encoder-learns-from-references", &c.encoder_learns_from_references, kAny,
            "1: the style encoder learns in their turn, too; 0: from noise's alone"},
           {"--same-clip", &c.same_clip, kAny,
            "1: identity takes the code of another window of the clip"},
           {"--generator-rate", &c.generator_rate, kAtLeast0,
            "Learning rate of the generator at the start (Adam)"},
           {"--critic-rate", &c.critic_rate, kAtLeast0, "The same of the critic"},
           {"--encoder-rate", &c.encoder_rate, kAtLeast0, "The same of the style encoder"},
           {"--mapping-rate", &c.mapping_rate, kAtLeast0, "The same of the mapping network"},
           {"--warm-up-rate", &c.warm_up_rate, kAtLeast0, "Of all of them during the warm-up"},
           {"--beta1", &c.beta1, k0To1, "Adam's decay of the mean gradient, per iteration"},
           {"--beta2", &c.beta2, k0To1, "Adam's decay of the squared gradient, per iteration"},
           {"--weight-decay", &c.weight_decay, kAtLeast0, "Adam's decay of the weights"},
           {"--decay-to", &c.decay_to, k0To1,
            "Share of the learning rates that is left at the end; they fall quadratically"},
           {"--ema", &c.ema, k0To1,
            "Share of the running mean of the weights, which is exported, that an iteration keeps; "
            "0: the weights of the moment"},
       }},
      {"Losses",
       {
           {"--judge-published", &c.judge_published, kAny,
            "1: critic, cycle, style and diversity see windows as published; 0: as decoded"},
           {"--w-adversarial", &c.w_adversarial, kAtLeast0, "Weight of the critic"},
           {"--w-cycle", &c.w_cycle, kAtLeast0, "Of the way to another style and back"},
           {"--w-identity", &c.w_identity, kAtLeast0, "Of a window decoded in its own style"},
           {"--w-style", &c.w_style, kAtLeast0, "Of the style code, read again off the output"},
           {"--w-penalty", &c.w_penalty, kAtLeast0, "Of the critic's gradient penalty, R1"},
           {"--penalty-every", &c.penalty_every, kAtLeast1,
            "Gradient penalty every so many iterations, as much stronger"},
           {"--w-diversity", &c.w_diversity, kAtLeast0,
            "Of the distance of two outputs of one source, at first"},
           {"--diversity-target", &c.diversity_target_cm, kAtLeast0,
            "Distance of two outputs, cm, that its weight is steered to; 0: constant"},
           {"--w-fk", &c.w_fk, kAtLeast0,
            "Of positions' distance to those that follow from the rotations"},
           {"--w-free", &c.w_free, kAtLeast0, "Of the encoder's head for clips without a label"},
           {"--free-head-teaches", &c.free_head_teaches, kAny,
            "1: its gradient reaches the layers below"},
           {"--w-smooth", &c.w_smooth, kAtLeast0,
            "Of the third difference of what a style changes, cm per frame3"},
           {"--w-posture", &c.w_posture, kAtLeast0,
            "Of the mean pose over a window, toward that of the target in this content"},
           {"--w-read", &c.w_read, kAtLeast0,
            "Of postures that are read off examples without a label"},
       }},
  };
}

Status Check(const Config& config) {
  using stgcn::kMaxWidth, stgcn::kWidthStep;
  if (config.width < kWidthStep || config.width > kMaxWidth || config.width % kWidthStep != 0) {
    return RefuseNumber(
        "--width", config.width,
        "a multiple of " + std::to_string(kWidthStep) + " up to " + std::to_string(kMaxWidth));
  }
  if (!config.even_contents && config.shared_contents) {
    return Status::Error("--even-contents 0: expected --shared-contents 0, too");
  }
  Config copy = config;
  return CheckRanges(FlagsOf(copy));
}

}  // namespace styled::train::st_gcn

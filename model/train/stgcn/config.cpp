#include "model/train/stgcn/config.h"

#include <cmath>
#include <utility>

#include "model/base/text.h"
#include "model/net/stgcn/network.h"

namespace styled::train::st_gcn {

void AsInThePaper(Config& config) {
  config.hop = 32;
  config.shared_contents = false;
  config.width = 64;
  config.node_bias = config.content_critic = config.scaled_heads = false;
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

Status Check(const Config& config) {
  const auto refuse = [](const char* flag, double found, const char* expected) {
    return Status::Error(std::string(flag) + ": found " + NumberText(found) + ", expected " +
                         expected);
  };
  using stgcn::kMaxWidth, stgcn::kWidthStep;
  if (config.width < kWidthStep || config.width > kMaxWidth || config.width % kWidthStep != 0) {
    const std::string expected =
        "a multiple of " + std::to_string(kWidthStep) + " up to " + std::to_string(kMaxWidth);
    return refuse("--width", config.width, expected.c_str());
  }
  for (const auto& [flag, value] : {std::pair{"--hop", config.hop},
                                    {"--batch", config.batch},
                                    {"--penalty-every", config.penalty_every}}) {
    if (value < 1) return refuse(flag, value, "1 or more");
  }
  if (config.warm_up < 0) return refuse("--warm-up", config.warm_up, "0 or more");
  const std::pair<const char*, double> shares[] = {{"--unpaired", config.unpaired},
                                                   {"--beta1", config.beta1},
                                                   {"--beta2", config.beta2},
                                                   {"--decay-to", config.decay_to},
                                                   {"--ema", config.ema}};
  for (const auto& [flag, value] : shares) {
    if (!(value >= 0 && value <= 1)) return refuse(flag, value, "a number from 0 to 1");
  }
  const std::pair<const char*, double> not_negative[] = {
      {"--heading-tau", config.heading_tau_s},
      {"--generator-rate", config.generator_rate},
      {"--critic-rate", config.critic_rate},
      {"--encoder-rate", config.encoder_rate},
      {"--mapping-rate", config.mapping_rate},
      {"--warm-up-rate", config.warm_up_rate},
      {"--weight-decay", config.weight_decay},
      {"--w-adversarial", config.w_adversarial},
      {"--w-cycle", config.w_cycle},
      {"--w-identity", config.w_identity},
      {"--w-style", config.w_style},
      {"--w-penalty", config.w_penalty},
      {"--w-diversity", config.w_diversity},
      {"--diversity-target", config.diversity_target_cm},
      {"--w-fk", config.w_fk},
      {"--w-free", config.w_free},
      {"--w-smooth", config.w_smooth},
      {"--w-posture", config.w_posture},
      {"--w-read", config.w_read}};
  for (const auto& [flag, value] : not_negative) {
    if (!(value >= 0 && std::isfinite(value))) return refuse(flag, value, "a number, 0 or more");
  }
  return Status::Ok();
}

}  // namespace styled::train::st_gcn

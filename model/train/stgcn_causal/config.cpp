#include "model/train/stgcn_causal/config.h"

#include <cmath>
#include <utility>

#include "model/base/text.h"

namespace styled::train::st_gcn_causal {

Status Check(const Config& config) {
  const auto refuse = [](const char* flag, double found, const char* expected) {
    return Status::Error(std::string(flag) + ": found " + NumberText(found) + ", expected " +
                         expected);
  };
  if (config.init.empty()) {
    return Status::Error("--init is needed, the weights of family st-gcn to learn from");
  }
  for (const auto& [flag, value] : {std::pair{"--hop", config.hop},
                                    {"--batch", config.batch},
                                    {"--single-codes", config.single_codes}}) {
    if (value < 1) return refuse(flag, value, "1 or more");
  }
  if (config.start_windows < 0) {
    return refuse("--start-windows", config.start_windows, "0 or more");
  }
  const std::pair<const char*, double> shares[] = {
      {"--neutral", config.neutral},   {"--unpaired", config.unpaired},
      {"--varied", config.varied},     {"--single", config.single},
      {"--beta1", config.beta1},       {"--beta2", config.beta2},
      {"--decay-to", config.decay_to}, {"--ema", config.ema},
      {"--w-first", config.w_first}};
  for (const auto& [flag, value] : shares) {
    if (!(value >= 0 && value <= 1)) return refuse(flag, value, "a number from 0 to 1");
  }
  constexpr double kMostLead_s = 0.5;  // the student sees no future frames
  if (!(config.lead_s >= 0 && config.lead_s <= kMostLead_s)) {
    return refuse("--lead", config.lead_s, "seconds from 0 to 0.5");
  }
  const std::pair<const char*, double> not_negative[] = {
      {"--generator-rate", config.generator_rate},
      {"--w-velocity", config.w_velocity},
      {"--w-smooth", config.w_smooth},
      {"--gain", config.gain}};
  for (const auto& [flag, value] : not_negative) {
    if (!(value >= 0 && std::isfinite(value))) return refuse(flag, value, "a number, 0 or more");
  }
  return Status::Ok();
}

}  // namespace styled::train::st_gcn_causal

#include "model/train/erd/config.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/base/text.h"

namespace styled::train::style_erd {

Status Check(const Config& config) {
  if (config.window < 4 || config.per_style < 1 || config.rate_hz <= 0) {
    return Status::Error("--window must be at least 4, --per-style 1, --rate above 0");
  }
  if (config.wide && !config.init.empty()) {
    return Status::Error("--wide: the weights of --init have a shape of their own");
  }
  if (!(config.idle >= 0 && config.idle < 1) || (config.idle > 0 && config.teachers.empty())) {
    return Status::Error("--idle: found " + NumberText(config.idle) +
                         ", expected 0, or below 1 and a --teacher");
  }
  if (!(config.unpaired >= 0 && config.unpaired <= 1)) {
    return Status::Error("--unpaired: found " + NumberText(config.unpaired) +
                         ", expected a share, 0 to 1");
  }
  if (!config.idle_contents.empty() && config.idle <= 0) {
    return Status::Error("--idle-content needs --idle");
  }
  if (!config.kept_contents.empty() && config.teachers.empty()) {
    return Status::Error("--keep-content needs a --teacher");
  }
  const auto named = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const std::string& name : config.idle_contents) {
    if (name == config.idle_as || named(config.kept_contents, name)) {
      return Status::Error("--idle-content " + name +
                           ": --idle-as or --keep-content names it, too");
    }
  }
  const std::pair<const char*, double> not_negative[] = {
      {"--rate", config.rate_hz},
      {"--heading-tau", config.heading_tau_s},
      {"--carry", config.carry},
      {"--session-start", config.session_start},
      {"--offset", config.offset},
      {"--noise", config.noise},
      {"--miscalibrated", config.miscalibrated},
      {"--generator-rate", config.generator_rate},
      {"--critic-rate", config.critic_rate},
      {"--decay-from", config.decay_from},
      {"--decay-to", config.decay_to},
      {"--beta1", config.beta1},
      {"--beta2", config.beta2},
      {"--ema", config.ema},
      {"--smooth-from", config.smooth_from},
      {"--smooth-full", config.smooth_full},
      {"--w-rotation", config.w_rotation},
      {"--w-position", config.w_position},
      {"--w-velocity", config.w_velocity},
      {"--w-height", config.w_height},
      {"--w-adversarial", config.w_adversarial},
      {"--w-movement", config.w_movement},
      {"--w-legs", config.w_legs},
      {"--w-perceptual", config.w_perceptual},
      {"--w-penalty", config.w_penalty},
      {"--w-moments", config.w_moments},
      {"--teacher-lead", config.teacher_lead_s},
      {"--w-teacher", config.w_teacher},
      {"--w-teacher-position", config.w_teacher_position},
      {"--w-teacher-velocity", config.w_teacher_velocity},
      {"--w-smooth", config.w_smooth}};
  for (const auto& [flag, value] : not_negative) {
    if (!(value >= 0 && std::isfinite(value))) {
      return Status::Error(std::string(flag) + ": found " + NumberText(value) +
                           ", expected a number, 0 or more");
    }
  }
  return Status::Ok();
}

}  // namespace styled::train::style_erd

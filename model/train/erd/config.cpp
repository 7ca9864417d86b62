#include "model/train/erd/config.h"

#include <algorithm>

namespace styled::train::style_erd {

std::vector<FlagGroup> FlagsOf(Config& c) {
  using enum Range;
  return {
      {"Start",
       {
           {"--init", &c.init, kAny, "Weights to start from; styles are matched by name"},
           {"--teacher", &c.teachers, kAny,
            "Weights whose changes of style are imitated, as FILE or "
            "FILE:STYLE[/CONTENT][*GAIN],...; repeatable, later ones win"},
           {"--idle-content", &c.idle_contents, kAny,
            "A content in which performers idle; taught like idle postures; repeatable"},
           {"--keep-content", &c.kept_contents, kAny,
            "A content that no style was recorded in: stays as it is; repeatable"},
           {"--teacher-lead", &c.teacher_lead_s, kAtLeast0,
            "Seconds by which the student is ahead of a teacher that sees whole clips"},
           {"--idle", &c.idle, kAny,
            "Share of neutral windows with an idle posture; needs --teacher"},
           {"--idle-as", &c.idle_as, kAny,
            "Content whose mean change of style is the target there"},
       }},
      {"Data",
       {
           {"--rate", &c.rate_hz, kAtLeast0, "The network's rate, Hz; clips are resampled to it"},
           {"--heading-tau", &c.heading_tau_s, kAtLeast0, "Time constant of the heading filter, s"},
           {"--window", &c.window, kAny, "Length of a window, frames; at least 4"},
           {"--per-style", &c.per_style, kAny,
            "Number of windows of each style in a batch, and of neutral windows for it"},
           {"--carry", &c.carry, kAtLeast0,
            "Share of windows that start from the states at the end of the one before"},
           {"--session-start", &c.session_start, kAtLeast0,
            "Share of the others that begin as a new session, without a past"},
           {"--unpaired", &c.unpaired, k0To1,
            "Share of neutral windows of any content, recorded in their target style or not"},
           {"--pairs", &c.pairs, kAny,
            "Above 0: a batch is so many pairs of a neutral and a styled window of one content, "
            "and "
            "--per-style does not apply"},
           {"--offset", &c.offset, kAtLeast0,
            "Constant disturbance of a window's features, in deviations of each"},
           {"--noise", &c.noise, kAtLeast0,
            "Disturbance of each frame's features, in deviations of each"},
           {"--miscalibrated", &c.miscalibrated, kAtLeast0,
            "Share of windows with wrong rest poses and a wrong floor"},
       }},
      {"Schedule",
       {
           {"--generator-rate", &c.generator_rate, kAtLeast0,
            "Learning rate of the generator at the start (Adam)"},
           {"--critic-rate", &c.critic_rate, kAtLeast0, "The same of the critics"},
           {"--beta1", &c.beta1, kAtLeast0, "Adam's decay of the mean gradient, per iteration"},
           {"--beta2", &c.beta2, kAtLeast0, "Adam's decay of the squared gradient, per iteration"},
           {"--decay-from", &c.decay_from, kAtLeast0,
            "Share of the run from which the learning rates fall"},
           {"--decay-to", &c.decay_to, kAtLeast0, "Share of them that is left at the end"},
           {"--ema", &c.ema, kAtLeast0,
            "Share of the running mean of the weights, which is exported, that an iteration keeps"},
           {"--penalty-every", &c.penalty_every, kAtLeast1,
            "Gradient penalty every so many iterations, as much stronger"},
           {"--critic-first", &c.critic_first, kAny,
            "Iterations in which only the critic learns (with --init)"},
           {"--classifier-iterations", &c.classifier_iterations, kAny,
            "Iterations of the classifier of contents, before the first of the run"},
       }},
      {"Losses",
       {
           {"--summed", &c.summed, kAny,
            "1: the reconstruction is eq. 3 as it stands, summed over joints and frames, without "
            "the three weights that follow"},
           {"--w-rotation", &c.w_rotation, kAtLeast0,
            "Weight of the reconstruction's rotations: eq. 2, summed over joints and frames"},
           {"--w-position", &c.w_position, kAtLeast0,
            "Of the positions that follow: mean squared distance, m2 (eq. 3)"},
           {"--w-velocity", &c.w_velocity, kAtLeast0,
            "Of the head of velocities: mean square, standardized"},
           {"--w-height", &c.w_height, kAtLeast0,
            "Of the head of the hips' height: mean square, standardized"},
           {"--w-adversarial", &c.w_adversarial, kAtLeast0,
            "Of the critic of style and content; 0: no critic"},
           {"--w-perceptual", &c.w_perceptual, kAtLeast0,
            "Of the classifier's features, which keep the content"},
           {"--w-penalty", &c.w_penalty, kAtLeast0, "Of the critic's gradient penalty (eq. 6)"},
           {"--w-moments", &c.w_moments, kAtLeast0,
            "Of the distance of each style's mean effect from that in the clips, m2"},
           {"--w-teacher", &c.w_teacher, kAtLeast0,
            "Of the rotations of what a teacher does, as in eq. 2"},
           {"--w-teacher-position", &c.w_teacher_position, kAtLeast0,
            "Of the positions that follow from it, m2"},
           {"--w-teacher-velocity", &c.w_teacher_velocity, kAtLeast0,
            "Of their velocities, (m/s)2"},
           {"--w-smooth", &c.w_smooth, kAtLeast0,
            "Of the second difference of the change of style: less jerk, less expression"},
           {"--smooth-from", &c.smooth_from, kAtLeast0,
            "Share of the run from which --w-smooth is raised from 0"},
           {"--smooth-full", &c.smooth_full, kAtLeast0, "Share of the run from which it is full"},
       }},
      {"Network",
       {
           {"--wide", &c.wide, kAny, "1: a network of twice the paper's widths"},
           {"--content-input", &c.content_input, kAny,
            "1: the network also takes the content, recognized in live streams"},
           {"--content-label", &c.content_label, k0To1,
            "Share of windows that it gets with their label"},
           {"--content-unknown", &c.content_unknown, k0To1,
            "Share that it gets as unknown; in the others the content is what the recognizer "
            "finds"},
           {"--content-rise", &c.content_rise_s, kAtLeast0,
            "Seconds in which a recognized content becomes certain"},
           {"--attention", &c.attention, kAny, "0: a plain multi-class discriminator (ablation)"},
           {"--learned-states", &c.learned_states, kAny,
            "0: recurrent states start at zero (ablation)"},
           {"--judge-published", &c.judge_published, kAny,
            "1: judges see the detail-preserving output, 0: the absolute one"},
       }},
  };
}

void AsInThePaper(Config& config) {
  config.content_input = true;
  config.content_label = 1;
  config.content_unknown = 0;
  config.rate_hz = 60;
  config.window = 24;
  config.pairs = 8;  // batch 16
  config.carry = config.session_start = config.unpaired = 0;
  config.offset = config.noise = config.miscalibrated = config.idle = 0;
  config.generator_rate = 1e-4;
  config.critic_rate = 5e-5;
  config.beta1 = 0.9;  // those of PyTorch
  config.beta2 = 0.999;
  config.decay_to = 1;
  config.ema = 0;
  config.summed = true;
  config.w_adversarial = 1;
  config.w_perceptual = 0.1;
  config.w_penalty = 128;
  config.penalty_every = 1;
  config.w_moments = config.w_smooth = 0;
  config.attention = config.learned_states = true;
  config.judge_published = false;
}

Status Check(const Config& config) {
  if (config.window < 4 || config.per_style < 1 || config.rate_hz <= 0) {
    return Status::Error("--window must be at least 4, --per-style 1, --rate above 0");
  }
  if (config.wide && !config.init.empty()) {
    return Status::Error("--wide: the weights of --init have a shape of their own");
  }
  if (!(config.idle >= 0 && config.idle < 1) || (config.idle > 0 && config.teachers.empty())) {
    return RefuseNumber("--idle", config.idle, "0, or below 1 and a --teacher");
  }
  if (!config.idle_contents.empty() && config.idle <= 0) {
    return Status::Error("--idle-content needs --idle");
  }
  if (!config.kept_contents.empty() && config.teachers.empty()) {
    return Status::Error("--keep-content needs a --teacher");
  }
  if (config.content_label + config.content_unknown > 1) {
    return RefuseNumber("--content-unknown", config.content_unknown,
                        "at most 1 together with --content-label");
  }
  if (config.pairs < 0 || (config.pairs > 0 && config.carry > 0)) {
    return Status::Error("--pairs: at least 0, and above 0 only with --carry 0");
  }
  if (config.pairs > 0 && !config.teachers.empty()) {
    return Status::Error("--pairs: a --teacher needs batches without it");
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
  Config copy = config;
  return CheckRanges(FlagsOf(copy));
}

}  // namespace styled::train::style_erd

// The flags of styletrain for Style-ERD.
#include <algorithm>
#include <utility>

#include "model/tools/train_family.h"
#include "model/train/erd/lessons.h"
#include "model/train/erd/recipe.h"

namespace styled::train {
namespace {

// The start of a run, and its teachers.
void AddStartFlags(CLI::App& app, style_erd::Config& config) {
  app.option_defaults()->group("Start");
  app.add_option("--init", config.init, "Weights to start from; styles are matched by name");
  app.add_option("--teacher", config.teachers,
                 "Weights whose changes of style are imitated, as FILE or "
                 "FILE:STYLE[/CONTENT][*GAIN],...; repeatable, later ones win");
  app.add_option("--idle-content", config.idle_contents,
                 "A content in which performers idle; taught like idle postures; repeatable");
  app.add_option("--keep-content", config.kept_contents,
                 "A content that no style was recorded in: stays as it is; repeatable");
  app.add_option("--teacher-lead", config.teacher_lead_s,
                 "Seconds by which the student is ahead of a teacher that sees whole clips")
      ->capture_default_str();
  app.add_option("--idle", config.idle,
                 "Share of neutral windows with an idle posture; needs --teacher")
      ->capture_default_str();
  app.add_option("--idle-as", config.idle_as,
                 "Content whose mean change of style is the target there")
      ->capture_default_str();
}

// Windows and their perturbations.
void AddDataFlags(CLI::App& app, style_erd::Config& config) {
  app.option_defaults()->group("Data");
  app.add_option("--rate", config.rate_hz, "The network's rate, Hz; clips are resampled to it")
      ->capture_default_str();
  app.add_option("--heading-tau", config.heading_tau_s, "Time constant of the heading filter, s")
      ->capture_default_str();
  app.add_option("--window", config.window, "Length of a window, frames; at least 4")
      ->capture_default_str();
  app.add_option("--per-style", config.per_style,
                 "Windows in a batch, of each style, and as many neutral ones for it")
      ->capture_default_str();
  app.add_option("--carry", config.carry,
                 "Share of windows that start from the states at the end of the one before")
      ->capture_default_str();
  app.add_option("--session-start", config.session_start,
                 "Share of the others that begin as a new session, without a past")
      ->capture_default_str();
  app.add_option(
         "--unpaired", config.unpaired,
         "Share of neutral windows of any content, whether or not recorded in their target style")
      ->capture_default_str();
  app.add_option("--offset", config.offset,
                 "Constant disturbance of a window's features, in deviations of each")
      ->capture_default_str();
  app.add_option("--noise", config.noise,
                 "Disturbance of each frame's features, in deviations of each")
      ->capture_default_str();
  app.add_option("--miscalibrated", config.miscalibrated,
                 "Share of windows with wrong rest poses and a wrong floor")
      ->capture_default_str();
}

// Learning rates and schedules.
void AddOptimizerFlags(CLI::App& app, style_erd::Config& config) {
  app.option_defaults()->group("Schedule");
  app.add_option("--generator-rate", config.generator_rate,
                 "Learning rate of the generator at the start (Adam)")
      ->capture_default_str();
  app.add_option("--critic-rate", config.critic_rate, "The same of the critics")
      ->capture_default_str();
  app.add_option("--beta1", config.beta1, "Adam's decay of the mean gradient, per iteration")
      ->capture_default_str();
  app.add_option("--beta2", config.beta2, "Adam's decay of the squared gradient, per iteration")
      ->capture_default_str();
  app.add_option("--decay-from", config.decay_from,
                 "Share of the run from which the learning rates fall")
      ->capture_default_str();
  app.add_option("--decay-to", config.decay_to, "Share of them that is left at the end")
      ->capture_default_str();
  app.add_option("--ema", config.ema,
                 "Share of the running mean of the weights, which is exported, that an iteration "
                 "keeps")
      ->capture_default_str();
  app.add_option("--penalty-every", config.penalty_every,
                 "Gradient penalty every so many iterations, as much stronger")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--critic-first", config.critic_first,
                 "Iterations in which only the critic learns (with --init)")
      ->capture_default_str();
  app.add_option("--classifier-iterations", config.classifier_iterations,
                 "Iterations of the classifier of contents, before the first of the run")
      ->capture_default_str();
}

// Weights of the losses.
void AddLossFlags(CLI::App& app, style_erd::Config& config) {
  app.option_defaults()->group("Losses");
  app.add_option("--w-rotation", config.w_rotation,
                 "Weight of the reconstruction's rotations: eq. 2, summed over joints and frames")
      ->capture_default_str();
  app.add_option("--w-position", config.w_position,
                 "Weight of the positions that follow:  mean squared distance, m2 (eq. 3)")
      ->capture_default_str();
  app.add_option("--w-velocity", config.w_velocity,
                 "Of the head of velocities: mean square, standardized")
      ->capture_default_str();
  app.add_option("--w-height", config.w_height,
                 "Of the head of the hips' height: mean square, standardized")
      ->capture_default_str();
  app.add_option("--w-adversarial", config.w_adversarial,
                 "Of the critic of style and content; 0: no critic")
      ->capture_default_str();
  app.add_option("--w-movement", config.w_movement, "Of a critic of the movement alone")
      ->capture_default_str();
  app.add_option("--w-legs", config.w_legs, "Of a critic of the legs alone")->capture_default_str();
  app.add_option("--w-perceptual", config.w_perceptual,
                 "Of the classifier's features, which keep the content")
      ->capture_default_str();
  app.add_option("--w-penalty", config.w_penalty, "Of the critic's gradient penalty (eq. 6)")
      ->capture_default_str();
  app.add_option("--w-moments", config.w_moments,
                 "Of the distance of each style's mean effect from that in the clips, m2")
      ->capture_default_str();
  app.add_option("--w-teacher", config.w_teacher,
                 "Of the rotations of what a teacher does, as in eq. 2")
      ->capture_default_str();
  app.add_option("--w-teacher-position", config.w_teacher_position,
                 "Of the positions that follow from it, m2")
      ->capture_default_str();
  app.add_option("--w-teacher-velocity", config.w_teacher_velocity, "Of their velocities, (m/s)2")
      ->capture_default_str();
  app.add_option("--w-smooth", config.w_smooth,
                 "Of the second difference of the change of style: less jerk, less expression")
      ->capture_default_str();
  app.add_option("--smooth-from", config.smooth_from,
                 "Share of the run from which --w-smooth is raised from 0")
      ->capture_default_str();
  app.add_option("--smooth-full", config.smooth_full, "Share of the run from which it is full")
      ->capture_default_str();
}

// The shape of the network, and parts of the paper that an ablation leaves out.
void AddNetworkFlags(CLI::App& app, style_erd::Config& config) {
  app.option_defaults()->group("Network");
  app.add_option("--wide", config.wide, "1: a network of twice the paper's widths")
      ->capture_default_str();
  app.add_option("--attention", config.attention, "0: a plain multi-class discriminator (ablation)")
      ->capture_default_str();
  app.add_option("--learned-states", config.learned_states,
                 "0: recurrent states start at zero (ablation)")
      ->capture_default_str();
  app.add_option("--judge-published", config.judge_published,
                 "1: judges see the detail-preserving output, 0: the absolute one")
      ->capture_default_str();
  app.add_option("--judge-root", config.judge_root,
                 "1: judged velocities include the hips' path, 0: not")
      ->capture_default_str();
}

CLI::App* AddAddStyle(CLI::App& app, style_erd::Config& config) {
  app.option_defaults()->group("Options");
  CLI::App* add =
      app.add_subcommand("add-style", "Teach trained weights more styles")->fallthrough();
  add->footer(
      "styletrain add-style --name NAME --init WEIGHTS --manifest M.toml --data DIR --out RUN\n"
      "The manifest has the neutral style and NAME. All that WEIGHTS has is frozen and stays\n"
      "bit for bit the same. All other options of styletrain hold, but --per-style is 12; and "
      "without\n"
      "--replace --w-moments 200, --w-smooth 3, --w-penalty 60, --penalty-every 4, --decay-from "
      "0.5,\n"
      "--smooth-from 0 and --smooth-full 0.1, where you give no others.");
  add->add_option("--name", config.add_styles,
                  "The new style, as the manifest names it; repeatable")
      ->required();
  add->add_flag("--replace", config.replace,
                "NAME may be a style of WEIGHTS: its training continues");
  return add;
}

class StyleErdFlags : public FamilyFlags {
 public:
  explicit StyleErdFlags(CLI::App& app) {
    AddStartFlags(app, config_);
    AddDataFlags(app, config_);
    AddOptimizerFlags(app, config_);
    AddLossFlags(app, config_);
    AddNetworkFlags(app, config_);
    add_style_ = AddAddStyle(app, config_);
  }

  Status Resolve(const CLI::App& app) override {
    if (!add_style_->parsed()) return Status::Ok();
    if (config_.init.empty()) {  // before judges are trained for nothing
      return Status::Error("add-style: --init is needed, the weights to add to");
    }
    // The best settings of RESULTS.md ("A style added to frozen weights") for a style without
    // weights.
    const auto unless_given = [&app](const char* flag, auto& value, double of_added) {
      if (app.get_option(flag)->count() > 0) return;
      value = static_cast<std::decay_t<decltype(value)>>(of_added);
    };
    unless_given("--per-style", config_.per_style, 12);
    if (config_.replace) return Status::Ok();
    unless_given("--w-moments", config_.w_moments, 200);
    unless_given("--w-smooth", config_.w_smooth, 3);
    unless_given("--w-penalty", config_.w_penalty, 60);
    unless_given("--penalty-every", config_.penalty_every, 4);
    unless_given("--decay-from", config_.decay_from, 0.5);
    unless_given("--smooth-from", config_.smooth_from, 0);
    unless_given("--smooth-full", config_.smooth_full, 0.1);
    return Status::Ok();
  }

  Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run) const override {
    return style_erd::MakeRecipe(run, config_);
  }

  Needs RequiredInputs() const override {
    Needs needs;
    needs.rate_hz = config_.rate_hz;
    needs.train_frames = needs.window_frames = config_.window + 1;
    // Only a critic compares windows of one content.
    needs.paired = config_.w_adversarial > 0;
    if (!config_.init.empty()) needs.files.emplace_back("--init", config_.init);
    for (const std::string& text : config_.teachers) {
      const auto teacher = style_erd::ParseTeacher(text);
      if (teacher.ok()) needs.files.emplace_back("--teacher", teacher.value().weights);
    }
    return needs;
  }

  void ShortenStart() override {
    config_.classifier_iterations = std::min(config_.classifier_iterations, 20);
  }

 private:
  style_erd::Config config_;
  CLI::App* add_style_ = nullptr;
};

}  // namespace

std::unique_ptr<FamilyFlags> AddStyleErdFlags(CLI::App& app) {
  return std::make_unique<StyleErdFlags>(app);
}

}  // namespace styled::train

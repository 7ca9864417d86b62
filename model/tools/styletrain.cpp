// styletrain: trains the style network on a dataset manifest, or exports a run's weights.

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>
#include <string_view>

#include "model/train/blas.h"
#include "model/train/judge/judge_validation.h"
#include "model/train/trainer.h"

int main(int argc, char** argv) {
  styled::train::UseFastKernels(argv);
  styled::train::TrainConfig config;
  std::vector<std::string> export_paths;
  std::string validation_cache;
  const char* data = std::getenv("STYLED_DATA");
  config.data = data != nullptr ? data : "../shared/data";
  config.manifest = "model/weights/manifests/bandai-2.toml";
  // What the weights' metadata say, wherever this program and the data lie.
  config.command = "styletrain";
  for (int i = 1; i < argc; ++i) {
    const bool folder = std::string_view(argv[i - 1]) == "--data";
    config.command += std::string(" ") + (folder ? "DIR" : argv[i]);
  }

  CLI::App app{"Trains the style network of Style-ERD."};
  app.set_config("--config", "", "TOML file with any of these options");
  app.add_option("--export", export_paths, "RUN FILE: write the weights of a run and end")
      ->expected(2);
  app.add_option("--manifest", config.manifest, "Dataset manifest")->capture_default_str();
  app.add_option("--data", config.data, "Folder of the unpacked data (default $STYLED_DATA)")
      ->capture_default_str();
  app.add_option("--out", config.out, "Folder of the run");
  app.add_option("--init", config.init, "Weights to start from; styles are matched by name");
  app.add_option("--teacher", config.teachers,
                 "Weights whose changes of style are imitated, as FILE or "
                 "FILE:STYLE[/CONTENT][*GAIN],...; repeatable, later ones win");
  app.add_option("--minutes", config.minutes, "Length of the run in wall time, all resumes");
  app.add_option("--iterations", config.iterations, "Length of the run in iterations");
  app.add_option("--stop-at", config.stop_at, "End this session at an iteration; resume later");
  app.add_option("--seed", config.seed)->capture_default_str();
  app.add_flag("--resume", config.resume, "Continue the run in --out; give the same flags");
  app.add_option("--device", config.device)
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  app.add_option("--threads", config.threads)->capture_default_str();
  app.add_option("--rate", config.rate_hz, "The network's rate, Hz")->capture_default_str();
  app.add_option("--heading-tau", config.heading_tau_s, "Heading filter, s")->capture_default_str();
  app.add_option("--window", config.window, "Frames that are judged")->capture_default_str();
  app.add_option("--per-style", config.per_style, "Windows per style in a batch")
      ->capture_default_str();
  app.add_option("--carry", config.carry, "Share of windows that start with carried states")
      ->capture_default_str();
  app.add_option("--session-start", config.session_start)->capture_default_str();
  app.add_option("--offset", config.offset)->capture_default_str();
  app.add_option("--noise", config.noise)->capture_default_str();
  app.add_option("--miscalibrated", config.miscalibrated,
                 "Share of windows with wrong rest poses and floor")
      ->capture_default_str();
  app.add_option("--idle", config.idle,
                 "Share of neutral windows in which the performer just stands; needs --teacher")
      ->capture_default_str();
  app.add_option("--idle-as", config.idle_as, "Content whose mean change of style is taught there")
      ->capture_default_str();
  app.add_option("--generator-rate", config.generator_rate)->capture_default_str();
  app.add_option("--critic-rate", config.critic_rate)->capture_default_str();
  app.add_option("--beta1", config.beta1)->capture_default_str();
  app.add_option("--beta2", config.beta2)->capture_default_str();
  app.add_option("--decay-from", config.decay_from)->capture_default_str();
  app.add_option("--decay-to", config.decay_to)->capture_default_str();
  app.add_option("--ema", config.ema)->capture_default_str();
  app.add_option("--w-rotation", config.w_rotation)->capture_default_str();
  app.add_option("--w-position", config.w_position)->capture_default_str();
  app.add_option("--w-velocity", config.w_velocity)->capture_default_str();
  app.add_option("--w-height", config.w_height)->capture_default_str();
  app.add_option("--w-adversarial", config.w_adversarial)->capture_default_str();
  app.add_option("--w-perceptual", config.w_perceptual)->capture_default_str();
  app.add_option("--w-penalty", config.w_penalty)->capture_default_str();
  app.add_option("--w-moments", config.w_moments)->capture_default_str();
  app.add_option("--w-teacher", config.w_teacher)->capture_default_str();
  app.add_option("--w-smooth", config.w_smooth)->capture_default_str();
  app.add_option("--penalty-every", config.penalty_every,
                 "Gradient penalty every so many iterations, as much stronger")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--critic-first", config.critic_first,
                 "Iterations in which only the critic learns (with --init)")
      ->capture_default_str();
  app.add_option("--smooth-from", config.smooth_from)->capture_default_str();
  app.add_option("--smooth-full", config.smooth_full)->capture_default_str();
  app.add_option("--attention", config.attention, "0: a plain multi-class discriminator (ablation)")
      ->capture_default_str();
  app.add_option("--learned-states", config.learned_states,
                 "0: recurrent states start at zero (ablation)")
      ->capture_default_str();
  app.add_option("--judge-published", config.judge_published,
                 "1: judges see the detail-preserving output, 0: the absolute one")
      ->capture_default_str();
  app.add_option("--judge-root", config.judge_root, "Judged velocities include the hips' path")
      ->capture_default_str();
  app.add_option("--classifier-iterations", config.classifier_iterations)->capture_default_str();
  app.add_option("--checkpoint-minutes", config.checkpoint_minutes)->capture_default_str();
  app.add_option("--log-every", config.log_every)->capture_default_str();
  app.add_option("--monitor-every", config.monitor_every)->capture_default_str();
  auto* validation = app.add_option(
      "--validate", validation_cache,
      "Judge the run while it learns (validation.csv, curve.svg, best.safetensors); the judges are "
      "kept in this folder");
  app.add_option("--validate-minutes", config.validate_minutes, "Between two validations")
      ->capture_default_str();
  app.add_option("--patience", config.patience,
                 "End after so many validations without a better score; 0: never")
      ->capture_default_str()
      ->needs(validation);
  CLI::App* add =
      app.add_subcommand("add-style", "Teach trained weights more styles")->fallthrough();
  add->footer(
      "styletrain add-style --name NAME --init WEIGHTS --manifest M.toml --data DIR --out RUN\n"
      "The manifest has the neutral style and NAME. All that WEIGHTS has is frozen and comes out\n"
      "bit for bit. All other options of styletrain hold, but --per-style is 12; and without\n"
      "--replace --w-moments 200, --w-smooth 3, --w-penalty 60, --penalty-every 4, --decay-from "
      "0.5,\n"
      "--smooth-from 0 and --smooth-full 0.1, where you give no others.");
  add->add_option("--name", config.add_styles,
                  "The new style, as the manifest names it; repeatable")
      ->required();
  add->add_flag("--replace", config.replace,
                "NAME may be a style of WEIGHTS: it is learned anew, from where it is");
  CLI11_PARSE(app, argc, argv);
  if (add->parsed() && config.init.empty()) {  // before judges are trained for nothing
    std::cerr << "styletrain: add-style: --init is needed, the weights to add to\n";
    return 2;
  }
  // What RESULTS.md found best for one that is learned from nothing but minutes of it.
  const auto usual = [&](const char* flag, auto& value, double of_added) {
    const bool given = app.get_option(flag)->count() > 0;
    if (!given) value = static_cast<std::decay_t<decltype(value)>>(of_added);
  };
  if (add->parsed()) usual("--per-style", config.per_style, 12);
  if (add->parsed() && !config.replace) {
    usual("--w-moments", config.w_moments, 200);
    usual("--w-smooth", config.w_smooth, 3);
    usual("--w-penalty", config.w_penalty, 60);
    usual("--penalty-every", config.penalty_every, 4);
    usual("--decay-from", config.decay_from, 0.5);
    usual("--smooth-from", config.smooth_from, 0);
    usual("--smooth-full", config.smooth_full, 0.1);
  }

  if (export_paths.empty() && config.out.empty()) {
    std::cerr << "styletrain: --out or --export is needed\n";
    return 2;
  }
  const auto run = [&]() -> styled::Status {
    if (!export_paths.empty()) return styled::train::ExportRun(export_paths[0], export_paths[1]);
    if (validation_cache.empty()) return styled::train::Train(config);
    auto judge = styled::judge::Validator::Make(config.manifest, config.data, validation_cache);
    if (!judge.ok()) return judge.status();
    return styled::train::Train(
        config, [&judge](const auto& weights) { return judge.value().Measure(weights); });
  };
  const styled::Status status = run();
  if (!status.ok()) {
    std::cerr << "styletrain: " << status.message() << '\n';
    return 1;
  }
  return 0;
}

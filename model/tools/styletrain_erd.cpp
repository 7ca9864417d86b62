// The flags of styletrain for Style-ERD.
#include <algorithm>

#include "model/tools/train_family.h"
#include "model/train/erd/lessons.h"
#include "model/train/erd/recipe.h"

namespace styled::train {
namespace {

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
    app.option_defaults()->group("Schedule");
    // A callback at once: flags after this one on the command line change its settings.
    app.add_flag_callback(
           "--as-in-the-paper", [this] { style_erd::AsInThePaper(config_); },
           "Settings of Tao et al. 2022; other flags still apply")
        ->trigger_on_parse();
    AddFlags(app, style_erd::FlagsOf(config_));
    add_style_ = AddAddStyle(app, config_);
  }

  Status Resolve(const CLI::App& app) override {
    if (!add_style_->parsed()) return style_erd::Check(config_);
    if (config_.init.empty()) {  // checked before the judges are trained
      return Status::Error("add-style: --init is needed, the weights to add to");
    }
    // The best settings of RESULTS.md ("A style added to frozen weights") for a style without
    // weights.
    const auto unless_given = [&app](const char* flag, auto& value, double of_added) {
      if (app.get_option(flag)->count() > 0) return;
      value = static_cast<std::decay_t<decltype(value)>>(of_added);
    };
    unless_given("--per-style", config_.per_style, 12);
    if (config_.replace) return style_erd::Check(config_);
    unless_given("--w-moments", config_.w_moments, 200);
    unless_given("--w-smooth", config_.w_smooth, 3);
    unless_given("--w-penalty", config_.w_penalty, 60);
    unless_given("--penalty-every", config_.penalty_every, 4);
    unless_given("--decay-from", config_.decay_from, 0.5);
    unless_given("--smooth-from", config_.smooth_from, 0);
    unless_given("--smooth-full", config_.smooth_full, 0.1);
    return style_erd::Check(config_);
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

// The flags of styletrain for the causal spatio-temporal graph network.
#include "model/tools/train_family.h"
#include "model/train/stgcn_causal/recipe.h"

namespace styled::train {
namespace {

// The teacher, windows and what they are taught.
void AddDataFlags(CLI::App& app, st_gcn_causal::Config& config) {
  app.option_defaults()->group("Start");
  app.add_option("--init", config.init, "Weights of family st-gcn to learn from");
  app.add_option("--start-windows", config.start_windows,
                 "Windows that the start of the statistics is measured on; 0: mean 0, square 1")
      ->capture_default_str();
  app.option_defaults()->group("Data");
  app.add_option("--hop", config.hop, "Frames between the starts of two windows of a clip")
      ->capture_default_str();
  app.add_option("--mirror", config.mirror, "1: half of the windows are mirror images")
      ->capture_default_str();
  app.add_option("--neutral", config.neutral,
                 "Share of the sources that is neutral, in addition to random ones")
      ->capture_default_str();
  app.add_option("--unpaired", config.unpaired,
                 "Share of sources of any content, whether or not recorded in their target style")
      ->capture_default_str();
  app.add_option("--varied", config.varied, "Share of targets of a strength from 0 to 1.5, not 1")
      ->capture_default_str();
  app.add_option("--single", config.single,
                 "Share of targets that are a single example or noise, not their style's mean")
      ->capture_default_str();
  app.add_option("--single-codes", config.single_codes,
                 "Examples and noises of each style that those are drawn from")
      ->capture_default_str();
  app.add_option("--lead", config.lead_s,
                 "Seconds that the target's change of style is later, as the low-pass is late")
      ->capture_default_str();
  app.add_option("--gain", config.gain, "How many times as large as the teacher's that change is")
      ->capture_default_str();
  app.option_defaults()->group("Network");
  app.add_option("--precision", config.precision, "Of activations; auto: bf16 where it is fast")
      ->check(CLI::IsMember({"auto", "fp32", "bf16"}))
      ->capture_default_str();
}

void AddLearningFlags(CLI::App& app, st_gcn_causal::Config& config) {
  app.option_defaults()->group("Schedule");
  app.add_option("--batch", config.batch, "Windows in a batch")->capture_default_str();
  app.add_option("--generator-rate", config.generator_rate, "Learning rate at the start (Adam)")
      ->capture_default_str();
  app.add_option("--beta1", config.beta1, "Adam's decay of the mean gradient, per iteration")
      ->capture_default_str();
  app.add_option("--beta2", config.beta2, "Adam's decay of the squared gradient, per iteration")
      ->capture_default_str();
  app.add_option("--decay-to", config.decay_to,
                 "Share of the learning rate that is left at the end; it falls quadratically")
      ->capture_default_str();
  app.add_option("--ema", config.ema,
                 "Share of the running mean of the weights, which is exported, that an iteration "
                 "keeps; 0: the weights of the moment")
      ->capture_default_str();
  app.option_defaults()->group("Losses");
  app.add_option("--w-velocity", config.w_velocity,
                 "Weight of differences from frame to frame, relative to 1 for the features")
      ->capture_default_str();
  app.add_option("--w-first", config.w_first,
                 "Weight of the first 8 frames of a window, relative to 1 for the others")
      ->capture_default_str();
  app.add_option("--w-smooth", config.w_smooth,
                 "Weight of the squared second difference of the change of style")
      ->capture_default_str();
}

class StGcnCausalFlags : public FamilyFlags {
 public:
  explicit StGcnCausalFlags(CLI::App& app) {
    AddDataFlags(app, config_);
    AddLearningFlags(app, config_);
  }

  Status Resolve(const CLI::App& app) override {
    // Neither an export nor a measurement of speeds trains anything.
    const bool trains = app.get_option("--out")->count() > 0;
    return trains ? st_gcn_causal::Check(config_) : Status::Ok();
  }

  Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run) const override {
    return st_gcn_causal::MakeRecipe(run, config_);
  }

  Needs RequiredInputs() const override {
    Needs needs = NeedsOfGraphs();
    if (!config_.init.empty()) needs.files.emplace_back("--init", config_.init);
    return needs;
  }

  void ShortenStart() override { config_.start_windows = std::min(config_.start_windows, 32); }

 private:
  st_gcn_causal::Config config_;
};

}  // namespace

std::unique_ptr<FamilyFlags> AddStGcnCausalFlags(CLI::App& app) {
  return std::make_unique<StGcnCausalFlags>(app);
}

}  // namespace styled::train

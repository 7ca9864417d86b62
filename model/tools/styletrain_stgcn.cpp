// The flags of styletrain for the spatio-temporal graph network.
#include "model/tools/train_family.h"
#include "model/train/stgcn/recipe.h"

namespace styled::train {
namespace {

class StGcnFlags : public FamilyFlags {
 public:
  explicit StGcnFlags(CLI::App& app) {
    app.option_defaults()->group("Schedule");
    // A callback at once: flags after this one on the command line change its settings.
    app.add_flag_callback(
           "--as-in-the-paper", [this] { st_gcn::AsInThePaper(config_); },
           "Settings of Park et al. 2021 and their code; other flags still apply")
        ->trigger_on_parse();
    AddFlags(app, st_gcn::FlagsOf(config_));
  }

  // Before judges are trained for nothing.
  Status Resolve(const CLI::App&) override { return st_gcn::Check(config_); }

  Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run) const override {
    return st_gcn::MakeRecipe(run, config_);
  }

  Needs RequiredInputs() const override {
    Needs needs = NeedsOfGraphs();
    needs.train_frames = config_.fewest_frames;
    return needs;
  }

 private:
  st_gcn::Config config_;
};

}  // namespace

Needs NeedsOfGraphs() {
  Needs needs;
  needs.rate_hz = 30;
  needs.window_frames = 64;
  needs.train_frames = needs.window_frames / 2;
  return needs;
}

std::unique_ptr<FamilyFlags> AddStGcnFlags(CLI::App& app) {
  return std::make_unique<StGcnFlags>(app);
}

}  // namespace styled::train

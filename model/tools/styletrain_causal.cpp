// The flags of styletrain for the causal spatio-temporal graph network.
#include "model/tools/train_family.h"
#include "model/train/stgcn_causal/recipe.h"

namespace styled::train {
namespace {

class StGcnCausalFlags : public FamilyFlags {
 public:
  explicit StGcnCausalFlags(CLI::App& app) { AddFlags(app, st_gcn_causal::FlagsOf(config_)); }

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

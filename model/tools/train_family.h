#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string_view>
#include <vector>

#include "model/base/status.h"
#include "model/train/check.h"
#include "model/train/flags.h"
#include "model/train/recipe.h"
#include "model/train/trainer.h"

// The network families that styletrain can train. Each has a row in the table of styletrain.cpp and
// a source like styletrain_erd.cpp with its own flags.
namespace styled::train {

// The values of a family's flags, and the recipe made from them.
class FamilyFlags {
 public:
  virtual ~FamilyFlags() = default;
  // Call after `app` has parsed the command line. Sets defaults that depend on other flags, and
  // checks which flags exclude each other. Errors name the flag.
  virtual Status Resolve(const CLI::App& app) = 0;
  virtual Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run) const = 0;
  // The recipe's requirements for clips and files; the caller sets `judges`.
  virtual Needs RequiredInputs() const = 0;
  // For a run whose results are discarded: a shorter start before the first iteration.
  virtual void ShortenStart() {}
};

// Adds an option for each flag, the value of now as its default; for a family's constructor.
void AddFlags(CLI::App& app, const std::vector<FlagGroup>& groups);

// What windows of st-gcn and st-gcn-causal ask of clips: 64 frames at 30 Hz, half of which may be
// repeated. styletrain_stgcn.cpp
Needs NeedsOfGraphs();

struct Family {
  std::string_view name;  // of --family, of checkpoints and of weights files
  // Adds the family's flags and subcommands; the result must outlive the parsing.
  std::unique_ptr<FamilyFlags> (*add_flags)(CLI::App& app);
  ExportFunction export_weights;
};

// style-erd: styletrain_erd.cpp
std::unique_ptr<FamilyFlags> AddStyleErdFlags(CLI::App& app);
// st-gcn: styletrain_stgcn.cpp
std::unique_ptr<FamilyFlags> AddStGcnFlags(CLI::App& app);
// st-gcn-causal: styletrain_causal.cpp
std::unique_ptr<FamilyFlags> AddStGcnCausalFlags(CLI::App& app);

}  // namespace styled::train

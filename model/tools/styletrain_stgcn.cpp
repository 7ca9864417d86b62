// The flags of styletrain for the spatio-temporal graph network.
#include "model/tools/train_family.h"
#include "model/train/stgcn/recipe.h"

namespace styled::train {
namespace {

using st_gcn::Config;

// Windows and networks.
void AddDataFlags(CLI::App& app, Config& config) {
  app.add_option("--heading-tau", config.heading_tau_s, "Heading filter, s")->capture_default_str();
  app.add_option("--hop", config.hop, "Frames between the starts of windows")
      ->capture_default_str();
  app.add_option("--mirror", config.mirror, "Half of the windows are mirror images")
      ->capture_default_str();
  app.add_option("--shared-contents", config.shared_contents,
                 "Sources have a content in which the target domain was recorded")
      ->capture_default_str();
  app.add_option("--unpaired", config.unpaired,
                 "Share of sources of any content, which the critic does not see")
      ->capture_default_str();
  app.add_option("--width", config.width, "Channels of the finest level, a multiple of 16 up to 96")
      ->capture_default_str();
  app.add_option("--node-bias", config.node_bias)->capture_default_str();
  app.add_option("--content-critic", config.content_critic,
                 "The critic also says whether the content is the source's")
      ->capture_default_str();
  app.add_option("--scaled-heads", config.scaled_heads)->capture_default_str();
  app.add_option("--precision", config.precision)
      ->check(CLI::IsMember({"auto", "fp32", "bf16"}))
      ->capture_default_str();
}

// Order of work and learning rates.
void AddOptimizerFlags(CLI::App& app, Config& config) {
  app.add_option("--batch", config.batch)->capture_default_str();
  app.add_option("--warm-up", config.warm_up, "Iterations of identity alone")
      ->capture_default_str();
  app.add_option("--both-turns", config.both_turns, "Noise and references in every iteration")
      ->capture_default_str();
  app.add_option("--encoder-learns-from-references", config.encoder_learns_from_references)
      ->capture_default_str();
  app.add_option("--same-clip", config.same_clip,
                 "Identity takes the code of another window of the clip")
      ->capture_default_str();
  app.add_option("--generator-rate", config.generator_rate)->capture_default_str();
  app.add_option("--critic-rate", config.critic_rate)->capture_default_str();
  app.add_option("--encoder-rate", config.encoder_rate)->capture_default_str();
  app.add_option("--mapping-rate", config.mapping_rate)->capture_default_str();
  app.add_option("--warm-up-rate", config.warm_up_rate)->capture_default_str();
  app.add_option("--beta1", config.beta1)->capture_default_str();
  app.add_option("--beta2", config.beta2)->capture_default_str();
  app.add_option("--weight-decay", config.weight_decay)->capture_default_str();
  app.add_option("--decay-to", config.decay_to)->capture_default_str();
  app.add_option("--ema", config.ema)->capture_default_str();
}

void AddLossFlags(CLI::App& app, Config& config) {
  app.add_option("--w-adversarial", config.w_adversarial)->capture_default_str();
  app.add_option("--w-cycle", config.w_cycle)->capture_default_str();
  app.add_option("--w-identity", config.w_identity)->capture_default_str();
  app.add_option("--w-style", config.w_style, "Style reconstruction")->capture_default_str();
  app.add_option("--w-penalty", config.w_penalty, "R1")->capture_default_str();
  app.add_option("--penalty-every", config.penalty_every)->capture_default_str();
  app.add_option("--w-diversity", config.w_diversity, "At first")->capture_default_str();
  app.add_option("--diversity-target", config.diversity_target_cm,
                 "Distance of two outputs, cm, that its weight is steered to; 0: constant")
      ->capture_default_str();
  app.add_option("--w-fk", config.w_fk)->capture_default_str();
  app.add_option("--w-free", config.w_free, "The head without a label")->capture_default_str();
  app.add_option("--free-head-teaches", config.free_head_teaches)->capture_default_str();
  app.add_option("--w-smooth", config.w_smooth)->capture_default_str();
  app.add_option("--w-posture", config.w_posture)->capture_default_str();
  app.add_option("--w-read", config.w_read)->capture_default_str();
}

class StGcnFlags : public FamilyFlags {
 public:
  explicit StGcnFlags(CLI::App& app) {
    // A callback at once: flags after this one on the command line change its settings.
    app.add_flag_callback(
           "--as-in-the-paper", [this] { st_gcn::AsInThePaper(config_); },
           "Settings of Park et al. 2021 and their code; other flags still count")
        ->trigger_on_parse();
    AddDataFlags(app, config_);
    AddOptimizerFlags(app, config_);
    AddLossFlags(app, config_);
  }

  // Before judges are trained in vain.
  Status Resolve(const CLI::App&) override { return st_gcn::Check(config_); }

  Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run) const override {
    return st_gcn::MakeRecipe(run, config_);
  }

 private:
  Config config_;
};

}  // namespace

std::unique_ptr<FamilyFlags> AddStGcnFlags(CLI::App& app) {
  return std::make_unique<StGcnFlags>(app);
}

}  // namespace styled::train

// The flags of styletrain for the spatio-temporal graph network.
#include "model/tools/train_family.h"
#include "model/train/stgcn/recipe.h"

namespace styled::train {
namespace {

// Windows and networks.
void AddDataFlags(CLI::App& app, st_gcn::Config& config) {
  app.option_defaults()->group("Data");
  app.add_option("--heading-tau", config.heading_tau_s, "Time constant of the heading filter, s")
      ->capture_default_str();
  app.add_option("--hop", config.hop, "Frames between the starts of two windows of a clip")
      ->capture_default_str();
  app.add_option("--mirror", config.mirror, "1: half of the windows are mirror images")
      ->capture_default_str();
  app.add_option("--shared-contents", config.shared_contents,
                 "1: sources have a content in which the target domain was recorded")
      ->capture_default_str();
  app.add_option("--unpaired", config.unpaired,
                 "Share of sources of any content, which the critic does not see")
      ->capture_default_str();
  app.option_defaults()->group("Network");
  app.add_option("--width", config.width, "Channels of the finest level, a multiple of 16 up to 96")
      ->capture_default_str();
  app.add_option("--node-bias", config.node_bias, "1: every joint has a bias of its own")
      ->capture_default_str();
  app.add_option("--content-critic", config.content_critic,
                 "1: the critic also says whether the content is the source's")
      ->capture_default_str();
  app.add_option("--scaled-heads", config.scaled_heads,
                 "1: smaller outputs at first; otherwise the critic wins at once")
      ->capture_default_str();
  app.add_option("--precision", config.precision, "Of activations; auto: bf16 where it is fast")
      ->check(CLI::IsMember({"auto", "fp32", "bf16"}))
      ->capture_default_str();
}

// Order of work and learning rates.
void AddOptimizerFlags(CLI::App& app, st_gcn::Config& config) {
  app.option_defaults()->group("Schedule");
  app.add_option("--batch", config.batch, "Windows in a batch")->capture_default_str();
  app.add_option("--warm-up", config.warm_up, "Iterations of identity alone")
      ->capture_default_str();
  app.add_option("--both-turns", config.both_turns,
                 "1: noise and references in every iteration, 0: in turn")
      ->capture_default_str();
  app.add_option("--encoder-learns-from-references", config.encoder_learns_from_references,
                 "1: the style encoder learns in their turn, too; 0: from noise's alone")
      ->capture_default_str();
  app.add_option("--same-clip", config.same_clip,
                 "1: identity takes the code of another window of the clip")
      ->capture_default_str();
  app.add_option("--generator-rate", config.generator_rate,
                 "Learning rate of the generator at the start (Adam)")
      ->capture_default_str();
  app.add_option("--critic-rate", config.critic_rate, "The same of the critic")
      ->capture_default_str();
  app.add_option("--encoder-rate", config.encoder_rate, "The same of the style encoder")
      ->capture_default_str();
  app.add_option("--mapping-rate", config.mapping_rate, "The same of the mapping network")
      ->capture_default_str();
  app.add_option("--warm-up-rate", config.warm_up_rate, "Of all of them during the warm-up")
      ->capture_default_str();
  app.add_option("--beta1", config.beta1, "Adam's decay of the mean gradient, per iteration")
      ->capture_default_str();
  app.add_option("--beta2", config.beta2, "Adam's decay of the squared gradient, per iteration")
      ->capture_default_str();
  app.add_option("--weight-decay", config.weight_decay, "Adam's decay of the weights")
      ->capture_default_str();
  app.add_option("--decay-to", config.decay_to,
                 "Share of the learning rates that is left at the end; they fall quadratically")
      ->capture_default_str();
  app.add_option("--ema", config.ema,
                 "Share of the running mean of the weights, which is exported, that an iteration "
                 "keeps; 0: the weights of the moment")
      ->capture_default_str();
}

void AddLossFlags(CLI::App& app, st_gcn::Config& config) {
  app.option_defaults()->group("Losses");
  app.add_option("--w-adversarial", config.w_adversarial, "Weight of the critic")
      ->capture_default_str();
  app.add_option("--w-cycle", config.w_cycle, "Of the way to another style and back")
      ->capture_default_str();
  app.add_option("--w-identity", config.w_identity, "Of a window decoded in its own style")
      ->capture_default_str();
  app.add_option("--w-style", config.w_style, "Of the style code, read again off the output")
      ->capture_default_str();
  app.add_option("--w-penalty", config.w_penalty, "Of the critic's gradient penalty, R1")
      ->capture_default_str();
  app.add_option("--penalty-every", config.penalty_every,
                 "Gradient penalty every so many iterations, as much stronger")
      ->capture_default_str();
  app.add_option("--w-diversity", config.w_diversity,
                 "Of the distance of two outputs of one source, at first")
      ->capture_default_str();
  app.add_option("--diversity-target", config.diversity_target_cm,
                 "Distance of two outputs, cm, that its weight is steered to; 0: constant")
      ->capture_default_str();
  app.add_option("--w-fk", config.w_fk,
                 "Of positions' distance to those that follow from the rotations")
      ->capture_default_str();
  app.add_option("--w-free", config.w_free, "Of the encoder's head for clips without a label")
      ->capture_default_str();
  app.add_option("--free-head-teaches", config.free_head_teaches,
                 "1: its gradient reaches the layers below")
      ->capture_default_str();
  app.add_option("--w-smooth", config.w_smooth,
                 "Of the third difference of what a style changes, cm per frame3")
      ->capture_default_str();
  app.add_option("--w-posture", config.w_posture,
                 "Of the mean pose over a window, toward that of the target in this content")
      ->capture_default_str();
  app.add_option("--w-read", config.w_read,
                 "Of postures that are read off examples without a label")
      ->capture_default_str();
}

class StGcnFlags : public FamilyFlags {
 public:
  explicit StGcnFlags(CLI::App& app) {
    app.option_defaults()->group("Schedule");
    // A callback at once: flags after this one on the command line change its settings.
    app.add_flag_callback(
           "--as-in-the-paper", [this] { st_gcn::AsInThePaper(config_); },
           "Settings of Park et al. 2021 and their code; other flags still apply")
        ->trigger_on_parse();
    AddDataFlags(app, config_);
    AddOptimizerFlags(app, config_);
    AddLossFlags(app, config_);
  }

  // Before judges are trained for nothing.
  Status Resolve(const CLI::App&) override { return st_gcn::Check(config_); }

  Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run) const override {
    return st_gcn::MakeRecipe(run, config_);
  }

  Needs RequiredInputs() const override { return NeedsOfGraphs(); }

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

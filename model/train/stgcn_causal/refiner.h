#pragma once

#include <torch/torch.h>

#include <cstdint>
#include <random>

#include "model/train/adam.h"
#include "model/train/stgcn_causal/published_form.h"
#include "model/train/stgcn_causal/read_student.h"
#include "model/train/stgcn_causal/refine_motion.h"
#include "model/train/stgcn_causal/style_vector.h"

namespace styled::train::st_gcn_causal {

// How a style is fitted to its takes. Defaults are for a minute on one CPU core.
struct RefineConfig {
  uint64_t seed = 1;
  int batch = 8;
  std::string precision = "auto";  // of activations: "fp32", "bf16", or bf16 where it is fast

  // The optimizer (Adam), whose rates fall quadratically to decay_to of their start. First the code
  // is fitted alone, for this share of the time.
  double code_rate = 0.03, rate = 0.01;
  double decay_to = 0.05;
  double code_alone = 0.25;

  // Weights of the losses. The published form of neutral motion is compared with the take: by its
  // moments (refine_motion.h: mean pose, spread, change from frame to frame), and by its
  // distribution (sliced Wasserstein distance of poses and their changes). `reproduce`: the take
  // itself, under its own style, and its differences from frame to frame. `small`: bias and
  // additions, squared.
  double w_moments = 1;
  double w_distribution = 0;
  double w_reproduce = 0.3;
  double w_small = 0.02;
};
Status Check(const RefineConfig& config);

// The data to which a style is fitted and on which it is judged. The two do not overlap.
struct RefineMotion {
  Frames take, neutral;  // to fit; each clip has at least one frame
  Frames judged_take, judged_neutral;
};

// The distance of the style's output on neutral motion from the take, on the parts that are kept
// apart.
struct RefineFigures {
  double mean_cm = 0;                                   // of mean poses
  double spread_cm = 0;                                 // of joint movement about the mean poses
  double score() const { return mean_cm + spread_cm; }  // less is better
};

// Fits a style (FullStyle) by gradient; the network stays as it is. Deterministic by seed and
// steps. References must outlive it. One thread. Pinned by
// tests/unit/train/stgcn_causal/refiner_test.cpp.
class Refiner {
 public:
  // `start`: for one sample, in full form.
  Refiner(const RefineConfig& config, const LoadedStudent& network, const RefineMotion& motion,
          const FullStyle& start);

  // One step. `progress` in [0, 1] decides rates, and what is fitted. Returns the loss.
  double Step(double progress);
  FullStyle style() const;

  // For any style. Neutral: of the neutral motion itself, without a style.
  RefineFigures Measure(const FullStyle& style) const;
  RefineFigures MeasureNeutral() const;
  bool Finite() const;

 private:
  // Windows, and the part of their data that does not depend on the style.
  struct Pool {
    torch::Tensor content;  // [N, T, 5, 4 width]
    PublishedForm::Basis basis;
    torch::Tensor window;
  };
  Pool MakePool(const Frames& clips, int64_t count, const Graph& graph,
                std::mt19937_64& random) const;
  torch::Tensor Publish(const Pool& pool, const torch::Tensor& samples, const FullStyle& style,
                        const Graph& graph) const;
  torch::Tensor MomentsLoss(const torch::Tensor& published) const;
  torch::Tensor DistributionLoss(const torch::Tensor& published) const;
  torch::Tensor ReproductionLoss(const FullStyle& style);
  torch::Tensor Draw(int64_t below);
  void PullIn();

  const RefineConfig config_;
  const LoadedStudent& network_;
  const PublishedForm form_;
  const Graph graph_, exact_graph_;
  mutable std::mt19937_64 random_;
  Pool neutral_, take_, judged_;
  Moments wanted_, judged_wanted_;
  torch::Tensor described_;  // the take's frames as DistributionLoss compares them
  Parameters code_, more_;
  torch::Tensor code_value_, bias_, additions_;
  Adam code_adam_, more_adam_;
};

}  // namespace styled::train::st_gcn_causal

#pragma once

#include <torch/torch.h>

#include <memory>
#include <string>

#include "model/train/adam.h"

// The normalization of a network that sees no future (model/net/stgcn_causal/FORMAT.md): mean and
// variance are those of the frames so far, each weighted by 1 - 1 / memory relative to the one
// after it, from a learned start that counts as `start_frames` frames.
namespace styled::train::st_gcn_causal {

inline constexpr double kMemory = 21, kStartFrames = 16;
inline constexpr double kEpsilon = 1e-5;  // of the variance
inline constexpr double kSlope = 0.2;     // of LeakyReLU

// The shares of frames 0 .. t in the statistics at t, and that of the start: they sum to 1.
struct Past {
  Past(int64_t frames, const torch::Device& device);
  torch::Tensor shares;  // [T, T], a row per frame
  torch::Tensor start;   // [T, 1]
};

// One normalization with its LeakyReLU.
class PastNorm {
 public:
  PastNorm() = default;
  PastNorm(Parameters& parameters, const std::string& name, int64_t channels);

  // x [B, T, V, C]; scale and shift float32 [B or 1, C]; `share` of each node in the means, float32
  // [V]. Whatever the type of x, the arithmetic is float32.
  torch::Tensor operator()(const Past& past, const torch::Tensor& x, const torch::Tensor& scale,
                           const torch::Tensor& shift, const torch::Tensor& share) const;

  // Between Observe(true) and Observe(false) a window is normalized by its own moments, as in the
  // network of whole clips. Their means over all windows become the start of the statistics.
  void Observe(bool on);

  torch::Tensor start_mean, start_square;  // [C]

 private:
  struct Observed {
    torch::Tensor sum;  // [2C]
    int64_t windows = 0;
  };
  std::shared_ptr<Observed> observed_;  // null: not observing
};

}  // namespace styled::train::st_gcn_causal

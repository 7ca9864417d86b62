#pragma once

#include <torch/torch.h>

#include <vector>

#include "model/clip/manifest.h"
#include "model/train/dataset.h"
#include "model/train/sampler.h"

namespace styled::train::style_erd {

// Windows as tensors on the device, time-major: T = window + 1 frames (velocities need one more
// than the judged ones), B windows.
struct Batch {
  torch::Tensor features, yaw_change_rad, hips_step_m;  // [T, B, 211], [T, B], [T, B, 3]
  torch::Tensor u;                                      // features, standardized
  torch::Tensor input;  // the generator's input: u, or disturbed or from a miscalibrated rig
  torch::Tensor rotations, positions;  // views of features, [T, B, 21, 4 or 3]
  torch::Tensor content;               // [B, contents] one-hot
  torch::Tensor carried, idle;         // [B] bool
  torch::Tensor paired;  // [B] 1 where the target style was recorded in the window's content
  std::vector<Sampler::Window> windows;  // their sources
};

// Makes batches of the sampler's windows. `clips` must outlive it. One thread.
class BatchMaker {
 public:
  // mean, deviation [211] on the device of the batches.
  BatchMaker(const std::vector<TrainingClip>& clips, int contents, int frames,
             const erd::FeatureParameters& parameters, const torch::Tensor& mean,
             const torch::Tensor& deviation);

  Batch Make(const std::vector<Sampler::Window>& windows) const;

 private:
  // A batch's tensors on the CPU while the windows are written into them.
  struct Buffers;
  void Fill(const Sampler::Window& window, int64_t index, Buffers& out) const;

  const std::vector<TrainingClip>& clips_;
  int64_t contents_, frames_;
  erd::FeatureParameters parameters_;
  torch::Tensor mean_, deviation_;
};

// A rough and cheap model of the effect of another performer, rig or floor on the features: each is
// off by a constant of the window and by noise of the frame. Both have a size drawn per window from
// [0, 1], times `offset` and `noise` (in deviations). u [T, B, 211]; seeded by `seed` alone, so
// that a resumed run continues bit for bit.
torch::Tensor Disturb(const torch::Tensor& u, double offset, double noise, uint64_t seed);

}  // namespace styled::train::style_erd

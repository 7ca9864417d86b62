#pragma once

#include <torch/torch.h>

#include <array>
#include <vector>

#include "model/clip/manifest.h"
#include "model/train/dataset.h"
#include "model/train/erd/networks.h"
#include "model/train/sampler.h"

namespace styled::train::style_erd {

// Windows as tensors, time-major: T = window + 1 frames (velocities need one more than the judged
// ones), B windows.
struct Batch {
  torch::Tensor features, yaw_change_rad, hips_step_m;  // [T, B, 211], [T, B], [T, B, 3]
  torch::Tensor u;                                      // features, standardized
  torch::Tensor input;    // the generator's input: u, or disturbed or from a miscalibrated rig
  torch::Tensor content;  // [B, contents] one-hot
  torch::Tensor carried, idle;  // [B] bool
  torch::Tensor paired;         // [B] 1 where the target style was recorded in the window's content
  torch::Tensor labelled, recognized;    // [B] 1 where the content input is of that source
  Slots slots;                           // the windows' styles
  std::vector<Sampler::Window> windows;  // their sources

  torch::Tensor rotations() const;  // views of features, [T, B, 21, 4 or 3]
  torch::Tensor positions() const;

  // The tensors that differ from one batch to the next; slots' are among them where each batch has
  // its own.
  std::array<torch::Tensor*, 18> all() {
    return {&features,
            &yaw_change_rad,
            &hips_step_m,
            &u,
            &input,
            &content,
            &carried,
            &idle,
            &paired,
            &labelled,
            &recognized,
            &slots.input,
            &slots.target,
            &slots.input_one_hot,
            &slots.target_one_hot,
            &slots.styled,
            &slots.window_of_place,
            &slots.place_of_window};
  }
};

// Makes batches of the sampler's windows, in memory of the CPU. `clips` must outlive it. Any
// thread.
class BatchMaker {
 public:
  // mean, deviation [211].
  BatchMaker(const std::vector<TrainingClip>& clips, int contents, int frames,
             const erd::FeatureParameters& parameters, const torch::Tensor& mean,
             const torch::Tensor& deviation);

  // All but the slots and the sources of contents.
  Batch Make(const std::vector<Sampler::Window>& windows) const;

 private:
  // A batch's tensors while the windows are written into them.
  struct Buffers;
  void Fill(const Sampler::Window& window, int64_t index, Buffers& out) const;

  const std::vector<TrainingClip>& clips_;
  int64_t contents_, frames_;
  erd::FeatureParameters parameters_;
  torch::Tensor mean_, deviation_;
};

// The slots of windows with these styles, the same number for each style branch and in their order.
Slots OrderedSlots(const std::vector<int64_t>& input, const std::vector<int64_t>& target,
                   int64_t styles);
// Of any windows; a branch has a place for each.
Slots PlacedSlots(const std::vector<int64_t>& input, const std::vector<int64_t>& target,
                  int64_t styles);

// A rough and cheap model of the effect of another performer, rig or floor on the features: each is
// off by a constant of the window and by noise of the frame. Both have a size drawn per window from
// [0, 1], times `offset` and `noise` (in deviations). u [T, B, 211]; seeded by `seed` alone, so
// that a resumed run continues bit for bit.
torch::Tensor Disturb(const torch::Tensor& u, double offset, double noise, uint64_t seed);

}  // namespace styled::train::style_erd

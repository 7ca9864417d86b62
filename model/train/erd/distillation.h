#pragma once

#include <torch/torch.h>

#include <memory>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/train/checkpoint.h"
#include "model/train/erd/batch.h"
#include "model/train/erd/lessons.h"
#include "model/train/erd/networks.h"
#include "model/train/erd/weights.h"

namespace styled::train::style_erd {

// Teachers, whose changes of style the generator imitates in the same windows (knowledge
// distillation, Hinton et al. 2015). Targets are computed on undisturbed input. `manifest` must
// outlive it. One thread.
class Distillation {
 public:
  // What it has to know of the run. `idle_content` is the content whose mean change of style is the
  // target of idle windows; -1: there are none. mean, deviation [211] on the device.
  struct Setup {
    const clip::Manifest& manifest;
    Slots slots;
    torch::Tensor mean, deviation;
    int64_t idle_content = -1;
  };
  explicit Distillation(Setup setup) : setup_(std::move(setup)) {}

  // Adds a teacher for the styles that its lessons name, or, without lessons, for all that it and
  // the run have. Where it teaches, earlier teachers no longer do. Refuses other feature statistics
  // than the run's and lessons that it or the run cannot have.
  Status Add(const LoadedWeights& weights, const std::vector<Lesson>& lessons);
  bool empty() const { return teachers_.empty(); }

  // The distance (eq. 2) of `change` [T, B, 21, 4], the generator's change of style, from the
  // teachers'; mean over windows with a teacher. Also adds to the means for idle windows.
  torch::Tensor Loss(const Batch& batch, const torch::Tensor& change);

  // Carried states and means, under "teacher.N.". Restore throws where they do not fit.
  void Save(Checkpoint& checkpoint) const;
  void Restore(const Checkpoint& checkpoint);

 private:
  struct Teacher {
    std::unique_ptr<Generator> generator;  // its styles are in the run's order
    Carried carried;
    torch::Tensor gain;  // [B, contents] of its change in the slot; 0: it does not teach there
    // Of its changes to a style in windows of idle_content: the sum of rotation vectors, [styles,
    // 21, 3], and their number [styles]. Undefined without idle windows.
    torch::Tensor mean_sum, mean_count;
  };
  // What a teacher's change in each window is compared with, and whether it is.
  struct Target {
    torch::Tensor change;  // [T, B, 21, 4], gain included
    torch::Tensor taught;  // [B], 1 or 0
  };

  int64_t styles() const { return setup_.slots.input_one_hot.size(1); }
  std::vector<std::string> SharedStyles(const LoadedWeights& weights) const;
  Status CheckLesson(const Lesson& lesson, const std::vector<std::string>& shared) const;
  Result<torch::Tensor> Gains(const std::vector<std::string>& shared,
                              const std::vector<Lesson>& lessons) const;
  Result<std::unique_ptr<Generator>> InOurOrder(const LoadedWeights& weights,
                                                const std::vector<std::string>& shared) const;
  Target TargetOf(Teacher& teacher, const Batch& batch) const;
  void ReplaceIdle(const Batch& batch, Teacher& teacher, torch::Tensor& change,
                   torch::Tensor& gain) const;

  Setup setup_;
  std::vector<Teacher> teachers_;
};

}  // namespace styled::train::style_erd

#pragma once

#include <torch/torch.h>

#include <memory>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/train/checkpoint.h"
#include "model/train/erd/batch.h"
#include "model/train/erd/clip_teacher.h"
#include "model/train/erd/lessons.h"
#include "model/train/erd/networks.h"
#include "model/train/erd/weights.h"

namespace styled::train::style_erd {

// Teachers, whose changes of style the generator imitates in the same windows (knowledge
// distillation, Hinton et al. 2015): other weights of this family, or networks that see whole clips
// (clip_teacher.h). Targets are those of undisturbed input. `manifest` and `clips` must outlive it.
// One thread.
class Distillation {
 public:
  // The data about the run that it needs. `idle_content` is the content whose mean change of style
  // is the target of idle windows; -1: there are none. mean, deviation [211] on the device.
  struct Setup {
    const clip::Manifest& manifest;
    const std::vector<TrainingClip>& clips;
    double rate_hz;
    double lead_s;  // of the changes of networks that see whole clips
    Slots slots;
    torch::Tensor mean, deviation;
    int64_t idle_content = -1;
    torch::Tensor idle_contents, kept_contents;  // [contents] 1 or 0: Config's, on the device
  };
  explicit Distillation(Setup setup);

  // Adds a teacher for the styles that its lessons name, or, without lessons, for all that it and
  // the run have. For these it replaces earlier teachers. Refuses other feature statistics than the
  // run's and lessons that it or the run cannot have.
  Status Add(const LoadedWeights& weights, const std::vector<Lesson>& lessons);
  // The same for a network that sees whole clips; it processes all of them here.
  Status Add(const net::ClipStylizer& network, const std::vector<Lesson>& lessons);
  bool empty() const { return teachers_.empty(); }

  // The generator's effect on the input: its change of style [T, B, 21, 4], the joints' positions
  // that follow from it [T, B, 21, 3], relative to the hips, and the rise of the hips [T, B], m.
  // Positions may be undefined: only rotations are compared then.
  struct Student {
    torch::Tensor change, positions_m, rise_m;
  };
  // The distance of that effect from the teachers': the distance of eq. 2, m², (m/s)²; means over
  // windows with a teacher.
  struct Distance {
    torch::Tensor rotation, position, velocity;
  };
  // Looks at the teachers' changes in these windows; also adds to the means for idle windows.
  void See(const Batch& batch);
  // Of the batch that was seen last. It is on the device alone: it can be recorded.
  Distance Apart(const Batch& batch, const Student& student) const;

  // Carried states and means, under "teacher.N.". Restore throws if they do not fit. Teachers added
  // since the checkpoint have no state in it, and start without one.
  void Save(Checkpoint& checkpoint) const;
  void Restore(const Checkpoint& checkpoint);

 private:
  // The teacher's change in each window for comparison, and whether there is one.
  struct Target {
    torch::Tensor change;  // [T, B, 21, 4], gain included
    torch::Tensor rise_m;  // [T, B], gain included
    torch::Tensor taught;  // [B], 1 or 0
  };
  struct Teacher {
    std::unique_ptr<Generator> generator;  // its styles are in the run's order; otherwise:
    std::unique_ptr<ClipTeacher> clips;
    Carried carried;
    torch::Tensor gain;  // [B, contents] of its change in the slot; 0: not taught there
    // Of its changes to a style in windows of idle_content: the sum of rotation vectors, [styles,
    // 21, 3], that of the rise [styles], and their number [styles]. Undefined without idle windows.
    torch::Tensor mean_sum, rise_sum, mean_count;
    Target target;  // of the batch that was seen last, always in the same memory
  };

  int64_t styles() const { return setup_.slots.input_one_hot.size(1); }
  std::vector<std::string> SharedStyles(const std::vector<std::string>& of_teacher) const;
  Status CheckLesson(const Lesson& lesson, const std::vector<std::string>& shared) const;
  Result<torch::Tensor> Gains(const std::vector<std::string>& shared,
                              const std::vector<Lesson>& lessons) const;
  Result<std::unique_ptr<Generator>> InOurOrder(const LoadedWeights& weights,
                                                const std::vector<std::string>& shared) const;
  Status Add(Teacher teacher, const torch::Tensor& gains);
  Target Undisturbed(Teacher& teacher, const Batch& batch) const;
  Target TargetOf(Teacher& teacher, const Batch& batch) const;
  static torch::Tensor OffBy(const Batch& batch, const Student& student, const Target& target);
  void ReplaceIdle(const Batch& batch, Teacher& teacher, Target& target, torch::Tensor& gain) const;

  Setup setup_;
  ClipTeacher::Roles roles_;  // of the slots
  std::vector<Teacher> teachers_;
};

}  // namespace styled::train::style_erd

#include "model/train/erd/distillation.h"

#include <algorithm>

#include "model/train/geometry.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

// Windows before a mean is a target of idle windows: fewer are noise.
constexpr int kFewestWindows = 4;

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string Prefix(std::size_t teacher) { return "teacher." + std::to_string(teacher) + "."; }

}  // namespace

// Per style but neutral its name, or an empty one where the teacher does not have it.
std::vector<std::string> Distillation::SharedStyles(const LoadedWeights& weights) const {
  std::vector<std::string> shared;
  for (std::size_t style = 1; style < setup_.manifest.styles.size(); ++style) {
    const std::string& name = setup_.manifest.styles[style].name;
    const bool known =
        std::find(weights.styles.begin() + 1, weights.styles.end(), name) != weights.styles.end();
    shared.push_back(known ? name : "");
  }
  return shared;
}

Status Distillation::CheckLesson(const Lesson& lesson,
                                 const std::vector<std::string>& shared) const {
  const auto refuse = [](const std::string& what, const std::string& why) {
    return Status::Error("cannot teach \"" + what + "\": " + why);
  };
  if (lesson.style == setup_.manifest.styles[0].name) {
    return refuse(lesson.style, "changes are relative to the neutral style");
  }
  if (lesson.style.empty() || !Contains(shared, lesson.style)) {
    return refuse(lesson.style, "it and the run must both have it");
  }
  if (!lesson.content.empty() && !Contains(setup_.manifest.contents, lesson.content)) {
    return refuse(lesson.style + "/" + lesson.content, "the manifest has no such content");
  }
  return Status::Ok();
}

// [styles, contents]
Result<Tensor> Distillation::Gains(const std::vector<std::string>& shared,
                                   const std::vector<Lesson>& lessons) const {
  const std::vector<std::string>& contents = setup_.manifest.contents;
  Tensor gain = torch::zeros({styles(), static_cast<int64_t>(contents.size())});
  for (std::size_t i = 0; lessons.empty() && i < shared.size(); ++i) {
    if (!shared[i].empty()) gain.select(0, static_cast<int64_t>(i) + 1).fill_(1);
  }
  for (const Lesson& lesson : lessons) {
    const Status fits = CheckLesson(lesson, shared);
    if (!fits.ok()) return fits;
    const auto style = std::find(shared.begin(), shared.end(), lesson.style) - shared.begin() + 1;
    for (std::size_t content = 0; content < contents.size(); ++content) {
      if (!lesson.content.empty() && lesson.content != contents[content]) continue;
      gain.index_put_({style, static_cast<int64_t>(content)}, lesson.gain);
    }
  }
  if (gain.sum().item<double>() == 0) return Status::Error("has none of the run's styles");
  return gain;
}

// A style that the teacher lacks gets its first branch, which is never used.
Result<std::unique_ptr<Generator>> Distillation::InOurOrder(
    const LoadedWeights& weights, const std::vector<std::string>& shared) const {
  std::vector<int64_t> source{0};
  for (const std::string& name : shared) {
    const auto found = std::find(weights.styles.begin() + 1, weights.styles.end(), name);
    source.push_back(found == weights.styles.end() ? 1 : found - weights.styles.begin());
  }
  GeneratorShape shape = weights.generator->shape;
  shape.styles = styles();
  auto generator = std::make_unique<Generator>(shape, setup_.mean, setup_.deviation);
  const Status copied = generator->CopyStyles(*weights.generator, source);
  if (!copied.ok()) return copied;
  return generator;
}

Status Distillation::Add(const LoadedWeights& weights, const std::vector<Lesson>& lessons) {
  const torch::NoGradGuard no_grad;
  if (!torch::equal(weights.mean, setup_.mean.cpu()) ||
      !torch::equal(weights.deviation, setup_.deviation.cpu())) {
    return Status::Error(
        "has other feature statistics than the run; train one with --init the other");
  }
  const std::vector<std::string> shared = SharedStyles(weights);
  const Result<Tensor> gains = Gains(shared, lessons);
  if (!gains.ok()) return gains.status();
  Result<std::unique_ptr<Generator>> generator = InOurOrder(weights, shared);
  if (!generator.ok()) return generator.status();

  const Slots& slots = setup_.slots;
  Teacher teacher;
  teacher.generator = std::move(generator.value());
  teacher.carried = teacher.generator->Start(slots);
  // One of a slot's two styles is neutral, number 0, so that the sum is the other.
  teacher.gain = gains.value().to(setup_.mean.device()).index_select(0, slots.input + slots.target);
  for (Teacher& earlier : teachers_) earlier.gain.masked_fill_(teacher.gain > 0, 0);
  // Changes from a style have no gain.
  const Tensor from_style = slots.styled.flatten().unsqueeze(1) * (teacher.gain > 0);
  teacher.gain = torch::where(from_style > 0, torch::ones_like(teacher.gain), teacher.gain);
  if (setup_.idle_content >= 0) {
    teacher.mean_sum = torch::zeros({styles(), body::kJointCount, 3}, setup_.mean.options());
    teacher.mean_count = torch::zeros({styles()}, setup_.mean.options());
  }
  teachers_.push_back(std::move(teacher));
  return Status::Ok();
}

// The target of an idle window is a mean, the same in every frame; there is none before the mean is
// of enough windows.
void Distillation::ReplaceIdle(const Batch& batch, Teacher& teacher, Tensor& change,
                               Tensor& gain) const {
  const Slots& slots = setup_.slots;
  const Tensor measured =
      (slots.input == 0) & (batch.content.argmax(1) == setup_.idle_content) & ~batch.idle;
  const Tensor counts = measured.to(change.dtype());
  const Tensor mean = LogQuaternion(change).mean(0);  // [B, 21, 3]
  teacher.mean_sum.index_add_(0, slots.target, mean * counts.view({-1, 1, 1}));
  teacher.mean_count.index_add_(0, slots.target, counts);

  const Tensor known = teacher.mean_count.index({slots.target});
  const Tensor target =
      teacher.mean_sum.index({slots.target}) / known.clamp_min(1).view({-1, 1, 1});
  change = torch::where(batch.idle.view({1, -1, 1, 1}), ExpQuaternion(target).unsqueeze(0), change);
  const Tensor idle_gain = torch::where(known < kFewestWindows, torch::zeros_like(gain),
                                        teacher.gain.select(1, setup_.idle_content));
  gain = torch::where(batch.idle, idle_gain, gain);
}

Distillation::Target Distillation::TargetOf(Teacher& teacher, const Batch& batch) const {
  const torch::NoGradGuard no_grad;
  const int64_t count = setup_.slots.count();
  const Tensor both =
      teacher.generator->Transfer(batch.u, setup_.slots, batch.carried, teacher.carried).rotations;
  Target target;
  target.change = Multiply(Conjugate(both.narrow(1, 0, count)), both.narrow(1, count, count));
  Tensor gain = (teacher.gain * batch.content).sum(1);
  if (teacher.mean_sum.defined()) ReplaceIdle(batch, teacher, target.change, gain);
  target.taught = (gain > 0).to(target.change.dtype());
  target.change = ScaleRotation(target.change, gain.view({1, count, 1, 1}));
  return target;
}

Tensor Distillation::Loss(const Batch& batch, const Tensor& change) {
  Tensor sum = torch::zeros({}, batch.u.options());
  Tensor taught = torch::zeros({}, batch.u.options());
  for (Teacher& teacher : teachers_) {
    const Target target = TargetOf(teacher, batch);
    const Tensor apart = SquaredHalfAngle(change, target.change);  // [T, B, 21]
    sum = sum + (apart.sum(torch::IntArrayRef({0, 2})) * target.taught).sum();
    taught = taught + target.taught.sum();
  }
  return sum / taught.clamp_min(1.0);
}

void Distillation::Save(Checkpoint& checkpoint) const {
  for (std::size_t i = 0; i < teachers_.size(); ++i) {
    SaveCarried(teachers_[i].carried, Prefix(i), checkpoint);
    if (!teachers_[i].mean_sum.defined()) continue;
    checkpoint.tensors[Prefix(i) + "mean_sum"] = teachers_[i].mean_sum;
    checkpoint.tensors[Prefix(i) + "mean_count"] = teachers_[i].mean_count;
  }
}

void Distillation::Restore(const Checkpoint& checkpoint) {
  for (std::size_t i = 0; i < teachers_.size(); ++i) {
    RestoreCarried(checkpoint, Prefix(i), teachers_[i].carried);
    if (!teachers_[i].mean_sum.defined()) continue;
    teachers_[i].mean_sum.copy_(checkpoint.tensors.at(Prefix(i) + "mean_sum"));
    teachers_[i].mean_count.copy_(checkpoint.tensors.at(Prefix(i) + "mean_count"));
  }
}

}  // namespace styled::train::style_erd

#include "model/train/erd/distillation.h"

#include <algorithm>
#include <iostream>
#include <utility>

#include "model/train/geometry.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

// Windows before a mean is a target of idle windows: fewer are noise.
constexpr int kFewestIdle = 4;

// As many identity rotations as `rotations` has.
Tensor Identity(const Tensor& rotations) {
  Tensor out = torch::zeros_like(rotations);
  out.select(-1, 3).fill_(1);
  return out;
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string Prefix(std::size_t teacher) { return "teacher." + std::to_string(teacher) + "."; }

}  // namespace

Distillation::Distillation(Setup setup) : setup_(std::move(setup)) {
  for (const auto& [slots, styles] : {std::pair(&setup_.slots.input, &roles_.input),
                                      std::pair(&setup_.slots.target, &roles_.target)}) {
    const Tensor on_cpu = slots->cpu();
    const auto* const begin = on_cpu.data_ptr<int64_t>();
    styles->assign(begin, begin + on_cpu.numel());
  }
}

// Per style but neutral its name, or an empty one where the teacher does not have it.
std::vector<std::string> Distillation::SharedStyles(
    const std::vector<std::string>& of_teacher) const {
  std::vector<std::string> shared;
  for (std::size_t style = 1; style < setup_.manifest.styles.size(); ++style) {
    const std::string& name = setup_.manifest.styles[style].name;
    shared.push_back(Contains(of_teacher, name) ? name : "");
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
  if (weights.generator->shape.contents > 0) {
    return Status::Error("takes contents as input; such a network cannot teach");
  }
  const std::vector<std::string> shared = SharedStyles(weights.styles);
  const Result<Tensor> gains = Gains(shared, lessons);
  if (!gains.ok()) return gains.status();
  Result<std::unique_ptr<Generator>> generator = InOurOrder(weights, shared);
  if (!generator.ok()) return generator.status();
  Teacher teacher;
  teacher.generator = std::move(generator.value());
  teacher.carried = teacher.generator->Start(setup_.slots);
  return Add(std::move(teacher), gains.value());
}

Status Distillation::Add(const net::ClipStylizer& network, const std::vector<Lesson>& lessons) {
  const torch::NoGradGuard no_grad;
  std::vector<std::string> names;
  for (const net::StyleInfo& style : network.model().styles) names.push_back(style.name);
  std::vector<std::string> shared = SharedStyles(names);
  const Result<Tensor> gains = Gains(shared, lessons);
  if (!gains.ok()) return gains.status();
  const Tensor taught = gains.value().sum(1);
  for (std::size_t i = 0; i < shared.size(); ++i) {
    if (taught[static_cast<int64_t>(i) + 1].item<double>() == 0) shared[i].clear();
  }
  Result<ClipTeacher> clips =
      ClipTeacher::Make(network, setup_.manifest, setup_.clips, setup_.rate_hz, shared);
  if (!clips.ok()) return clips.status();
  std::cout << "teacher: its change of style, not its output, in "
            << 100 * clips.value().share_by_change() << " % of the clips" << std::endl;
  Teacher teacher;
  teacher.clips = std::make_unique<ClipTeacher>(std::move(clips.value()));
  return Add(std::move(teacher), gains.value());
}

Status Distillation::Add(Teacher teacher, const Tensor& gains) {
  const Slots& slots = setup_.slots;
  // One of a slot's two styles is neutral, number 0, so that the sum is the other.
  teacher.gain = gains.to(setup_.mean.device()).index_select(0, slots.input + slots.target);
  for (Teacher& earlier : teachers_) earlier.gain.masked_fill_(teacher.gain > 0, 0);
  // Changes from a style have no gain.
  const Tensor from_style = slots.styled.flatten().unsqueeze(1) * (teacher.gain > 0);
  teacher.gain = torch::where(from_style > 0, torch::ones_like(teacher.gain), teacher.gain);
  if (setup_.idle_content >= 0) {
    teacher.mean_sum = torch::zeros({styles(), body::kJointCount, 3}, setup_.mean.options());
    teacher.rise_sum = torch::zeros({styles()}, setup_.mean.options());
    teacher.mean_count = torch::zeros({styles()}, setup_.mean.options());
  }
  teachers_.push_back(std::move(teacher));
  return Status::Ok();
}

// The target of an idle window is a mean, the same in every frame; there is none before the mean is
// of enough windows.
void Distillation::ReplaceIdle(const Batch& batch, Teacher& teacher, Target& target,
                               Tensor& gain) const {
  const Slots& slots = setup_.slots;
  const Tensor idle =
      batch.idle | (((batch.content * setup_.idle_contents).sum(1) > 0) & (slots.input == 0));
  const Tensor measured =
      (slots.input == 0) & (batch.content.argmax(1) == setup_.idle_content) & ~idle;
  const Tensor counts = measured.to(target.change.dtype());
  const Tensor mean = LogQuaternion(target.change).mean(0);  // [B, 21, 3]
  teacher.mean_sum.index_add_(0, slots.target, mean * counts.view({-1, 1, 1}));
  teacher.rise_sum.index_add_(0, slots.target, target.rise_m.mean(0) * counts);
  teacher.mean_count.index_add_(0, slots.target, counts);

  const Tensor known = teacher.mean_count.index({slots.target});
  const Tensor turned =
      teacher.mean_sum.index({slots.target}) / known.clamp_min(1).view({-1, 1, 1});
  const Tensor risen = teacher.rise_sum.index({slots.target}) / known.clamp_min(1);
  target.change =
      torch::where(idle.view({1, -1, 1, 1}), ExpQuaternion(turned).unsqueeze(0), target.change);
  target.rise_m = torch::where(idle.view({1, -1}), risen.unsqueeze(0), target.rise_m);
  const Tensor idle_gain = torch::where(known < kFewestIdle, torch::zeros_like(gain),
                                        teacher.gain.select(1, setup_.idle_content));
  gain = torch::where(idle, idle_gain, gain);
}

Distillation::Target Distillation::Undisturbed(Teacher& teacher, const Batch& batch) const {
  const Slots& slots = setup_.slots;
  Target target;
  if (teacher.clips) {
    const auto frames = static_cast<int>(batch.u.size(0));
    const torch::Device device = setup_.mean.device();
    const ClipTeacher::Changes changes =
        teacher.clips->Of(batch.windows, roles_, frames, setup_.lead_s * setup_.rate_hz);
    target.change = changes.rotations.to(device);
    target.rise_m = changes.rise_m.to(device);
    return target;
  }
  const int64_t count = slots.count();
  const Decoded both =
      teacher.generator->Transfer(batch.u, slots, {}, batch.carried, teacher.carried);
  target.change = Multiply(Conjugate(both.rotations.narrow(1, 0, count)),
                           both.rotations.narrow(1, count, count));
  target.rise_m =
      (both.height.narrow(1, count, count) - both.height.narrow(1, 0, count)).squeeze(2) *
      setup_.deviation[erd::kHipsHeightIndex];
  return target;
}

Distillation::Target Distillation::TargetOf(Teacher& teacher, const Batch& batch) const {
  const torch::NoGradGuard no_grad;
  Target target = Undisturbed(teacher, batch);
  Tensor gain = (teacher.gain * batch.content).sum(1);
  if (teacher.mean_sum.defined()) ReplaceIdle(batch, teacher, target, gain);
  const Tensor kept =
      ((batch.content * setup_.kept_contents).sum(1) > 0) & (setup_.slots.input == 0) & ~batch.idle;
  gain = torch::where(kept, (gain > 0).to(gain.dtype()), gain);
  target.change = torch::where(kept.view({1, -1, 1, 1}), Identity(target.change), target.change);
  target.rise_m = torch::where(kept.view({1, -1}), torch::zeros_like(target.rise_m), target.rise_m);
  target.taught = (gain > 0).to(target.change.dtype());
  target.change = ScaleRotation(target.change, gain.view({1, -1, 1, 1}));
  target.rise_m = target.rise_m * gain;
  return target;
}

// From the places of the joints that the teacher wants, the rise of the hips included.
Tensor Distillation::OffBy(const Batch& batch, const Student& student, const Target& target) {
  Tensor wanted_m;
  {
    const torch::NoGradGuard no_grad;
    wanted_m = HipsRelativePositions(Multiply(batch.rotations(), target.change));
  }
  const Tensor rise_m = student.rise_m - target.rise_m;
  const Tensor none = torch::zeros_like(rise_m);
  return student.positions_m - wanted_m + torch::stack({none, rise_m, none}, 2).unsqueeze(2);
}

void Distillation::See(const Batch& batch) {
  const torch::NoGradGuard no_grad;
  for (Teacher& teacher : teachers_) {
    const Target seen = TargetOf(teacher, batch);
    for (const auto& [from, to] : {std::pair(&seen.change, &teacher.target.change),
                                   std::pair(&seen.rise_m, &teacher.target.rise_m),
                                   std::pair(&seen.taught, &teacher.target.taught)}) {
      if (to->defined()) {
        to->copy_(*from);
      } else {
        *to = from->clone();
      }
    }
  }
}

Distillation::Distance Distillation::Apart(const Batch& batch, const Student& student) const {
  const Tensor zero = torch::zeros({}, batch.u.options());
  Distance sum{zero, zero, zero};
  Tensor taught = zero;
  for (const Teacher& teacher : teachers_) {
    const Target& target = teacher.target;
    taught = taught + target.taught.sum();
    const Tensor apart = SquaredHalfAngle(student.change, target.change);  // [T, B, 21]
    sum.rotation = sum.rotation + (apart.sum(torch::IntArrayRef({0, 2})) * target.taught).sum();
    if (!student.positions_m.defined()) continue;
    const Tensor off_m = OffBy(batch, student, target);
    const auto add = [&target](const Tensor& off, Tensor& to) {  // off [T, B, 21, 3]
      const Tensor of_window = off.square().sum(3).mean(torch::IntArrayRef({0, 2}));
      to = to + (of_window * target.taught).sum();
    };
    add(off_m, sum.position);
    add(off_m.diff(1, 0) * setup_.rate_hz, sum.velocity);
  }
  taught = taught.clamp_min(1.0);
  return {sum.rotation / taught, sum.position / taught, sum.velocity / taught};
}

void Distillation::Save(Checkpoint& checkpoint) const {
  for (std::size_t i = 0; i < teachers_.size(); ++i) {
    if (teachers_[i].generator) SaveCarried(teachers_[i].carried, Prefix(i), checkpoint);
    if (!teachers_[i].mean_sum.defined()) continue;
    checkpoint.tensors[Prefix(i) + "mean_sum"] = teachers_[i].mean_sum;
    checkpoint.tensors[Prefix(i) + "rise_sum"] = teachers_[i].rise_sum;
    checkpoint.tensors[Prefix(i) + "mean_count"] = teachers_[i].mean_count;
  }
}

void Distillation::Restore(const Checkpoint& checkpoint) {
  const auto& tensors = checkpoint.tensors;
  for (std::size_t i = 0; i < teachers_.size(); ++i) {
    Teacher& teacher = teachers_[i];
    const std::string mean_sum = Prefix(i) + "mean_sum";
    if (teacher.generator && tensors.contains(Prefix(i) + "neutral.h")) {
      RestoreCarried(checkpoint, Prefix(i), teacher.carried);
    }
    if (!teacher.mean_sum.defined() || !tensors.contains(mean_sum)) continue;
    teacher.mean_sum.copy_(tensors.at(mean_sum));
    teacher.rise_sum.copy_(tensors.at(Prefix(i) + "rise_sum"));
    teacher.mean_count.copy_(tensors.at(Prefix(i) + "mean_count"));
  }
}

}  // namespace styled::train::style_erd

#include "model/train/erd/batch.h"

#include <algorithm>

namespace styled::train::style_erd {

using torch::Tensor;

struct BatchMaker::Buffers {
  Buffers(int64_t frames, int64_t count, int64_t contents, bool miscalibrated)
      : features(torch::empty({frames, count, erd::kFeatureCount})),
        yaw(torch::empty({frames, count})),
        step(torch::empty({frames, count, 3})),
        content(torch::zeros({count, contents})),
        carried(torch::zeros({count}, torch::kBool)),
        idle(torch::zeros({count}, torch::kBool)),
        paired(torch::zeros({count})) {
    if (miscalibrated) input = torch::empty_like(features);
  }

  Tensor features, yaw, step, content, carried, idle, paired;
  Tensor input;  // undefined if no window is miscalibrated: the features are the input
};

BatchMaker::BatchMaker(const std::vector<TrainingClip>& clips, int contents, int frames,
                       const erd::FeatureParameters& parameters, const Tensor& mean,
                       const Tensor& deviation)
    : clips_(clips),
      contents_(contents),
      frames_(frames),
      parameters_(parameters),
      mean_(mean.cpu()),
      deviation_(deviation.cpu()) {}

void BatchMaker::Fill(const Sampler::Window& window, int64_t index, Buffers& out) const {
  const int64_t count = out.features.size(1);
  const TrainingClip& clip = clips_[window.clip];
  const auto frames = static_cast<int>(frames_);
  FillWindow(clip, window.start, frames, window.mirrored, window.session_start || window.idle,
             parameters_,
             {.features = out.features.data_ptr<float>() + index * erd::kFeatureCount,
              .feature_stride = count * erd::kFeatureCount,
              .yaw_change_rad = out.yaw.data_ptr<float>() + index,
              .yaw_stride = count,
              .hips_step_m = out.step.data_ptr<float>() + index * 3,
              .step_stride = count * 3});
  if (out.input.defined()) {
    const bool wrong = window.miscalibration != 0;
    const Miscalibration draw =
        wrong ? DrawMiscalibration(window.miscalibration) : Miscalibration{};
    FillWindow(clip, window.start, frames, window.mirrored, window.session_start, parameters_,
               {.features = out.input.data_ptr<float>() + index * erd::kFeatureCount,
                .feature_stride = count * erd::kFeatureCount},
               wrong ? &draw : nullptr);
  }
  if (window.idle) {  // the first frame, held: no motion
    out.features.narrow(1, index, 1)
        .copy_(out.features.narrow(0, 0, 1).narrow(1, index, 1).clone());
    if (out.input.defined()) out.input.narrow(1, index, 1).copy_(out.features.narrow(1, index, 1));
    out.yaw.narrow(1, index, 1).zero_();
    out.step.narrow(1, index, 1).zero_();
    out.idle.data_ptr<bool>()[index] = true;
  }
  out.content.data_ptr<float>()[index * contents_ + window.content] = 1.0F;
  out.paired.data_ptr<float>()[index] = window.paired ? 1.0F : 0.0F;
  out.carried.data_ptr<bool>()[index] = window.carried;
}

Batch BatchMaker::Make(const std::vector<Sampler::Window>& windows) const {
  const auto count = static_cast<int64_t>(windows.size());
  const bool miscalibrated =
      std::any_of(windows.begin(), windows.end(),
                  [](const Sampler::Window& window) { return window.miscalibration != 0; });
  Buffers buffers(frames_, count, contents_, miscalibrated);
  for (int64_t i = 0; i < count; ++i) Fill(windows[i], i, buffers);

  Batch batch;
  batch.features = buffers.features;
  batch.u = (batch.features - mean_) / deviation_;
  batch.input = buffers.input.defined() ? (buffers.input - mean_) / deviation_ : batch.u;
  batch.yaw_change_rad = buffers.yaw;
  batch.hips_step_m = buffers.step;
  batch.content = buffers.content;
  batch.carried = buffers.carried;
  batch.idle = buffers.idle;
  batch.paired = buffers.paired;
  batch.windows = windows;
  return batch;
}

Tensor Batch::rotations() const {
  return features.narrow(2, 0, erd::kRotationFeatures)
      .view({features.size(0), features.size(1), body::kJointCount, 4});
}

Tensor Batch::positions() const {
  return features.narrow(2, erd::kPositionBegin, erd::kPositionFeatures)
      .view({features.size(0), features.size(1), body::kJointCount, 3});
}

Slots OrderedSlots(const std::vector<int64_t>& input, const std::vector<int64_t>& target,
                   int64_t styles) {
  Slots slots;
  slots.input = torch::tensor(input, torch::kInt64);
  slots.target = torch::tensor(target, torch::kInt64);
  slots.input_one_hot = torch::one_hot(slots.input, styles).to(torch::kFloat32);
  slots.target_one_hot = torch::one_hot(slots.target, styles).to(torch::kFloat32);
  slots.styled = (slots.input > 0).to(torch::kFloat32).view({1, -1, 1});
  return slots;
}

Slots PlacedSlots(const std::vector<int64_t>& input, const std::vector<int64_t>& target,
                  int64_t styles) {
  Slots slots = OrderedSlots(input, target, styles);
  const std::size_t count = input.size();
  std::vector<int64_t> window((static_cast<std::size_t>(styles) - 1) * count, 0), place(count);
  std::vector<std::size_t> taken(static_cast<std::size_t>(styles), 0);
  for (std::size_t i = 0; i < count; ++i) {
    // One of the two is neutral, number 0.
    const auto branch = static_cast<std::size_t>(input[i] + target[i] - 1);
    place[i] = static_cast<int64_t>(branch * count + taken[branch]++);
    window[static_cast<std::size_t>(place[i])] = static_cast<int64_t>(i);
  }
  slots.window_of_place = torch::tensor(window, torch::kInt64);
  slots.place_of_window = torch::tensor(place, torch::kInt64);
  return slots;
}

Tensor Disturb(const Tensor& u, double offset, double noise, uint64_t seed) {
  torch::manual_seed(seed);
  const auto size = [&u] { return torch::rand({1, u.size(1), 1}, u.options()); };
  const Tensor constant = torch::randn({1, u.size(1), u.size(2)}, u.options()) * size();
  const Tensor varying = torch::randn_like(u) * size();
  return u + offset * constant + noise * varying;
}

}  // namespace styled::train::style_erd

#pragma once

#include <torch/torch.h>

#include <array>
#include <functional>
#include <future>
#include <string>
#include <utility>

namespace styled::train {

// Makes the batches of a run, each while the device trains on the one before. The batches depend
// on nothing but a sampler, so `make` may run in another thread, never twice at a time. Used by
// one thread.
template <class Batch>
class OneAhead {
 public:
  struct Made {
    Batch batch;
    std::string sampler;  // the sampler's state after it
  };

  // `make`: the batch of an iteration, in memory of the CPU. Without `ahead` it runs in Next.
  OneAhead(bool ahead, std::function<Made(int64_t iteration)> make)
      : ahead_(ahead), make_(std::move(make)) {}

  Batch Next(int64_t iteration) {
    Made made = next_.valid() ? next_.get() : make_(iteration);
    sampler_ = std::move(made.sampler);
    if (ahead_) {
      next_ = std::async(std::launch::async, [this, iteration] { return make_(iteration + 1); });
    }
    return std::move(made.batch);
  }
  // The sampler's state after the last batch that Next returned; empty before the first.
  const std::string& sampler() const { return sampler_; }

 private:
  bool ahead_;
  std::function<Made(int64_t)> make_;
  std::string sampler_;
  std::future<Made> next_;  // destroyed first: it waits for the thread
};

// Moves tensors of the CPU to memory from which a device copies while both work on.
template <std::size_t N>
void PinMemory(const std::array<torch::Tensor*, N>& tensors) {
  for (torch::Tensor* tensor : tensors) {
    if (tensor->defined()) *tensor = tensor->pin_memory();
  }
}

// Copies those that are defined to the device, where `to` stays where it is in memory. It is made
// the first time.
template <std::size_t N>
void CopyToDevice(const std::array<torch::Tensor*, N>& from, const torch::Device& device,
                  const std::array<torch::Tensor*, N>& to) {
  for (std::size_t i = 0; i < N; ++i) {
    if (!from[i]->defined()) continue;
    if (!to[i]->defined())
      *to[i] =
          torch::empty(from[i]->sizes(), from[i]->options().device(device).pinned_memory(false));
    to[i]->copy_(*from[i], true);
  }
}

}  // namespace styled::train

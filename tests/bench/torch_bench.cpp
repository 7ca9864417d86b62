// Compares, in one run, our step (hot and L2-cold), the same step in plain Eigen, and libtorch's
// forward pass of the same network, weights and frames: one performer, one style, one frame at a
// time, one thread. libtorch runs eagerly without gradients in three forms: the recurrent layers op
// by op; by at::lstm, which takes all layers in one call; and by the trainer's own kernel, which is
// not part of libtorch. In addition, at::lstm over whole clips, as in the paper's Table 2. All are
// timed in turn in many short rounds, so that other load on the machine affects all of them alike;
// medians are compared. No assertion on wall time.
#include <torch/torch.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <thread>
#include <tuple>

#include "model/net/kernels/kernel.h"
#include "model/train/blas.h"
#include "model/train/erd/lstm.h"
#include "model/train/erd/weights.h"
#include "tests/bench/plain_step.h"
#include "tests/bench/step_run.h"

namespace styled::erd {
namespace {

using torch::Tensor;

constexpr int kRounds = 40;

enum class Recurrent { kOps, kLstm, kTrainer };

// Runs the trainer's generator one frame at a time, with only one of its branches.
class TorchRun {
 public:
  TorchRun(const train::style_erd::LoadedWeights& weights, int style, Recurrent recurrent)
      : generator_(*weights.generator),
        recurrent_(recurrent),
        mean_(weights.mean),
        deviation_(weights.deviation),
        neutral_(generator_.neutral),
        branch_(Only(generator_.branches, style)),
        neutral_state_(neutral_.Initial(1)),
        branch_state_(branch_.Initial(1)),
        neutral_fused_(neutral_),
        branch_fused_(branch_) {
    own_ = torch::zeros({1, generator_.shape.styles});
    own_[0][0] = 1.0;
    target_ = torch::zeros({1, generator_.shape.styles});
    target_[0][style] = 1.0;
  }

  void Step(const Features& features) { Steps({&features, 1}); }

  // All frames are available at once: each layer runs over all of them.
  void Steps(std::span<const Features> frames) {
    const Tensor x =
        torch::from_blob(const_cast<float*>(frames[0].data()),
                         {static_cast<int64_t>(frames.size()), 1, kFeatureCount}, torch::kFloat32);
    const Tensor z = generator_.Encode((x - mean_) / deviation_, own_, {});
    const Tensor r0 = Run(neutral_, neutral_state_, neutral_fused_, z);
    const Tensor rs = Run(branch_, branch_state_, branch_fused_, z);
    reconstruction = generator_.Decode(r0, own_).rotations;
    styled = generator_.Decode(r0 + rs, target_).rotations;
  }

  Tensor reconstruction, styled;

 private:
  // A stack in the form of at::lstm: all layers in one call.
  struct Fused {
    explicit Fused(const train::style_erd::Stack& stack)
        : layers(static_cast<int64_t>(stack.input.size())) {
      for (int64_t l = 0; l < layers; ++l) {
        const Tensor bias = stack.bias[l][0].contiguous();
        parameters.insert(parameters.end(),
                          {stack.input[l][0].contiguous(), stack.hidden[l][0].contiguous(), bias,
                           torch::zeros_like(bias)});
      }
      std::vector<Tensor> h, c;
      for (int64_t l = 0; l < layers; ++l) {
        h.push_back(stack.h0[l]);
        c.push_back(stack.c0[l]);
      }
      state = {torch::stack(h), torch::stack(c)};
    }
    Tensor operator()(const Tensor& z) {
      auto [y, h, c] = torch::lstm(z, state, parameters, true, layers, 0.0, false, false, false);
      state = {h, c};
      return y;
    }
    int64_t layers;
    std::vector<Tensor> parameters, state;
  };

  Tensor Run(const train::style_erd::Stack& stack, train::style_erd::StackState& state,
             Fused& fused, const Tensor& z) const {
    if (recurrent_ == Recurrent::kLstm) return fused(z);
    Tensor x = z.unsqueeze(0);
    if (recurrent_ == Recurrent::kTrainer) return stack(x, state)[0];
    for (std::size_t l = 0; l < stack.input.size(); ++l) {
      std::tie(x, state.c[l]) = train::style_erd::LstmLayerByOps(
          x, stack.input[l], stack.hidden[l], stack.bias[l], state.h[l], state.c[l]);
      state.h[l] = x.squeeze(1);
    }
    return x[0];
  }

  static train::style_erd::Stack Only(const train::style_erd::Stack& all, int style) {
    train::style_erd::Stack one;
    for (std::size_t l = 0; l < all.input.size(); ++l) {
      const auto slice = [style](const Tensor& tensor) {
        return tensor.narrow(0, style - 1, 1).contiguous();
      };
      one.input.push_back(slice(all.input[l]));
      one.hidden.push_back(slice(all.hidden[l]));
      one.bias.push_back(slice(all.bias[l]));
      one.h0.push_back(slice(all.h0[l]));
      one.c0.push_back(slice(all.c0[l]));
    }
    return one;
  }

  const train::style_erd::Generator& generator_;
  Recurrent recurrent_;
  Tensor mean_, deviation_, own_, target_;
  train::style_erd::Stack neutral_, branch_;
  train::style_erd::StackState neutral_state_, branch_state_;
  Fused neutral_fused_, branch_fused_;
};

// The largest difference between our outputs for a frame and libtorch's.
double Difference(const net::Prediction& ours, const TorchRun& theirs) {
  double largest = 0;
  const auto compare = [&largest](const net::Decoded& decoded, const Tensor& rotations) {
    const float* values = rotations.data_ptr<float>();
    for (int i = 0; i < kRotationFeatures; ++i) {
      const double found = decoded.rotations[i / 4].coeffs()[i % 4];
      largest = std::max(largest, std::abs(found - values[i]));
    }
  };
  compare(ours.reconstruction, theirs.reconstruction);
  compare(ours.styled, theirs.styled);
  return largest;
}

double Difference(const net::Prediction& ours, const net::Prediction& plain) {
  float largest = 0;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const auto difference = [joint](const net::Decoded& a, const net::Decoded& b) {
      return (a.rotations[joint].coeffs() - b.rotations[joint].coeffs()).cwiseAbs().maxCoeff();
    };
    largest = std::max({largest, difference(ours.reconstruction, plain.reconstruction),
                        difference(ours.styled, plain.styled)});
  }
  return largest;
}

struct Timing {
  const char* name;
  int steps;  // per round
  std::function<void()> before, step;
  int ours = 0;  // index of our timing that this one is compared with
  std::vector<double> times_us = {};

  void Round() {
    using Clock = std::chrono::steady_clock;
    for (int i = 0; i < steps; ++i) {
      if (before) before();
      const auto begin = Clock::now();
      step();
      times_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
    }
  }
  double Percentile_us(int percent) {
    std::sort(times_us.begin(), times_us.end());
    return times_us[times_us.size() * static_cast<std::size_t>(percent) / 100];
  }
};

// Paces frames at 120 Hz; the process sleeps in between.
class Pace {
 public:
  void Wait() {
    next_ = std::max(next_ + std::chrono::microseconds(8333), Clock::now());
    std::this_thread::sleep_until(next_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point next_ = Clock::now();
};

Result<train::style_erd::LoadedWeights> LoadRandomWeights(int styles, unsigned seed) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("styled-torch-bench-" + std::to_string(getpid()) + ".safetensors");
  const auto bytes = RandomWeights(styles, seed).Bytes();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  auto weights = train::style_erd::ReadWeights(file);
  std::filesystem::remove(file);
  return weights;
}

int Main() {
  torch::set_num_threads(1);
  const torch::NoGradGuard no_grad;
  constexpr int kStyles = 7;
  auto weights = LoadRandomWeights(kStyles, 1);
  if (!weights.ok()) {
    std::fprintf(stderr, "%s\n", weights.status().message().c_str());
    return 1;
  }
  const auto network = RandomNetwork(kStyles, 1);
  StepRun hot(network, 1), cold(network, 1);
  StepRun inputs(network, 1);  // used for its frames only
  TorchRun ops(weights.value(), 1, Recurrent::kOps), lstm(weights.value(), 1, Recurrent::kLstm),
      trainer(weights.value(), 1, Recurrent::kTrainer);
  PlainStep plain_hot(RandomWeights(kStyles, 1), hot.active);
  PlainStep plain_cold(RandomWeights(kStyles, 1), hot.active);
  net::Prediction plain_out;
  const OtherWork other;
  int sink = 0;
  StepRun paced(network, 1);
  Pace pace;
  std::vector<Timing> timings{
      {"our step, hot", 500, nullptr, [&] { hot.Step(); }},
      {"our step, L2-cold", 50, [&] { sink += other.Read(); }, [&] { cold.Step(); }, 1},
      {"our step, paced at 120 Hz", 6, [&] { pace.Wait(); }, [&] { paced.Step(); }, 2},
      {"plain Eigen, hot", 500, nullptr, [&] { plain_hot.Step(inputs.NextFrame(), plain_out); }},
      {"plain Eigen, L2-cold", 50, [&] { sink += other.Read(); },
       [&] { plain_cold.Step(inputs.NextFrame(), plain_out); }, 1},
      {"libtorch, op by op", 25, nullptr, [&] { ops.Step(inputs.NextFrame()); }},
      {"libtorch, at::lstm", 25, nullptr, [&] { lstm.Step(inputs.NextFrame()); }},
      {"libtorch, at::lstm, L2-cold", 25, [&] { sink += other.Read(); },
       [&] { lstm.Step(inputs.NextFrame()); }, 1},
      {"libtorch, at::lstm, paced", 6, [&] { pace.Wait(); }, [&] { lstm.Step(inputs.NextFrame()); },
       2},
      {"libtorch, the trainer's kernel", 25, nullptr, [&] { trainer.Step(inputs.NextFrame()); }},
  };
  // Whole clips, as in the paper's Table 2; our step still runs frame by frame.
  const auto add_clip = [&](const char* our_name, const char* their_name, int frames) {
    timings.push_back({our_name, 2, nullptr, [&hot, frames] {
                         for (int i = 0; i < frames; ++i) hot.Step();
                       }});
    const int ours = static_cast<int>(timings.size()) - 1;
    timings.back().ours = ours;
    timings.push_back({their_name, 2, nullptr,
                       [&inputs, &lstm, frames] {
                         lstm.Steps(
                             std::span(inputs.frames).first(static_cast<std::size_t>(frames)));
                       },
                       ours});
  };
  add_clip("our steps, clip of 60 frames", "libtorch, at::lstm, 60 frames", 60);
  add_clip("our steps, clip of 90 frames", "libtorch, at::lstm, 90 frames", 90);
  add_clip("our steps, clip of 120 frames", "libtorch, at::lstm, 120 frames", 120);

  // First a check that both do the same work: equal outputs for equal frames.
  StepRun check(network, 1);
  PlainStep plain_check(RandomWeights(kStyles, 1), check.active);
  double difference = 0;
  for (int i = 0; i < StepRun::kFrames; ++i) {
    check.Step();
    plain_check.Step(check.frames[i], plain_out);
    difference = std::max(difference, Difference(check.out, plain_out));
    for (TorchRun* run : {&ops, &lstm, &trainer}) {
      run->Step(check.frames[i]);
      difference = std::max(difference, Difference(check.out, *run));
    }
  }

  for (int round = 0; round < kRounds + 1; ++round) {
    for (Timing& timing : timings) timing.Round();
    if (round > 0) continue;
    for (Timing& timing : timings) timing.times_us.clear();  // the first round warms up
  }
  std::printf("one performer, one style, one frame, one thread; our SIMD target %s\n",
              net::BestKernels().target);
  std::printf("largest difference %.1e\n\n", difference);
  std::printf("%-32s %9s %9s %12s\n", "", "p50 us", "p99 us", "of ours");
  for (Timing& timing : timings) {
    const double p50_us = timing.Percentile_us(50);
    std::printf("%-32s %9.2f %9.2f %11.1fx\n", timing.name, p50_us, timing.Percentile_us(99),
                p50_us / timings[static_cast<std::size_t>(timing.ours)].Percentile_us(50));
  }
  return difference < 1e-4 && sink != 1 ? 0 : 1;
}

}  // namespace
}  // namespace styled::erd

int main(int, char** argv) {
  styled::train::UseFastKernels(argv);  // without them libtorch would appear slower than it is
  return styled::erd::Main();
}

// One step of the network, and the same in plain Eigen: with hot caches, and after other work has
// read 8 MB, which is the state in which a step at 120 Hz finds the caches. No assertion on wall
// time.
#include <benchmark/benchmark.h>
#include <sys/prctl.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include "model/net/erd/weights.h"
#include "model/net/kernels/kernel.h"
#include "model/net/weights_file.h"
#include "tests/bench/plain_step.h"
#include "tests/bench/step_run.h"

namespace styled::erd {
namespace {

struct OurRun : StepRun {
  explicit OurRun(int styles) : StepRun(RandomNetwork(16, 1), styles) {}
};

struct WideRun : StepRunOf<kWide> {
  explicit WideRun(int styles) : StepRunOf(RandomWideNetwork(16, 1), styles) {}
};

// As shipped: wide, with weights in int8.
struct ShippedRun : StepRunOf<kWide> {
  static std::shared_ptr<const WideNetwork> Network() {
    const std::vector<std::byte> bytes = RandomWeights(16, 1, kWide).Bytes();
    auto file = net::ParseWeights(bytes, "random");
    file.value().precision = net::Precision::kInt8;
    return WideNetwork::Read(file.value()).value();
  }
  explicit ShippedRun(int styles) : StepRunOf(Network(), styles) {}
};

// The same network with a content input, which it recognizes.
template <int kContents>
struct ContentsRun : StepRun {
  explicit ContentsRun(int styles)
      : StepRun(NetworkOf(RandomWeightsWithContents(16, kContents, 1)), styles) {}
};

struct PlainRun : OurRun {
  PlainStep plain;
  explicit PlainRun(int styles) : OurRun(styles), plain(RandomWeights(16, 1), active) {}
  void Step() { plain.Step(NextFrame(), out); }
};

template <typename Run>
void Hot(benchmark::State& state) {
  Run run(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    run.Step();
    benchmark::DoNotOptimize(run.out);
  }
}

template <typename Run>
void Cold(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  Run run(static_cast<int>(state.range(0)));
  const OtherWork other;
  std::vector<double> times_us;
  for (auto _ : state) {
    benchmark::DoNotOptimize(other.Read());
    const auto begin = Clock::now();
    run.Step();
    benchmark::DoNotOptimize(run.out);
    const double time_s = std::chrono::duration<double>(Clock::now() - begin).count();
    state.SetIterationTime(time_s);
    times_us.push_back(time_s * 1e6);
  }
  std::sort(times_us.begin(), times_us.end());
  state.counters["p50_us"] = times_us[times_us.size() / 2];
  state.counters["p99_us"] = times_us[times_us.size() * 99 / 100];
}

// The lower bound from memory: the bytes of a step's weights, read once, in order.
template <int Rows, int Columns>
constexpr std::size_t kBytes = sizeof(net::PackedMatrix<Rows, Columns>);
template <Shape kShape>
constexpr std::size_t StepBytes(std::size_t styles) {
  constexpr int kZ = kShape.latent;
  constexpr auto kWidths = kShape.decoder;
  return kBytes<kShape.encoder, kFeatureCount> + kBytes<kZ, kShape.encoder> +
         (kNeutralLayers + styles * kStyleLayers) * kBytes<4 * kZ, 2 * kZ> +
         kBytes<kWidths[0], kZ> + kBytes<kWidths[1], kWidths[0]> + kBytes<kWidths[2], kWidths[1]> +
         kBytes<kHeads, kWidths[2]>;
}

// Uses the machine's full register width, with enough accumulators that no addition waits for
// another.
#if defined(__x86_64__)
#define STYLED_EACH_WIDTH __attribute__((target_clones("avx512f", "avx2,fma", "default")))
#else
#define STYLED_EACH_WIDTH
#endif
constexpr std::size_t kAtOnce = 8;
using Words = std::uint32_t __attribute__((vector_size(64)));
using Floats = float __attribute__((vector_size(64)));

STYLED_EACH_WIDTH std::uint32_t ReadAll(const Words* words, std::size_t count) {
  Words sums[kAtOnce] = {};
  for (std::size_t i = 0; i + kAtOnce <= count; i += kAtOnce) {
    for (std::size_t k = 0; k < kAtOnce; ++k) sums[k] ^= words[i + k];
  }
  for (std::size_t k = 1; k < kAtOnce; ++k) sums[0] ^= sums[k];
  return sums[0][0] ^ sums[0][7] ^ sums[0][15];
}

// `kParts`: of a float32, 4 for weights in int8.
template <Shape kShape, std::size_t kParts>
void ReadWeights(benchmark::State& state) {
  const std::size_t bytes = StepBytes<kShape>(static_cast<std::size_t>(state.range(0))) / kParts;
  std::vector<Words> words(bytes / sizeof(Words), Words{} + 1);
  for (auto _ : state) benchmark::DoNotOptimize(ReadAll(words.data(), words.size()));
  state.counters["kB"] = static_cast<double>(bytes) * 1e-3;
}

STYLED_EACH_WIDTH float MultiplyAll(std::size_t count, float factor) {
  Floats sums[2 * kAtOnce];
  for (std::size_t k = 0; k < 2 * kAtOnce; ++k) sums[k] = Floats{} + static_cast<float>(k);
  for (std::size_t i = 0; i < count; i += 2 * kAtOnce) {
    for (std::size_t k = 0; k < 2 * kAtOnce; ++k) sums[k] = sums[k] * factor + 0.5F;
  }
  for (std::size_t k = 1; k < 2 * kAtOnce; ++k) sums[0] += sums[k];
  return sums[0][0] + sums[0][7] + sums[0][15];
}

// The other bound: the same number of multiplications and additions, from registers.
void MultiplyWeights(benchmark::State& state) {
  const std::size_t floats =
      StepBytes<kPaper>(static_cast<std::size_t>(state.range(0))) / sizeof(float);
  float factor = 0.5F;
  for (auto _ : state) {
    benchmark::DoNotOptimize(factor);
    benchmark::DoNotOptimize(MultiplyAll(floats / 16, factor));
  }
}

// Steps at 120 Hz; the process sleeps in between. Like the pipeline's prewarming, an extra step is
// computed and discarded some microseconds before the real one is due (0: none). The rest of that
// time is slept, as in a blocking loop, or polled, as in a hybrid one.
void Paced(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::nanoseconds kPeriod{1'000'000'000 / 120};
  const std::chrono::microseconds before{state.range(0)};
  const bool polled = state.range(1) != 0;
  prctl(PR_SET_TIMERSLACK, 1UL);  // like the pipeline's thread
  OurRun run(1);
  State scratch;
  net::Prediction nothing;
  std::vector<double> times_us, prewarm_us;
  auto due = Clock::now();
  const auto since_us = [](Clock::time_point begin) {
    return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
  };
  for (auto _ : state) {
    due += kPeriod;
    if (before.count() > 0) {
      std::this_thread::sleep_until(due - before);
      const auto begin = Clock::now();
      scratch = run.state;
      run.network->Step(run.frames.front(), 0, run.active, scratch, nothing);
      benchmark::DoNotOptimize(nothing);
      prewarm_us.push_back(since_us(begin));
    }
    while (polled && Clock::now() < due) {
    }
    std::this_thread::sleep_until(due);
    const auto begin = Clock::now();
    run.Step();
    benchmark::DoNotOptimize(run.out);
    times_us.push_back(since_us(begin));
    state.SetIterationTime(times_us.back() * 1e-6);
  }
  const auto median = [](std::vector<double>& values) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  };
  state.counters["p50_us"] = median(times_us);
  state.counters["p99_us"] = times_us[times_us.size() * 99 / 100];
  if (!prewarm_us.empty()) state.counters["prewarm_p50_us"] = median(prewarm_us);
}

// Several performers, each as Run; the result is per performer.
template <typename Run, bool Together>
void Crowd(benchmark::State& state) {
  const auto count = static_cast<std::size_t>(state.range(0));
  std::vector<Run> runs;
  for (std::size_t k = 0; k < count; ++k) runs.emplace_back(1);
  for (Run& run : runs) run.network = runs.front().network;
  std::vector<typename Run::Job> jobs(count);
  for (auto _ : state) {
    if constexpr (Together) {
      for (std::size_t k = 0; k < count; ++k) {
        Run& run = runs[k];
        jobs[k] = {&run.NextFrame(), 0, run.active, &run.state, &run.out};
      }
      runs.front().network->StepTogether(jobs);
    } else {
      for (Run& run : runs) run.Step();
    }
    benchmark::ClobberMemory();
  }
  state.counters["each"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(count),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void Styles(benchmark::internal::Benchmark* bench) {
  bench->ArgName("styles")->Arg(0)->Arg(1)->Arg(4)->Unit(benchmark::kMicrosecond);
}
BENCHMARK(Hot<OurRun>)->Apply(Styles);
BENCHMARK(Hot<ContentsRun<5>>)->Apply(Styles);
BENCHMARK(Hot<ContentsRun<64>>)->Apply(Styles);
BENCHMARK(Hot<WideRun>)->Apply(Styles);
BENCHMARK(Hot<PlainRun>)->Apply(Styles);
BENCHMARK(ReadWeights<kPaper, 1>)->Name("ReadWeights")->Apply(Styles);
BENCHMARK(Hot<ShippedRun>)->Apply(Styles);
BENCHMARK(ReadWeights<kWide, 4>)->Name("ReadWeights<ShippedRun>")->Apply(Styles);
BENCHMARK(MultiplyWeights)->Apply(Styles);
void Performers(benchmark::internal::Benchmark* bench) {
  bench->ArgName("performers")->Arg(8)->Arg(64)->Arg(512);
}
BENCHMARK(Crowd<OurRun, false>)->Apply(Performers);
BENCHMARK(Crowd<OurRun, true>)->Apply(Performers);
BENCHMARK(Crowd<ContentsRun<5>, true>)->Apply(Performers);
BENCHMARK(Crowd<WideRun, false>)->Apply(Performers);
BENCHMARK(Crowd<WideRun, true>)->Apply(Performers);
BENCHMARK(Crowd<ShippedRun, false>)->Apply(Performers);
BENCHMARK(Crowd<ShippedRun, true>)->Apply(Performers);
BENCHMARK(Cold<OurRun>)->Apply(Styles)->UseManualTime()->Iterations(2000);
BENCHMARK(Cold<WideRun>)->Apply(Styles)->UseManualTime()->Iterations(2000);
BENCHMARK(Cold<ShippedRun>)->Apply(Styles)->UseManualTime()->Iterations(2000);
BENCHMARK(Cold<PlainRun>)->Apply(Styles)->UseManualTime()->Iterations(2000);
BENCHMARK(Paced)
    ->ArgNames({"before_us", "polled"})
    ->Args({0, 0})
    ->Args({50, 0})
    ->Args({100, 0})
    ->Args({250, 0})
    ->Args({250, 1})
    ->UseManualTime()
    ->Iterations(480)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace styled::erd

int main(int argc, char** argv) {
  benchmark::AddCustomContext("simd_target", styled::net::BestKernels().target);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}

// One step of the network, and the same in plain Eigen: hot, and after 8 MB of other work has gone
// through the caches, which is how a step at 120 Hz finds them. Never asserted by wall time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "model/erd/kernel.h"
#include "model/erd/weights.h"
#include "tests/bench/plain_step.h"
#include "tests/bench/step_run.h"

namespace styled::erd {
namespace {

struct OurRun : StepRun {
  explicit OurRun(int styles) : StepRun(RandomNetwork(16, 1), styles) {}
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

// What this machine's caches can do at best: the bytes of a step's weights, read once, in order.
template <int Rows, int Columns>
constexpr std::size_t kBytes = sizeof(PackedMatrix<Rows, Columns>);
constexpr std::size_t StepBytes(std::size_t styles) {
  return kBytes<kEncoderWidth, body::kFeatureCount> + kBytes<kLatent, kEncoderWidth> +
         (kNeutralLayers + styles * kStyleLayers) * kBytes<kGates, 2 * kLatent> +
         kBytes<kDecoderWidths[0], kLatent> + kBytes<kDecoderWidths[1], kDecoderWidths[0]> +
         kBytes<kDecoderWidths[2], kDecoderWidths[1]> + kBytes<kHeads, kDecoderWidths[2]>;
}

#if defined(__x86_64__)
__attribute__((target_clones("avx512f", "avx2", "default")))
#endif
std::uint32_t
ReadAll(const std::uint32_t* words, std::size_t count) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += words[i];
  return sum;
}

void ReadWeights(benchmark::State& state) {
  const std::size_t bytes = StepBytes(static_cast<std::size_t>(state.range(0)));
  std::vector<std::uint32_t> words(bytes / sizeof(std::uint32_t), 1);
  for (auto _ : state) benchmark::DoNotOptimize(ReadAll(words.data(), words.size()));
  state.counters["kB"] = static_cast<double>(bytes) * 1e-3;
}

// So many performers, each as OurRun; per performer.
template <bool Together>
void Crowd(benchmark::State& state) {
  const auto count = static_cast<std::size_t>(state.range(0));
  std::vector<OurRun> runs;
  for (std::size_t k = 0; k < count; ++k) runs.emplace_back(1);
  for (OurRun& run : runs) run.network = runs.front().network;
  std::vector<StepJob> jobs(count);
  for (auto _ : state) {
    if constexpr (Together) {
      for (std::size_t k = 0; k < count; ++k) {
        OurRun& run = runs[k];
        jobs[k] = {&run.NextFrame(), 0, run.active, &run.state, &run.out};
      }
      runs.front().network->StepTogether(jobs);
    } else {
      for (OurRun& run : runs) run.Step();
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
BENCHMARK(Hot<PlainRun>)->Apply(Styles);
BENCHMARK(ReadWeights)->Apply(Styles);
BENCHMARK(Crowd<false>)->ArgName("performers")->Arg(8)->Arg(64)->Arg(512);
BENCHMARK(Crowd<true>)->ArgName("performers")->Arg(8)->Arg(64)->Arg(512);
BENCHMARK(Cold<OurRun>)->Apply(Styles)->UseManualTime()->Iterations(2000);
BENCHMARK(Cold<PlainRun>)->Apply(Styles)->UseManualTime()->Iterations(2000);

}  // namespace
}  // namespace styled::erd

int main(int argc, char** argv) {
  benchmark::AddCustomContext("simd_target", styled::erd::BestKernels().target);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}

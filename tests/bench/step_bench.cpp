// One step of the network: hot, and after 8 MB of other work has gone through the caches, which is
// how a step at 120 Hz finds them. Never asserted by wall time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "tests/unit/erd/random_weights.h"

namespace styled::erd {
namespace {

constexpr int kFrames = 256;
constexpr std::size_t kOtherWork = std::size_t{8} << 20;

struct Run {
  std::shared_ptr<const Network> network = RandomNetwork(16, 1);
  std::vector<body::Features> frames{kFrames};
  std::vector<ActiveStyle> active;
  State state;
  StepOutput out;
  int frame = 0;

  explicit Run(int styles) {
    for (int f = 0; f < kFrames; ++f) {
      for (int i = 0; i < body::kFeatureCount; ++i) {
        frames[f][i] = 0.5F * std::sin(0.01F * static_cast<float>(f * (1 + i % 7) + 37 * i));
      }
    }
    for (int s = 1; s <= styles; ++s) active.push_back({s, 1.0F / static_cast<float>(styles)});
    network->Start(state);
  }
  void Step() {
    network->Step(frames[frame++ % kFrames], 0, active, state, out);
    benchmark::DoNotOptimize(out);
  }
};

void StepHot(benchmark::State& state) {
  Run run(static_cast<int>(state.range(0)));
  for (auto _ : state) run.Step();
}

void StepCold(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  Run run(static_cast<int>(state.range(0)));
  const std::vector<int> other(kOtherWork / sizeof(int), 1);
  std::vector<double> times_us;
  for (auto _ : state) {
    benchmark::DoNotOptimize(std::accumulate(other.begin(), other.end(), 0));
    const auto begin = Clock::now();
    run.Step();
    const double time_s = std::chrono::duration<double>(Clock::now() - begin).count();
    state.SetIterationTime(time_s);
    times_us.push_back(time_s * 1e6);
  }
  std::sort(times_us.begin(), times_us.end());
  state.counters["p50_us"] = times_us[times_us.size() / 2];
  state.counters["p99_us"] = times_us[times_us.size() * 99 / 100];
}

BENCHMARK(StepHot)->ArgName("styles")->Arg(0)->Arg(1)->Arg(4)->Unit(benchmark::kMicrosecond);
BENCHMARK(StepCold)
    ->ArgName("styles")
    ->Arg(0)
    ->Arg(1)
    ->Arg(4)
    ->UseManualTime()
    ->Iterations(2000)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace styled::erd

BENCHMARK_MAIN();

// One step of the network: hot, and after 8 MB of other work has gone through the caches, which is
// how a step at 120 Hz finds them. Never asserted by wall time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "tests/bench/step_run.h"

namespace styled::erd {
namespace {

void StepHot(benchmark::State& state) {
  StepRun run(RandomNetwork(16, 1), static_cast<int>(state.range(0)));
  for (auto _ : state) {
    run.Step();
    benchmark::DoNotOptimize(run.out);
  }
}

void StepCold(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  StepRun run(RandomNetwork(16, 1), static_cast<int>(state.range(0)));
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

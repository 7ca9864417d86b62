// One step of the network, and the same in plain Eigen: hot, and after 8 MB of other work has gone
// through the caches, which is how a step at 120 Hz finds them. Never asserted by wall time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "model/erd/kernel.h"
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

void Styles(benchmark::internal::Benchmark* bench) {
  bench->ArgName("styles")->Arg(0)->Arg(1)->Arg(4)->Unit(benchmark::kMicrosecond);
}
BENCHMARK(Hot<OurRun>)->Apply(Styles);
BENCHMARK(Hot<PlainRun>)->Apply(Styles);
BENCHMARK(Cold<OurRun>)->Apply(Styles)->UseManualTime()->Iterations(2000);
BENCHMARK(Cold<PlainRun>)->Apply(Styles)->UseManualTime()->Iterations(2000);

}  // namespace
}  // namespace styled::erd

int main(int argc, char** argv) {
  benchmark::AddCustomContext("simd_target", styled::erd::BestKernels().target);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}

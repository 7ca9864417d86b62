// The whole stylist per frame, from binding to feet, with the synthetic performer at 120 Hz, beside
// one step of the network in plain Eigen, which serves as a unit that stays the same from commit to
// commit. Random weights: the cost depends on shapes, not on values. No assertion on wall time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "model/rig/dialects.h"
#include "model/stylist/stylist.h"
#include "model/synthetic/performer.h"
#include "tests/bench/plain_step.h"
#include "tests/bench/step_run.h"

namespace styled {
namespace {

constexpr double kRate_hz = 120;

struct Stream {
  rig::Skeleton skeleton = synthetic::MakeSkeleton({});
  std::vector<rig::RigPose> frames;
  std::shared_ptr<const rig::Binding> binding;
  std::shared_ptr<const net::Stylizer> network;

  explicit Stream(bool wide)
      : network(erd::RandomStylizer(16, 1, wide ? erd::kWide : erd::kPaper)) {
    auto bound = rig::BindDialect(skeleton, "auto");
    binding = std::make_shared<const rig::Binding>(std::move(bound.value()));
    synthetic::Performer performer(synthetic::Options{});
    for (int i = 0; i < 2400; ++i) {
      body::Pose pose;
      performer.Pose(i / kRate_hz, pose);
      rig::RigPose frame(skeleton);
      frame.translations[0] = pose.hips_position_m;
      std::copy(pose.rotations.begin(), pose.rotations.end(), frame.rotations.begin());
      frames.push_back(frame);
    }
  }
};

// `state.range(0)`: number of styles in the mix; `state.range(1)`: whether feet are held;
// `state.range(2)`: whether the network is wide.
void WholeStylist(benchmark::State& state) {
  const Stream stream(state.range(2) != 0);
  stylist::Options options;
  options.feet = state.range(1) != 0;
  stylist::Stylist stylist(stream.network, stream.binding, options);
  stylist::Settings settings;
  const auto styles = static_cast<std::size_t>(state.range(0));
  for (std::size_t i = 0; i < styles; ++i) {
    settings.mix[i] = {static_cast<int>(i) + 1, 1.0F / static_cast<float>(styles)};
  }
  settings.transition_s = 0;
  stylist.Set(settings);
  stylist::Output out(stream.skeleton);
  std::int64_t frame = 0;
  for (auto _ : state) {
    const auto time_ns = static_cast<std::int64_t>(1e9 * static_cast<double>(frame) / kRate_hz);
    stylist.Process(time_ns + 1, stream.frames[frame % stream.frames.size()], out);
    benchmark::DoNotOptimize(out);
    ++frame;
  }
}
BENCHMARK(WholeStylist)
    ->ArgNames({"styles", "feet", "wide"})
    ->Args({0, 0, 0})
    ->Args({1, 0, 0})
    ->Args({1, 1, 0})
    ->Args({4, 1, 0})
    ->Args({0, 0, 1})
    ->Args({1, 0, 1})
    ->Args({1, 1, 1})
    ->Args({4, 1, 1})
    ->Unit(benchmark::kMicrosecond);

// The unit: one step of the network, one style, in plain Eigen.
void PlainStep(benchmark::State& state) {
  erd::StepRun run(erd::RandomNetwork(16, 1), 1);
  erd::PlainStep plain(erd::RandomWeights(16, 1), run.active);
  for (auto _ : state) {
    plain.Step(run.NextFrame(), run.out);
    benchmark::DoNotOptimize(run.out);
  }
}
BENCHMARK(PlainStep)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace styled

BENCHMARK_MAIN();

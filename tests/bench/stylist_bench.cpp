// The whole stylist per frame, from binding to feet, with the synthetic performer at 120 Hz, beside
// one step of the network in plain Eigen, which serves as a unit that stays the same from commit to
// commit. Random weights: the cost depends on shapes, not on values. No assertion on wall time.
#include <benchmark/benchmark.h>
#include <hwy/targets.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include "model/net/load.h"
#include "model/net/several.h"
#include "model/net/shipped_weights.h"
#include "model/net/weights_file.h"
#include "model/rig/dialects.h"
#include "model/stylist/stylist.h"
#include "model/synthetic/performer.h"
#include "tests/bench/plain_step.h"
#include "tests/bench/step_run.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled {
namespace {

constexpr double kRate_hz = 120;

// The networks: Style-ERD in the paper's shape and as shipped, the causal graph network as shipped,
// the last two as one; the shipped file of styles that are measured; the three as in the daemon;
// and the second with AVX2 alone; with weights in int8, as it ships, and that with AVX2 alone. The
// numbers stay, since benchmarks are compared by them.
enum Network {
  kPaper,
  kWide,
  kGraph,
  kBoth,
  kMeasured,
  kAll,
  kWideAvx2 = 7,
  kWideInt8 = 9,
  kWideInt8Avx2
};

std::shared_ptr<const net::Stylizer> MakeNetwork(int network);

// With AVX2 alone, as on a processor without AVX-512.
std::shared_ptr<const net::Stylizer> MakeForAvx2(int network) {
  const auto targets = [](std::int64_t set) {
    hwy::SetSupportedTargetsForTest(set);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  };
  targets(HWY_AVX2);
  auto made = MakeNetwork(network);
  targets(0);
  return made;
}

std::shared_ptr<const net::Stylizer> MakeNetwork(int network) {
  if (network == kWideAvx2) return MakeForAvx2(kWide);
  if (network == kWideInt8Avx2) return MakeForAvx2(kWideInt8);
  const auto graph = [] {
    return net::Parse(stgcn_causal::RandomWeights(7, 32, 1).Bytes(), "graph").value();
  };
  const auto wide = [network] {
    erd::WeightsFile file = erd::RandomWeights(16, 1, erd::kWide);
    file.metadata["version"] = net::kWeightsVersion;
    file.metadata["reference"] = net::AsJson(neutral::Reference());
    const net::Precision precision =
        network == kWideInt8 ? net::Precision::kInt8 : net::Precision::kFloat32;
    return net::Parse(file.Bytes(), "wide", precision).value();
  };
  if (network == kPaper) return erd::RandomStylizer(16, 1, erd::kPaper);
  if (network == kWide || network == kWideInt8) return wide();
  if (network == kGraph) return graph();
  const auto measured = [] { return net::Load(net::FindWeights("open").value()).value(); };
  if (network == kMeasured) return measured();
  if (network == kAll) {
    return net::Combine({{"v2", wide()}, {"graph", graph()}, {"open", measured()}}).value();
  }
  return net::Combine({{"v2", wide()}, {"graph", graph()}}).value();
}

struct Stream {
  rig::Skeleton skeleton = synthetic::MakeSkeleton({});
  std::vector<rig::RigPose> frames;
  std::shared_ptr<const rig::Binding> binding;
  std::shared_ptr<const net::Stylizer> network;

  explicit Stream(int which) : network(MakeNetwork(which)) {
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
// `state.range(2)`: the network; `state.range(3)`: whether the performer's neutral is taken out,
// which only kWide and kBoth can do.
void WholeStylist(benchmark::State& state) {
  const Stream stream(static_cast<int>(state.range(2)));
  stylist::Options options;
  options.feet = state.range(1) != 0;
  options.neutral = state.range(3) != 0;
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
    ->ArgNames({"styles", "feet", "network", "neutral"})
    ->Args({0, 0, 0, 0})
    ->Args({1, 0, 0, 0})
    ->Args({1, 1, 0, 0})
    ->Args({4, 1, 0, 0})
    ->Args({0, 0, 1, 1})
    ->Args({1, 0, 1, 1})
    ->Args({1, 1, 1, 0})
    ->Args({1, 1, 1, 1})
    ->Args({4, 1, 1, 1})
    ->Args({1, 1, kWideAvx2, 1})
    ->Args({1, 0, kWideInt8, 1})
    ->Args({1, 1, kWideInt8, 1})
    ->Args({1, 1, kWideInt8Avx2, 1})
    ->Args({0, 1, kGraph, 0})
    ->Args({1, 1, kGraph, 0})
    ->Args({1, 1, kBoth, 0})
    ->Args({1, 1, kBoth, 1})
    ->Args({1, 1, kAll, 1})
    ->Args({0, 1, kMeasured, 1})
    ->Args({1, 0, kMeasured, 1})
    ->Args({1, 1, kMeasured, 1})
    ->Unit(benchmark::kMicrosecond);

// 64 performers in one style each, whose states together are larger than the caches: a frame each,
// `state.range(1)` at a time. Reported per frame; and how many such performers one core has time
// for at 120 Hz.
void Crowd(benchmark::State& state) {
  const Stream stream(static_cast<int>(state.range(0)));
  const auto together = static_cast<std::size_t>(state.range(1));
  constexpr std::size_t kPerformers = 64;
  std::vector<stylist::Stylist> stylists;
  std::vector<stylist::Output> outs;
  std::vector<stylist::Stylist::Job> jobs(kPerformers);
  for (std::size_t i = 0; i < kPerformers; ++i) {
    stylists.emplace_back(stream.network, stream.binding, stylist::Options{});
    outs.emplace_back(stream.skeleton);
    stylist::Settings settings;
    settings.mix[0] = {static_cast<int>(i % 6) + 1, 1.0F};
    settings.transition_s = 0;
    stylists.back().Set(settings);
  }
  std::size_t frame = 0;
  for (auto _ : state) {
    const auto time_ns = static_cast<std::int64_t>(1e9 * static_cast<double>(frame) / kRate_hz);
    for (std::size_t i = 0; i < kPerformers; ++i) {
      jobs[i] = {&stylists[i], time_ns + 1, &stream.frames[(frame + 17 * i) % stream.frames.size()],
                 &outs[i]};
    }
    for (std::size_t i = 0; i < kPerformers; i += together) {
      stylist::Stylist::ProcessTogether(std::span(jobs).subspan(i, together));
    }
    ++frame;
  }
  const auto frames = static_cast<double>(state.iterations() * kPerformers);
  state.counters["us_per_frame"] =
      benchmark::Counter(frames / 1e6, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["performers_per_core"] =
      benchmark::Counter(frames / kRate_hz, benchmark::Counter::kIsRate);
}
BENCHMARK(Crowd)
    ->ArgNames({"network", "together"})
    ->Args({kWide, 1})
    ->Args({kWide, 8})
    ->Args({kWide, 16})
    ->Args({kWideAvx2, 16})
    ->Args({kWideInt8, 1})
    ->Args({kWideInt8, 16})
    ->Args({kWideInt8Avx2, 16})
    ->Args({kGraph, 1})
    ->Args({kGraph, 8})
    ->Args({kMeasured, 1})
    ->Args({kMeasured, 8})
    ->Unit(benchmark::kMillisecond);

// One performer, with the time between frames slept away, as live: caches are cold.
void Paced(benchmark::State& state) {
  const Stream stream(static_cast<int>(state.range(0)));
  stylist::Stylist stylist(stream.network, stream.binding, {});
  stylist::Settings settings;
  settings.mix[0] = {1, 1.0F};
  settings.transition_s = 0;
  stylist.Set(settings);
  stylist::Output out(stream.skeleton);
  std::int64_t frame = 0;
  for (auto _ : state) {
    std::this_thread::sleep_for(std::chrono::duration<double>(1 / kRate_hz));
    const auto time_ns = static_cast<std::int64_t>(1e9 * static_cast<double>(frame) / kRate_hz);
    const auto begun = std::chrono::steady_clock::now();
    stylist.Process(time_ns + 1, stream.frames[frame % stream.frames.size()], out);
    state.SetIterationTime(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
    ++frame;
  }
}
BENCHMARK(Paced)
    ->ArgName("network")
    ->Arg(kWide)
    ->Arg(kWideAvx2)
    ->Arg(kWideInt8)
    ->Arg(kGraph)
    ->UseManualTime()
    ->Iterations(360)
    ->Unit(benchmark::kMicrosecond);

// One step of the styles that are measured, of a performer who walks; and what the stylist does for
// them beside it in each frame: `state.range(0)`: 0 the step, 1 the performer's gait and neutral
// with gaits, 2 without gaits.
void MeasuredStep(benchmark::State& state) {
  const auto network = MakeNetwork(kMeasured);
  neutral::Reference reference = *network->model().reference;
  if (state.range(0) == 2) reference.gaits.reset();
  synthetic::Performer performer({.seed = 1, .script = synthetic::ParseScript("walk:600").value()});
  std::vector<body::Pose> poses(2400);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    performer.Pose(static_cast<double>(i) / kRate_hz, poses[i]);
  }
  neutral::Neutral neutral;
  for (const body::Pose& pose : poses) neutral.Follow(pose, 1 / kRate_hz, true, reference);
  const auto stream = network->MakeStream();
  network->Start(*stream);
  const net::StyleWeight style{1, 1};
  net::Prediction out;
  std::size_t frame = 0;
  for (auto _ : state) {
    const body::Pose& pose = poses[frame % poses.size()];
    if (state.range(0) == 0) {
      const net::Performer known{&pose, &neutral, &reference, 0.08F, 0};
      const net::StepJob job{&pose, 0, {&style, 1}, stream.get(), &out, {}, &known};
      network->Step({&job, 1});
      benchmark::DoNotOptimize(out);
    } else {
      neutral.Follow(pose, 1 / kRate_hz, true, reference);
      benchmark::DoNotOptimize(neutral);
    }
    ++frame;
  }
}
BENCHMARK(MeasuredStep)->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMicrosecond);

// A style of an example, as `like` makes it on the thread of files: 10 s of a walk.
void Example(benchmark::State& state) {
  const auto network = MakeNetwork(static_cast<int>(state.range(0)));
  synthetic::Performer performer({.seed = 1, .script = synthetic::ParseScript("walk:600").value()});
  const double rate_hz = static_cast<double>(network->model().rate_hz);
  std::vector<body::Pose> poses(static_cast<std::size_t>(10 * rate_hz));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    performer.Pose(static_cast<double>(i) / rate_hz, poses[i]);
  }
  net::StyleRequest request;
  request.sources.push_back({.style = -1, .seed = {}, .reference = poses, .weight = 1});
  for (auto _ : state) benchmark::DoNotOptimize(network->space()->MakeCode(request));
}
BENCHMARK(Example)->ArgName("network")->Arg(kGraph)->Arg(kMeasured)->Arg(kAll)->Unit(
    benchmark::kMillisecond);

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

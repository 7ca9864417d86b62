// From a rig's datagrams to published frames: translator, outbox and pipeline as in the daemon,
// without sockets, with the synthetic performer at 60 Hz. "HandedOn" ends where the pipeline copies
// the pose, so it measures the translation only; "Published" also styles the pose and serializes
// one topic. Random weights: the cost depends on shapes, not on values. No assertion on wall time.
#include <benchmark/benchmark.h>

#include <memory>
#include <string>
#include <vector>

#include "daemon/pipeline/pipeline.h"
#include "daemon/source/rigs/make.h"
#include "model/net/load.h"
#include "model/net/shipped_weights.h"
#include "model/synthetic/performer.h"
#include "sim/rigs/rig.h"
#include "tests/bench/plain_step.h"
#include "tests/support/native_frames.h"
#include "tests/support/rig.h"

namespace styled {
namespace {

constexpr double kRate_hz = 60;
constexpr auto kPeriod_ns = static_cast<std::int64_t>(1e9 / kRate_hz);
using Datagram = std::vector<std::byte>;

// The datagrams of a simulated rig, frame by frame.
std::vector<std::vector<Datagram>> Record(const std::string& type) {
  auto rig = rigs::Make(type, {{"sim"}, kRate_hz, 1, {}});
  synthetic::Performer performer(synthetic::Options{});
  std::vector<std::vector<Datagram>> frames(1200);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double time_s = static_cast<double>(i) / kRate_hz;
    body::Pose pose;
    performer.Pose(time_s, pose);
    rig.value()->Encode({i, time_s, {&pose, 1}}, [&](std::span<const std::byte> bytes) {
      frames[i].emplace_back(bytes.begin(), bytes.end());
    });
  }
  return frames;
}

struct Clock final : runtime::Clock {
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
  std::int64_t now_ns = 1'000'000'000;
};

struct Publisher final : publish::Publisher {
  explicit Publisher(std::string the_topic) : topic(std::move(the_topic)) {}
  void Send(std::string_view, std::span<const std::byte> payload) noexcept override {
    bytes += payload.size();
    ++messages;
  }
  bool NextSubscription(publish::SubscriptionEvent& event) override {
    event = {true, topic};
    return std::exchange(asking, false);
  }
  int fd() const override { return -1; }
  std::size_t bytes = 0, messages = 0;
  std::string topic;
  bool asking = true;
};

// The part of the pipeline up to the copy of the pose.
struct Copies final : source::Receiver {
  void OnFrames(int, std::span<const source::SourceFrame> frames, bool) override {
    for (const source::SourceFrame& frame : frames) {
      const auto joints = static_cast<int>(frame.rotations.size() / sizeof(rig::Quat));
      if (frame.is_body) continue;
      pose.rotations.resize(static_cast<std::size_t>(joints));
      pose.translations.resize(1);
      if (source::CopyPose(frame, joints, pose)) ++copied;
    }
  }
  rig::RigPose pose{rig::Skeleton{}};
  std::size_t copied = 0;
};

class Sender {
 public:
  explicit Sender(const std::string& type) : frames_(Record(type)) {
    config::Source config;
    config.name = "rig";
    config.type = type;
    config.performer = "sim";
    translator_ = source::MakeTranslator(config);
  }
  void Next(source::Receiver& receiver, std::int64_t now_ns) {
    outbox_.Open(receiver, -1);
    for (const Datagram& datagram : frames_[next_ % frames_.size()]) {
      translator_->Handle(datagram, source::Peer(), now_ns, outbox_);
    }
    translator_->Tick(now_ns, outbox_);
    outbox_.Close();
    ++next_;
  }

 private:
  std::vector<std::vector<Datagram>> frames_;
  runtime::Counters counters_;
  source::Outbox outbox_{0, counters_};
  std::unique_ptr<source::Translator> translator_;
  std::size_t next_ = 0;
};

void HandedOn(benchmark::State& state, const std::string& type) {
  Sender sender(type);
  Clock clock;
  Copies receiver;
  for (auto _ : state) {
    clock.now_ns += kPeriod_ns;
    sender.Next(receiver, clock.now_ns);
  }
  state.counters["frames"] =
      static_cast<double>(receiver.copied) / static_cast<double>(state.iterations());
}

void Published(benchmark::State& state, const std::string& type) {
  Sender sender(type);
  Clock clock;
  runtime::Counters counters;
  Publisher publisher("styled/rig.sim/canonical/");
  pipeline::Mailboxes mailboxes;
  auto config = std::make_shared<pipeline::RuntimeConfig>();
  config->network = erd::RandomStylizer(16, 1);
  pipeline::Pipeline pipeline({clock, counters, publisher, mailboxes}, {"rig"}, {}, config, 1, 100);
  for (auto _ : state) {
    clock.now_ns += kPeriod_ns;
    sender.Next(pipeline, clock.now_ns);
    while (pipeline.DoWork() > 0) continue;
  }
  state.counters["frames"] = static_cast<double>(counters.Get(runtime::Counter::kPipelineFrames)) /
                             static_cast<double>(state.iterations());
}

// 64 performers in the shipped style, whose frames arrive in full batches: `state.range(0)` threads
// style them. From the decoded datagrams to the published bundle, in real time per frame.
void Crowd(benchmark::State& state) {
  constexpr int kPerformers = 64;
  const auto threads = static_cast<int>(state.range(0));
  runtime::Helpers helpers(threads - 1);
  runtime::SystemClock clock;
  runtime::Counters counters;
  Publisher publisher("frames/rig/");
  pipeline::Mailboxes mailboxes;
  auto config = std::make_shared<pipeline::RuntimeConfig>();
  config->network = net::Load(state.range(1) == 0 ? net::FindWeights("v2").value()
                                                  : net::FindWeights("graph").value(),
                              net::Precision::kInt8)
                        .value();
  config->style.initial = "elderly";
  pipeline::Pipeline pipeline({.clock = clock,
                               .counters = counters,
                               .publisher = publisher,
                               .mailboxes = mailboxes,
                               .helpers = threads == 1 ? nullptr : &helpers},
                              {"rig"}, {}, config, 1, 100);
  std::vector<support::Rig> rigs;
  for (int i = 0; i < kPerformers; ++i) rigs.emplace_back("p" + std::to_string(i), 7 + i);
  // Calls deliver(datagrams) for each full batch.
  const auto in_batches = [&rigs](auto make, auto deliver) {
    for (std::size_t from = 0; from < rigs.size(); from += source::kBatch) {
      std::vector<support::Bytes> datagrams;
      for (std::size_t i = 0; i < source::kBatch; ++i) datagrams.push_back(make(rigs[from + i]));
      const std::vector<std::span<const std::byte>> spans(datagrams.begin(), datagrams.end());
      deliver(spans);
    }
  };
  const auto hand_on = [&](std::span<const std::span<const std::byte>> datagrams) {
    support::HandOn(datagrams, {}, counters, pipeline);
  };
  while (pipeline.DoWork() > 0) continue;
  in_batches([](support::Rig& rig) { return rig.Body(); }, hand_on);
  while (pipeline.DoWork() > 0) continue;
  for (auto _ : state) {
    state.PauseTiming();
    in_batches([](support::Rig& rig) { return rig.Frame(); },
               [&](std::span<const std::span<const std::byte>> datagrams) {
                 state.ResumeTiming();
                 hand_on(datagrams);
                 state.PauseTiming();
               });
    state.ResumeTiming();
  }
  const auto frames = static_cast<double>(state.iterations() * kPerformers);
  state.counters["us_per_frame"] =
      benchmark::Counter(frames / 1e6, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

BENCHMARK(Crowd)
    ->ArgNames({"threads", "graph"})
    ->ArgsProduct({{1, 2}, {0, 1}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(HandedOn, vmc, "vmc");
BENCHMARK_CAPTURE(HandedOn, mvn, "mvn");
BENCHMARK_CAPTURE(HandedOn, mocopi, "mocopi");
BENCHMARK_CAPTURE(Published, vmc, "vmc");
BENCHMARK_CAPTURE(Published, mvn, "mvn");
BENCHMARK_CAPTURE(Published, mocopi, "mocopi");

}  // namespace
}  // namespace styled

BENCHMARK_MAIN();

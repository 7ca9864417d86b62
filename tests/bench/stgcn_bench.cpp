// Whole clips through the spatio-temporal network, clips per second on one core: encoded and
// decoded once (the styled clip), decoded twice (the detail-preserving form), and the style
// encoder. Where libtorch is built, its forward pass of the same network, weights and clips beside
// ours, in one run. Timed in turn in many short rounds, so that other load on the machine affects
// all alike; medians are compared. No assertion on wall time.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "tests/unit/net/stgcn/random_weights.h"

namespace styled::stgcn {
namespace {

constexpr int kRounds = 60;

struct Timing {
  std::string name;
  std::function<void()> run;
  std::size_t ours = 0;  // the timing that this one is compared with
  std::vector<double> times_us = {};

  void Round() {
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    run();
    times_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
  }
  double Median_us() {
    std::sort(times_us.begin(), times_us.end());
    return times_us[times_us.size() / 2];
  }
};

// Our network on one clip.
struct Ours {
  Ours(const Network& the_network, int frames)
      : network(the_network), clip(WalkFeatures(frames, network.features())), out(clip.size()) {}
  void Once() {
    network.Encode(clip, content, scratch);
    network.Decode(content, network.mean_code(1), out, scratch);
  }
  void Twice() {
    Once();
    network.Decode(content, network.mean_code(0), out, scratch);
  }
  const Network& network;
  std::vector<Features> clip, out;
  Network::Content content;
  Scratch scratch;
};

int Main(int width) {
  constexpr int kDomains = 7;
  const WeightsFile file = RandomWeights(kDomains, width, 1);
  const auto network = NetworkOf(file);
  Ours window(*network, 64), clip(*network, 300);
  Code code = Code::Zero();
  std::vector<Timing> timings{
      {"ours, 64 frames", [&] { window.Once(); }},
      {"ours, 300 frames", [&] { clip.Once(); }, 1},
      {"ours, 64 frames, decoded twice", [&] { window.Twice(); }},
      {"ours, style encoder, 64 frames",
       [&] { code += network->EncodeStyle(window.clip, kFreeHead, window.scratch); }, 3},
      {"ours, style encoder, 300 frames",
       [&] { code += network->EncodeStyle(clip.clip, kFreeHead, clip.scratch); }, 4},
  };
  for (int round = 0; round < kRounds + 1; ++round) {
    for (Timing& timing : timings) timing.Round();
    if (round > 0) continue;
    for (Timing& timing : timings) timing.times_us.clear();  // the first round warms up
  }
  std::printf("width %d, one core, SIMD target %s\n\n", width, net::BestRowKernels().target);
  std::printf("%-36s %9s %9s %9s\n", "", "p50 us", "clips/s", "of ours");
  for (Timing& timing : timings) {
    const double p50_us = timing.Median_us();
    std::printf("%-36s %9.1f %9.1f %8.2fx\n", timing.name.c_str(), p50_us, 1e6 / p50_us,
                p50_us / timings[timing.ours].Median_us());
  }
  return code.allFinite() ? 0 : 1;
}

}  // namespace
}  // namespace styled::stgcn

// The width is the argument; 64 without one, as the paper's.
int main(int argc, char** argv) {
  return styled::stgcn::Main(argc > 1 ? std::atoi(argv[1]) : 64);
}

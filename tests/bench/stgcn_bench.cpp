// Whole clips through the spatio-temporal network, clips per second on one core: encoded and
// decoded once (the styled clip), decoded twice (the detail-preserving form), and the style
// encoder; and 64 frames of a live stream through the causal one, frame by frame. Where libtorch is
// built, its forward pass of the same network, weights and clips beside ours, in one run. Timed in
// turn in many short rounds, so that other load on the machine affects all alike, in processor
// time; medians are compared, and the least. Nothing is asserted.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "tests/unit/net/stgcn/random_weights.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

#ifdef STYLED_STGCN_TORCH
#include <torch/torch.h>

#include "model/train/blas.h"
#include "tests/parity/stgcn_torch.h"
#include "tests/support/temporary_folder.h"
#endif

namespace styled::stgcn {
namespace {

constexpr int kRounds = 30;
constexpr int kClips = 5;  // one after the other in a round, as a folder of clips is styled

// The processor time of all threads: that of one core, whatever else runs on it.
double Cpu_us() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
}

struct Timing {
  std::string name;
  std::function<void()> run;
  std::size_t ours = 0;  // the timing that this one is compared with
  std::vector<double> times_us = {};

  void Round() {
    const double begin_us = Cpu_us();
    for (int clip = 0; clip < kClips; ++clip) run();
    times_us.push_back((Cpu_us() - begin_us) / kClips);
  }
  double Least_us() const { return *std::min_element(times_us.begin(), times_us.end()); }
  double Median_us() const {
    std::vector<double> sorted = times_us;
    std::nth_element(sorted.begin(), sorted.begin() + kRounds / 2, sorted.end());
    return sorted[kRounds / 2];
  }
};

// Our network on one clip.
struct Ours {
  Ours(const Network& the_network, int frames)
      : network(the_network), clip(WalkFeatures(frames, network.features())), out(clip.size()) {}
  void Once() {
    network.Encode(clip, content, scratch);
    network.Decode(content, network.space().mean_code(1), out, scratch);
  }
  void Twice() {
    Once();
    network.Decode(content, network.space().mean_code(0), out, scratch);
  }
  const Network& network;
  std::vector<Features> clip, out;
  Network::Content content;
  Scratch scratch;
};

// A stream of live frames: with a style the decoder runs twice.
struct Causal {
  Causal(int domains, int width, std::vector<net::StyleWeight> the_styles)
      : network(stgcn_causal::CausalNetwork(stgcn_causal::RandomWeights(domains, width, 1))),
        state(network->MakeState()),
        clip(WalkFeatures(kReference, network->features())),
        styles(std::move(the_styles)) {}
  void Run() {
    for (const Features& features : clip) network->Step(features, 0, styles, state, out);
  }
  std::shared_ptr<const stgcn_causal::Network> network;
  stgcn_causal::State state;
  std::vector<Features> clip;
  std::vector<net::StyleWeight> styles;
  stgcn_causal::Output out;
};

#ifdef STYLED_STGCN_TORCH
// The same work by libtorch, without gradients.
struct Torch {
  Torch(const parity::StgcnPair& the_pair, const Ours& ours)
      : pair(the_pair), x(pair.Standardized(ours.clip)), code(torch::zeros({1, kCode})) {}
  void Once() {
    const torch::NoGradGuard no_grad;
    const auto& g = pair.networks.generator;
    out = g.Decode(pair.graph, g.Encode(pair.graph, x), code);
  }
  void Style() {
    const torch::NoGradGuard no_grad;
    const auto& e = pair.networks.encoder;
    out = e.FreeCode(e.Features(pair.graph, x));
  }
  const parity::StgcnPair& pair;
  torch::Tensor x, code, out;
};

std::shared_ptr<const Network> LoadOrExit(const std::string& file) {
  const auto loaded = Network::Load(file);
  if (loaded.ok()) return loaded.value();
  std::fprintf(stderr, "%s\n", loaded.status().message().c_str());
  std::exit(1);
}
#endif

// Runs all in turn, prints a row for each.
void Compare(std::vector<Timing>& timings) {
  for (int round = 0; round < kRounds + 1; ++round) {
    for (Timing& timing : timings) timing.Round();
    if (round > 0) continue;
    for (Timing& timing : timings) timing.times_us.clear();  // the first round warms up
  }
  std::printf("%-36s %9s %9s %9s %9s %9s\n", "", "p50 us", "clips/s", "of ours", "least us",
              "of ours");
  for (const Timing& timing : timings) {
    const Timing& ours = timings[timing.ours];
    std::printf("%-36s %9.1f %9.1f %8.2fx %9.1f %8.2fx\n", timing.name.c_str(), timing.Median_us(),
                1e6 / timing.Median_us(), timing.Median_us() / ours.Median_us(), timing.Least_us(),
                timing.Least_us() / ours.Least_us());
  }
}

int Main(int width) {
  constexpr int kDomains = 7;
#ifdef STYLED_STGCN_TORCH
  torch::set_num_threads(1);
  const support::TemporaryFolder folder;
  const std::string file = folder / "weights.safetensors";
  const parity::StgcnPair pair(kDomains, width, 1, file);
  const auto network = LoadOrExit(file);
#else
  const auto network = NetworkOf(RandomWeights(kDomains, width, 1));
#endif
  Ours window(*network, 64), clip(*network, 300);
  Causal plain(kDomains, width, {}), styled(kDomains, width, {{1, 1.0F}});
  Code code = Code::Zero();
  std::vector<Timing> timings{
      {"ours, 64 frames", [&] { window.Once(); }, 0},
      {"ours, 300 frames", [&] { clip.Once(); }, 1},
      {"ours, 64 frames, decoded twice", [&] { window.Twice(); }, 0},
      {"ours, style encoder, 64 frames",
       [&] { code += network->space().EncodeStyle(window.clip, kFreeHead, window.scratch); }, 3},
      {"ours, causal, 64 frames, no style", [&] { plain.Run(); }, 0},
      {"ours, causal, 64 frames, styled", [&] { styled.Run(); }, 0},
  };
#ifdef STYLED_STGCN_TORCH
  Torch torch_window(pair, window), torch_clip(pair, clip);
  timings.push_back({"libtorch, 64 frames", [&] { torch_window.Once(); }, 0});
  timings.push_back({"libtorch, 300 frames", [&] { torch_clip.Once(); }, 1});
  timings.push_back({"libtorch, style encoder, 64 frames", [&] { torch_window.Style(); }, 3});
#endif
  std::printf("width %d, one core, SIMD target %s\n\n", width, net::BestRowKernels().target);
  Compare(timings);
  return code.allFinite() ? 0 : 1;
}

}  // namespace
}  // namespace styled::stgcn

// The width is the argument; 64 without one, as the paper's.
int main(int argc, char** argv) {
#ifdef STYLED_STGCN_TORCH
  styled::train::UseFastKernels(argv);  // without them libtorch would appear slower than it is
#endif
  return styled::stgcn::Main(argc > 1 ? std::atoi(argv[1]) : 64);
}

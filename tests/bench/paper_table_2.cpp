// Table 2 of Style-ERD's paper: milliseconds that each method takes to style one more frame of a
// live stream, and clips of 60, 90 and 120 frames, on one core. Methods that need a clip get the
// last 32 frames with each frame of a stream, as in the paper. Trained weights do not matter for
// the time, so the baselines are random. All methods take turns, and the least of a few rounds
// counts.
//
//   styled_paper_table_2 WEIGHTS...     e.g. v2.safetensors st-gcn.safetensors
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "model/net/load.h"
#include "model/train/baselines/baseline.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/train/walker.h"

namespace styled {
namespace {

using train::TrainingClip;

constexpr int kPast = 32;   // frames before the one that is styled live
constexpr int kRounds = 5;  // of all methods
constexpr std::array<int, 3> kLengths{60, 90, 120};

// A method: the frames that it was designed for, and its work on a clip of `frames` frames.
struct Method {
  std::string name;
  int designed_frames;
  std::function<void(int frames)> run;
  std::function<void()> online;
};

double Milliseconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
      .count();
}

// Styles a clip as a whole.
void RunClip(const net::ClipStylizer& network, const net::StyleCode& code, const TrainingClip& clip,
             int frames) {
  const auto stream = network.MakeStream(code, 0, net::Extent::kWhole);
  for (int t = 0; t < frames; ++t) stream->Add(clip.poses[static_cast<std::size_t>(t)]);
  stream->End();
  net::Prediction out;
  while (stream->Pop(out)) {
  }
}

Method OfClips(const std::string& name, std::shared_ptr<const net::ClipStylizer> network,
               const TrainingClip& clip, int designed_frames) {
  const net::StyleCode code =
      network->MakeCode({.sources = {{.style = 1, .seed = {}, .reference = {}}}});
  const auto run = [network, code, &clip](int frames) { RunClip(*network, code, clip, frames); };
  return {name, designed_frames, run, [run] { run(kPast + 1); }};
}

Method OfStreams(const std::string& name, std::shared_ptr<const net::Stylizer> network,
                 const TrainingClip& clip) {
  const std::shared_ptr<net::Stream> stream = network->MakeStream();
  const auto step = [network, stream, &clip](int t) {
    static net::Prediction out;
    static const std::array<net::StyleWeight, 1> styles{{{.style = 1, .weight = 1}}};
    const net::StepJob job{.pose = &clip.poses[static_cast<std::size_t>(t)],
                           .styles = styles,
                           .stream = stream.get(),
                           .out = &out};
    network->Step({&job, 1});
  };
  return {name, 1,
          [network, stream, step](int frames) {
            network->Start(*stream);
            for (int t = 0; t < frames; ++t) step(t);
          },
          [step] { step(0); }};
}

int Main(int argc, char** argv) {
  const torch::NoGradGuard no_grad;
  at::set_num_threads(1);
  const TrainingClip clip = train::Walker(200);
  std::vector<Method> methods;
  for (int i = 1; i < argc; ++i) {
    const auto loaded = net::LoadAny(argv[i]);
    if (!loaded.ok()) {
      std::fprintf(stderr, "%s\n", loaded.status().message().c_str());
      return 1;
    }
    const std::string name = std::filesystem::path(argv[i]).stem();
    if (loaded.value().clips) {
      methods.push_back(OfClips(name, loaded.value().clips, clip, 64));
    } else {
      methods.push_back(OfStreams(name, loaded.value().frames, clip));
    }
  }
  clip::Manifest manifest;
  manifest.styles = {{"neutral", {}, {}}, {"odd", {}, {}}};
  manifest.contents = {"walk"};
  std::vector<TrainingClip> clips;
  for (int i = 0; i < 60; ++i) {  // 18,000 frames of each style, as set 2 has
    clips.push_back(train::Walker(600, 0.4F * static_cast<float>(i)));
    clips.back().style = i % 2;
  }
  const train::baselines::Material material(manifest, clips);
  const support::TemporaryFolder folder;
  const auto add = [&](const std::string& name, std::unique_ptr<train::baselines::Baseline> made,
                       int designed_frames) {
    made->TrainOrLoad({.iterations = 1, .batch = 2}, folder / name);
    methods.push_back(OfClips(name, std::move(made), clip, designed_frames));
  };
  add("Aberman", train::baselines::MakeAberman(material, train::baselines::AbermanChannels(47.1e6)),
      32);
  add("neighbours (Xia)", train::baselines::MakeNeighbours(material), 5);

  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::vector<std::array<double, 1 + kLengths.size()>> best(methods.size());
  for (auto& row : best) row.fill(kNever);
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < methods.size(); ++i) {
      constexpr int kFrames = 20;  // of a stream, whose mean counts
      const double online = Milliseconds([&] {
                              for (int t = 0; t < kFrames; ++t) methods[i].online();
                            }) /
                            kFrames;
      best[i][0] = std::min(best[i][0], online);
      for (std::size_t k = 0; k < kLengths.size(); ++k) {
        const double time_ms = Milliseconds([&] { methods[i].run(kLengths[k]); });
        best[i][k + 1] = std::min(best[i][k + 1], time_ms);
      }
    }
  }
  std::printf("| method | online, ms | 60 frames | 90 frames | 120 frames | frames it needs |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (std::size_t i = 0; i < methods.size(); ++i) {
    std::printf("| %s | %.3f | %.2f | %.2f | %.2f | %d |\n", methods[i].name.c_str(), best[i][0],
                best[i][1], best[i][2], best[i][3], methods[i].designed_frames);
  }
  return 0;
}

}  // namespace
}  // namespace styled

int main(int argc, char** argv) {
  try {
    return styled::Main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "styled_paper_table_2: %s\n", error.what());
    return 1;
  }
}

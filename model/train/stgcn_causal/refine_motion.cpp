#include "model/train/stgcn_causal/refine_motion.h"

#include <algorithm>
#include <cmath>

namespace styled::train::st_gcn_causal {
namespace {

using stgcn::kFeatureCount;
using stgcn::kPositionChannels;
using torch::Tensor;

double JointDistance_cm(const Tensor& difference, const Tensor& deviation) {
  const Tensor metres = (difference * deviation).narrow(-1, 0, kPositionChannels);
  return 100 * metres.square().sum(-1).sqrt().mean().item<double>();
}

}  // namespace

Frames FramesOf(const std::vector<std::vector<body::Pose>>& clips,
                const st_gcn::Statistics& statistics, const stgcn::FeatureParameters& parameters) {
  std::vector<TrainingClip> all;
  for (const std::vector<body::Pose>& poses : clips) {
    all.emplace_back();
    all.back().poses = poses;
  }
  const st_gcn::WindowStore store(all, statistics, parameters, 1);
  Frames frames;
  for (int clip = 0; clip < store.clips(); ++clip) frames.push_back(store.FramesOf(clip));
  return frames;
}

Frames Mirrored(const Frames& clips) {
  Frames mirrored;
  for (const Tensor& clip : clips) {
    const Tensor other = clip.clone();
    for (int64_t t = 0; t < other.size(0); ++t) {
      float* const at = other.data_ptr<float>() + t * kFeatureCount;
      stgcn::Features features;
      std::copy_n(at, kFeatureCount, features.begin());
      stgcn::MirrorFeatures(features, features);
      std::copy(features.begin(), features.end(), at);
    }
    mirrored.push_back(other);
  }
  return mirrored;
}

Parts Split(const Frames& clips, double share) {
  Parts parts;
  for (const Tensor& clip : clips) {
    const auto last = std::clamp<int64_t>(std::llround(share * static_cast<double>(clip.size(0))),
                                          1, clip.size(0) - 1);
    parts.first.push_back(clip.narrow(0, 0, clip.size(0) - last));
    parts.last.push_back(clip.narrow(0, clip.size(0) - last, last));
  }
  return parts;
}

Tensor DrawWindows(const Frames& clips, int64_t frames, int64_t count, std::mt19937_64& random) {
  const auto places = [frames](const Tensor& clip) {
    return std::max<int64_t>(clip.size(0) - frames, 0) + 1;
  };
  int64_t all = 0;
  for (const Tensor& clip : clips) all += places(clip);
  std::vector<Tensor> windows;
  for (int64_t i = 0; i < count; ++i) {
    auto place = static_cast<int64_t>(random() % static_cast<uint64_t>(all));
    std::size_t at = 0;
    while (place >= places(clips[at])) place -= places(clips[at++]);
    const Tensor& clip = clips[at];
    const int64_t missing = std::max<int64_t>(frames - clip.size(0), 0);
    const Tensor window = clip.narrow(0, place, frames - missing);
    windows.push_back(missing == 0
                          ? window
                          : torch::cat({window.narrow(0, 0, 1).expand({missing, -1, -1}), window}));
  }
  return torch::stack(windows);
}

Moments MomentsOf(const Tensor& windows) {
  const Tensor mean = windows.mean(torch::IntArrayRef{0, 1});
  const Tensor about = (windows - mean).square().mean(torch::IntArrayRef{0, 1});
  const Tensor change = windows.diff(1, 1).square().mean(torch::IntArrayRef{0, 1});
  return {mean, (about + 1e-6).sqrt(), (change + 1e-6).sqrt()};
}

Moments MomentsOf(const Frames& clips) {
  std::vector<Tensor> changes;
  for (const Tensor& clip : clips) changes.push_back(clip.diff(1, 0));
  const Tensor all = torch::cat(clips);
  Moments moments = MomentsOf(all.unsqueeze(0));
  moments.change = (torch::cat(changes).square().mean(0) + 1e-6).sqrt();
  return moments;
}

double MeanDistance_cm(const Moments& a, const Moments& b, const Tensor& deviation) {
  return JointDistance_cm(a.mean - b.mean, deviation);
}

double SpreadDistance_cm(const Moments& a, const Moments& b, const Tensor& deviation) {
  return JointDistance_cm(a.deviation - b.deviation, deviation);
}

}  // namespace styled::train::st_gcn_causal

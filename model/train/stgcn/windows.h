#pragma once

#include <torch/torch.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "model/net/stgcn/features.h"
#include "model/train/dataset.h"

namespace styled::train::st_gcn {

// Mean and deviation of every feature over a set of clips and their mirror images, exactly as
// symmetric as those. The mean of each rotation also defines its hemisphere.
struct Statistics {
  stgcn::Features mean{}, deviation{};
};

// With `floored`, deviations are at least 2 cm and, of rotations, 0.05: otherwise toes and hips,
// which hardly move, dominate the losses. Without, those below 1e-5 are 1, as the authors' are. The
// hips' constant x and z have mean 0 and deviation 1.
Statistics ComputeStatistics(const std::vector<TrainingClip>& clips,
                             stgcn::FeatureParameters parameters, bool floored = true);

// A window of 64 frames. A clip that is shorter has its first and last frame repeated at both
// ends; `start` is then negative.
struct Window {
  int clip = 0;
  int start = 0;
  bool mirrored = false;
};

// The standardized features of clips, frame by frame. Immutable.
class WindowStore {
 public:
  // `parameters`: with the hemisphere of `statistics`. Windows start every `hop` frames.
  WindowStore(const std::vector<TrainingClip>& clips, const Statistics& statistics,
              const stgcn::FeatureParameters& parameters, int hop);

  // [B, 64, 21, 7], on the CPU.
  torch::Tensor Read(const std::vector<Window>& windows) const;
  // Windows of a clip that are not mirrored, the last one at its end.
  const std::vector<int>& Starts(int clip) const { return starts_[clip]; }
  int clips() const { return static_cast<int>(features_.size()); }
  const torch::Tensor& FramesOf(int clip) const { return features_[clip]; }  // [frames, 21, 7]
  int StyleOf(int clip) const { return clips_[clip].style; }
  int ContentOf(int clip, int start) const;
  int SourceOf(int clip) const { return clips_[clip].source; }

 private:
  const std::vector<TrainingClip>& clips_;
  std::vector<torch::Tensor> features_;  // per clip [frames, 21, 7]
  std::vector<std::vector<int>> starts_;
};

// The sources of one sample of a batch.
struct Sample {
  Window source, same_clip;  // same_clip: another window of the source's clip, where it has one
  Window reference1, reference2;  // of the target domain
  int domain = 0, target = 0;
  int content = 0;     // of the source
  bool paired = true;  // the target domain has the content, so that a critic can compare
};

// Draws samples: source and target domain uniform, then the content uniform among those that both
// have, then folder, clip and window; so real and transferred windows of a domain have the same
// distribution of contents. A share `unpaired` of the sources has any content. Without
// `shared_contents` all have, and count as paired. Without `even_contents`, which needs that, all
// windows of a domain are as likely, whatever their content, folder and clip. A share `neutral` of
// the source domains is domain 0, in addition to random ones. Deterministic; Save and Restore are
// exact.
class Sampler {
 public:
  struct Options {
    int domains = 0, contents = 0;
    bool shared_contents = true, even_contents = true;
    double unpaired = 0.1;
    double neutral = 0;
    bool mirror = true;
    uint64_t seed = 1;
  };
  // `store` must outlive the sampler.
  Sampler(const WindowStore& store, const Options& options);

  std::vector<Sample> Next(int count);
  bool HasAll() const;  // whether every domain has windows
  std::string Save() const;
  void Restore(const std::string& text);

 private:
  struct Place {
    int clip = 0;
    std::vector<int> starts;
  };
  // The windows of one domain and content: by folder, by clip.
  using Cell = std::vector<std::vector<Place>>;

  void FindCells();
  void FindContents();
  int Below(std::size_t bound);
  double Uniform();
  Window Draw(const Cell& cell);
  Window DrawAny(int domain);
  Window DrawReference(int domain);
  Window AnotherOf(const Window& window);

  const WindowStore& store_;
  Options options_;
  std::mt19937_64 random_;
  std::vector<std::vector<Cell>> cells_;               // [domain][content]
  std::vector<std::vector<Window>> windows_;           // per domain; without even_contents
  std::vector<std::vector<int>> contents_of_;          // per domain, contents that it has
  std::vector<std::vector<std::vector<int>>> shared_;  // [domain][domain], contents of both
};

}  // namespace styled::train::st_gcn

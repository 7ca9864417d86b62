#pragma once

#include <torch/torch.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/clip/manifest.h"
#include "model/net/clip_stylizer.h"
#include "model/train/stgcn/networks.h"
#include "model/train/stgcn/windows.h"

// The systems that Park et al. 2021 compare theirs with, trained and judged only: libtorch runs
// them, and no program publishes with them. They see the same features as st-gcn
// (model/net/stgcn/features.h), standardized, as [147, T].
namespace styled::train::baselines {

// The training data of a baseline. The clips must outlive it.
struct Material {
  Material(const clip::Manifest& manifest, const std::vector<TrainingClip>& clips);

  net::Model model;  // the manifest's styles
  int contents = 0;
  stgcn::FeatureParameters parameters;  // before the statistics, which need and complete them
  st_gcn::Statistics statistics;
  st_gcn::WindowStore store;
};

// Norms over time need more than one frame, and the networks keep every fourth.
inline constexpr int kLeastFrames = 8;

struct Budget {
  double minutes = 10;          // of processor time, which other programs do not shorten
  long iterations = 1'000'000;  // the run ends at whichever comes first
  int batch = 16;
};

// A network of whole clips. Its style codes are vectors of any length.
class Baseline : public net::ClipStylizer {
 public:
  // Reads the networks from `file` if that exists; otherwise trains them, with progress on stderr,
  // and writes them there. Then computes the mean code of each style. Throws if the file is of a
  // network of other sizes, or was trained on other clips.
  void TrainOrLoad(const Budget& budget, const std::filesystem::path& file);

  const net::Model& model() const noexcept override { return material_.model; }
  int least_frames() const noexcept override { return kLeastFrames; }
  // No variation from noise: a seed changes nothing.
  net::StyleCode MakeCode(const net::StyleRequest& request) const override;
  net::NearestStyle Nearest(const net::StyleCode& code) const override;
  // The extent is the whole clip, always.
  std::unique_ptr<net::ClipStream> MakeStream(const net::StyleCode& code, int input_style,
                                              net::Extent extent) const override;

  // Clips [147, T], T a multiple of 4 and at least kLeastFrames, on the CPU; a code is flat.
  virtual torch::Tensor CodeOf(const torch::Tensor& clip) const = 0;
  virtual torch::Tensor Styled(const torch::Tensor& clip, const torch::Tensor& code) const = 0;
  // The clip as the network reproduces it, without a change of style.
  virtual torch::Tensor Own(const torch::Tensor& clip) const = 0;

  // A clip of poses at the model's rate as the networks see it; at its end the last frame is
  // repeated as often as T requires.
  torch::Tensor Read(std::span<const body::Pose> poses, std::vector<float>* headings_rad) const;

 protected:
  // `seed`: of the weights at the start, which the derived class makes next, and of the training.
  Baseline(const Material& material, std::uint64_t seed);
  virtual void Train(const Budget& budget) = 0;
  virtual void Prepare() {}  // what is computed of the material, trained or read
  virtual torch::nn::Module& networks() = 0;

  const Material& material_;
  const std::uint64_t seed_;

 private:
  void Load(const std::filesystem::path& file);
  void ComputeMeanCodes();

  std::vector<torch::Tensor> mean_codes_;  // by style
};

// Aberman et al. 2020, "Unpaired Motion Style Transfer from Video to Animation": 1-D convolutions
// over time and all joints at once; a content encoder with instance norms, a style encoder, a
// decoder with AdaIN. Content consistency (L1), adversarial and triplet losses. Its critic's
// objective is st-gcn's (logistic, R1), so that the networks are compared and not the critics.
// `channels`: of the first layer.
std::unique_ptr<Baseline> MakeAberman(const Material& material, int channels,
                                      std::uint64_t seed = 1);
// Multiply-adds of encoder and decoder for a window of 64 frames, and the channels that come
// nearest to a number of them.
double AbermanMacs(int channels);
int AbermanChannels(double macs);

// Holden et al. 2016, "A Deep Learning Framework for Character Motion Synthesis and Editing": a
// convolutional auto-encoder; a clip's style is the Gram matrix of its hidden units, and a clip is
// restyled by moving its hidden units towards another's Gram matrix, by gradient descent.
// `style_weight`: the weight of the Gram matrix's relative error compared with the content's.
std::unique_ptr<Baseline> MakeHolden(const Material& material, double style_weight,
                                     std::uint64_t seed = 1);
// Multiply-adds for a window of 64 frames: encoder, decoder and the descent between them.
double HoldenMacs();

// After Xia et al. 2015, "Realtime Style Transfer for Unlabeled Heterogeneous Human Motion":
// nothing is trained. Of each frame, with four before it, the nearest neutral frames of the clips
// are found, and it is turned by the mean difference to their likes in the style, smoothed over
// time. Where the paper registers clips in time, a frame's like is the nearest of its content
// without the styles' means; where the paper fits autoregressive models to the neighbours, this
// takes their mean.
std::unique_ptr<Baseline> MakeNeighbours(const Material& material);

// Calls `step(progress)`, 0 to 1, until the budget is spent, and prints `state()` to stderr now and
// then.
void Iterate(const Budget& budget, const std::function<void(double progress)>& step,
             const std::function<std::string()>& state);

}  // namespace styled::train::baselines

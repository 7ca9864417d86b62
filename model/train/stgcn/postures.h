#pragma once

#include <torch/torch.h>

#include <random>
#include <vector>

#include "model/train/stgcn/windows.h"

namespace styled::train::st_gcn {

// Postures of clips: time means of standardized features, [21, 7], on the CPU. A clip's own
// deviation is its posture minus the mean of its cell, the clips of its domain and content;
// examples of a style differ by it. The difference of two cells of one content is the difference of
// two styles. For mirrored windows all of this is mirrored. Immutable.
class Postures {
 public:
  // `single_act`: by content, whether its clips are of one act, so that a posture does not depend
  // on which hand is raised.
  Postures(const WindowStore& store, int domains, std::vector<bool> single_act);

  // The target of a sample's mean output by its first reference, as a difference to the source:
  // from the source's cell to the target's of the same content, plus the reference's own deviation.
  // False if it is undefined: the target domain lacks the content, or the reference is not a single
  // act.
  bool Wanted(const Sample& sample, torch::Tensor& shift) const;

  // A random new posture, as a difference: up to kMostOfStyles of the way between two random styles
  // of one content, and up to kMostOfClips times a random clip's own deviation. Half of the draws
  // are of the whole body; in the others each limb is drawn separately.
  torch::Tensor Draw(std::mt19937_64& random) const;

 private:
  torch::Tensor Own(const Window& window) const;
  torch::Tensor DrawWhole(std::mt19937_64& random) const;
  bool HasCell(int domain, int content) const;
  const torch::Tensor& CellOf(int domain, int content) const {
    return cells_[static_cast<std::size_t>(domain)][static_cast<std::size_t>(content)];
  }

  const WindowStore& store_;
  std::vector<bool> single_act_;
  std::vector<torch::Tensor> clips_;               // by clip
  std::vector<std::vector<torch::Tensor>> cells_;  // [domain][content]; undefined where empty
  std::vector<int> drawn_;                         // clips of single acts
  struct Pair {
    int from, to, content;
  };
  std::vector<Pair> pairs_;  // of domains that share a content
};

}  // namespace styled::train::st_gcn

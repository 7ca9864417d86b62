#pragma once

#include <torch/torch.h>

#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/net/erd/shape.h"
#include "model/train/adam.h"

namespace styled::train {
struct Checkpoint;
}

// The three networks of Style-ERD. Everything is time-major: [T, B, features].
namespace styled::train::style_erd {

// y = W x + b on the last dimension.
struct Affine {
  torch::Tensor weight, bias;
  Affine() = default;
  Affine(Parameters& parameters, const std::string& name, int64_t in, int64_t out);
  torch::Tensor operator()(const torch::Tensor& x) const;
};

struct GeneratorShape {
  int64_t styles = 7;    // neutral included
  int64_t contents = 0;  // that the encoder takes as input; 0: it takes none
  int64_t latent = erd::kPaper.latent;
  std::vector<int64_t> encoder{erd::kPaper.encoder};
  std::vector<int64_t> decoder{erd::kPaper.decoder.begin(), erd::kPaper.decoder.end()};
  int64_t neutral_layers = erd::kNeutralLayers, style_layers = erd::kStyleLayers;

  static GeneratorShape Of(const erd::Shape& widths);
};

// The states of a stack of LSTM layers: per layer [groups, samples, Z].
struct StackState {
  std::vector<torch::Tensor> h, c;

  StackState Concrete() const;  // a copy of its own, without gradients
};

// A stack of LSTM layers for each of G groups, with learned initial states: one for each group, or
// `starts` of them if there is one group.
struct Stack {
  int64_t groups = 1;
  std::vector<torch::Tensor> input, hidden, bias;  // per layer, first dimension G
  std::vector<torch::Tensor> h0, c0;               // per layer, [G or starts, Z]

  Stack() = default;
  Stack(Parameters& parameters, const std::string& name, int64_t groups, int64_t layers,
        int64_t width, int64_t starts = 1);
  // The learned states, for `samples` samples of each group; the first of several.
  StackState Initial(int64_t samples) const;
  // Of one group: the learned states `starts` [samples] int64.
  StackState InitialOf(const torch::Tensor& starts) const;
  // `initial`, but `carried` where `mask` [groups or 1, samples, 1] is set.
  static StackState Start(const StackState& initial, const StackState& carried,
                          const torch::Tensor& mask);
  // x [G, T, N, Z]; `state` is where the window starts and, detached, where it ended.
  torch::Tensor operator()(torch::Tensor x, StackState& state) const;
};

// The decoder's output for a frame, with the standardization undone.
struct Decoded {
  torch::Tensor rotations;   // [T, B, 21, 4], unit
  torch::Tensor velocities;  // [T, B, 63], standardized
  torch::Tensor height;      // [T, B, 1], standardized
};

// The styles of a batch's windows.
struct Slots {
  torch::Tensor input, target;                  // [B] int64: styles; one of the two is neutral, 0
  torch::Tensor input_one_hot, target_one_hot;  // [B, styles]
  torch::Tensor styled;                         // [1, B, 1]: 1 where the input style is not neutral
  // Each style branch processes equally many windows. Undefined: these are the batch's, in the
  // order of styles. Otherwise [(styles - 1) * n] int64, the window in each place of a branch; and
  // [B], the place of each window. Places that are left over have window 0.
  torch::Tensor window_of_place, place_of_window;

  int64_t count() const { return input.size(0); }
  int64_t per_branch(int64_t branches) const {
    return (window_of_place.defined() ? window_of_place.size(0) : count()) / branches;
  }
};

// The input of contents. Undefined tensors if the generator takes none.
struct ContentInput {
  torch::Tensor content;  // [T, B, C]: the label, scaled by how certain it is; zeros: unknown
  torch::Tensor start;    // [B] int64: the initial state of the neutral branch; C: unknown
};

// Where each slot's last window ended.
struct Carried {
  StackState neutral, branches;
  // With a content input: of the recognizer, and the age of its states in seconds, [B].
  StackState recognizer;
  torch::Tensor age_s;

  // Copies the states to where those of this are in memory.
  void CopyFrom(const Carried& other);
};
// As tensors of a checkpoint whose names begin with `prefix`. RestoreCarried throws (c10::Error) if
// it finds states of another batch; `carried` must have the shape of this one.
void SaveCarried(const Carried& carried, const std::string& prefix, Checkpoint& checkpoint);
void RestoreCarried(const Checkpoint& checkpoint, const std::string& prefix, Carried& carried);

// Encoder, neutral branch, style branches, decoder and the recognizer of contents of
// model/net/erd/FORMAT.md.
class Generator {
 public:
  Generator(const GeneratorShape& shape, const torch::Tensor& mean, const torch::Tensor& deviation);

  // u [T, B, 211] standardized features, one_hot [B, N] of the styles, content [T, B, C] or
  // undefined: z [T, B, Z].
  torch::Tensor Encode(const torch::Tensor& u, const torch::Tensor& one_hot,
                       const torch::Tensor& content) const;
  // The recognizer's logits for each content, [T, B, C], of frames 0..t alone at t.
  torch::Tensor Recognize(const torch::Tensor& u, StackState& state) const;
  // z [T, B, Z] of all samples.
  torch::Tensor Neutral(const torch::Tensor& z, StackState& state) const;
  // z [T, (styles-1) * n, Z], ordered by style: each block of n goes through its own branch.
  torch::Tensor Branches(const torch::Tensor& z, StackState& state) const;
  // target [B, N]: the decoder's style input.
  Decoded Decode(const torch::Tensor& z, const torch::Tensor& target) const;

  // Every slot's window in its input style, then every one in its target: [T, 2B, ...]. Neutral
  // windows are reconstructed by r_0 alone and transferred with their slot's branch, styled ones
  // the other way. `goes_on` [B] bool: the windows that start from `carried`, which is updated to
  // their ends.
  Decoded Transfer(const torch::Tensor& u, const Slots& slots, const ContentInput& content,
                   const torch::Tensor& goes_on, Carried& carried) const;
  // Learned states for all slots, without gradients.
  Carried Start(const Slots& slots) const;
  // Copies the part shared by all styles from `from`, a generator of the same widths, and for style
  // i of this one the branch and input columns of its style `source[i]`. Where only this one takes
  // contents, it ignores them at first, and its recognizer is left as it is. Errors name the
  // tensor.
  Status CopyStyles(const Generator& from, const std::vector<int64_t>& source);

  Parameters parameters;
  GeneratorShape shape;
  Stack neutral, branches, recognizer;  // the last with a content input only

 private:
  void AddRecognizer();

  torch::Tensor rotation_mean_, rotation_deviation_;
  std::vector<Affine> encoder_, decoder_, recognizer_;
  Affine rotation_, velocity_, height_, recognized_;
};

// FT-Att discriminator D_S(p, v | S, C), eq. 1. x [24, B, 126] standardized positions and
// velocities, labels [B, styles + contents] one-hots; the score is [B]. Without attention, the
// multi-class discriminator that the paper compares with: the same convolutions, a head per style,
// contents not looked at.
class Critic {
 public:
  Critic(int64_t features, int64_t styles, int64_t contents, int64_t frames, bool attention = true);
  torch::Tensor operator()(const torch::Tensor& x, const torch::Tensor& labels) const;

  Parameters parameters;

 private:
  std::vector<Affine> convolutions_;
  std::vector<Affine> attention_;
  Affine feature_attention_, time_attention_;
  Affine heads_;
};

// D_C on standardized [r, p, v]: x [T, B, 210]. Channels are halved by every layer, kernel 5.
class ContentClassifier {
 public:
  ContentClassifier(int64_t features, int64_t contents);
  // The feature maps after each layer, for the perceptual loss (eq. 7).
  std::vector<torch::Tensor> Maps(const torch::Tensor& x) const;
  torch::Tensor Logits(const torch::Tensor& x) const;

  Parameters parameters;

 private:
  std::vector<Affine> convolutions_;
  Affine head_;
};

}  // namespace styled::train::style_erd

#pragma once

#include <torch/torch.h>

#include <cstdint>

#include "model/train/adam.h"
#include "model/train/stgcn/layers.h"

// The four networks of Park et al. 2021. Windows are standardized features [B, T, 21, 7] in
// float32 (model/net/stgcn/features.h); codes are [B, code]; domains (styles, neutral included) are
// int64 [B].
namespace styled::train::st_gcn {

inline constexpr int64_t kWindowFrames = 64;  // encoder and critic see exactly so many

struct Shape {
  int64_t domains = 7;  // styles, neutral included
  int64_t width = 32;   // channels of the finest level
  int64_t code = 64, noise = 16;
  bool node_bias = true;
};

// A graph convolution network without norms over a window of 64 frames: [B, 64, 21, 7] to
// [B, 4 width]. Shared by encoder and critic.
class Trunk {
 public:
  Trunk() = default;
  Trunk(Parameters& parameters, const std::string& name, const Shape& shape);
  torch::Tensor operator()(const Graph& graph, const torch::Tensor& x) const;

 private:
  Linear in_;
  torch::Tensor in_node_bias_;  // [21, width]
  ResBlock res1_, res2_;
  torch::Tensor conv_weight_, conv_bias_;  // [4w, 16, 5, 4w]: out, frame, node, in; [4w]
};

// G: a motion's content, decoded with a code. T is a multiple of 4.
class Generator {
 public:
  Generator(const Shape& shape, const torch::Device& device, double out_scale = 1.0);
  // [B, T, 21, 7] to [B, T/4, 5, 4 width], in the type of `graph`.
  torch::Tensor Encode(const Graph& graph, const torch::Tensor& x) const;
  // Standardized features in float32; the hips' constant x and z are 0.
  torch::Tensor Decode(const Graph& graph, const torch::Tensor& content,
                       const torch::Tensor& code) const;

  Parameters parameters;
  Shape shape;

 private:
  Linear in_, out_;
  torch::Tensor in_node_bias_, mask_;
  ResBlock enc1_, enc2_;
  AdainBlock dec1_, dec2_;
};

// E: the code of a window, read by a head for its domain, or by one for windows without a label.
class Encoder {
 public:
  Encoder(const Shape& shape, const torch::Device& device, double head_scale = 1.0);
  torch::Tensor Features(const Graph& graph, const torch::Tensor& x) const;  // [B, 4 width]
  torch::Tensor Code(const torch::Tensor& features, const torch::Tensor& domain) const;
  torch::Tensor FreeCode(const torch::Tensor& features) const { return free_(features); }

  Parameters parameters;

 private:
  Trunk trunk_;
  torch::Tensor heads_weight_, heads_bias_;  // [domains, code, 4w], [domains, code]
  Linear free_;
};

// F: a code of a domain from noise z [B, noise], each number of it in (-1, 1).
class Mapping {
 public:
  Mapping(const Shape& shape, const torch::Device& device);
  torch::Tensor operator()(const torch::Tensor& z, const torch::Tensor& domain) const;

  Parameters parameters;

 private:
  int64_t domains_;
  Linear noise_, label_, fc1_, fc2_, out_;
};

// D: whether a window is real motion of its domain, as a logit [B]. With `contents` above 0, each
// content adds an affine function of the same features: real motion of that content. With
// `last_layer`, the domains' logits go through one more layer, from all to all.
class Critic {
 public:
  Critic(const Shape& shape, int64_t contents, const torch::Device& device, double head_scale = 1.0,
         bool last_layer = false);
  torch::Tensor operator()(const Graph& graph, const torch::Tensor& x, const torch::Tensor& domain,
                           const torch::Tensor& content) const;

  Parameters parameters;

 private:
  Trunk trunk_;
  Linear heads_, last_, content_heads_;
};

}  // namespace styled::train::st_gcn

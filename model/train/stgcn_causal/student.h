#pragma once

#include <torch/torch.h>

#include <array>
#include <cstdint>
#include <vector>

#include "model/train/adam.h"
#include "model/train/stgcn/networks.h"
#include "model/train/stgcn_causal/layers.h"

namespace styled::train::st_gcn_causal {

// Frames between the taps of the convolutions over time in enc1, enc2, dec1 and dec2: those at
// which the network of whole clips, which works at a half and a quarter of the rate, has them.
inline constexpr std::array<int64_t, 4> kSpacing{2, 4, 2, 1};
// Standardized features are limited to this in both signs, live as well.
inline constexpr double kInputLimit = 4;

// A style in full form (model/net/stgcn_causal/FORMAT.md), for one or for each sample of a batch.
// Undefined: 0.
struct FullStyle {
  torch::Tensor code;       // [1 or B, code]
  torch::Tensor bias;       // [1 or B, 21, 7]: of the standardized output
  torch::Tensor additions;  // [1 or B, AdditionsOf(width)]: of dec1.adain1 [γ, β], dec1.adain2,
                            // dec2.adain1, dec2.adain2
};
constexpr int64_t AdditionsOf(int64_t width) { return 2 * (4 + 2 + 2 + 1) * width; }

// The generator of the network of whole clips for a stream of frames (layers.h). One thread.
class Student {
 public:
  Student(const st_gcn::Shape& shape, const torch::Device& device);

  // Copies all weights of the network of whole clips, which has the same shape. The starts of the
  // statistics stay.
  void CopyFrom(const st_gcn::Generator& teacher);

  // Standardized features [B, T, 21, 7] to [B, T, 5, 4 width], in the type of `graph`; T is the
  // graph's.
  torch::Tensor Encode(const Graph& graph, const torch::Tensor& x) const;
  // Standardized features in float32; the hips' constant x and z are 0.
  torch::Tensor Decode(const Graph& graph, const torch::Tensor& content,
                       const torch::Tensor& code) const;
  torch::Tensor Decode(const Graph& graph, const torch::Tensor& content,
                       const FullStyle& style) const;

  std::vector<PastNorm*> norms();

  Parameters parameters;
  st_gcn::Shape shape;

 private:
  st_gcn::Linear in_, out_;
  torch::Tensor in_node_bias_, mask_;
  ResBlock enc1_, enc2_;
  AdainBlock dec1_, dec2_;
};

}  // namespace styled::train::st_gcn_causal

#pragma once

#include <torch/torch.h>

#include <array>
#include <string>

#include "model/net/stgcn/graph.h"
#include "model/train/adam.h"

// The layers of the spatio-temporal graph network (Park et al. 2021, section 3.2). Activations are
// [B, T, V, C]: samples, frames, nodes of a level, channels. Parameters are float32; a layer
// computes in the type of its input, float32 or bfloat16. Every layer that Critic uses can be
// differentiated twice. Tensors of parameters have the names and shapes of the weights file
// (weights.h).
namespace styled::train::st_gcn {

// Of the sum of a block's two paths; both are linear at their ends, where it costs nothing.
inline constexpr double kShare = M_SQRT1_2;
inline constexpr double kSlope = 0.2;  // of LeakyReLU

// m [R, V] applied to the nodes of x [B, T, V, C]: [B, T, R, C].
torch::Tensor Mix(const torch::Tensor& m, const torch::Tensor& x);
// x [..., in] times wᵀ, w [out, in], in the type of x.
torch::Tensor Product(const torch::Tensor& x, const torch::Tensor& w);

// The fixed matrices of the graph and of time, in one type on one device. Mixing matrices multiply
// from the left and have a row per node and label, the labels of a node one after the other.
struct Graph {
  Graph(const torch::Device& device, torch::Dtype type,
        stgcn::Normalization normalization = stgcn::Normalization::kNeighbours);

  torch::Dtype type;
  std::array<torch::Tensor, stgcn::kLevels> mixing;      // [3V, V]: A_k
  std::array<torch::Tensor, stgcn::kLevels> labels;      // [V, 3]: column sums of A_k, float32
  std::array<torch::Tensor, stgcn::kLevels - 1> pooled;  // [3V', V]: A_k, then half the mean of
                                                         // each cluster: for sums of two frames
  std::array<torch::Tensor, stgcn::kLevels - 1> pool;    // [V', V]: half the mean of a cluster
  std::array<torch::Tensor, stgcn::kLevels - 1> mean;    // [V', V]: the mean, float32
  std::array<torch::Tensor, stgcn::kLevels - 1> unpool;  // [V, V']
  // [2T, T]: linear interpolation between the first and the last frame, T frames to 2T.
  torch::Tensor Stretch(int64_t frames) const;
};

// x·Wᵀ + b on the last dimension.
struct Linear {
  Linear() = default;
  Linear(Parameters& parameters, const std::string& name, int64_t in, int64_t out);
  torch::Tensor operator()(const torch::Tensor& x) const;
  torch::Tensor weight, bias;  // [out, in], [out]
};

// A graph convolution of one level: y_i = Σ_k Σ_j A_k[j, i] (W_k x_j + b_k) + node bias of i.
struct GraphConv {
  GraphConv() = default;
  GraphConv(Parameters& parameters, const std::string& name, int level, int64_t in, int64_t out,
            bool node_bias);
  torch::Tensor operator()(const Graph& graph, const torch::Tensor& x) const;
  // Followed by the pooling of nodes and of frame pairs: [B, T, V, in] to [B, T/2, V', out].
  torch::Tensor Pooled(const Graph& graph, const torch::Tensor& x) const;

  // The parts of both: the product for mixing matrices [3R, V], which may pool or unpool nodes, and
  // biases of all kinds, float32 [V of the level, out].
  torch::Tensor Mixed(const torch::Tensor& mixing, const torch::Tensor& x) const;
  torch::Tensor NodeBias(const Graph& graph) const;

  int level = 0;
  torch::Tensor weight, bias, node_bias;  // [3 out, in], [3 out], [V of the level, out] or none
};

// A convolution over three frames, zeros before the first and after the last.
struct TemporalConv {
  TemporalConv() = default;
  TemporalConv(Parameters& parameters, const std::string& name, int64_t channels);
  // The result is multiplied by `gain`.
  torch::Tensor operator()(const torch::Tensor& x, double gain = 1) const;
  torch::Tensor weight, bias;  // [C, C, 3], [C]
};

// The encoding block: half the frames, the next coarser level. With norms in the generator.
class ResBlock {
 public:
  ResBlock() = default;
  ResBlock(Parameters& parameters, const std::string& name, int level, int64_t in, int64_t out,
           bool node_bias, bool norms);
  torch::Tensor operator()(const Graph& graph, const torch::Tensor& x) const;

 private:
  torch::Tensor Activate(const torch::Tensor& x, const torch::Tensor& scale,
                         const torch::Tensor& shift) const;

  int level_ = 0;
  torch::Tensor scale1_, shift1_, scale2_, shift2_;  // [C]; none without norms
  GraphConv gconv1_, gconv2_;
  TemporalConv tconv1_, tconv2_;
  torch::Tensor skip_;  // [out, in]
};

// The decoding block: twice the frames, the next finer level; the code sets scale and shift of its
// norms. `level` is that of its input.
class AdainBlock {
 public:
  AdainBlock() = default;
  AdainBlock(Parameters& parameters, const std::string& name, int level, int64_t in, int64_t out,
             int64_t code, bool node_bias);
  torch::Tensor operator()(const Graph& graph, const torch::Tensor& x,
                           const torch::Tensor& code) const;

 private:
  torch::Tensor Unpool(const Graph& graph, const torch::Tensor& x) const;

  int level_ = 0;
  Linear adain1_, adain2_;  // code to [γ, β]: scale is 1 + γ, shift is β
  GraphConv gconv1_, gconv2_;
  TemporalConv tconv1_, tconv2_;
  torch::Tensor skip_;
};

}  // namespace styled::train::st_gcn

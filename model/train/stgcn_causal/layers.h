#pragma once

#include <torch/torch.h>

#include <array>
#include <string>

#include "model/net/stgcn/graph.h"
#include "model/train/stgcn/layers.h"
#include "model/train/stgcn_causal/past_norm.h"

// The layers of the network of whole clips (model/train/stgcn/layers.h) for a stream of frames: no
// frame is pooled or unpooled, and convolutions over time and normalizations see only the past.
// Activations are [B, T, V, C]; T frames are a stream's first. Parameters have the names and shapes
// of the network of whole clips where both have them. Equations: model/net/stgcn_causal/FORMAT.md;
// pinned by tests/unit/train/stgcn_causal/student_test.cpp.
namespace styled::train::st_gcn_causal {

// The fixed matrices, in one type on one device.
struct Graph {
  Graph(const torch::Device& device, torch::Dtype type, int64_t frames);

  st_gcn::Graph spatial;
  Past past;
  // Of level and the coarser one: A_k and then the mean of each cluster [3V', V]; that mean alone
  // [V', V]; A_k of nodes that got their cluster's value [3V, V'].
  std::array<torch::Tensor, stgcn::kLevels - 1> pooled, pool, unpooled;
  std::array<torch::Tensor, stgcn::kLevels> equal;         // [V]: 1 / V, float32
  std::array<torch::Tensor, stgcn::kLevels - 1> clusters;  // [V']: its nodes' share of V, float32
};

// W_0 x_(t - 2 spacing) + W_1 x_(t - spacing) + W_2 x_t + bias, times `gain`; before the first
// frame is the first frame.
torch::Tensor OverThePast(const st_gcn::TemporalConv& conv, const torch::Tensor& x, int64_t spacing,
                          double gain = 1);

// The encoding block: from `level` to the next coarser one.
class ResBlock {
 public:
  ResBlock() = default;
  ResBlock(Parameters& parameters, const std::string& name, int level, int64_t in, int64_t out,
           int64_t spacing);
  torch::Tensor operator()(const Graph& graph, const torch::Tensor& x) const;
  std::array<PastNorm*, 2> norms() { return {&norm1_, &norm2_}; }

 private:
  int level_ = 0;
  int64_t spacing_ = 1;
  torch::Tensor scale1_, shift1_, scale2_, shift2_;  // [1, C]
  PastNorm norm1_, norm2_;
  st_gcn::GraphConv gconv1_, gconv2_;
  st_gcn::TemporalConv tconv1_, tconv2_;
  torch::Tensor skip_;  // [out, in]
};

// A style's additions to the scale and shift [γ, β] of a decoding block's norms, which otherwise
// follow from its code: [1 or B, 2C] each. Undefined: nothing.
struct Additions {
  torch::Tensor first, second;
};

// The decoding block: from `level` to the next finer one. Copies of a node are made as late as
// possible, so that operations on each node alone run once per cluster.
class AdainBlock {
 public:
  AdainBlock() = default;
  AdainBlock(Parameters& parameters, const std::string& name, int level, int64_t in, int64_t out,
             int64_t code, int64_t spacing);
  torch::Tensor operator()(const Graph& graph, const torch::Tensor& x, const torch::Tensor& code,
                           const Additions& additions = {}) const;
  std::array<PastNorm*, 2> norms() { return {&norm1_, &norm2_}; }

 private:
  int level_ = 0;
  int64_t spacing_ = 1;
  st_gcn::Linear adain1_, adain2_;  // code to [γ, β]: scale is 1 + γ, shift is β
  PastNorm norm1_, norm2_;
  st_gcn::GraphConv gconv1_, gconv2_;
  st_gcn::TemporalConv tconv1_, tconv2_;
  torch::Tensor skip_;
};

}  // namespace styled::train::st_gcn_causal

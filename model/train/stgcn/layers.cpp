#include "model/train/stgcn/layers.h"

#include "model/train/stgcn/normalized_leaky.h"

namespace styled::train::st_gcn {
namespace {

using stgcn::kLabelCount;
using torch::Tensor;

// He et al. 2015: the variance of uniform numbers in ±bound is 2 / inputs.
double HeBound(int64_t inputs) { return std::sqrt(6.0 / static_cast<double>(inputs)); }

Tensor FromEigen(const Eigen::MatrixXf& matrix) {  // column-major
  return torch::from_blob(const_cast<float*>(matrix.data()), {matrix.cols(), matrix.rows()})
      .t()
      .clone(at::MemoryFormat::Contiguous);
}

Tensor SumOfPairs(const Tensor& x) {
  const Tensor pairs = x.view({x.size(0), x.size(1) / 2, 2, x.size(2), x.size(3)});
  return pairs.select(2, 0) + pairs.select(2, 1);
}

}  // namespace

Tensor Mix(const Tensor& m, const Tensor& x) {
  const int64_t rows = x.size(0) * x.size(1);
  return at::bmm(m.expand({rows, m.size(0), m.size(1)}), x.reshape({rows, x.size(2), x.size(3)}))
      .view({x.size(0), x.size(1), m.size(0), x.size(3)});
}

Tensor Product(const Tensor& x, const Tensor& w) {
  return at::matmul(x, w.to(x.scalar_type()).t());
}

Graph::Graph(const torch::Device& device, torch::Dtype type, stgcn::Normalization normalization)
    : type(type) {
  const auto place = [&](const Tensor& matrix) { return matrix.to(device).to(type).contiguous(); };
  for (int level = 0; level < stgcn::kLevels; ++level) {
    const auto adjacency = stgcn::Adjacency(level, normalization);
    std::vector<Tensor> mixed, pooled_mixed, sums;
    for (const Eigen::MatrixXf& label : adjacency) {
      mixed.push_back(FromEigen(label.transpose()));
      sums.push_back(FromEigen(label.colwise().sum().transpose()));
      if (level + 1 == stgcn::kLevels) continue;
      pooled_mixed.push_back(FromEigen(0.5F * (label * stgcn::Pooling(level)).transpose()));
    }
    mixing[level] = place(torch::stack(mixed, 1).flatten(0, 1));
    labels[level] = torch::cat(sums, 1).to(device).contiguous();
    if (level + 1 == stgcn::kLevels) continue;
    pooled[level] = place(torch::stack(pooled_mixed, 1).flatten(0, 1));
    mean[level] = FromEigen(stgcn::Pooling(level).transpose()).to(device).contiguous();
    pool[level] = place(0.5 * mean[level]);
    unpool[level] = place(FromEigen(stgcn::Unpooling(level).transpose()));
  }
}

Tensor Graph::Stretch(int64_t frames) const {
  const auto floats = torch::TensorOptions().dtype(torch::kFloat32).device(pool[0].device());
  const Tensor at = torch::arange(2 * frames, floats) *
                    (static_cast<double>(frames - 1) / static_cast<double>(2 * frames - 1));
  const Tensor distance = (at.unsqueeze(1) - torch::arange(frames, floats)).abs();
  return (1.0 - distance).clamp_min(0).to(type);
}

Linear::Linear(Parameters& parameters, const std::string& name, int64_t in, int64_t out)
    : weight(parameters.Add(name + ".weight", {out, in}, HeBound(in))),
      bias(parameters.Add(name + ".bias", {out}, 0)) {}

Tensor Linear::operator()(const Tensor& x) const {
  return at::linear(x, weight.to(x.scalar_type()), bias.to(x.scalar_type()));
}

GraphConv::GraphConv(Parameters& parameters, const std::string& name, int level, int64_t in,
                     int64_t out, bool with_node_bias)
    : level(level),
      weight(parameters.Add(name + ".weight", {kLabelCount * out, in}, HeBound(in))),
      bias(parameters.Add(name + ".bias", {kLabelCount * out}, 0)) {
  if (with_node_bias) {
    node_bias = parameters.Add(name + ".node_bias", {stgcn::kNodes[level], out}, 0);
  }
}

Tensor GraphConv::NodeBias(const Graph& graph) const {
  const Tensor all = torch::matmul(graph.labels[level], bias.view({kLabelCount, -1}));
  return node_bias.defined() ? all + node_bias : all;
}

// Nodes are mixed first: a node's three mixtures lie one after the other then, and one product
// with [W_0 W_1 W_2] sums over the labels.
Tensor GraphConv::Mixed(const Tensor& mixing, const Tensor& x) const {
  const int64_t in = x.size(3), out = bias.size(0) / kLabelCount;
  const int64_t nodes = mixing.size(0) / kLabelCount;
  const Tensor mixed = Mix(mixing, x).view({x.size(0), x.size(1), nodes, kLabelCount * in});
  const Tensor w = weight.view({kLabelCount, out, in}).transpose(0, 1).reshape({out, -1});
  return Product(mixed, w);
}

Tensor GraphConv::operator()(const Graph& graph, const Tensor& x) const {
  return Mixed(graph.mixing[level], x) + NodeBias(graph).to(x.scalar_type());
}

Tensor GraphConv::Pooled(const Graph& graph, const Tensor& x) const {
  const Tensor constant = torch::matmul(graph.mean[level], NodeBias(graph));
  return Mixed(graph.pooled[level], SumOfPairs(x)) + constant.to(x.scalar_type());
}

TemporalConv::TemporalConv(Parameters& parameters, const std::string& name, int64_t channels)
    : weight(parameters.Add(name + ".weight", {channels, channels, 3}, HeBound(3 * channels))),
      bias(parameters.Add(name + ".bias", {channels}, 0)) {}

// Seen as [B, C, T, V] the memory is that of channels_last, which oneDNN prefers.
Tensor TemporalConv::operator()(const Tensor& x, double gain) const {
  const auto type = x.scalar_type();
  return at::conv2d(x.permute({0, 3, 1, 2}), (gain * weight).to(type).unsqueeze(-1),
                    (gain * bias).to(type), 1, {1, 0})
      .permute({0, 2, 3, 1});
}

namespace {

Tensor Leaky(const Tensor& x) { return at::leaky_relu(x, kSlope); }

// A norm's scale, at first 1.
Tensor AddScale(Parameters& parameters, const std::string& name, int64_t channels) {
  const Tensor scale = parameters.Add(name, {channels}, 0);
  const torch::NoGradGuard no_grad;
  scale.fill_(1);
  return scale;
}

}  // namespace

ResBlock::ResBlock(Parameters& parameters, const std::string& name, int level, int64_t in,
                   int64_t out, bool node_bias, bool norms)
    : level_(level) {
  if (norms) {
    scale1_ = AddScale(parameters, name + ".norm1.scale", in);
    shift1_ = parameters.Add(name + ".norm1.shift", {in}, 0);
  }
  gconv1_ = GraphConv(parameters, name + ".gconv1", level, in, in, node_bias);
  tconv1_ = TemporalConv(parameters, name + ".tconv1", in);
  if (norms) {
    scale2_ = AddScale(parameters, name + ".norm2.scale", in);
    shift2_ = parameters.Add(name + ".norm2.shift", {in}, 0);
  }
  gconv2_ = GraphConv(parameters, name + ".gconv2", level + 1, in, out, node_bias);
  tconv2_ = TemporalConv(parameters, name + ".tconv2", out);
  skip_ = parameters.Add(name + ".skip.weight", {out, in}, HeBound(in));
}

Tensor ResBlock::Activate(const Tensor& x, const Tensor& scale, const Tensor& shift) const {
  if (!scale.defined()) return Leaky(x);
  return NormalizedLeaky(x, scale.unsqueeze(0), shift.unsqueeze(0));
}

Tensor ResBlock::operator()(const Graph& graph, const Tensor& x) const {
  Tensor y = gconv1_.Pooled(graph, Activate(x, scale1_, shift1_));
  y = tconv1_(torch::relu(y));
  y = gconv2_(graph, Activate(y, scale2_, shift2_));
  y = tconv2_(torch::relu(y), kShare);
  return y + Product(Mix(graph.pool[level_], SumOfPairs(x)), kShare * skip_);
}

AdainBlock::AdainBlock(Parameters& parameters, const std::string& name, int level, int64_t in,
                       int64_t out, int64_t code, bool node_bias)
    : level_(level),
      adain1_(parameters, name + ".adain1", code, 2 * in),
      adain2_(parameters, name + ".adain2", code, 2 * out),
      gconv1_(parameters, name + ".gconv1", level, in, out, node_bias),
      gconv2_(parameters, name + ".gconv2", level - 1, out, out, node_bias),
      tconv1_(parameters, name + ".tconv1", out),
      tconv2_(parameters, name + ".tconv2", out),
      skip_(parameters.Add(name + ".skip.weight", {out, in}, HeBound(in))) {}

// To twice the frames, then to the finer level.
Tensor AdainBlock::Unpool(const Graph& graph, const Tensor& x) const {
  const int64_t batch = x.size(0), frames = x.size(1);
  const Tensor stretch = graph.Stretch(frames);
  const Tensor stretched = at::bmm(stretch.expand({batch, 2 * frames, frames}), x.flatten(2, 3))
                               .view({batch, 2 * frames, x.size(2), x.size(3)});
  return Mix(graph.unpool[level_ - 1], stretched);
}

Tensor AdainBlock::operator()(const Graph& graph, const Tensor& x, const Tensor& code) const {
  const auto norm = [&code](const Linear& adain, const Tensor& of) {
    const std::vector<Tensor> style = adain(code).chunk(2, 1);
    return NormalizedLeaky(of, 1.0 + style[0], style[1]);
  };
  Tensor y = gconv1_(graph, norm(adain1_, x));
  y = tconv1_(torch::relu(Unpool(graph, y)));
  y = gconv2_(graph, norm(adain2_, y));
  y = tconv2_(torch::relu(y), kShare);
  return y + Unpool(graph, Product(x, kShare * skip_));
}

}  // namespace styled::train::st_gcn

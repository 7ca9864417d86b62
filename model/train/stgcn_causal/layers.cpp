#include "model/train/stgcn_causal/layers.h"

namespace styled::train::st_gcn_causal {
namespace {

using st_gcn::kShare;
using st_gcn::Mix;
using st_gcn::Product;
using torch::Tensor;

// A tensor of the network of whole clips; its value comes from there.
Tensor Add(Parameters& parameters, const std::string& name, torch::IntArrayRef shape) {
  return parameters.Add(name, shape, 0);
}

}  // namespace

Graph::Graph(const torch::Device& device, torch::Dtype type, int64_t frames)
    : spatial(device, type), past(frames, device) {
  const st_gcn::Graph exact(device, torch::kFloat32);
  for (std::size_t level = 0; level < equal.size(); ++level) {
    const int64_t nodes = stgcn::kNodes[level];
    equal[level] = torch::full({nodes}, 1.0 / static_cast<double>(nodes)).to(device);
    if (level + 1 == equal.size()) continue;
    pooled[level] = (2 * exact.pooled[level]).to(type);  // those are for sums of two frames
    pool[level] = exact.mean[level].to(type);
    unpooled[level] = torch::matmul(exact.mixing[level], exact.unpool[level]).to(type);
    clusters[level] = exact.unpool[level].mean(0).contiguous();
  }
}

Tensor OverThePast(const st_gcn::TemporalConv& conv, const Tensor& x, int64_t spacing,
                   double gain) {
  const auto type = x.scalar_type();
  const Tensor before = x.narrow(1, 0, 1).expand({-1, 2 * spacing, -1, -1});
  const std::array<int64_t, 2> once{1, 1}, none{0, 0}, apart{spacing, 1};
  // Seen as [B, C, T, V] the memory is that of channels_last, which oneDNN prefers.
  return at::conv2d(torch::cat({before, x}, 1).permute({0, 3, 1, 2}),
                    (gain * conv.weight).to(type).unsqueeze(-1), (gain * conv.bias).to(type), once,
                    none, apart)
      .permute({0, 2, 3, 1});
}

ResBlock::ResBlock(Parameters& parameters, const std::string& name, int level, int64_t in,
                   int64_t out, int64_t spacing)
    : level_(level),
      spacing_(spacing),
      scale1_(Add(parameters, name + ".norm1.scale", {in})),
      shift1_(Add(parameters, name + ".norm1.shift", {in})),
      scale2_(Add(parameters, name + ".norm2.scale", {in})),
      shift2_(Add(parameters, name + ".norm2.shift", {in})),
      norm1_(parameters, name + ".norm1", in),
      norm2_(parameters, name + ".norm2", in),
      gconv1_(parameters, name + ".gconv1", level, in, in, true),
      gconv2_(parameters, name + ".gconv2", level + 1, in, out, true),
      tconv1_(parameters, name + ".tconv1", in),
      tconv2_(parameters, name + ".tconv2", out),
      skip_(Add(parameters, name + ".skip.weight", {out, in})) {}

Tensor ResBlock::operator()(const Graph& graph, const Tensor& x) const {
  const auto level = static_cast<std::size_t>(level_);
  Tensor y = norm1_(graph.past, x, scale1_.unsqueeze(0), shift1_.unsqueeze(0), graph.equal[level]);
  const Tensor bias = torch::matmul(graph.spatial.mean[level], gconv1_.NodeBias(graph.spatial));
  y = gconv1_.Mixed(graph.pooled[level], y) + bias.to(x.scalar_type());
  y = OverThePast(tconv1_, torch::relu(y), spacing_);
  y = norm2_(graph.past, y, scale2_.unsqueeze(0), shift2_.unsqueeze(0), graph.equal[level + 1]);
  y = OverThePast(tconv2_, torch::relu(gconv2_(graph.spatial, y)), spacing_, kShare);
  return y + Product(Mix(graph.pool[level], x), kShare * skip_);
}

AdainBlock::AdainBlock(Parameters& parameters, const std::string& name, int level, int64_t in,
                       int64_t out, int64_t code, int64_t spacing)
    : level_(level),
      spacing_(spacing),
      adain1_(parameters, name + ".adain1", code, 2 * in),
      adain2_(parameters, name + ".adain2", code, 2 * out),
      norm1_(parameters, name + ".adain1", in),
      norm2_(parameters, name + ".adain2", out),
      gconv1_(parameters, name + ".gconv1", level, in, out, true),
      gconv2_(parameters, name + ".gconv2", level - 1, out, out, true),
      tconv1_(parameters, name + ".tconv1", out),
      tconv2_(parameters, name + ".tconv2", out),
      skip_(Add(parameters, name + ".skip.weight", {out, in})) {}

Tensor AdainBlock::operator()(const Graph& graph, const Tensor& x, const Tensor& code,
                              const Additions& additions) const {
  const auto coarse = static_cast<std::size_t>(level_), fine = coarse - 1;
  const auto norm = [&](const PastNorm& of, const st_gcn::Linear& adain, const Tensor& more,
                        const Tensor& y, const Tensor& share) {
    Tensor both = adain(code);
    if (more.defined()) both = both + more;
    const std::vector<Tensor> style = both.chunk(2, 1);
    return of(graph.past, y, 1.0 + style[0], style[1], share);
  };
  Tensor y = gconv1_(graph.spatial, norm(norm1_, adain1_, additions.first, x, graph.equal[coarse]));
  y = OverThePast(tconv1_, torch::relu(y), spacing_);
  y = gconv2_.Mixed(graph.unpooled[fine],
                    norm(norm2_, adain2_, additions.second, y, graph.clusters[fine])) +
      gconv2_.NodeBias(graph.spatial).to(x.scalar_type());
  y = OverThePast(tconv2_, torch::relu(y), spacing_, kShare);
  return y + Mix(graph.spatial.unpool[fine], Product(x, kShare * skip_));
}

}  // namespace styled::train::st_gcn_causal

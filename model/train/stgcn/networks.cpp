#include "model/train/stgcn/networks.h"

#include <cmath>

#include "model/net/stgcn/features.h"

namespace styled::train::st_gcn {
namespace {

using stgcn::kChannels;
using torch::Tensor;

constexpr int64_t kJoints = body::kJointCount;
constexpr int64_t kHidden = 256;  // of the mapping network

Tensor InNodeBias(Parameters& parameters, const std::string& name, const Shape& shape) {
  return shape.node_bias ? parameters.Add(name + ".in.node_bias", {kJoints, shape.width}, 0)
                         : Tensor();
}

// The input layer: in float32, since features are differences of large numbers.
Tensor In(const Graph& graph, const Linear& in, const Tensor& node_bias, const Tensor& x) {
  const Tensor y = in(x);
  return (node_bias.defined() ? y + node_bias : y).to(graph.type);
}

void Scale(const Tensor& parameter, double factor) {
  const torch::NoGradGuard no_grad;
  parameter.mul_(factor);
}

Tensor OfDomain(const Tensor& all, const Tensor& domain) {
  return all.gather(1, domain.unsqueeze(1)).squeeze(1);
}

}  // namespace

Trunk::Trunk(Parameters& parameters, const std::string& name, const Shape& shape)
    : in_(parameters, name + ".in", kChannels, shape.width),
      in_node_bias_(InNodeBias(parameters, name, shape)) {
  const int64_t w = shape.width, frames = kWindowFrames / 4, nodes = stgcn::kNodes[2];
  res1_ = ResBlock(parameters, name + ".res1", 0, w, 2 * w, shape.node_bias, false);
  res2_ = ResBlock(parameters, name + ".res2", 1, 2 * w, 4 * w, shape.node_bias, false);
  conv_weight_ = parameters.Add(name + ".conv.weight", {4 * w, frames, nodes, 4 * w},
                                std::sqrt(6.0 / static_cast<double>(4 * w * frames * nodes)));
  conv_bias_ = parameters.Add(name + ".conv.bias", {4 * w}, 0);
}

// The convolution covers all frames and nodes, so it is a product.
Tensor Trunk::operator()(const Graph& graph, const Tensor& x) const {
  const Tensor y = res2_(graph, res1_(graph, In(graph, in_, in_node_bias_, x)));
  const Tensor flat = at::leaky_relu(y.to(torch::kFloat32), kSlope).flatten(1);
  // In float32, because converting ten thousand weights per channel costs more than it saves.
  const Tensor features = at::linear(flat, conv_weight_.flatten(1), conv_bias_);
  return at::leaky_relu(features, kSlope);
}

Generator::Generator(const Shape& shape, const torch::Device& device, double out_scale)
    : shape(shape),
      in_(parameters, "g.in", kChannels, shape.width),
      in_node_bias_(InNodeBias(parameters, "g", shape)) {
  const int64_t w = shape.width;
  enc1_ = ResBlock(parameters, "g.enc1", 0, w, 2 * w, shape.node_bias, true);
  enc2_ = ResBlock(parameters, "g.enc2", 1, 2 * w, 4 * w, shape.node_bias, true);
  dec1_ = AdainBlock(parameters, "g.dec1", 2, 4 * w, 2 * w, shape.code, shape.node_bias);
  dec2_ = AdainBlock(parameters, "g.dec2", 1, 2 * w, w, shape.code, shape.node_bias);
  out_ = Linear(parameters, "g.out", w, kChannels);
  Scale(out_.weight, out_scale);
  parameters.Flatten(device);
  mask_ = torch::ones({kJoints, kChannels}, device);
  mask_[body::kHips][0] = 0;
  mask_[body::kHips][2] = 0;
}

Tensor Generator::Encode(const Graph& graph, const Tensor& x) const {
  return enc2_(graph, enc1_(graph, In(graph, in_, in_node_bias_, x)));
}

Tensor Generator::Decode(const Graph& graph, const Tensor& content, const Tensor& code) const {
  const Tensor y = dec2_(graph, dec1_(graph, content, code), code);
  return out_(y.to(torch::kFloat32)) * mask_;
}

Encoder::Encoder(const Shape& shape, const torch::Device& device, double head_scale)
    : trunk_(parameters, "e", shape) {
  const int64_t features = 4 * shape.width;
  heads_weight_ = parameters.Add("e.heads.weight", {shape.domains, shape.code, features},
                                 std::sqrt(6.0 / static_cast<double>(features)));
  heads_bias_ = parameters.Add("e.heads.bias", {shape.domains, shape.code}, 0);
  free_ = Linear(parameters, "e.free", features, shape.code);
  Scale(heads_weight_, head_scale);
  Scale(free_.weight, head_scale);
  parameters.Flatten(device);
}

Tensor Encoder::Features(const Graph& graph, const Tensor& x) const { return trunk_(graph, x); }

Tensor Encoder::Code(const Tensor& features, const Tensor& domain) const {
  const Tensor weight = heads_weight_.index_select(0, domain);
  return at::bmm(weight, features.unsqueeze(2)).squeeze(2) + heads_bias_.index_select(0, domain);
}

Mapping::Mapping(const Shape& shape, const torch::Device& device)
    : domains_(shape.domains),
      noise_(parameters, "f.noise", shape.noise, kHidden),
      label_(parameters, "f.label", shape.domains, kHidden),
      fc1_(parameters, "f.fc1", 2 * kHidden, 2 * kHidden),
      fc2_(parameters, "f.fc2", 2 * kHidden, 4 * kHidden),
      out_(parameters, "f.out", 4 * kHidden, shape.code) {
  parameters.Flatten(device);
}

Tensor Mapping::operator()(const Tensor& z, const Tensor& domain) const {
  const Tensor label = torch::one_hot(domain, domains_).to(torch::kFloat32);
  const Tensor both = torch::cat({torch::relu(noise_(z)), torch::relu(label_(label))}, 1);
  return torch::tanh(out_(torch::relu(fc2_(torch::relu(fc1_(both))))));
}

Critic::Critic(const Shape& shape, int64_t contents, const torch::Device& device, double head_scale,
               bool last_layer)
    : trunk_(parameters, "d", shape),
      heads_(parameters, "d.heads", 4 * shape.width, shape.domains) {
  Scale(heads_.weight, head_scale);
  if (last_layer) last_ = Linear(parameters, "d.last", shape.domains, shape.domains);
  if (contents > 0) {
    content_heads_ = Linear(parameters, "d.contents", 4 * shape.width, contents);
    Scale(content_heads_.weight, head_scale);
  }
  parameters.Flatten(device);
}

Tensor Critic::operator()(const Graph& graph, const Tensor& x, const Tensor& domain,
                          const Tensor& content) const {
  const Tensor features = trunk_(graph, x);
  const Tensor heads = heads_(features);
  const Tensor logit = OfDomain(last_.weight.defined() ? last_(heads) : heads, domain);
  if (!content_heads_.weight.defined()) return logit;
  return logit + OfDomain(content_heads_(features), content);
}

}  // namespace styled::train::st_gcn

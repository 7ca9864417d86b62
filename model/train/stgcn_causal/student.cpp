#include "model/train/stgcn_causal/student.h"

#include "model/net/stgcn/features.h"

namespace styled::train::st_gcn_causal {

using stgcn::kChannels;
using torch::Tensor;

Student::Student(const st_gcn::Shape& shape, const torch::Device& device)
    : shape(shape),
      in_(parameters, "g.in", kChannels, shape.width),
      in_node_bias_(parameters.Add("g.in.node_bias", {body::kJointCount, shape.width}, 0)) {
  const int64_t w = shape.width;
  enc1_ = ResBlock(parameters, "g.enc1", 0, w, 2 * w, kSpacing[0]);
  enc2_ = ResBlock(parameters, "g.enc2", 1, 2 * w, 4 * w, kSpacing[1]);
  dec1_ = AdainBlock(parameters, "g.dec1", 2, 4 * w, 2 * w, shape.code, kSpacing[2]);
  dec2_ = AdainBlock(parameters, "g.dec2", 1, 2 * w, w, shape.code, kSpacing[3]);
  out_ = st_gcn::Linear(parameters, "g.out", w, kChannels);
  parameters.Flatten(device);
  mask_ = torch::ones({body::kJointCount, kChannels}, device);
  mask_[body::kHips][0] = 0;
  mask_[body::kHips][2] = 0;
}

void Student::CopyFrom(const st_gcn::Generator& teacher) {
  const torch::NoGradGuard no_grad;
  for (const auto& [name, tensor] : parameters.named()) {
    const bool ours = name.ends_with(".start_mean") || name.ends_with(".start_square");
    if (!ours) tensor.copy_(teacher.parameters.Find(name));
  }
}

Tensor Student::Encode(const Graph& graph, const Tensor& x) const {
  // In float32, since features are differences of large numbers.
  const Tensor in = in_(x.clamp(-kInputLimit, kInputLimit)) + in_node_bias_;
  return enc2_(graph, enc1_(graph, in.to(graph.spatial.type)));
}

Tensor Student::Decode(const Graph& graph, const Tensor& content, const Tensor& code) const {
  return Decode(graph, content, FullStyle{.code = code, .bias = {}, .additions = {}});
}

Tensor Student::Decode(const Graph& graph, const Tensor& content, const FullStyle& style) const {
  const int64_t w = shape.width;
  std::array<Additions, 2> more;
  if (style.additions.defined()) {
    const std::vector<Tensor> parts =
        style.additions.split_with_sizes({8 * w, 4 * w, 4 * w, 2 * w}, 1);
    more = {Additions{parts[0], parts[1]}, Additions{parts[2], parts[3]}};
  }
  const Tensor y = dec2_(graph, dec1_(graph, content, style.code, more[0]), style.code, more[1]);
  Tensor out = out_(y.to(torch::kFloat32));
  if (style.bias.defined()) out = out + style.bias.unsqueeze(1);
  return out * mask_;
}

std::vector<PastNorm*> Student::norms() {
  std::vector<PastNorm*> all;
  for (ResBlock* block : {&enc1_, &enc2_}) {
    for (PastNorm* norm : block->norms()) all.push_back(norm);
  }
  for (AdainBlock* block : {&dec1_, &dec2_}) {
    for (PastNorm* norm : block->norms()) all.push_back(norm);
  }
  return all;
}

}  // namespace styled::train::st_gcn_causal

#include "model/net/stgcn/code_space.h"

#include <cassert>

#include "model/net/stgcn/codes.h"

namespace styled::stgcn {

CodeSpace::CodeSpace(LayerReader& layers, const FeatureParameters& features,
                     const Standardization& standard, int width, int domains, int most_windows)
    : kernels_(&net::BestRowKernels()),
      features_(features),
      standard_(standard),
      encoder_(layers, width, domains, most_windows) {
  constexpr int kHidden = 256;
  net::TensorReader& tensors = layers.tensors();
  mapping_.noise = ReadDense(tensors, "f.noise", kHidden, kNoise);
  mapping_.label = ReadDense(tensors, "f.label", kHidden, domains);
  mapping_.first = ReadDense(tensors, "f.fc1", 2 * kHidden, 2 * kHidden);
  mapping_.second = ReadDense(tensors, "f.fc2", 4 * kHidden, 2 * kHidden);
  mapping_.out = ReadDense(tensors, "f.out", kCode, 4 * kHidden);
  const net::RowMajor codes = tensors.Matrix("codes.mean", domains, kCode);
  for (int domain = 0; domain < domains; ++domain) {
    mean_codes_.emplace_back(codes.row(domain).transpose());
  }
}

Code CodeSpace::EncodeStyle(std::span<const Features> clip, int domain, Scratch& scratch) const {
  assert(domain >= kFreeHead && domain < domain_count());
  return encoder_.Encode(*kernels_, standard_, clip, domain, scratch);
}

Code CodeSpace::MapNoise(const Noise& noise, int domain) const {
  assert(domain >= 0 && domain < domain_count());
  const auto relu = [](const Eigen::VectorXf& x) -> Eigen::VectorXf { return x.cwiseMax(0.0F); };
  const Dense& label = mapping_.label;
  Eigen::VectorXf both(mapping_.noise.bias.size() + label.bias.size());
  both << relu(mapping_.noise.Apply(noise)), relu(label.weight.col(domain) + label.bias);
  const Eigen::VectorXf hidden = relu(mapping_.second.Apply(relu(mapping_.first.Apply(both))));
  return mapping_.out.Apply(hidden).array().tanh();
}

Eigen::MatrixXf CodeSpace::MapNoises(const Eigen::MatrixXf& noises, int domain) const {
  assert(domain >= 0 && domain < domain_count());
  const auto layer = [](const Dense& dense, const Eigen::MatrixXf& x) -> Eigen::MatrixXf {
    return (dense.weight * x).colwise() + dense.bias;
  };
  const auto relu = [](const Eigen::MatrixXf& x) -> Eigen::MatrixXf { return x.cwiseMax(0.0F); };
  const Dense& label = mapping_.label;
  Eigen::MatrixXf both(mapping_.noise.bias.size() + label.bias.size(), noises.cols());
  both << relu(layer(mapping_.noise, noises)),
      relu(label.weight.col(domain) + label.bias).replicate(1, noises.cols());
  const Eigen::MatrixXf hidden = relu(layer(mapping_.second, relu(layer(mapping_.first, both))));
  return layer(mapping_.out, hidden).array().tanh();
}

net::StyleCode CodeSpace::MakeCode(const net::StyleRequest& request) const {
  std::vector<WeightedCode> codes;
  codes.reserve(request.sources.size());
  for (const net::StyleSource& source : request.sources) {
    codes.push_back({CodeOfSource(source, request.amount), source.weight});
  }
  const Code code = AtStrength(*this, Mixed(*this, codes), request.strength);
  return {code.data(), code.data() + code.size()};
}

net::NearestStyle CodeSpace::Nearest(const net::StyleCode& code) const {
  return stgcn::Nearest(*this, ToCode(code));
}

net::StyleCode CodeSpace::Limited(const net::StyleCode& code) const {
  const Code limited = PulledIn(*this, ToCode(code));
  return {limited.data(), limited.data() + limited.size()};
}

Code CodeSpace::CodeOfSource(const net::StyleSource& source, float amount) const {
  if (source.reference.empty()) {
    return source.seed ? PulledIn(*this, Varied(*this, *source.seed, source.style, amount))
                       : mean_code(source.style);
  }
  HeadingState heading;
  std::vector<Features> clip(source.reference.size());
  for (std::size_t i = 0; i < clip.size(); ++i) {
    ComputeFeatures(source.reference[i], features_, heading, clip[i]);
  }
  Scratch scratch;
  return PulledIn(*this, EncodeStyle(clip, source.style < 0 ? kFreeHead : source.style, scratch));
}

Code ToCode(const net::StyleCode& code) {
  assert(code.size() == kCode);
  return Eigen::Map<const Code>(code.data());
}

}  // namespace styled::stgcn

#include "model/net/stgcn_causal/points.h"

#include <algorithm>
#include <cassert>

namespace styled::stgcn_causal {

using stgcn::kCode;
using stgcn::kFeatureCount;

PointSpace::PointSpace(stgcn::LayerReader& layers, int width) {
  const std::array<std::pair<const char*, int>, kNorms> norms{{{"g.dec1.adain1", 4 * width},
                                                               {"g.dec1.adain2", 2 * width},
                                                               {"g.dec2.adain1", 2 * width},
                                                               {"g.dec2.adain2", width}}};
  for (std::size_t i = 0; i < kNorms; ++i) {
    const auto& [name, channels] = norms[i];
    adain_[i] = stgcn::ReadDense(layers.tensors(), name, 2 * channels, kCode);
    places_[i] = bias_;
    bias_ += static_cast<std::size_t>(2 * channels);
  }
}

bool PointSpace::IsSize(std::size_t numbers) const {
  return numbers == kCode || numbers == kCode + kFeatureCount || numbers == full_size();
}

std::shared_ptr<const Point> PointSpace::PointOf(const net::StyleCode& code) const {
  assert(IsSize(code.size()));
  const Eigen::VectorXf numbers = Eigen::Map<const Eigen::VectorXf>(code.data(), kCode);
  auto point = std::make_shared<Point>(size());
  for (std::size_t i = 0; i < kNorms; ++i) {
    const Eigen::VectorXf affine = adain_[i].Apply(numbers);
    float* const to = std::copy(affine.begin(), affine.end(), point->data() + places_[i]);
    const auto half = affine.size() / 2;
    for (float* scale = to - affine.size(); scale != to - half; ++scale) *scale += 1;  // 1 + γ
  }
  if (code.size() == kCode) return point;
  const float* const bias = code.data() + kCode;
  std::copy_n(bias, kFeatureCount, point->data() + bias_);
  if (code.size() < full_size()) return point;
  const float* const own = bias + kFeatureCount;
  for (std::size_t i = 0; i < bias_; ++i) (*point)[i] += own[i];
  return point;
}

Eigen::MatrixXf PointSpace::Directions(const Eigen::MatrixXf& codes) const {
  Eigen::MatrixXf directions(bias_, codes.cols());
  for (std::size_t i = 0; i < kNorms; ++i) {
    const auto place = static_cast<Eigen::Index>(places_[i]);
    directions.middleRows(place, adain_[i].weight.rows()).noalias() = adain_[i].weight * codes;
  }
  return directions;
}

}  // namespace styled::stgcn_causal

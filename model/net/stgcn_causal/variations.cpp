#include "model/net/stgcn_causal/variations.h"

#include <Eigen/Core>

#include "model/net/stgcn/codes.h"

namespace styled::stgcn_causal {

Variations::Variations(const stgcn::CodeSpace& space, const PointSpace& points)
    : size_(points.bias()) {
  constexpr int kMany = net::kVariations;
  Eigen::MatrixXf noises(stgcn::kNoise, kMany);
  for (int k = 1; k <= kMany; ++k) {
    noises.col(k - 1) = stgcn::NoiseOf(static_cast<std::uint64_t>(k));
  }
  all_.Grow(size_ * static_cast<std::size_t>(kMany * space.domain_count()));
  for (int domain = 0; domain < space.domain_count(); ++domain) {
    Eigen::MatrixXf codes = space.MapNoises(noises, domain);
    for (int k = 0; k < kMany; ++k) {
      codes.col(k) = stgcn::PulledIn(space, codes.col(k)) - space.mean_code(domain);
    }
    const auto rows = static_cast<Eigen::Index>(size_);
    Eigen::Map<Eigen::MatrixXf>(all_.data() + size_ * static_cast<std::size_t>(domain * kMany),
                                rows, kMany) = points.Directions(codes);
  }
}

}  // namespace styled::stgcn_causal

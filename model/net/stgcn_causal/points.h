#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "model/net/stgcn/code_space.h"
#include "model/net/stgcn/features.h"
#include "model/net/stgcn/layer_reader.h"
#include "model/net/style_space.h"

namespace styled::stgcn_causal {

// The form of a style that the decoder uses: the scale and shift, [1 + γ; β], of each of its four
// normalizations, and a bias of its standardized output, [21, 7]. All of it is linear in the code,
// so that points can be mixed like codes. Immutable, shared.
using Point = std::vector<float>;

// From codes to points. A net::StyleCode of this family is one of
//   64 numbers       a code; the bias is 0
//   64 + 147         the code and the bias
// 64 + 147 + 18 w  the code, the bias, and additions to scale and shift, in the order of the
// normalizations The last form belongs to a style that was refined on its clips: it has its own
// affine maps of AdaIN. Allocates; any thread. Pinned by
// tests/unit/net/stgcn_causal/points_test.cpp.
class PointSpace {
 public:
  // Reads g.dec1.adain1, g.dec1.adain2, g.dec2.adain1 and g.dec2.adain2 of a network of `width`.
  PointSpace(stgcn::LayerReader& layers, int width);

  static constexpr std::size_t kNorms = 4;
  // Floats of a point, and where each normalization's part and the bias begin in it.
  std::size_t size() const { return bias_ + stgcn::kFeatureCount; }
  std::size_t norm(std::size_t index) const { return places_[index]; }
  std::size_t bias() const { return bias_; }

  // The numbers of a code in full form.
  std::size_t full_size() const { return stgcn::kCode + size(); }
  // Whether a code has one of the sizes above.
  bool IsSize(std::size_t numbers) const;
  // `code` of one of these sizes.
  std::shared_ptr<const Point> PointOf(const net::StyleCode& code) const;
  // The scales and shifts of differences of codes, a column each: [bias(), columns].
  Eigen::MatrixXf Directions(const Eigen::MatrixXf& codes) const;

 private:
  std::array<stgcn::Dense, kNorms> adain_;
  std::array<std::size_t, kNorms> places_{};
  std::size_t bias_ = 0;
};

}  // namespace styled::stgcn_causal

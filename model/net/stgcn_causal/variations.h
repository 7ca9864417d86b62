#pragma once

#include <cassert>
#include <cstddef>

#include "model/net/kernels/kernel.h"
#include "model/net/stgcn/code_space.h"
#include "model/net/stgcn_causal/points.h"
#include "model/net/styles.h"

namespace styled::stgcn_causal {

// The variations 1 .. net::kVariations of each domain, as differences from its point. Variation k
// is the code that StyleSpace::MakeCode returns for the seed k; precomputed so that the real-time
// thread neither computes one nor waits for it. Made at load, in 4 ms per domain; 0.5 MB each at
// width 64. Immutable. Pinned by tests/unit/net/stgcn_causal/variations_test.cpp.
class Variations {
 public:
  Variations(const stgcn::CodeSpace& space, const PointSpace& points);

  // The floats of one variation: a point without its bias, which is the domain's.
  std::size_t size() const { return size_; }
  const float* Of(int domain, int variation) const {
    assert(variation >= 1 && variation <= net::kVariations);
    return all_.data() +
           size_ * static_cast<std::size_t>(domain * net::kVariations + variation - 1);
  }

 private:
  std::size_t size_;
  net::AlignedFloats all_;  // [domains, kVariations, size]
};

}  // namespace styled::stgcn_causal

#pragma once

#include <array>
#include <span>
#include <vector>

#include "model/net/stgcn/blocks.h"

namespace styled::stgcn {

// The style encoder E of FORMAT.md: a code from an example clip. Immutable; shared by all threads,
// each with its own scratch. Allocates; not for live streams. Pinned by
// tests/unit/net/stgcn/network_test.cpp and tests/parity.
class StyleEncoder {
 public:
  StyleEncoder() = default;
  // Reads the tensors `e.*` for a network of `width` and so many domains. Of a long clip at most
  // `most_windows` are read, at least 2.
  StyleEncoder(LayerReader& layers, int width, int domains, int most_windows);

  // As Network::EncodeStyle; `clip` in its own units, to be standardized by `standard`.
  Code Encode(const net::RowKernels& kernels, const Standardization& standard,
              std::span<const Features> clip, int domain, Scratch& scratch) const;

 private:
  void EncodeWindow(const net::RowKernels& kernels, const Standardization& standard,
                    std::span<const Features> window, float* y, Scratch& scratch) const;

  int most_windows_ = kAllWindows;
  Linear in_, conv_;  // conv: [80 * 4w, 4w]
  std::array<EncoderBlock, 2> blocks_;
  std::vector<Dense> heads_;  // one per domain, and the free head last
};

}  // namespace styled::stgcn

#pragma once

#include <span>
#include <vector>

#include "model/net/stgcn/style_encoder.h"
#include "model/net/style_space.h"

namespace styled::stgcn {

// The networks of a weights file that define styles: style encoder, mapping network and the
// domains' mean codes (FORMAT.md). Networks of whole clips and of live streams have the same ones.
// Pinned by tests/unit/net/stgcn/network_test.cpp, codes_test.cpp and tests/parity.
class CodeSpace final : public net::StyleSpace {
 public:
  // Reads the tensors `e.*`, `f.*` and `codes.mean` for a network of `width`.
  CodeSpace(LayerReader& layers, const FeatureParameters& features, const Standardization& standard,
            int width, int domains, int most_windows = kAllWindows);

  int domain_count() const { return static_cast<int>(mean_codes_.size()); }
  // The mean code of the domain's training clips.
  const Code& mean_code(int domain) const { return mean_codes_[static_cast<std::size_t>(domain)]; }

  // The code of a reference clip by the head of `domain` (0 .. domain_count() - 1), or by
  // kFreeHead. A clip of more than kReference frames: the mean over its windows, kReferenceHop
  // apart, or farther apart if there would be more than the most; of fewer: both ends are repeated.
  // Not empty.
  Code EncodeStyle(std::span<const Features> clip, int domain, Scratch& scratch) const;
  // The mapping network: a code of `domain`.
  Code MapNoise(const Noise& noise, int domain) const;
  // The same for many, a column each, up to rounding.
  Eigen::MatrixXf MapNoises(const Eigen::MatrixXf& noises, int domain) const;

  int least_frames() const noexcept override { return kLeastFrames; }
  net::StyleCode MakeCode(const net::StyleRequest& request) const override;
  net::NearestStyle Nearest(const net::StyleCode& code) const override;
  net::StyleCode Limited(const net::StyleCode& code) const override;  // PulledIn of codes.h

 private:
  Code CodeOfSource(const net::StyleSource& source, float amount) const;

  const net::RowKernels* kernels_;
  FeatureParameters features_;
  Standardization standard_;
  StyleEncoder encoder_;
  struct {
    Dense noise, label, first, second, out;
  } mapping_;
  std::vector<Code> mean_codes_;
};

// Its numbers, as many as kCode.
Code ToCode(const net::StyleCode& code);

}  // namespace styled::stgcn

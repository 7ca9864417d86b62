#pragma once

#include <torch/torch.h>

#include <vector>

#include "model/train/stgcn_causal/student.h"

namespace styled::train::st_gcn_causal {

// A style as the runtime accepts it (net::StyleCode of model/net/stgcn_causal): the code; the code
// and the bias of the output; or these and the additions. A style in full form is all three. Pinned
// by tests/unit/train/stgcn_causal/refiner_test.cpp.
struct VectorSizes {
  int64_t code = 0, bias = 0, additions = 0;
  explicit VectorSizes(const st_gcn::Shape& shape);
  int64_t full() const { return code + bias + additions; }
  bool Allow(std::size_t numbers) const;  // one of the three
};

// The style of `numbers`, whose size VectorSizes must allow, for one sample; missing parts are 0.
// And back, in full form.
FullStyle StyleOf(const std::vector<float>& numbers, const st_gcn::Shape& shape);
std::vector<float> VectorOf(const FullStyle& style);

}  // namespace styled::train::st_gcn_causal

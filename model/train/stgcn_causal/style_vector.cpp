#include "model/train/stgcn_causal/style_vector.h"

#include "model/net/stgcn/features.h"

namespace styled::train::st_gcn_causal {

using torch::Tensor;

VectorSizes::VectorSizes(const st_gcn::Shape& shape)
    : code(shape.code), bias(stgcn::kFeatureCount), additions(AdditionsOf(shape.width)) {}

bool VectorSizes::Allow(std::size_t numbers) const {
  const auto count = static_cast<int64_t>(numbers);
  return count == code || count == code + bias || count == full();
}

FullStyle StyleOf(const std::vector<float>& numbers, const st_gcn::Shape& shape) {
  const VectorSizes sizes(shape);
  TORCH_CHECK(sizes.Allow(numbers.size()), "a style of ", numbers.size(), " numbers");
  Tensor all = torch::zeros({1, sizes.full()});
  all.narrow(1, 0, static_cast<int64_t>(numbers.size())).copy_(torch::tensor(numbers));
  const std::vector<Tensor> parts =
      all.split_with_sizes({sizes.code, sizes.bias, sizes.additions}, 1);
  return {.code = parts[0].clone(),
          .bias = parts[1].reshape({1, body::kJointCount, stgcn::kChannels}).clone(),
          .additions = parts[2].clone()};
}

std::vector<float> VectorOf(const FullStyle& style) {
  const Tensor all =
      torch::cat({style.code.flatten(), style.bias.flatten(), style.additions.flatten()})
          .detach()
          .cpu()
          .contiguous();
  return {all.data_ptr<float>(), all.data_ptr<float>() + all.numel()};
}

}  // namespace styled::train::st_gcn_causal

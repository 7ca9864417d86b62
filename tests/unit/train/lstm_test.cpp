#include "model/train/erd/lstm.h"

#include <gtest/gtest.h>

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

// The hand-written layer against the same layer op by op: outputs and every gradient.
TEST(Lstm, HandWrittenGradientsAreThoseOfTheOps) {
  torch::manual_seed(3);
  const int64_t groups = 3, frames = 7, samples = 5, width = 8;
  std::vector<Tensor> inputs{
      torch::randn({groups, frames, samples, width}), torch::randn({groups, 4 * width, width}),
      torch::randn({groups, 4 * width, width}),       torch::randn({groups, 4 * width}),
      torch::randn({groups, samples, width}),         torch::randn({groups, samples, width})};
  const Tensor weight = torch::randn({groups, frames, samples, width});
  const Tensor last_weight = torch::randn({groups, samples, width});
  std::vector<std::vector<Tensor>> results;
  for (const bool by_ops : {false, true}) {
    std::vector<Tensor> x;
    for (const Tensor& input : inputs) x.push_back(input.clone().requires_grad_(true));
    const auto [y, c] = by_ops ? LstmLayerByOps(x[0], x[1], x[2], x[3], x[4], x[5])
                               : LstmLayer(x[0], x[1], x[2], x[3], x[4], x[5]);
    ((y * weight).sum() + (c * last_weight).sum()).backward();
    std::vector<Tensor> result{y.detach(), c.detach()};
    for (const Tensor& input : x) result.push_back(input.grad());
    results.push_back(result);
  }
  for (std::size_t i = 0; i < results[0].size(); ++i) {
    EXPECT_TRUE(torch::allclose(results[0][i], results[1][i], 1e-4, 1e-4)) << "result " << i;
  }
}

// The same on a CUDA device, where the cells are libtorch's.
TEST(Lstm, OnADeviceGradientsAreThoseOfTheOps) {
  if (!torch::cuda::is_available()) GTEST_SKIP() << "no CUDA device";
  torch::manual_seed(3);
  const int64_t groups = 3, frames = 7, samples = 5, width = 32;
  std::vector<Tensor> inputs{
      torch::randn({groups, frames, samples, width}), torch::randn({groups, 4 * width, width}),
      torch::randn({groups, 4 * width, width}),       torch::randn({groups, 4 * width}),
      torch::randn({groups, samples, width}),         torch::randn({groups, samples, width})};
  const Tensor weight = torch::randn({groups, frames, samples, width});
  std::vector<std::vector<Tensor>> results;
  for (const bool on_device : {true, false}) {
    const torch::Device device = on_device ? torch::kCUDA : torch::kCPU;
    std::vector<Tensor> x;
    for (const Tensor& input : inputs) x.push_back(input.to(device, true).requires_grad_(true));
    const auto [y, c] = on_device ? LstmLayer(x[0], x[1], x[2], x[3], x[4], x[5])
                                  : LstmLayerByOps(x[0], x[1], x[2], x[3], x[4], x[5]);
    ((y * weight.to(device)).sum() + c.sum()).backward();
    std::vector<Tensor> result{y.detach().cpu(), c.detach().cpu()};
    for (const Tensor& input : x) result.push_back(input.grad().cpu());
    results.push_back(result);
  }
  for (std::size_t i = 0; i < results[0].size(); ++i) {
    EXPECT_TRUE(torch::allclose(results[0][i], results[1][i], 1e-3, 1e-3)) << "result " << i;
  }
}

// Two windows with carried states are one long window.
TEST(Lstm, CarriedStatesContinueTheWindow) {
  torch::manual_seed(4);
  const int64_t width = 8;
  const Tensor x = torch::randn({1, 10, 2, width});
  const Tensor wi = torch::randn({1, 4 * width, width}), wh = torch::randn({1, 4 * width, width});
  const Tensor b = torch::randn({1, 4 * width}), s = torch::randn({1, 2, width});
  const auto [whole, whole_c] = LstmLayer(x, wi, wh, b, s, s);
  const auto [first, first_c] = LstmLayer(x.narrow(1, 0, 6), wi, wh, b, s, s);
  const auto [second, second_c] =
      LstmLayer(x.narrow(1, 6, 4), wi, wh, b, first.select(1, 5), first_c);
  EXPECT_TRUE(torch::allclose(whole.narrow(1, 6, 4), second, 1e-5, 1e-5));
  EXPECT_TRUE(torch::allclose(whole_c, second_c, 1e-5, 1e-5));
}

}  // namespace
}  // namespace styled::train::style_erd

#include "model/train/device.h"

namespace styled::train {

torch::Device DeviceOf(const RunConfig& run) {
  const bool cuda = run.device == "cuda" || (run.device == "auto" && torch::cuda::is_available());
  return cuda ? torch::kCUDA : torch::kCPU;
}

void SeedTorch(const RunConfig& run) {
  at::set_num_threads(run.threads);
  torch::manual_seed(run.seed);
}

}  // namespace styled::train

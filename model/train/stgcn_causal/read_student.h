#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "model/base/status.h"
#include "model/net/stgcn_causal/network.h"
#include "model/train/stgcn/windows.h"
#include "model/train/stgcn_causal/student.h"

namespace styled::train::st_gcn_causal {

// The generator of weights of family st-gcn-causal, on the CPU and without gradients, and the data
// to run it on clips. Errors name file, key or tensor: all that the runtime refuses, files of other
// families, and statistics or spacings that are not those of past_norm.h and student.h. Pinned by
// tests/unit/train/stgcn_causal/refiner_test.cpp.
struct LoadedStudent {
  std::unique_ptr<Student> student;
  std::shared_ptr<const stgcn_causal::Network> network;  // the same at run time
  st_gcn::Statistics statistics;
  torch::Tensor codes;  // [n, code]: the mean code of each style
};
Result<LoadedStudent> ReadStudent(const std::filesystem::path& file);

// The style of an example, poses at the network's rate, as the daemon makes it.
std::vector<float> ExampleStyle(const LoadedStudent& network, std::span<const body::Pose> example);

}  // namespace styled::train::st_gcn_causal

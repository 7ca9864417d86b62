#include "tests/parity/stgcn_torch.h"

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "model/net/weights_file.h"
#include "model/train/stgcn/weights.h"

namespace styled::parity {
namespace {

using torch::Tensor;

std::string Metadata(const train::st_gcn::Shape& shape, stgcn::Normalization normalization) {
  net::Model model;
  model.family = train::st_gcn::kFamily;
  for (int64_t style = 0; style < shape.domains; ++style) {
    model.styles.push_back({style == 0 ? "neutral" : "style" + std::to_string(style), {}});
  }
  model.licence = "CC0-1.0";
  model.training = "{}";
  nlohmann::json header = net::HeaderOf(model);
  header["heading_tau_s"] = 0.25;
  header["width"] = shape.width;
  header["code"] = shape.code;
  header["noise"] = shape.noise;
  header["window"] = train::st_gcn::kWindowFrames;
  header["contents"] = {"walk"};
  if (normalization == stgcn::Normalization::kSubset) header["normalization"] = "subset";
  return header.dump();
}

}  // namespace

StgcnPair::StgcnPair(int64_t domains, int64_t width, uint64_t seed,
                     const std::filesystem::path& file, stgcn::Normalization normalization)
    : shape{domains, width},
      networks(shape, torch::kCPU, false),
      graph(torch::kCPU, torch::kFloat32, normalization) {
  const torch::NoGradGuard no_grad;
  torch::manual_seed(seed);
  mean = 0.3 * torch::randn({body::kJointCount, stgcn::kChannels});
  mean.index_put_({torch::indexing::Slice(), 6}, 1.0);  // rotations: w
  deviation = torch::rand({body::kJointCount, stgcn::kChannels}) * 0.3 + 0.05;
  mean[body::kHips][0] = mean[body::kHips][2] = 0;
  train::Checkpoint checkpoint;
  checkpoint.strings["metadata"] = Metadata(shape, normalization);
  checkpoint.tensors["mean"] = mean;
  checkpoint.tensors["deviation"] = deviation;
  checkpoint.tensors["codes.mean"] = torch::randn({domains, shape.code});
  for (const auto& [part, parameters] : networks.parts()) {
    parameters->RequireGradient(false);
    for (const auto& [name, tensor] : parameters->named()) {
      const bool scale = name.ends_with(".scale");
      if (scale || tensor.dim() == 1 || name.ends_with("bias")) {
        tensor.uniform_(scale ? 0.5 : -0.3, scale ? 1.5 : 0.3);
      }
    }
    checkpoint.tensors[std::string("average.") + part] = parameters->flat().clone();
  }
  const Status status = train::st_gcn::ExportWeights(checkpoint, file);
  if (status.ok()) return;
  std::fprintf(stderr, "%s\n", status.message().c_str());
  std::abort();
}

Tensor StgcnPair::Standardized(std::span<const stgcn::Features> clip) const {
  const auto frames = static_cast<int64_t>((clip.size() + 3) / 4 * 4);
  Tensor x = torch::empty({1, frames, body::kJointCount, stgcn::kChannels});
  float* to = x.data_ptr<float>();
  for (std::size_t frame = 0; frame < static_cast<std::size_t>(frames); ++frame) {
    const stgcn::Features& from = clip[std::min(frame, clip.size() - 1)];
    to = std::copy(from.begin(), from.end(), to);
  }
  return (x - mean) / deviation;
}

std::vector<stgcn::Features> StgcnPair::Generate(std::span<const stgcn::Features> clip,
                                                 const Tensor& code) const {
  const torch::NoGradGuard no_grad;
  const train::st_gcn::Generator& g = networks.generator;
  const Tensor y = g.Decode(graph, g.Encode(graph, Standardized(clip)), code) * deviation + mean;
  const Tensor flat = y.contiguous();
  std::vector<stgcn::Features> out(clip.size());
  const float* from = flat.data_ptr<float>();
  for (stgcn::Features& frame : out) {
    std::copy_n(from, frame.size(), frame.begin());
    from += frame.size();
  }
  return out;
}

}  // namespace styled::parity

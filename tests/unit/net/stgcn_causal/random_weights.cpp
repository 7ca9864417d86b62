#include "tests/unit/net/stgcn_causal/random_weights.h"

#include <cstdio>
#include <cstdlib>
#include <random>

namespace styled::stgcn_causal {

WeightsFile RandomWeights(int domains, int width, unsigned seed) {
  WeightsFile file = stgcn::RandomWeights(domains, width, seed);
  file.metadata["family"] = "st-gcn-causal";
  file.metadata["spacing"] = {2, 4, 2, 1};
  file.metadata["memory"] = 21;
  file.metadata["start_frames"] = 16;
  std::mt19937 random(seed);
  const auto share = [&random] {
    return static_cast<float>(random() >> 8) / static_cast<float>(1 << 24);
  };
  const auto add = [&](const std::string& norm, int channels) {
    net::NamedTensor mean{norm + ".start_mean", {channels}, {}};
    net::NamedTensor square{norm + ".start_square", {channels}, {}};
    for (int c = 0; c < channels; ++c) {
      mean.values.push_back(share() - 0.5F);
      square.values.push_back(mean.values.back() * mean.values.back() + 0.3F + share());
    }
    file.tensors.push_back(std::move(mean));
    file.tensors.push_back(std::move(square));
  };
  const int w = width;
  add("g.enc1.norm1", w);
  add("g.enc1.norm2", w);
  add("g.enc2.norm1", 2 * w);
  add("g.enc2.norm2", 2 * w);
  add("g.dec1.adain1", 4 * w);
  add("g.dec1.adain2", 2 * w);
  add("g.dec2.adain1", 2 * w);
  add("g.dec2.adain2", w);
  return file;
}

std::shared_ptr<const Network> CausalNetwork(const WeightsFile& file) {
  const auto network = Network::Parse(file.Bytes(), "random");
  if (network.ok()) return network.value();
  std::fprintf(stderr, "%s\n", network.status().message().c_str());
  std::abort();
}

}  // namespace styled::stgcn_causal

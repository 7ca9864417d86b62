// Reads the file format of model/net/stgcn/FORMAT.md into a Network; an error is one sentence.

#include "model/net/stgcn/network.h"
#include "model/net/stgcn/weights.h"
#include "model/net/weights_file.h"

namespace styled::stgcn {
namespace {

using net::Faults;
using net::RowMajor;
using net::TensorReader;

GeneratorWeights ReadGenerator(LayerReader& layers, int width) {
  GeneratorWeights g;
  g.in = layers.ReadLinear("g.in", width, kChannels, kNodes[0]);
  g.encoder[0] = ReadEncoder(layers, "g.enc1", 0, width, 2 * width, true);
  g.encoder[1] = ReadEncoder(layers, "g.enc2", 1, 2 * width, 4 * width, true);
  g.decoder[0] = ReadDecoder(layers, "g.dec1", 1, 4 * width, 2 * width);
  g.decoder[1] = ReadDecoder(layers, "g.dec2", 0, 2 * width, width);
  g.out = layers.ReadLinear("g.out", kChannels, width, 0);
  return g;
}

}  // namespace

Network::Network() : weights_(std::make_unique<Weights>()) {}

Result<std::shared_ptr<const Network>> Network::Load(const std::filesystem::path& file) {
  const Result<std::vector<std::byte>> bytes = net::ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  return Parse(bytes.value(), file.string());
}

Result<std::shared_ptr<const Network>> Network::Parse(std::span<const std::byte> bytes,
                                                      const std::string& name) {
  Result<net::WeightsFile> file = net::ParseWeights(bytes, name);
  if (!file.ok()) return file.status();
  return Read(file.value());
}

Result<std::shared_ptr<const Network>> Network::Read(net::WeightsFile& file) {
  const std::shared_ptr<Network> network(new Network);
  Weights& w = *network->weights_;
  Faults faults(file.name);
  network->model_ = file.model;
  FeatureParameters& features = network->features_;
  ReadParameters(file, features, faults);
  net::ExpectEqual(file.header, "code", static_cast<unsigned>(kCode), faults);
  net::ExpectEqual(file.header, "noise", static_cast<unsigned>(kNoise), faults);
  net::ExpectEqual(file.header, "window", static_cast<unsigned>(kReference), faults);
  CheckContents(file.header, faults);
  const Normalization normalization = ReadNormalization(file.header, faults);
  const int width = w.width = ReadWidth(file.header, faults);
  if (!faults.none()) return faults.status();

  TensorReader tensors(file.view, faults);
  LayerReader layers(tensors, normalization);
  w.standard = ReadStandardization(tensors, features, faults);
  if (!faults.none()) return faults.status();
  w.generator = ReadGenerator(layers, width);
  const auto domains = static_cast<int>(file.model.styles.size());
  w.space = std::make_unique<const CodeSpace>(layers, features, w.standard, width, domains);
  tensors.Finish();
  if (!faults.none()) return faults.status();
  return std::shared_ptr<const Network>(network);
}

}  // namespace styled::stgcn

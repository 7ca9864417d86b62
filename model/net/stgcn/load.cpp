// Reads the file format of model/net/stgcn/FORMAT.md into a Network; an error is one sentence.
#include <cmath>

#include "model/net/stgcn/network.h"
#include "model/net/stgcn/weights.h"
#include "model/net/weights_file.h"

namespace styled::stgcn {
namespace {

using net::Faults;
using net::RowMajor;
using net::TensorReader;

Dense TakeDense(TensorReader& tensors, const std::string& name, int rows, int columns) {
  return {tensors.Matrix(name + ".weight", rows, columns), tensors.Vector(name + ".bias", rows)};
}

TimeConv TakeTime(TensorReader& tensors, const std::string& name, int channels, float scale) {
  const RowMajor weight = tensors.Tensor(name + ".weight", {channels, channels, 3});
  return {weight, tensors.Vector(name + ".bias", channels), scale};
}

AdaIn TakeAdaIn(TensorReader& tensors, const std::string& name, int channels) {
  AdaIn adain{tensors.Matrix(name + ".weight", 2 * channels, kCode),
              tensors.Vector(name + ".bias", 2 * channels)};
  adain.bias.head(channels).array() += 1;  // 1 + γ
  return adain;
}

// From `level` to the coarser one.
EncoderBlock TakeEncoder(LayerReader& layers, const std::string& name, int level, int in, int out,
                         bool normalized) {
  EncoderBlock block{layers.TakeEncoder(name, level, in, out, 2), {}, {}, {}, {}};
  if (normalized) block.norm1 = layers.TakeNorm(name + ".norm1", in);
  block.time1 = TakeTime(layers.tensors(), name + ".tconv1", in, 1);
  if (normalized) block.norm2 = layers.TakeNorm(name + ".norm2", in);
  block.time2 = TakeTime(layers.tensors(), name + ".tconv2", out, kPathShare);
  return block;
}

// From the coarser level to `level`.
DecoderBlock TakeDecoder(LayerReader& layers, const std::string& name, int level, int in, int out) {
  DecoderBlock block{layers.TakeDecoder(name, level, in, out), {}, {}, {}, {}};
  block.adain1 = TakeAdaIn(layers.tensors(), name + ".adain1", in);
  block.time1 = TakeTime(layers.tensors(), name + ".tconv1", out, 1);
  block.adain2 = TakeAdaIn(layers.tensors(), name + ".adain2", out);
  block.time2 = TakeTime(layers.tensors(), name + ".tconv2", out, kPathShare);
  return block;
}

// The convolution over 16 frames of 5 nodes as one matrix; the trunk's floats are in the order
// frame, node, channel, the file's in channel, frame, node.
Linear TakeConv(TensorReader& tensors, int channels) {
  constexpr int kFrames = kReference / 4;
  const RowMajor weight = tensors.Tensor("e.conv.weight", {channels, channels, kFrames, kNodes[2]});
  const RowMajor bias = tensors.Vector("e.conv.bias", channels).transpose();
  constexpr int kPlaces = kFrames * kNodes[2];
  const std::array<int, 1> depth{kPlaces * channels};
  Linear linear;
  linear.weight = net::PackedColumns(depth, channels);
  for (int out = 0; out < channels; ++out) {
    for (int place = 0; place < kPlaces; ++place) {
      for (int in = 0; in < channels; ++in) {
        linear.weight.At(0, out, place * channels + in) = weight(out, in * kPlaces + place);
      }
    }
  }
  Copy(bias, linear.bias);
  return linear;
}

GeneratorWeights TakeGenerator(LayerReader& layers, int width) {
  GeneratorWeights g;
  g.in = layers.TakeLinear("g.in", width, kChannels, kNodes[0]);
  g.encoder[0] = TakeEncoder(layers, "g.enc1", 0, width, 2 * width, true);
  g.encoder[1] = TakeEncoder(layers, "g.enc2", 1, 2 * width, 4 * width, true);
  g.decoder[0] = TakeDecoder(layers, "g.dec1", 1, 4 * width, 2 * width);
  g.decoder[1] = TakeDecoder(layers, "g.dec2", 0, 2 * width, width);
  g.out = layers.TakeLinear("g.out", kChannels, width, 0);
  return g;
}

StyleEncoderWeights TakeStyleEncoder(LayerReader& layers, int width, int domains) {
  StyleEncoderWeights e;
  const int trunk = 4 * width;
  e.in = layers.TakeLinear("e.in", width, kChannels, kNodes[0]);
  e.blocks[0] = TakeEncoder(layers, "e.res1", 0, width, 2 * width, false);
  e.blocks[1] = TakeEncoder(layers, "e.res2", 1, 2 * width, trunk, false);
  e.conv = TakeConv(layers.tensors(), trunk);
  const RowMajor heads = layers.tensors().Tensor("e.heads.weight", {domains, kCode, trunk});
  const RowMajor bias = layers.tensors().Matrix("e.heads.bias", domains, kCode);
  for (int domain = 0; domain < domains; ++domain) {
    e.heads.push_back({Eigen::Map<const RowMajor>(heads.row(domain).data(), kCode, trunk),
                       bias.row(domain).transpose()});
  }
  e.heads.push_back(TakeDense(layers.tensors(), "e.free", kCode, trunk));
  return e;
}

MappingWeights TakeMapping(LayerReader& layers, int domains) {
  constexpr int kHidden = 256;
  MappingWeights f;
  f.noise = TakeDense(layers.tensors(), "f.noise", kHidden, kNoise);
  f.label = TakeDense(layers.tensors(), "f.label", kHidden, domains);
  f.first = TakeDense(layers.tensors(), "f.fc1", 2 * kHidden, 2 * kHidden);
  f.second = TakeDense(layers.tensors(), "f.fc2", 4 * kHidden, 2 * kHidden);
  f.out = TakeDense(layers.tensors(), "f.out", kCode, 4 * kHidden);
  return f;
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
  const int width = w.width = ReadWidth(file.header, faults);
  if (!faults.none()) return faults.status();

  TensorReader tensors(file.view, faults);
  LayerReader layers(tensors);
  w.standard = TakeStandardization(tensors, features, faults);
  if (!faults.none()) return faults.status();
  const int domains = network->domain_count();
  w.generator = TakeGenerator(layers, width);
  w.encoder = TakeStyleEncoder(layers, width, domains);
  w.mapping = TakeMapping(layers, domains);
  const RowMajor codes = tensors.Matrix("codes.mean", domains, kCode);
  for (int domain = 0; domain < domains; ++domain) {
    w.mean_codes.emplace_back(codes.row(domain).transpose());
  }
  tensors.Finish();
  if (!faults.none()) return faults.status();
  return std::shared_ptr<const Network>(network);
}

}  // namespace styled::stgcn

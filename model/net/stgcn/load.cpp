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

constexpr float kMaxHeadingTau_s = 60.0F;
const float kShare = std::sqrt(0.5F);  // of the main and the skip path in a block's sum

// Reads the width; 0 and a fault if there is none that the kernels can run.
int ReadWidth(const nlohmann::json& object, Faults& faults) {
  const nlohmann::json* const value = net::FindKey(object, "width", faults);
  if (value == nullptr) return 0;
  const double width = value->is_number_integer() ? value->get<double>() : 0;
  if (width >= kWidthStep && width <= kMaxWidth && std::fmod(width, kWidthStep) == 0) {
    return static_cast<int>(width);
  }
  faults.Key("width",
             "a multiple of " + std::to_string(kWidthStep) + " up to " + std::to_string(kMaxWidth),
             net::Shown(*value));
  return 0;
}

// Names of the acts of the training data, for people.
void CheckContents(const nlohmann::json& object, Faults& faults) {
  const nlohmann::json* const value = net::FindKey(object, "contents", faults);
  if (value == nullptr) return;
  bool names = value->is_array();
  for (const nlohmann::json& name : *value) names = names && name.is_string();
  if (!names) faults.Key("contents", "an array of strings", net::Shown(*value));
}

void Copy(const RowMajor& from, net::AlignedFloats& to) {
  to.Grow(static_cast<std::size_t>(from.size()));
  std::copy_n(from.data(), from.size(), to.data());
}

void Pack(const RowMajor& from, float scale, std::size_t term, net::PackedColumns& to) {
  for (int column = 0; column < from.rows(); ++column) {
    for (int channel = 0; channel < from.cols(); ++channel) {
      to.At(term, column, channel) = scale * from(column, channel);
    }
  }
}

// A bias as the kernels want it: as many columns as the product has.
void CopyPadded(const RowMajor& bias, int columns, net::AlignedFloats& to) {
  RowMajor padded = RowMajor::Zero(bias.rows(), columns);
  padded.leftCols(bias.cols()) = bias;
  Copy(padded, to);
}

// Reads layers from a file's tensors.
class LayerReader {
 public:
  explicit LayerReader(TensorReader& tensors) : tensors_(tensors) {}

  Dense TakeDense(const std::string& name, int rows, int columns) {
    return {tensors_.Matrix(name + ".weight", rows, columns),
            tensors_.Vector(name + ".bias", rows)};
  }

  // A 1 x 1 convolution of every node; with `nodes`, and a bias of each node.
  Linear TakeLinear(const std::string& name, int out, int in, int nodes) {
    Linear linear;
    const std::array<int, 1> depth{in};
    linear.weight = net::PackedColumns(depth, out);
    Pack(tensors_.Matrix(name + ".weight", out, in), 1, 0, linear.weight);
    RowMajor bias = tensors_.Vector(name + ".bias", out).transpose();
    if (nodes > 0) {
      bias = bias.replicate(nodes, 1).eval();
      bias += tensors_.Matrix(name + ".node_bias", nodes, out);
    }
    linear.bias_rows = static_cast<int>(bias.rows());
    CopyPadded(bias, linear.weight.columns(), linear.bias);
    return linear;
  }

  // `mixing`: adjacency with pooling behind or unpooling before it, `pooling` that pooling (or
  // identity): the bias of each node comes before it.
  GraphConv TakeGraph(const std::string& name, int out, int in,
                      const std::array<Eigen::MatrixXf, kLabelCount>& mixing,
                      const Eigen::MatrixXf& pooling) {
    const RowMajor weight = tensors_.Matrix(name + ".weight", kLabelCount * out, in);
    const Eigen::VectorXf bias = tensors_.Vector(name + ".bias", kLabelCount * out);
    const RowMajor node_bias =
        tensors_.Matrix(name + ".node_bias", static_cast<int>(pooling.rows()), out);
    return {mixing, weight, bias, pooling.transpose() * node_bias};
  }

  TimeConv TakeTime(const std::string& name, int channels, float scale) {
    const RowMajor weight = tensors_.Tensor(name + ".weight", {channels, channels, 3});
    return {weight, tensors_.Vector(name + ".bias", channels), scale};
  }

  // The skip path's weight, scaled.
  net::PackedColumns TakeSkip(const std::string& name, int out, int in) {
    const std::array<int, 1> depth{in};
    net::PackedColumns packed(depth, out);
    Pack(tensors_.Matrix(name + ".skip.weight", out, in), kShare, 0, packed);
    return packed;
  }

  Norm TakeNorm(const std::string& name, int channels) {
    const RowMajor scale = tensors_.Vector(name + ".scale", channels);
    const RowMajor shift = tensors_.Vector(name + ".shift", channels);
    return {{scale.data(), scale.data() + scale.size()},
            {shift.data(), shift.data() + shift.size()}};
  }

  AdaIn TakeAdaIn(const std::string& name, int channels) {
    AdaIn adain{tensors_.Matrix(name + ".weight", 2 * channels, kCode),
                tensors_.Vector(name + ".bias", 2 * channels)};
    adain.bias.head(channels).array() += 1;  // 1 + γ
    return adain;
  }

  EncoderBlock TakeEncoder(const std::string& name, int level, int in, int out, bool normalized);
  DecoderBlock TakeDecoder(const std::string& name, int level, int in, int out);
  TensorReader& tensors() { return tensors_; }

 private:
  TensorReader& tensors_;
};

// From `level` to the coarser one.
EncoderBlock LayerReader::TakeEncoder(const std::string& name, int level, int in, int out,
                                      bool normalized) {
  EncoderBlock block;
  block.in = in;
  block.out = out;
  const Eigen::MatrixXf pooling = Pooling(level);
  const Eigen::MatrixXf same = Eigen::MatrixXf::Identity(pooling.cols(), pooling.cols());
  auto pooled = Adjacency(level);
  for (Eigen::MatrixXf& label : pooled) label *= pooling;
  if (normalized) block.norm1 = TakeNorm(name + ".norm1", in);
  block.graph1 = TakeGraph(name + ".gconv1", in, in, pooled, pooling);
  block.time1 = TakeTime(name + ".tconv1", in, 1);
  if (normalized) block.norm2 = TakeNorm(name + ".norm2", in);
  block.graph2 = TakeGraph(name + ".gconv2", out, in, Adjacency(level + 1), same);
  block.time2 = TakeTime(name + ".tconv2", out, kShare);
  block.skip = TakeSkip(name, out, in);
  block.pool_begins.push_back(0);
  for (int cluster = 0; cluster < pooling.cols(); ++cluster) {
    for (int node = 0; node < pooling.rows(); ++node) {
      if (pooling(node, cluster) == 0) continue;
      for (const int of_pair : {0, 1}) {
        block.pool_parts.push_back({of_pair, node, pooling(node, cluster) / 2});
      }
    }
    block.pool_begins.push_back(static_cast<int>(block.pool_parts.size()));
  }
  return block;
}

// From the coarser level to `level`.
DecoderBlock LayerReader::TakeDecoder(const std::string& name, int level, int in, int out) {
  DecoderBlock block;
  block.in = in;
  block.out = out;
  const Eigen::MatrixXf unpooling = Unpooling(level);
  auto unpooled = Adjacency(level);
  for (Eigen::MatrixXf& label : unpooled) label = (unpooling * label).eval();
  const auto same = [](Eigen::Index nodes) -> Eigen::MatrixXf {
    return Eigen::MatrixXf::Identity(nodes, nodes);
  };
  block.adain1 = TakeAdaIn(name + ".adain1", in);
  block.graph1 = TakeGraph(name + ".gconv1", out, in, Adjacency(level + 1), same(unpooling.rows()));
  block.time1 = TakeTime(name + ".tconv1", out, 1);
  block.adain2 = TakeAdaIn(name + ".adain2", out);
  block.graph2 = TakeGraph(name + ".gconv2", out, out, unpooled, same(unpooling.cols()));
  block.time2 = TakeTime(name + ".tconv2", out, kShare);
  block.skip = TakeSkip(name, out, in);
  const std::span<const int> clusters = ClustersOf(level);
  block.clusters.assign(clusters.begin(), clusters.end());
  for (Eigen::Index c = 0; c < unpooling.rows(); ++c) {
    block.cluster_sizes.push_back(unpooling.row(c).sum());
  }
  return block;
}

// The hemispheres are the mean rotations; deviations must be usable as divisors.
void CheckFeatures(const RowMajor& mean, const RowMajor& deviation, Faults& faults) {
  constexpr float kLeastNorm = 1e-3F;
  for (Eigen::Index i = 0; i < deviation.size(); ++i) {
    if (deviation.data()[i] > 0) continue;
    faults.Add("tensor 'features.deviation': expected values > 0, found " +
               std::to_string(deviation.data()[i]) + " at " + std::to_string(i));
  }
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const float length = mean.row(joint).tail<kRotationChannels>().norm();
    if (length >= kLeastNorm) continue;
    faults.Add("tensor 'features.mean': expected a rotation for " +
               std::string(body::kHumanoid[static_cast<std::size_t>(joint)].name) +
               ", found one of length " + std::to_string(length));
  }
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
  g.encoder[0] = layers.TakeEncoder("g.enc1", 0, width, 2 * width, true);
  g.encoder[1] = layers.TakeEncoder("g.enc2", 1, 2 * width, 4 * width, true);
  g.decoder[0] = layers.TakeDecoder("g.dec1", 1, 4 * width, 2 * width);
  g.decoder[1] = layers.TakeDecoder("g.dec2", 0, 2 * width, width);
  g.out = layers.TakeLinear("g.out", kChannels, width, 0);
  return g;
}

StyleEncoderWeights TakeStyleEncoder(LayerReader& layers, int width, int domains) {
  StyleEncoderWeights e;
  const int trunk = 4 * width;
  e.in = layers.TakeLinear("e.in", width, kChannels, kNodes[0]);
  e.blocks[0] = layers.TakeEncoder("e.res1", 0, width, 2 * width, false);
  e.blocks[1] = layers.TakeEncoder("e.res2", 1, 2 * width, trunk, false);
  e.conv = TakeConv(layers.tensors(), trunk);
  const RowMajor heads = layers.tensors().Tensor("e.heads.weight", {domains, kCode, trunk});
  const RowMajor bias = layers.tensors().Matrix("e.heads.bias", domains, kCode);
  for (int domain = 0; domain < domains; ++domain) {
    e.heads.push_back({Eigen::Map<const RowMajor>(heads.row(domain).data(), kCode, trunk),
                       bias.row(domain).transpose()});
  }
  e.heads.push_back(layers.TakeDense("e.free", kCode, trunk));
  return e;
}

MappingWeights TakeMapping(LayerReader& layers, int domains) {
  constexpr int kHidden = 256;
  MappingWeights f;
  f.noise = layers.TakeDense("f.noise", kHidden, kNoise);
  f.label = layers.TakeDense("f.label", kHidden, domains);
  f.first = layers.TakeDense("f.fc1", 2 * kHidden, 2 * kHidden);
  f.second = layers.TakeDense("f.fc2", 4 * kHidden, 2 * kHidden);
  f.out = layers.TakeDense("f.out", kCode, 4 * kHidden);
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
  features.rate_hz = file.model.rate_hz;
  features.heading_tau_s =
      net::ReadNumber(file.header, "heading_tau_s", {0, kMaxHeadingTau_s}, faults);
  net::ExpectEqual(file.header, "code", static_cast<unsigned>(kCode), faults);
  net::ExpectEqual(file.header, "noise", static_cast<unsigned>(kNoise), faults);
  net::ExpectEqual(file.header, "window", static_cast<unsigned>(kReference), faults);
  CheckContents(file.header, faults);
  const int width = w.width = ReadWidth(file.header, faults);
  if (!faults.none()) return faults.status();

  TensorReader tensors(file.view, faults);
  LayerReader layers(tensors);
  const RowMajor mean = tensors.Matrix("features.mean", body::kJointCount, kChannels);
  const RowMajor deviation = tensors.Matrix("features.deviation", body::kJointCount, kChannels);
  if (faults.none()) CheckFeatures(mean, deviation, faults);
  if (!faults.none()) return faults.status();
  std::copy_n(mean.data(), kFeatureCount, w.mean.begin());
  std::copy_n(deviation.data(), kFeatureCount, w.deviation.begin());
  for (std::size_t i = 0; i < kFeatureCount; ++i) w.inverse_deviation[i] = 1 / w.deviation[i];
  SetHemisphere(w.mean, features);

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

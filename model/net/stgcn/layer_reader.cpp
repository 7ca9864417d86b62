#include "model/net/stgcn/layer_reader.h"

#include <algorithm>
#include <cmath>

#include "model/net/stgcn/network.h"

namespace styled::stgcn {
namespace {

using net::Faults;
using net::RowMajor;

constexpr float kMaxHeadingTau_s = 60.0F;

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

// A bias as the kernels want it: as many columns as the product has.
void CopyPadded(const RowMajor& bias, int columns, net::AlignedFloats& to) {
  RowMajor padded = RowMajor::Zero(bias.rows(), columns);
  padded.leftCols(bias.cols()) = bias;
  Copy(padded, to);
}

}  // namespace

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

Normalization ReadNormalization(const nlohmann::json& object, Faults& faults) {
  const auto found = object.find("normalization");
  if (found == object.end() || *found == "neighbours") return Normalization::kNeighbours;
  if (*found != "subset") {
    faults.Key("normalization", "\"neighbours\" or \"subset\"", net::Shown(*found));
  }
  return Normalization::kSubset;
}

void CheckContents(const nlohmann::json& object, Faults& faults) {
  const nlohmann::json* const value = net::FindKey(object, "contents", faults);
  if (value == nullptr) return;
  bool names = value->is_array();
  for (const nlohmann::json& name : *value) names = names && name.is_string();
  if (!names) faults.Key("contents", "an array of strings", net::Shown(*value));
}

void ReadParameters(const net::WeightsFile& file, FeatureParameters& features, Faults& faults) {
  features.rate_hz = file.model.rate_hz;
  features.heading_tau_s =
      net::ReadNumber(file.header, "heading_tau_s", {0, kMaxHeadingTau_s}, faults);
}

Standardization ReadStandardization(net::TensorReader& tensors, FeatureParameters& features,
                                    Faults& faults) {
  Standardization standard{};
  const RowMajor mean = tensors.Matrix("features.mean", body::kJointCount, kChannels);
  const RowMajor deviation = tensors.Matrix("features.deviation", body::kJointCount, kChannels);
  if (faults.none()) CheckFeatures(mean, deviation, faults);
  if (!faults.none()) return standard;
  std::copy_n(mean.data(), kFeatureCount, standard.mean.begin());
  std::copy_n(deviation.data(), kFeatureCount, standard.deviation.begin());
  for (std::size_t i = 0; i < kFeatureCount; ++i) {
    standard.inverse_deviation[i] = 1 / standard.deviation[i];
  }
  SetHemisphere(standard.mean, features);
  return standard;
}

void Pack(const RowMajor& from, float scale, std::size_t term, net::PackedColumns& to) {
  for (int column = 0; column < from.rows(); ++column) {
    for (int channel = 0; channel < from.cols(); ++channel) {
      to.At(term, column, channel) = scale * from(column, channel);
    }
  }
}

void Copy(const RowMajor& from, net::AlignedFloats& to) {
  to.Grow(static_cast<std::size_t>(from.size()));
  std::copy_n(from.data(), from.size(), to.data());
}

Linear LayerReader::ReadLinear(const std::string& name, int out, int in, int nodes) {
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

Norm LayerReader::ReadNorm(const std::string& name, int channels) {
  const RowMajor scale = tensors_.Vector(name + ".scale", channels);
  const RowMajor shift = tensors_.Vector(name + ".shift", channels);
  return {{scale.data(), scale.data() + scale.size()}, {shift.data(), shift.data() + shift.size()}};
}

// `mixing`: adjacency with pooling behind or unpooling before it, `pooling` that pooling (or
// identity): the bias of each node comes before it.
GraphConv LayerReader::ReadGraph(const std::string& name, int out, int in,
                                 const std::array<Eigen::MatrixXf, kLabelCount>& mixing,
                                 const Eigen::MatrixXf& pooling) {
  const RowMajor weight = tensors_.Matrix(name + ".weight", kLabelCount * out, in);
  const Eigen::VectorXf bias = tensors_.Vector(name + ".bias", kLabelCount * out);
  const RowMajor node_bias =
      tensors_.Matrix(name + ".node_bias", static_cast<int>(pooling.rows()), out);
  return {mixing, weight, bias, pooling.transpose() * node_bias};
}

net::PackedColumns LayerReader::ReadSkip(const std::string& name, int out, int in) {
  const std::array<int, 1> depth{in};
  net::PackedColumns packed(depth, out);
  Pack(tensors_.Matrix(name + ".skip.weight", out, in), kPathShare, 0, packed);
  return packed;
}

EncoderNodes LayerReader::ReadEncoder(const std::string& name, int level, int in, int out,
                                      int frames) {
  EncoderNodes block;
  block.in = in;
  block.out = out;
  const Eigen::MatrixXf pooling = Pooling(level);
  const Eigen::MatrixXf same = Eigen::MatrixXf::Identity(pooling.cols(), pooling.cols());
  auto pooled = Adjacency(level, normalization_);
  for (Eigen::MatrixXf& label : pooled) label *= pooling;
  block.graph1 = ReadGraph(name + ".gconv1", in, in, pooled, pooling);
  block.graph2 = ReadGraph(name + ".gconv2", out, in, Adjacency(level + 1, normalization_), same);
  block.skip = ReadSkip(name, out, in);
  block.pool_begins.push_back(0);
  for (int cluster = 0; cluster < pooling.cols(); ++cluster) {
    for (int node = 0; node < pooling.rows(); ++node) {
      if (pooling(node, cluster) == 0) continue;
      for (int frame = 0; frame < frames; ++frame) {
        const float share = pooling(node, cluster) / static_cast<float>(frames);
        block.pool_parts.push_back({frame, node, share});
      }
    }
    block.pool_begins.push_back(static_cast<int>(block.pool_parts.size()));
  }
  return block;
}

DecoderNodes LayerReader::ReadDecoder(const std::string& name, int level, int in, int out) {
  DecoderNodes block;
  block.in = in;
  block.out = out;
  const Eigen::MatrixXf unpooling = Unpooling(level);
  auto unpooled = Adjacency(level, normalization_);
  for (Eigen::MatrixXf& label : unpooled) label = (unpooling * label).eval();
  const auto same = [](Eigen::Index nodes) -> Eigen::MatrixXf {
    return Eigen::MatrixXf::Identity(nodes, nodes);
  };
  block.graph1 = ReadGraph(name + ".gconv1", out, in, Adjacency(level + 1, normalization_),
                           same(unpooling.rows()));
  block.graph2 = ReadGraph(name + ".gconv2", out, out, unpooled, same(unpooling.cols()));
  block.skip = ReadSkip(name, out, in);
  const std::span<const int> clusters = ClustersOf(level);
  block.clusters.assign(clusters.begin(), clusters.end());
  for (Eigen::Index c = 0; c < unpooling.rows(); ++c) {
    block.cluster_sizes.push_back(unpooling.row(c).sum());
  }
  return block;
}

}  // namespace styled::stgcn

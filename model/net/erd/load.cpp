// Reads the file format of model/net/erd/FORMAT.md into a Network; an error is one sentence.
#include <type_traits>

#include "model/net/erd/network.h"
#include "model/net/erd/weights.h"
#include "model/net/weights_file.h"

namespace styled::erd {
namespace {

using net::Faults;
using net::RowMajor;
using nlohmann::json;

constexpr float kMaxHeadingTau_s = 60.0F;

// The keys of this family. A size that differs from the network's is refused.
void ReadKeys(const json& object, const Shape& shape, FeatureParameters& features, Faults& faults) {
  if (const json* contents = net::FindKey(object, "contents", faults)) {
    if (!contents->is_array()) {
      faults.Key("contents", "an array", net::Shown(*contents));
    } else if (!contents->empty()) {
      faults.Key("contents", "[]",
                 net::Shown(*contents) +
                     ": the network takes a content input, which this build does "
                     "not feed");
    }
  }
  features.heading_tau_s = net::ReadNumber(object, "heading_tau_s", {0, kMaxHeadingTau_s}, faults);
  const auto expect = [&](const char* key, const json& expected) {
    net::ExpectEqual(object, key, expected, faults);
  };
  expect("latent", static_cast<unsigned>(shape.latent));
  expect("encoder", json::array({static_cast<unsigned>(shape.encoder)}));
  expect("decoder", shape.decoder);
  expect("neutral_layers", static_cast<unsigned>(kNeutralLayers));
  expect("style_layers", static_cast<unsigned>(kStyleLayers));
  expect("gates", "ifgo");
}

template <typename Derived, std::size_t Size>
void Pack(const Eigen::MatrixBase<Derived>& vector, std::array<float, Size>& out) {
  for (Eigen::Index i = 0; i < vector.size(); ++i) out[i] = vector[i];
}
template <typename Derived, int Rows, int Columns>
void Pack(const Eigen::MatrixBase<Derived>& matrix, PackedMatrix<Rows, Columns>& out) {
  for (int column = 0; column < Columns; ++column) {
    for (int row = 0; row < Rows; ++row) out[out.Index(row, column)] = matrix(row, column);
  }
}

// Reads layers from a file's tensors.
class LayerReader {
 public:
  explicit LayerReader(net::TensorReader& tensors) : tensors_(tensors) {}

  RowMajor Read(const std::string& name, int rows, int columns) {
    return tensors_.Matrix(name, rows, columns);
  }
  template <int Rows>
  Vector<Rows> Read(const std::string& name) {
    return tensors_.Vector(name, Rows);
  }
  template <int Rows, int Columns>
  void Read(const std::string& name, Affine<Rows, Columns>& out) {
    Pack(Read(name + ".weight", Rows, Columns), out.weight);
    Pack(Read<Rows>(name + ".bias"), out.bias);
  }
  // The same for a weight with one extra column per style at its end, which is added to the bias of
  // its style.
  template <int Rows, int Columns>
  void Read(const std::string& name, int style_count, PackedMatrix<Rows, Columns>& out,
            std::array<PackedVector<Rows>, net::kMaxStyles>& style_bias) {
    const RowMajor all = Read(name + ".weight", Rows, Columns + style_count);
    const Vector<Rows> bias = Read<Rows>(name + ".bias");
    Pack(all.leftCols<Columns>(), out);
    for (int s = 0; s < style_count; ++s) Pack(bias + all.col(Columns + s), style_bias[s]);
  }
  template <int Latent>
  void Read(const std::string& name, LstmLayer<Latent>& out) {
    constexpr int kGates = 4 * Latent;
    const RowMajor input = Read(name + ".input", kGates, Latent);
    const RowMajor hidden = Read(name + ".hidden", kGates, Latent);
    const Vector<kGates> bias = Read<kGates>(name + ".bias");
    RowMajor weight(kGates, 2 * Latent);
    Vector<kGates> ordered_bias;
    for (int row = 0; row < kGates; ++row) {
      const int gate = row / Latent;  // of ifgo
      const int to = net::LstmRow(gate, row % Latent);
      // See weights.h: the sigmoid gates' rows are halved.
      const float scale = gate == 2 ? 1.0F : 0.5F;
      weight.row(to) << scale * hidden.row(row), scale * input.row(row);
      ordered_bias[to] = scale * bias[row];
    }
    Pack(weight, out.weight);
    Pack(ordered_bias, out.bias);
    Pack(Read<Latent>(name + ".h0"), out.h0);
    Pack(Read<Latent>(name + ".c0"), out.c0);
  }

 private:
  net::TensorReader& tensors_;
};

template <int Rows, int Columns>
void RoundMatrix(const Kernels& kernels, PackedMatrix<Rows, Columns>& weight) {
  static_assert(Columns <= net::kMostColumns);
  kernels.pack(weight.data(), net::PaddedRows(Rows) / net::kPanelRows, Columns);
}

std::string LayerName(int style, int layer) {
  return "recurrent." + std::to_string(style) + "." + std::to_string(layer);
}

// The hemispheres are the mean rotations; deviations must be usable as divisors.
void CheckFeatures(const Vector<kFeatureCount>& mean, const Vector<kFeatureCount>& deviation,
                   FeatureParameters& features, Faults& faults) {
  constexpr float kLeastNorm = 1e-3F;
  for (int i = 0; i < kFeatureCount; ++i) {
    if (!(deviation[i] > 0)) {
      faults.Add("tensor 'feature.deviation': expected values > 0, found " +
                 std::to_string(deviation[i]) + " at " + std::to_string(i));
    }
  }
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const Eigen::Vector4f q = mean.segment<4>(4 * joint);
    if (!(q.norm() >= kLeastNorm)) {
      faults.Add("tensor 'feature.mean': expected a rotation for " +
                 std::string(body::kHumanoid[joint].name) + ", found one of length " +
                 std::to_string(q.norm()));
    }
    features.hemisphere[joint].coeffs() = q.normalized();
  }
}

// Stacks the heads into one layer. The file's heads give standardized features; deviation and mean
// are folded into the weights, so that no step has to undo the standardization.
template <int Width>
void ReadHeads(LayerReader& tensors, const Vector<kFeatureCount>& mean,
               const Vector<kFeatureCount>& deviation, Affine<kHeads, Width>& out) {
  RowMajor weight(kHeads, Width);
  Vector<kHeads> bias;
  int row = 0;
  const auto take = [&](const std::string& name, auto rows, int feature) {
    const auto scale = deviation.segment<rows>(feature);
    weight.middleRows<rows>(row) = scale.asDiagonal() * tensors.Read(name + ".weight", rows, Width);
    bias.segment<rows>(row) =
        scale.cwiseProduct(tensors.Read<rows>(name + ".bias")) + mean.segment<rows>(feature);
    row += rows;
  };
  take("head.rotation", std::integral_constant<int, kRotationFeatures>(), 0);
  take("head.velocity", std::integral_constant<int, kVelocityFeatures>(), kVelocityBegin);
  take("head.height", std::integral_constant<int, 1>(), kHipsHeightIndex);
  Pack(weight, out.weight);
  Pack(bias, out.bias);
}

}  // namespace

template <Shape kShape>
void ShapedNetwork<kShape>::Weights::Round(const Kernels& for_kernels) {
  kernels = &for_kernels;
  if (kernels->pack == nullptr) return;
  const auto round = [&](auto&... matrices) { (RoundMatrix(*kernels, matrices), ...); };
  round(encoder0, encoder1.weight, decoder0, decoder1.weight, decoder2.weight, heads.weight);
  for (auto& layer : neutral) round(layer.weight);
  for (auto& style : styles) {
    for (auto& layer : style) round(layer.weight);
  }
}

template <Shape kShape>
ShapedNetwork<kShape>::ShapedNetwork() : weights_(std::make_unique<Weights>()) {}

template <Shape kShape>
Result<std::shared_ptr<const ShapedNetwork<kShape>>> ShapedNetwork<kShape>::Load(
    const std::filesystem::path& file) {
  const Result<std::vector<std::byte>> bytes = net::ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  return Parse(bytes.value(), file.string());
}

template <Shape kShape>
Result<std::shared_ptr<const ShapedNetwork<kShape>>> ShapedNetwork<kShape>::Parse(
    std::span<const std::byte> bytes, const std::string& name) {
  Result<net::WeightsFile> file = net::ParseWeights(bytes, name);
  if (!file.ok()) return file.status();
  return Read(file.value());
}

template <Shape kShape>
Result<std::shared_ptr<const ShapedNetwork<kShape>>> ShapedNetwork<kShape>::Read(
    net::WeightsFile& file) {
  const std::shared_ptr<ShapedNetwork> network(new ShapedNetwork);
  Weights& w = *network->weights_;
  FeatureParameters& features = network->features_;
  Faults faults(file.name);
  network->model_ = file.model;
  features.rate_hz = file.model.rate_hz;
  ReadKeys(file.header, kShape, features, faults);
  if (!faults.none()) return faults.status();

  net::TensorReader all(file.view, faults);
  LayerReader tensors(all);
  const int style_count = network->style_count();
  const auto mean = tensors.Read<kFeatureCount>("feature.mean");
  const auto deviation = tensors.Read<kFeatureCount>("feature.deviation");
  if (faults.none()) CheckFeatures(mean, deviation, features, faults);
  Pack(mean, w.mean);
  Pack(deviation.cwiseInverse(), w.inverse_deviation);
  tensors.Read("encoder.0", style_count, w.encoder0, w.encoder0_bias);
  tensors.Read("encoder.1", w.encoder1);
  for (int l = 0; l < kNeutralLayers; ++l) tensors.Read(LayerName(0, l), w.neutral[l]);
  w.styles.resize(style_count - 1);
  for (int s = 1; s < style_count; ++s) {
    for (int l = 0; l < kStyleLayers; ++l) tensors.Read(LayerName(s, l), w.styles[s - 1][l]);
  }
  tensors.Read("decoder.0", style_count, w.decoder0, w.decoder0_bias);
  tensors.Read("decoder.1", w.decoder1);
  tensors.Read("decoder.2", w.decoder2);
  ReadHeads(tensors, mean, deviation, w.heads);
  all.Finish();
  if (!faults.none()) return faults.status();
  w.Round(*net::BestKernels(file.precision));
  return std::shared_ptr<const ShapedNetwork>(network);
}

template ShapedNetwork<kPaper>::ShapedNetwork();
template Result<std::shared_ptr<const ShapedNetwork<kPaper>>> ShapedNetwork<kPaper>::Load(
    const std::filesystem::path& file);
template Result<std::shared_ptr<const ShapedNetwork<kPaper>>> ShapedNetwork<kPaper>::Parse(
    std::span<const std::byte> bytes, const std::string& name);
template Result<std::shared_ptr<const ShapedNetwork<kPaper>>> ShapedNetwork<kPaper>::Read(
    net::WeightsFile& file);
template ShapedNetwork<kWide>::ShapedNetwork();
template Result<std::shared_ptr<const ShapedNetwork<kWide>>> ShapedNetwork<kWide>::Load(
    const std::filesystem::path& file);
template Result<std::shared_ptr<const ShapedNetwork<kWide>>> ShapedNetwork<kWide>::Parse(
    std::span<const std::byte> bytes, const std::string& name);
template Result<std::shared_ptr<const ShapedNetwork<kWide>>> ShapedNetwork<kWide>::Read(
    net::WeightsFile& file);

}  // namespace styled::erd

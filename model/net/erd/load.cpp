// Reads the file format of model/net/erd/FORMAT.md into a Network; an error is one sentence.
#include <span>
#include <type_traits>

#include "model/base/text.h"
#include "model/net/erd/network.h"
#include "model/net/erd/weights.h"
#include "model/net/weights_file.h"

namespace styled::erd {
namespace {

using net::Faults;
using net::RowMajor;
using nlohmann::json;

constexpr float kMaxHeadingTau_s = 60.0F, kMaxContentRise_s = 60.0F;

// The contents that the network takes as input. Programs print names, and look them up without
// regard to case.
void ReadContents(const json& object, net::Contents& contents, Faults& faults) {
  const json* const found = net::FindKey(object, "contents", faults);
  if (found == nullptr) return;
  if (!found->is_array() || found->size() > net::kMaxContents) {
    faults.Key("contents", "0 to " + std::to_string(net::kMaxContents) + " names",
               found->is_array() ? std::to_string(found->size()) : net::Shown(*found));
    return;
  }
  for (std::size_t i = 0; i < found->size(); ++i) {
    const json& value = (*found)[i];
    const std::string place = "contents[" + std::to_string(i) + "]";
    const std::string name = value.is_string() ? value.get<std::string>() : "";
    if (name.empty() || Printable(name, name.size()) != name) {
      faults.Key(place, "a name without control characters", net::Shown(value));
    }
    // "unknown" is found, too: it means that the content is not known.
    contents.push_back(name);
    if (const auto taken = net::FindContent(contents, name);
        taken.ok() && taken.value() != static_cast<int>(i) && !name.empty()) {
      faults.Key(place, "a name that occurs once, other than " + std::string(net::kUnknownContent),
                 net::Shown(value));
    }
  }
}

// The keys of this family. A size that differs from the network's is refused.
void ReadKeys(const json& object, const Shape& shape, FeatureParameters& features, Faults& faults) {
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
  // The same for a weight with extra columns at its end: one per style, which is added to the bias
  // of its style, then one per content.
  template <int Rows, int Columns>
  void Read(const std::string& name, int style_count, PackedMatrix<Rows, Columns>& out,
            std::array<PackedVector<Rows>, net::kMaxStyles>& style_bias,
            std::span<PackedVector<Rows>> contents = {}) {
    const int labels = style_count + static_cast<int>(contents.size());
    const RowMajor all = Read(name + ".weight", Rows, Columns + labels);
    const Vector<Rows> bias = Read<Rows>(name + ".bias");
    Pack(all.leftCols<Columns>(), out);
    for (int s = 0; s < style_count; ++s) Pack(bias + all.col(Columns + s), style_bias[s]);
    int column = Columns + style_count;
    for (PackedVector<Rows>& content : contents) Pack(all.col(column++), content);
  }
  // The first `rows` rows of a layer; the others are left as they are.
  template <int Rows, int Columns>
  void ReadRows(const std::string& name, int rows, Affine<Rows, Columns>& out) {
    const RowMajor weight = Read(name + ".weight", rows, Columns);
    const RowMajor bias = tensors_.Vector(name + ".bias", rows);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < Columns; ++column) {
        out.weight[out.weight.Index(row, column)] = weight(row, column);
      }
      out.bias[static_cast<std::size_t>(row)] = bias(row);
    }
  }
  template <int Latent>
  void Read(const std::string& name, LstmLayer<Latent>& out) {
    ReadGates(name, out);
    Pack(Read<Latent>(name + ".h0"), out.h0);
    Pack(Read<Latent>(name + ".c0"), out.c0);
  }
  // A layer of the neutral branch. With contents it has one initial state for each of them, and the
  // last is for an unknown content.
  template <Shape kShape>
  void Read(const std::string& name, std::size_t layer,
            std::span<BranchStateOf<kShape>> of_contents, LstmLayer<kShape.latent>& out) {
    if (of_contents.empty()) return Read(name, out);
    ReadGates(name, out);
    const auto count = static_cast<int>(of_contents.size());
    const RowMajor h0 = Read(name + ".h0", count + 1, kShape.latent);
    const RowMajor c0 = Read(name + ".c0", count + 1, kShape.latent);
    for (int content = 0; content < count; ++content) {
      of_contents[static_cast<std::size_t>(content)].h[layer] = h0.row(content);
      of_contents[static_cast<std::size_t>(content)].c[layer] = c0.row(content);
    }
    Pack(h0.row(count), out.h0);
    Pack(c0.row(count), out.c0);
  }

 private:
  template <int Latent>
  void ReadGates(const std::string& name, LstmLayer<Latent>& out) {
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
  }

  net::TensorReader& tensors_;
};

template <int Rows, int Columns>
void RoundMatrix(const Kernels& kernels, PackedMatrix<Rows, Columns>& weight) {
  static_assert(Columns >= 2 && Columns <= net::kMostColumns);
  kernels.pack(weight.data(), net::PaddedRows(Rows) / net::kPanelRows, Columns, net::kScaleColumns);
}
template <int Latent>
void RoundMatrix(const Kernels& kernels, LstmLayer<Latent>& layer) {
  kernels.pack(layer.weight.data(), 4 * Latent / net::kPanelRows, 2 * Latent, Latent);
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

// Room for the tensors of `count` contents, and the keys that come with them.
template <Shape kShape>
std::unique_ptr<ContentWeights<kShape>> MakeContents(int count, const json& object, float rate_hz,
                                                     Faults& faults) {
  auto contents = std::make_unique<ContentWeights<kShape>>();
  contents->count = count;
  const float rise_s =
      net::ReadNumber(object, "content_rise_s", {0, kMaxContentRise_s, false}, faults);
  contents->per_frame = 1 / (rate_hz * rise_s);
  contents->columns.resize(static_cast<std::size_t>(count));
  contents->starts.resize(static_cast<std::size_t>(count));
  return contents;
}

template <Shape kShape>
void ReadRecognizer(LayerReader& tensors, ContentWeights<kShape>& contents) {
  tensors.Read("recognizer.0", contents.layer0);
  tensors.Read("recognizer.1", contents.layer1);
  tensors.Read("recognizer.lstm", contents.lstm);
  tensors.ReadRows("recognizer.head", contents.count, contents.head);
}

}  // namespace

template <Shape kShape>
void ShapedNetwork<kShape>::Weights::Round(const Kernels& for_kernels) {
  kernels = &for_kernels;
  if (kernels->pack == nullptr) return;
  const auto round = [&](auto&... matrices) { (RoundMatrix(*kernels, matrices), ...); };
  round(encoder0, encoder1.weight, decoder0, decoder1.weight, decoder2.weight, heads.weight);
  if (contents) {
    round(contents->layer0.weight, contents->layer1.weight, contents->lstm, contents->head.weight);
  }
  for (auto& layer : neutral) round(layer);
  for (auto& style : styles) {
    for (auto& layer : style) round(layer);
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
  ReadContents(file.header, network->model_.contents, faults);
  ReadKeys(file.header, kShape, features, faults);
  const int content_count = network->content_count();
  if (content_count > 0) {
    w.contents = MakeContents<kShape>(content_count, file.header, features.rate_hz, faults);
  }
  if (!faults.none()) return faults.status();

  net::TensorReader all(file.view, faults);
  LayerReader tensors(all);
  const int style_count = network->style_count();
  const auto mean = tensors.Read<kFeatureCount>("feature.mean");
  const auto deviation = tensors.Read<kFeatureCount>("feature.deviation");
  if (faults.none()) CheckFeatures(mean, deviation, features, faults);
  Pack(mean, w.mean);
  Pack(deviation.cwiseInverse(), w.inverse_deviation);
  std::span<PackedVector<kShape.encoder>> columns;
  std::span<BranchStateOf<kShape>> starts;
  if (w.contents) {
    columns = w.contents->columns;
    starts = w.contents->starts;
    ReadRecognizer(tensors, *w.contents);
  }
  tensors.Read("encoder.0", style_count, w.encoder0, w.encoder0_bias, columns);
  tensors.Read("encoder.1", w.encoder1);
  for (int l = 0; l < kNeutralLayers; ++l) {
    tensors.Read<kShape>(LayerName(0, l), static_cast<std::size_t>(l), starts, w.neutral[l]);
  }
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
  w.Round(net::BestKernels(file.precision));
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

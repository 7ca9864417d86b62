#include "tests/bench/plain_step.h"

#include <Eigen/Core>
#include <algorithm>

namespace styled::erd {
namespace {

constexpr int kLatent = kPaper.latent;
constexpr int kGates = 4 * kLatent;
constexpr int kHeads = kRotationFeatures + kVelocityFeatures + 1;
constexpr int kFeatures = kFeatureCount;

template <int Rows>
using Vector = Eigen::Matrix<float, Rows, 1>;

template <int Rows, int Columns>
struct Affine {
  Eigen::Matrix<float, Rows, Columns> weight;
  Vector<Rows> bias;

  void Apply(const Vector<Columns>& x, Vector<Rows>& y) const noexcept {
    y = bias;
    y.noalias() += weight * x;
  }
};

struct Layer {
  Affine<kGates, 2 * kLatent> gates;  // [z; h]; the sigmoids' rows are halved
  Vector<kLatent> h0, c0;
};

// Reads the file's tensors by name.
class Reader {
 public:
  explicit Reader(const WeightsFile& file) : file_(file) {}
  Eigen::MatrixXf Matrix(const std::string& name) {
    const NamedTensor& tensor = file_.tensor(name);
    using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const RowMajor>(tensor.values.data(), tensor.shape[0],
                                      tensor.shape.size() > 1 ? tensor.shape[1] : 1);
  }
  template <int Rows, int Columns>
  void Read(const std::string& name, Affine<Rows, Columns>& out) {
    out.weight = Matrix(name + ".weight").leftCols(Columns);
    out.bias = Matrix(name + ".bias");
  }
  void Read(const std::string& name, Layer& out) {
    out.gates.weight << Matrix(name + ".input"), Matrix(name + ".hidden");
    out.gates.bias = Matrix(name + ".bias");
    for (const int gate : {0, 1, 3}) {
      out.gates.weight.middleRows<kLatent>(gate * kLatent) *= 0.5F;
      out.gates.bias.segment<kLatent>(gate * kLatent) *= 0.5F;
    }
    out.h0 = Matrix(name + ".h0");
    out.c0 = Matrix(name + ".c0");
  }

 private:
  WeightsFile file_;
};

template <std::size_t Layers>
void Start(const std::array<Layer, Layers>& layers, BranchState& state) {
  for (std::size_t l = 0; l < Layers; ++l) {
    state.h[l] = layers[l].h0;
    state.c[l] = layers[l].c0;
  }
}

template <std::size_t Layers>
void Run(const std::array<Layer, Layers>& layers, const Vector<kLatent>& z, BranchState& state,
         Vector<kLatent>& out) noexcept {
  Vector<2 * kLatent> input;
  input.head<kLatent>() = z;
  for (std::size_t l = 0; l < Layers; ++l) {
    input.tail<kLatent>() = state.h[l];
    Vector<kGates> gates;
    layers[l].gates.Apply(input, gates);
    gates = gates.array().tanh();
    const auto in = 0.5F * gates.segment<kLatent>(0).array() + 0.5F;
    const auto forget = 0.5F * gates.segment<kLatent>(kLatent).array() + 0.5F;
    const auto cell = gates.segment<kLatent>(2 * kLatent).array();
    const auto open = 0.5F * gates.segment<kLatent>(3 * kLatent).array() + 0.5F;
    state.c[l] = forget * state.c[l].array() + in * cell;
    state.h[l] = open * state.c[l].array().tanh();
    input.head<kLatent>() = state.h[l];
  }
  out = input.head<kLatent>();
}

void ToDecoded(const Vector<kHeads>& heads, net::Decoded& out) noexcept {
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    out.rotations[joint].coeffs() = heads.segment<4>(4 * joint).normalized();
  }
  for (int i = 0; i < kVelocityFeatures; ++i) {
    out.velocities_m_s[i] = heads[kRotationFeatures + i];
  }
  out.hips_height_m = heads[kHeads - 1];
}

}  // namespace

struct PlainStep::Weights {
  Vector<kFeatures> mean, deviation;
  Affine<64, kFeatures> encoder0;
  Affine<kLatent, 64> encoder1;
  std::array<Layer, kNeutralLayers> neutral;
  std::vector<std::array<Layer, kStyleLayers>> styles;
  Affine<58, kLatent> decoder0;
  Eigen::Matrix<float, 58, net::kMaxStyles> decoder0_style;
  Affine<86, 58> decoder1;
  Affine<128, 86> decoder2;
  Affine<kHeads, 128> heads;
  Vector<kHeads> heads_deviation, heads_mean;
};

PlainStep::PlainStep(const WeightsFile& file, std::span<const net::StyleWeight> active)
    : weights_(std::make_unique<Weights>()), active_(active.begin(), active.end()) {
  Weights& w = *weights_;
  Reader reader(file);
  w.mean = reader.Matrix("feature.mean");
  w.deviation = reader.Matrix("feature.deviation");
  reader.Read("encoder.0", w.encoder0);
  // The input style is neutral.
  w.encoder0.bias += reader.Matrix("encoder.0.weight").col(kFeatures);
  reader.Read("encoder.1", w.encoder1);
  const auto layer = [](std::size_t style, std::size_t l) {
    return "recurrent." + std::to_string(style) + "." + std::to_string(l);
  };
  for (std::size_t l = 0; l < kNeutralLayers; ++l) reader.Read(layer(0, l), w.neutral[l]);
  Start(w.neutral, neutral_);
  w.styles.resize(active_.size());
  for (std::size_t i = 0; i < active_.size(); ++i) {
    for (std::size_t l = 0; l < kStyleLayers; ++l) {
      reader.Read(layer(active_[i].style, l), w.styles[i][l]);
    }
    Start(w.styles[i], branches_[i]);
  }
  reader.Read("decoder.0", w.decoder0);
  const Eigen::MatrixXf decoder0 = reader.Matrix("decoder.0.weight");
  w.decoder0_style.leftCols(decoder0.cols() - kLatent) = decoder0.rightCols(decoder0.cols() - 32);
  reader.Read("decoder.1", w.decoder1);
  reader.Read("decoder.2", w.decoder2);
  w.heads.weight << reader.Matrix("head.rotation.weight"), reader.Matrix("head.velocity.weight"),
      reader.Matrix("head.height.weight");
  w.heads.bias << reader.Matrix("head.rotation.bias"), reader.Matrix("head.velocity.bias"),
      reader.Matrix("head.height.bias");
  const auto heads_of = [](const Vector<kFeatures>& all, Vector<kHeads>& out) {
    out << all.head<kRotationFeatures>(), all.segment<kVelocityFeatures>(kVelocityBegin),
        all[kHipsHeightIndex];
  };
  heads_of(w.mean, w.heads_mean);
  heads_of(w.deviation, w.heads_deviation);
}

PlainStep::~PlainStep() = default;

void PlainStep::Step(const Features& features, net::Prediction& out) noexcept {
  const Weights& w = *weights_;
  const Eigen::Map<const Vector<kFeatures>> x(features.data());
  const Vector<kFeatures> u =
      ((x - w.mean).array() / w.deviation.array()).max(-kMaxStandardized).min(kMaxStandardized);
  Vector<64> e;
  w.encoder0.Apply(u, e);
  e = e.cwiseMax(0.0F);
  Vector<kLatent> z, neutral;
  w.encoder1.Apply(e, z);

  Run(w.neutral, z, neutral_, neutral);
  Vector<kLatent> styled = neutral;
  Vector<58> target = Vector<58>::Zero();
  float sum = 0;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    Vector<kLatent> residual;
    Run(w.styles[i], z, branches_[i], residual);
    styled += active_[i].weight * residual;
    target += active_[i].weight * w.decoder0_style.col(active_[i].style);
    sum += active_[i].weight;
  }
  target += std::max(0.0F, 1.0F - sum) * w.decoder0_style.col(0);
  if (sum > 1.0F) target /= sum;

  const auto decode = [&w](const Vector<kLatent>& latent, const Vector<58>& style_part,
                           net::Decoded& decoded) noexcept {
    Vector<58> d0;
    w.decoder0.Apply(latent, d0);
    d0 = (d0 + style_part).cwiseMax(0.0F);
    Vector<86> d1;
    w.decoder1.Apply(d0, d1);
    d1 = d1.cwiseMax(0.0F);
    Vector<128> d2;
    w.decoder2.Apply(d1, d2);
    d2 = d2.cwiseMax(0.0F);
    Vector<kHeads> heads;
    w.heads.Apply(d2, heads);
    heads = heads.cwiseProduct(w.heads_deviation) + w.heads_mean;
    ToDecoded(heads, decoded);
  };
  decode(neutral, w.decoder0_style.col(0), out.reconstruction);
  if (active_.empty()) {
    out.styled = out.reconstruction;
  } else {
    decode(styled, target, out.styled);
  }
}

}  // namespace styled::erd

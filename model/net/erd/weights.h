#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "model/net/erd/network.h"
#include "model/net/kernels/kernel.h"

// The weights in memory, in the order and layout in which a step reads them (kernel.h). Included
// only by load.cpp and network.cpp.
namespace styled::erd {

using net::Kernels;
using net::PackedMatrix;
using net::PackedVector;

inline constexpr int kHeads = kRotationFeatures + kVelocityFeatures + 1;

template <int Rows>
using Vector = Eigen::Matrix<float, Rows, 1>;
template <int Rows, int Columns>
using Matrix = Eigen::Matrix<float, Rows, Columns>;

// y = weight x + bias.
template <int Rows, int Columns>
struct Affine {
  PackedMatrix<Rows, Columns> weight;
  PackedVector<Rows> bias;
};

// gates = weight [h; z] + bias, with rows ordered by LstmRow. The rows of the sigmoid gates (input,
// forget, output) are halved, because sigmoid(x) = (1 + tanh(x / 2)) / 2. Halving is exact.
template <int Latent>
struct LstmLayer {
  PackedMatrix<4 * Latent, 2 * Latent> weight;
  PackedVector<4 * Latent> bias;
  PackedVector<Latent> h0, c0;
};

// The part of a network with contents that others lack.
template <Shape kShape>
struct ContentWeights {
  int count = 0;        // C
  float per_frame = 0;  // one frame's time as a share of content_rise_s
  // By content: its column of the encoder's first layer, and the neutral branch's initial state.
  std::vector<PackedVector<kShape.encoder>> columns;
  std::vector<BranchStateOf<kShape>> starts;
  // The recognizer. The rows of `head` after the contents are zeros.
  Affine<kShape.encoder, kFeatureCount> layer0;
  Affine<kShape.latent, kShape.encoder> layer1;
  LstmLayer<kShape.latent> lstm;
  Affine<net::kMaxContents, kShape.latent> head;
};

template <Shape kShape>
struct ShapedNetwork<kShape>::Weights {
  static constexpr int kLatent = kShape.latent;
  static constexpr std::array<int, 3> kDecoder = kShape.decoder;

  // Sets the kernels, and rounds the matrices to what they read.
  void Round(const Kernels& for_kernels);

  const Kernels* kernels = &net::BestKernels();
  PackedVector<kFeatureCount> mean, inverse_deviation;
  PackedMatrix<kShape.encoder, kFeatureCount> encoder0;
  Affine<kLatent, kShape.encoder> encoder1;
  std::array<LstmLayer<kLatent>, kNeutralLayers> neutral;  // starts as for an unknown content
  std::vector<std::array<LstmLayer<kLatent>, kStyleLayers>> styles;  // [s - 1] is style s
  PackedMatrix<kDecoder[0], kLatent> decoder0;
  Affine<kDecoder[1], kDecoder[0]> decoder1;
  Affine<kDecoder[2], kDecoder[1]> decoder2;
  // Rotations, velocities and height stacked; the output is in features' units, not standardized.
  Affine<kHeads, kDecoder[2]> heads;
  // The bias of the first layer per input or target style: the style's one-hot column is added to
  // it.
  std::array<PackedVector<kShape.encoder>, net::kMaxStyles> encoder0_bias;
  std::array<PackedVector<kDecoder[0]>, net::kMaxStyles> decoder0_bias;
  std::unique_ptr<ContentWeights<kShape>> contents;  // null: the network takes none
};

// y = weight x + bias, or its relu; of the weight's first `rows` rows.
template <int Rows, int Columns>
void Apply(const Kernels& kernels, const PackedMatrix<Rows, Columns>& weight,
           std::span<const net::Operands> inputs, bool relu, int rows = Rows) noexcept {
  kernels.affine(weight.data(), net::PaddedRows(rows) / net::kPanelRows, Columns, inputs, relu);
}

}  // namespace styled::erd

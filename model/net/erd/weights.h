#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "model/net/erd/network.h"
#include "model/net/kernels/kernel.h"

// The weights in memory, in the order and layout in which a step reads them (kernel.h). Included
// only by load.cpp and network.cpp.
namespace styled::erd {

using net::Kernels;
using net::PackedMatrix;
using net::PackedVector;

inline constexpr int kEncoderWidth = 64;
inline constexpr std::array<int, 3> kDecoderWidths{58, 86, 128};
inline constexpr int kGates = 4 * kLatent;
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
struct LstmLayer {
  PackedMatrix<kGates, 2 * kLatent> weight;
  PackedVector<kGates> bias;
  PackedVector<kLatent> h0, c0;
};

struct Network::Weights {
  const Kernels* kernels = &net::BestKernels();
  PackedVector<kFeatureCount> mean, inverse_deviation;
  PackedMatrix<kEncoderWidth, kFeatureCount> encoder0;
  Affine<kLatent, kEncoderWidth> encoder1;
  std::array<LstmLayer, kNeutralLayers> neutral;
  std::vector<std::array<LstmLayer, kStyleLayers>> styles;  // [s - 1] is style s
  PackedMatrix<kDecoderWidths[0], kLatent> decoder0;
  Affine<kDecoderWidths[1], kDecoderWidths[0]> decoder1;
  Affine<kDecoderWidths[2], kDecoderWidths[1]> decoder2;
  // Rotations, velocities and height stacked; the output is in features' units, not standardized.
  Affine<kHeads, kDecoderWidths[2]> heads;
  // The bias of the first layer per input or target style: the style's one-hot column is added to
  // it.
  std::array<PackedVector<kEncoderWidth>, net::kMaxStyles> encoder0_bias;
  std::array<PackedVector<kDecoderWidths[0]>, net::kMaxStyles> decoder0_bias;
};

}  // namespace styled::erd

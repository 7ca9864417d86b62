#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "model/erd/network.h"

// The weights in memory, in the order and layout in which a step reads them: column-major, so that
// a product runs down whole columns. Only load.cpp and network.cpp see this.
namespace styled::erd {

inline constexpr int kEncoderWidth = 64;
inline constexpr std::array<int, 3> kDecoderWidths{58, 86, 128};
inline constexpr int kGates = 4 * kLatent;
inline constexpr int kHeads = body::kRotationFeatures + body::kVelocityFeatures + 1;

template <int Rows>
using Vector = Eigen::Matrix<float, Rows, 1>;
template <int Rows, int Columns>
using Matrix = Eigen::Matrix<float, Rows, Columns>;
using Latent = Vector<kLatent>;

// y = weight x + bias.
template <int Rows, int Columns>
struct Affine {
  Matrix<Rows, Columns> weight;
  Vector<Rows> bias;
};

// Input and hidden weights side by side: gates = weight [z; h] + bias. The rows of the sigmoid
// gates (input, forget, output) are halved, since sigmoid(x) = (1 + tanh(x / 2)) / 2: one tanh over
// all rows serves all four. Halving is exact.
struct LstmLayer {
  Affine<kGates, 2 * kLatent> gates;
  Latent h0, c0;
};

struct Network::Weights {
  Vector<body::kFeatureCount> mean, deviation;
  Affine<kEncoderWidth, body::kFeatureCount> encoder0;
  Matrix<kEncoderWidth, kMaxStyles> encoder0_style;  // columns of the input style
  Affine<kLatent, kEncoderWidth> encoder1;
  std::array<LstmLayer, kNeutralLayers> neutral;
  std::vector<std::array<LstmLayer, kStyleLayers>> styles;  // [s - 1] is style s
  Affine<kDecoderWidths[0], kLatent> decoder0;
  Matrix<kDecoderWidths[0], kMaxStyles> decoder0_style;  // columns of the target styles
  Affine<kDecoderWidths[1], kDecoderWidths[0]> decoder1;
  Affine<kDecoderWidths[2], kDecoderWidths[1]> decoder2;
  // Rotations, velocities and height under each other; they give standardized features, which these
  // bring back.
  Affine<kHeads, kDecoderWidths[2]> heads;
  Vector<kHeads> heads_deviation, heads_mean;
};

}  // namespace styled::erd

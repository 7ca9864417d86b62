#pragma once

#include <array>

namespace styled::erd {

inline constexpr int kNeutralLayers = 6;
inline constexpr int kStyleLayers = 4;

// The widths of a network of this family. The numbers of layers are always those of the paper.
struct Shape {
  int latent;                  // Z: of every LSTM layer
  int encoder;                 // of its one hidden layer
  std::array<int, 3> decoder;  // of its hidden layers
};

// The paper's.
inline constexpr Shape kPaper{32, 64, {58, 86, 128}};
// Twice as wide, or a little more.
inline constexpr Shape kWide{64, 128, {128, 192, 256}};

}  // namespace styled::erd

#pragma once

#include <array>
#include <cstddef>
#include <span>

// The arithmetic of a step, compiled once per SIMD target (Google Highway): a function table per
// target, so that a step takes one indirect call per layer and nothing is resolved while it runs.
// None of the functions allocates, locks or throws; all are free of state. Pinned by
// tests/unit/net/kernels/kernel_test.cpp on every target that the machine has.
namespace styled::net {

// Rows of a matrix are stored in panels of this many, one whole number of vectors on every target.
inline constexpr int kPanelRows = 32;
constexpr int PaddedRows(int rows) { return (rows + kPanelRows - 1) / kPanelRows * kPanelRows; }

// A vector whose end is padded to whole panels.
template <int Rows>
struct alignas(64) PackedVector : std::array<float, PaddedRows(Rows)> {};

// A matrix as a kernel reads it, from the first float to the last: panel upon panel, within one
// column upon column. The rows that fill up the last panel are zeros.
template <int Rows, int Columns>
struct alignas(64) PackedMatrix : std::array<float, std::size_t{PaddedRows(Rows)} * Columns> {
  static constexpr std::size_t Index(int row, int column) {
    const std::size_t panel = row / kPanelRows;
    return (panel * Columns + column) * kPanelRows + row % kPanelRows;
  }
};

// An LSTM layer's gates are rows of one matrix [Wh Wi]. 16 units at a time have their input,
// forget, cell and output rows side by side.
constexpr int LstmRow(int gate, int unit) { return (unit / 16 * 4 + gate) * 16 + unit % 16; }

// One input of a product, and where its result goes. Bias and y are padded to whole panels, aligned
// to 64 bytes, and overlap nothing else.
struct Operands {
  const float *bias, *x;
  float* y;
};

// One state of an LSTM layer, h and c changed in place. All aligned to 64 bytes.
struct LstmOperands {
  const float* z;
  float *h, *c;
};

struct Kernels {
  const char* target;  // Highway's name, e.g. "AVX3" (AVX-512)

  // y = W x + bias, and relu of it on demand, for any number of inputs: up to four are taken at
  // once, since reading the weights is most of the work. The result is the same bit for bit,
  // whoever is beside an input. `panels` panels of `columns` columns.
  void (*affine)(const float* weights, int panels, int columns, std::span<const Operands> inputs,
                 bool relu) noexcept;

  // u = (x - mean) inverse_deviation, clamped to +-limit; not a number gives 0.
  void (*standardize)(const float* x, const float* mean, const float* inverse_deviation, int count,
                      float limit, float* u) noexcept;

  // [i f g o] = Wh h + Wi z + bias;  c' = σ(f) c + σ(i) tanh(g);  h' = σ(o) tanh(c'), for 32 units
  // of any number of states, as above. No state's z is another's h.
  void (*lstm)(const float* weights, const float* bias,
               std::span<const LstmOperands> states) noexcept;

  // unit = quaternions / their lengths; one without a direction becomes the identity.
  void (*normalize)(const float* quaternions, int count, float* unit) noexcept;
};

// The best that this machine has. Start-up only.
const Kernels& BestKernels();

}  // namespace styled::net

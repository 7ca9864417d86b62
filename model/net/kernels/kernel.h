#pragma once

#include <array>
#include <cstddef>
#include <span>

// The arithmetic of a network step, compiled once per SIMD target (Google Highway). Each target has
// a table of functions, so a step makes one indirect call per layer and dispatches nothing itself.
// The functions have no state, allocate nothing, lock nothing and do not throw. Pinned by
// tests/unit/net/kernels/kernel_test.cpp on every target that the machine has.
namespace styled::net {

// A matrix is stored in panels of this many rows: a whole number of vectors on every target.
inline constexpr int kPanelRows = 32;
constexpr int PaddedRows(int rows) { return (rows + kPanelRows - 1) / kPanelRows * kPanelRows; }

// A vector, zero-padded to whole panels.
template <int Rows>
struct alignas(64) PackedVector : std::array<float, PaddedRows(Rows)> {};

// A matrix in the order in which a kernel reads it: panel by panel, and column by column within a
// panel. Padding rows of the last panel are zeros.
template <int Rows, int Columns>
struct alignas(64) PackedMatrix : std::array<float, std::size_t{PaddedRows(Rows)} * Columns> {
  static constexpr std::size_t Index(int row, int column) {
    const std::size_t panel = row / kPanelRows;
    return (panel * Columns + column) * kPanelRows + row % kPanelRows;
  }
};

// The gates of an LSTM layer are the rows of one matrix [Wh Wi]. For each block of 16 units, the
// rows of the input, forget, cell and output gates follow one another.
constexpr int LstmRow(int gate, int unit) { return (unit / 16 * 4 + gate) * 16 + unit % 16; }

// The precision to which weights are rounded; states and activations are float32 in each. Of int8
// the weights of a row, up to kScaleColumns of them, are whole multiples, -127 to 127, of a number
// of their own, and each product's inputs, up to as many, of another one, -32767 to 32767. Their
// sums are exact, and thus the same bits on every target that rounds once per multiplication and
// addition (all but SSE in a build without FMA). It takes a quarter of float32's memory traffic.
enum class Precision { kFloat32, kInt8 };

// Of int8: the most columns that share a number.
inline constexpr int kScaleColumns = 64;

// One input of a product and the place of its result. `bias` and `y` are padded to whole panels,
// aligned to 64 bytes, and overlap nothing else.
struct Operands {
  const float *bias, *x;
  float* y;
};

// One state of an LSTM layer; h and c are changed in place. All are aligned to 64 bytes.
struct LstmOperands {
  const float* z;
  float *h, *c;
};

struct Kernels {
  const char* target;  // Highway's name, e.g. "AVX3" (AVX-512)

  // y = W x + bias, or its relu, for any number of inputs. Up to four inputs are processed at once,
  // because reading the weights is most of the work. A result does not depend on the other inputs,
  // bit for bit. `weights`: `panels` panels of `columns` columns.
  void (*affine)(const float* weights, int panels, int columns, std::span<const Operands> inputs,
                 bool relu) noexcept;

  // u = (x - mean) inverse_deviation, clamped to +-limit; NaN gives 0.
  void (*standardize)(const float* x, const float* mean, const float* inverse_deviation, int count,
                      float limit, float* u) noexcept;

  // [i f g o] = Wh h + Wi z + bias;  c' = σ(f) c + σ(i) tanh(g);  h' = σ(o) tanh(c'), for a layer
  // of 32 or 64 units and any number of states. No state's z may be another's h.
  void (*lstm)(int units, const float* weights, const float* bias,
               std::span<const LstmOperands> states) noexcept;

  // unit = quaternions / their lengths; a quaternion of length 0 becomes the identity.
  void (*normalize)(const float* quaternions, int count, float* unit) noexcept;

  // Rounds a packed matrix in place to the precision of affine and lstm, once. `together`: of int8,
  // the columns that share a number: kScaleColumns for affine, the units for lstm. At least 2
  // columns. Allocates. nullptr: they read float32.
  void (*pack)(float* weights, int panels, int columns, int together) noexcept;
};

// The most columns of a matrix that is rounded.
inline constexpr int kMostColumns = 512;

// The fastest table of this precision that this machine supports. Call at start-up only.
const Kernels& BestKernels(Precision precision = Precision::kFloat32);

}  // namespace styled::net

#pragma once

#include <cstddef>
#include <span>
#include <vector>

// Products of many rows with one matrix, for networks that see a whole clip: a row is one node of
// one frame, its floats are channels. Compiled once per SIMD target, as kernel.h. The functions
// have no state, allocate nothing, lock nothing and do not throw. Pinned by
// tests/unit/net/kernels/rows_test.cpp on every target that the machine has.
namespace styled::net {

// Columns of a product are stored in panels of this many: a whole number of vectors on every
// target, 64 bytes.
inline constexpr int kRowPanel = 16;
constexpr int PaddedColumns(int columns) {
  return (columns + kRowPanel - 1) / kRowPanel * kRowPanel;
}

// Floats at a 64-byte boundary.
class AlignedFloats {
 public:
  AlignedFloats() = default;
  explicit AlignedFloats(std::size_t size) : lines_((size + kRowPanel - 1) / kRowPanel) {}
  // Never shrinks; new floats are 0, the others keep their values.
  void Grow(std::size_t size) {
    const std::size_t lines = (size + kRowPanel - 1) / kRowPanel;
    if (lines > lines_.size()) lines_.resize(lines);
  }
  float* data() { return lines_.empty() ? nullptr : lines_[0].values; }
  const float* data() const { return lines_.empty() ? nullptr : lines_[0].values; }
  std::size_t size() const { return lines_.size() * kRowPanel; }

 private:
  struct alignas(64) Line {
    float values[kRowPanel] = {};
  };
  std::vector<Line> lines_;
};

// The weights of the sum of products Σ_t x_t W_t', packed in the order in which they are read:
// panel by panel, in it term by term, in it input channel by input channel.
class PackedColumns {
 public:
  PackedColumns() = default;
  // `depths`: the input channels of each term; `columns`: output channels, padded with zeros.
  PackedColumns(std::span<const int> depths, int columns);
  // Element (column, channel) of W_term, row-major as a linear layer's weight: [columns, depth].
  float& At(std::size_t term, int column, int channel);

  const float* data() const { return values_.data(); }
  int columns() const { return columns_; }  // padded
  std::span<const int> depths() const { return depths_; }

 private:
  std::vector<int> depths_;
  std::vector<int> begins_;  // of the terms, in channels
  int depth_ = 0;            // of all terms
  int columns_ = 0;
  AlignedFloats values_;
};

// The input of one term: row r begins at x + r * stride. Rows of terms may overlap: a temporal
// convolution is three terms over the same frames, each shifted by one frame.
struct RowTerm {
  const float* x;
  std::ptrdiff_t stride;  // floats
};

// y_r = Σ_t x_t,r W_t' + bias_(r mod bias_rows) + add_r, or its relu. All pointers in floats.
struct RowProduct {
  const PackedColumns* weights = nullptr;
  std::span<const RowTerm> terms;  // as many as the weights have
  int rows = 0;
  const float* bias = nullptr;  // [bias_rows, columns]; nullptr: none
  int bias_rows = 1;            // > 0
  const float* add = nullptr;   // as y, with y's stride; may be y; nullptr: none
  bool relu = false;
  float* y = nullptr;         // [rows, columns], all are written
  std::ptrdiff_t stride = 0;  // of y; >= columns
  // Only these columns of the weights, multiples of kRowPanel; 0: all. They are the first of y's.
  int first_column = 0, columns = 0;
};

// y_i = constant_i + Σ share x_row over the parts of output row i, or its relu, frame by frame: a
// sparse product over the nodes of a graph. All pointers in floats.
struct RowMixture {
  struct Part {
    int input, row;  // which of `inputs`, and the row of its frame
    float share;
  };
  struct Input {
    const float* x;
    std::ptrdiff_t frame;  // from one frame to the next
  };
  std::span<const int> begins;  // of the parts of each output row, and the end: rows + 1 numbers
  std::span<const Part> parts;
  std::span<const Input> inputs;
  int frames = 0;
  int channels = 0;                 // of a row; a multiple of kRowPanel
  const float* constant = nullptr;  // [rows, channels]; nullptr: 0
  bool relu = false;
  float* y = nullptr;  // [frames, rows, channels]
};

// Winograd's F(4, 3): a filter of three taps over time gives kTile frames from kTurned products of
// sums of kTile + 2 frames.
inline constexpr int kTile = 4;
inline constexpr int kTurned = 6;

// y_t,v = bias + the tile's frame t at node v + add_t,row(v), rows of `channels` floats.
struct TurnedTile {
  const float* x = nullptr;  // plane p at x + p plane: [nodes, channels]
  std::ptrdiff_t plane = 0;
  int nodes = 0, channels = 0;  // a multiple of kRowPanel
  int frames = kTile;           // 1 .. kTile
  const float* bias = nullptr;  // [channels]
  const float* add = nullptr;   // [frames, add_rows, channels]; nullptr: none
  int add_rows = 0;
  const int* add_row = nullptr;  // of each node; nullptr: the node's own
  float* y = nullptr;            // [frames, nodes, channels]; may be `add` where rows are nodes
};

struct RowKernels {
  const char* target;  // Highway's name

  // The products in registers: tiles of rows and panels, one pass over the weights per panel.
  // A row's result does not depend on the other rows, bit for bit.
  void (*product)(const RowProduct& product) noexcept;

  void (*mix)(const RowMixture& mixture) noexcept;

  // y = leaky(x scale + shift) by channel, leaky(u) = max(u, 0.2 u); [rows, channels], channels a
  // multiple of kRowPanel. With `other`, of the same shape, y is the mean of both results. Without
  // `scale` and `shift` (nullptr) they are 1 and 0.
  void (*activate)(const float* x, const float* other, int rows, int channels, const float* scale,
                   const float* shift, float* y) noexcept;

  // sum[c] = Σ_r w_r (x_r,c - centre[c])^power over [rows, channels], power 1 or 2, where w_r is
  // weights[r mod period]. Sums in single precision: add up longer columns from parts.
  void (*sum)(const float* x, int rows, int channels, const float* weights, int period,
              const float* centre, int power, float* sum) noexcept;

  // y = (1 - share) a + share b, or its relu; `count` floats, a multiple of kRowPanel.
  void (*blend)(const float* a, const float* b, float share, std::size_t count, bool relu,
                float* y) noexcept;

  // The sums of a tile, kTurned planes, from the frames x, x + frame, ..., of `frame` floats each;
  // a multiple of kRowPanel. Plane p is at y + p plane.
  void (*turn)(const float* x, int frame, float* y, std::ptrdiff_t plane) noexcept;

  // The first frames of a tile from the products of its planes.
  void (*turn_back)(const TurnedTile& tile) noexcept;
};

// The fastest table that this machine supports. Call at start-up only.
const RowKernels& BestRowKernels();

}  // namespace styled::net

#include "model/net/stgcn/time_conv.h"

#include <algorithm>

namespace styled::stgcn {
namespace {

using net::kTile;
using net::kTurned;

// Each product's weight, of the taps: the matrix G of F(4, 3).
constexpr double kTapShares[kTurned][3] = {{1.0 / 4, 0, 0},
                                           {-1.0 / 6, -1.0 / 6, -1.0 / 6},
                                           {-1.0 / 6, 1.0 / 6, -1.0 / 6},
                                           {1.0 / 24, 1.0 / 12, 1.0 / 6},
                                           {1.0 / 24, -1.0 / 12, 1.0 / 6},
                                           {0, 0, 1}};
// Floats of a product's input at a time: six of them and their outputs stay in the second-level
// cache, and the weights are read seldom enough: 96 rows of 64 channels, 24 of 256. Counted in
// rows, 48, 96 and 192 took 1.25, 1.28 and 1.32 ms for 64 frames at width 64.
constexpr int kFloatsTogether = 6144;

int Tiles(int frames) { return (frames + kTile - 1) / kTile; }

}  // namespace

TimeConv::TimeConv(const net::RowMajor& weight, const Eigen::VectorXf& bias, float scale)
    : channels_(static_cast<int>(weight.rows())), bias_(static_cast<std::size_t>(weight.rows())) {
  const std::array<int, 1> depth{channels_};
  weights_ = net::PackedColumns(depth, kTurned * channels_);
  for (int p = 0; p < kTurned; ++p) {
    for (int out = 0; out < channels_; ++out) {
      for (int in = 0; in < channels_; ++in) {
        double sum = 0;
        for (int tap = 0; tap < 3; ++tap) {
          sum += kTapShares[p][tap] * static_cast<double>(weight(out, 3 * in + tap));
        }
        weights_.At(0, p * channels_ + out, in) =
            static_cast<float>(sum * static_cast<double>(scale));
      }
    }
  }
  for (int c = 0; c < channels_; ++c) bias_.data()[c] = scale * bias[c];
}

float* TimeConv::Prepare(net::AlignedFloats& buffer, int frames, int nodes) const {
  const auto frame = static_cast<std::size_t>(nodes) * static_cast<std::size_t>(channels_);
  const auto inside = static_cast<std::size_t>(frames) * frame;
  const auto all = (static_cast<std::size_t>(Tiles(frames)) * kTile + 2) * frame;
  buffer.Grow(all);
  std::fill_n(buffer.data(), frame, 0.0F);
  std::fill(buffer.data() + frame + inside, buffer.data() + all, 0.0F);
  return buffer.data() + frame;
}

void TimeConv::Run(const net::RowKernels& kernels, const float* x, int frames, int nodes,
                   const Skip& skip, float* y, TimeScratch& scratch) const {
  const std::ptrdiff_t frame = std::ptrdiff_t{nodes} * channels_;
  const int together = std::max(1, kFloatsTogether / (nodes * channels_));  // tiles
  const std::ptrdiff_t plane = together * frame;
  scratch.turned.Grow(static_cast<std::size_t>(kTurned * plane));
  scratch.product.Grow(static_cast<std::size_t>(kTurned * plane));
  for (int tile = 0; tile < Tiles(frames); tile += together) {
    const int count = std::min(together, Tiles(frames) - tile);
    for (int i = 0; i < count; ++i) {
      kernels.turn(x + (std::ptrdiff_t{tile + i} * kTile - 1) * frame, static_cast<int>(frame),
                   scratch.turned.data() + i * frame, plane);
    }
    for (int p = 0; p < kTurned; ++p) {
      const std::ptrdiff_t offset = p * plane;
      const net::RowTerm term{scratch.turned.data() + offset, channels_};
      net::RowProduct product{&weights_, {&term, 1}, count * nodes};
      product.y = scratch.product.data() + offset;
      product.stride = product.columns = channels_;
      product.first_column = p * channels_;
      kernels.product(product);
    }
    for (int i = 0; i < count; ++i) {
      const int first = (tile + i) * kTile;
      net::TurnedTile turned{scratch.product.data() + i * frame, plane, nodes, channels_};
      turned.frames = std::min(kTile, frames - first);
      turned.bias = bias_.data();
      if (skip.x != nullptr) {
        turned.add = skip.x + std::ptrdiff_t{first} * skip.rows * channels_;
        turned.add_rows = skip.rows;
        turned.add_row = skip.row_of;
      }
      turned.y = y + first * frame;
      kernels.turn_back(turned);
    }
  }
}

}  // namespace styled::stgcn

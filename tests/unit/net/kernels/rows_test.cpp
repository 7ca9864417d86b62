// Products of rows on every SIMD target that this machine supports, compared with plain loops in
// double.
#include "model/net/kernels/rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/net/kernels/each_target.h"

namespace styled::net {
namespace {

std::vector<float> RandomFloats(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<float> values(count);
  for (float& value : values) value = uniform(random);
  return values;
}

// A product of random numbers and its parts. The inputs have nothing behind their last element, so
// that sanitizers detect a read beyond.
struct Case {
  Case(std::vector<int> the_depths, int the_columns, int the_rows, std::mt19937& random)
      : depths(std::move(the_depths)),
        columns(the_columns),
        rows(the_rows),
        packed(depths, columns),
        bias(RandomFloats(static_cast<std::size_t>(kBiasRows * PaddedColumns(columns)), random)),
        add(RandomFloats(static_cast<std::size_t>(rows * Stride()), random)),
        y(add.size(), -77.0F) {
    for (std::size_t t = 0; t < depths.size(); ++t) {
      x.push_back(RandomFloats(static_cast<std::size_t>(rows * depths[t]), random));
      weights.push_back(RandomFloats(static_cast<std::size_t>(columns * depths[t]), random));
      for (int column = 0; column < columns; ++column) {
        for (int channel = 0; channel < depths[t]; ++channel) {
          packed.At(t, column, channel) =
              weights[t][static_cast<std::size_t>(column * depths[t] + channel)];
        }
      }
      terms.push_back({x[t].data(), depths[t]});
    }
  }
  int Stride() const { return PaddedColumns(columns) + 3; }
  double Expected(int row, int column) const {
    double sum = 0;
    for (std::size_t t = 0; t < depths.size(); ++t) {
      for (int channel = 0; channel < depths[t]; ++channel) {
        sum += static_cast<double>(x[t][static_cast<std::size_t>(row * depths[t] + channel)]) *
               weights[t][static_cast<std::size_t>(column * depths[t] + channel)];
      }
    }
    return sum;
  }

  static constexpr int kBiasRows = 5;
  std::vector<int> depths;
  int columns, rows;
  PackedColumns packed;
  std::vector<float> bias, add, y;
  std::vector<std::vector<float>> x, weights;
  std::vector<RowTerm> terms;
};

TEST(Rows, AProductOfAnySizeIsThatOfTheEquation) {
  OnEachTarget([] {
    SCOPED_TRACE(BestRowKernels().target);
    std::mt19937 random(1);
    for (const std::vector<int>& depths :
         {std::vector<int>{1}, {7}, {16}, {48, 48, 48}, {64, 64, 64, 32}, {5, 1}}) {
      for (const int columns : {1, 7, 16, 17, 32, 48, 64}) {
        for (const int rows : {1, 2, 3, 5, 6, 7, 8, 11, 21, 40}) {
          Case c(depths, columns, rows, random);
          RowProduct product{&c.packed, c.terms, rows};
          product.y = c.y.data();
          product.stride = c.Stride();
          const bool biased = rows % 2 == 0, added = columns % 2 == 0;
          product.relu = (rows + columns) % 3 == 0;
          if (biased) {
            product.bias = c.bias.data();
            product.bias_rows = Case::kBiasRows;
          }
          if (added) product.add = c.add.data();
          BestRowKernels().product(product);
          for (int row = 0; row < rows; ++row) {
            for (int column = 0; column < columns; ++column) {
              const auto at = static_cast<std::size_t>(row * c.Stride() + column);
              double expected = c.Expected(row, column);
              if (biased) {
                expected += c.bias[static_cast<std::size_t>(
                    row % Case::kBiasRows * PaddedColumns(columns) + column)];
              }
              if (added) expected += c.add[at];
              if (product.relu) expected = std::max(0.0, expected);
              ASSERT_NEAR(c.y[at], expected, 2e-5)
                  << rows << " x " << columns << ": " << row << ", " << column;
            }
            for (int gap = PaddedColumns(columns); gap < c.Stride(); ++gap) {
              ASSERT_EQ(c.y[static_cast<std::size_t>(row * c.Stride() + gap)], -77.0F);
            }
          }
        }
      }
    }
  });
}

TEST(Rows, ARowIsBitForBitTheSameAloneAndAmongOthers) {
  OnEachTarget([] {
    SCOPED_TRACE(BestRowKernels().target);
    std::mt19937 random(2);
    Case c({64, 64}, 48, 29, random);
    RowProduct all{&c.packed, c.terms, c.rows};
    all.y = c.y.data();
    all.stride = c.Stride();
    BestRowKernels().product(all);
    for (int row = 0; row < c.rows; ++row) {
      std::vector<RowTerm> terms = c.terms;
      for (RowTerm& term : terms) term.x += row * term.stride;
      std::vector<float> y(static_cast<std::size_t>(c.Stride()));
      RowProduct one{&c.packed, terms, 1};
      one.y = y.data();
      one.stride = c.Stride();
      BestRowKernels().product(one);
      for (int column = 0; column < c.columns; ++column) {
        ASSERT_EQ(y[static_cast<std::size_t>(column)],
                  c.y[static_cast<std::size_t>(row * c.Stride() + column)])
            << row << ", " << column;
      }
    }
  });
}

// The terms of a temporal convolution overlap, and the output may be added to itself.
TEST(Rows, TermsMayOverlapAndYMayBeAddedToItself) {
  OnEachTarget([] {
    SCOPED_TRACE(BestRowKernels().target);
    constexpr int kNodes = 5, kChannels = 16, kFrames = 9;
    std::mt19937 random(3);
    const std::vector<float> x =
        RandomFloats(static_cast<std::size_t>((kFrames + 2) * kNodes * kChannels), random);
    const std::array<int, 3> depths{kChannels, kChannels, kChannels};
    PackedColumns packed(depths, 1);
    for (std::size_t tap = 0; tap < 3; ++tap) {
      packed.At(tap, 0, static_cast<int>(tap)) = static_cast<float>(tap + 1);
    }
    std::vector<float> y(static_cast<std::size_t>(kFrames * kNodes * kRowPanel), 0.5F);
    std::array<RowTerm, 3> terms;
    for (std::size_t tap = 0; tap < 3; ++tap) {
      terms[tap] = {x.data() + tap * kNodes * kChannels, kChannels};
    }
    RowProduct product{&packed, terms, kFrames * kNodes};
    product.y = y.data();
    product.add = y.data();
    product.stride = kRowPanel;
    BestRowKernels().product(product);
    for (std::size_t row = 0; row < std::size_t{kFrames} * kNodes; ++row) {
      const float* const at = x.data() + row * kChannels;
      const float expected =
          0.5F + at[0] + 2 * at[kNodes * kChannels + 1] + 3 * at[2 * kNodes * kChannels + 2];
      ASSERT_NEAR(y[row * kRowPanel], expected, 1e-5) << row;
    }
  });
}

// The other functions over rows, on random numbers of every width.
TEST(Rows, MixturesAreSumsOfRowsOfTheSameFrame) {
  OnEachTarget([] {
    SCOPED_TRACE(BestRowKernels().target);
    std::mt19937 random(4);
    for (const int channels : {16, 48, 64, 80}) {
      const auto c = static_cast<std::size_t>(channels);
      constexpr std::size_t kFrames = 3, kA = 4, kB = 2;  // rows of a frame of either input
      const std::vector<float> a = RandomFloats(kFrames * kA * c, random);
      const std::vector<float> b = RandomFloats(kFrames * kB * c, random);
      const std::vector<float> constant = RandomFloats(3 * c, random);
      const std::array<RowMixture::Input, 2> inputs{
          {{a.data(), static_cast<std::ptrdiff_t>(kA * c)},
           {b.data(), static_cast<std::ptrdiff_t>(kB * c)}}};
      const std::array<int, 4> begins{0, 2, 2, 3};
      const std::array<RowMixture::Part, 3> parts{{{0, 3, 0.5F}, {1, 1, -2.0F}, {0, 0, 1.0F}}};
      for (const bool relu : {false, true}) {
        std::vector<float> y(kFrames * 3 * c);
        BestRowKernels().mix(
            {begins, parts, inputs, kFrames, channels, constant.data(), relu, y.data()});
        for (std::size_t t = 0; t < kFrames; ++t) {
          for (std::size_t i = 0; i < c; ++i) {
            const std::array<float, 3> expected{
                constant[i] + 0.5F * a[(t * kA + 3) * c + i] - 2.0F * b[(t * kB + 1) * c + i],
                constant[c + i], constant[2 * c + i] + a[t * kA * c + i]};
            for (std::size_t row = 0; row < 3; ++row) {
              const float least = relu ? 0.0F : -100.0F;
              ASSERT_NEAR(y[(t * 3 + row) * c + i], std::max(least, expected[row]), 1e-6);
            }
          }
        }
      }
    }
  });
}

TEST(Rows, ActivationIsLeakyAfterScaleAndShiftAndMayAverageTwo) {
  OnEachTarget([] {
    std::mt19937 random(5);
    constexpr int kRows = 3, kChannels = 32;
    const std::vector<float> x = RandomFloats(kRows * kChannels, random);
    const std::vector<float> other = RandomFloats(kRows * kChannels, random);
    const std::vector<float> scale = RandomFloats(kChannels, random);
    const std::vector<float> shift = RandomFloats(kChannels, random);
    const auto leaky = [](float v) { return v > 0 ? v : 0.2F * v; };
    std::vector<float> plain(x.size()), affine(x.size()), mean(x.size());
    const auto activate = BestRowKernels().activate;
    activate(x.data(), nullptr, kRows, kChannels, nullptr, nullptr, plain.data());
    activate(x.data(), nullptr, kRows, kChannels, scale.data(), shift.data(), affine.data());
    activate(x.data(), other.data(), kRows, kChannels, scale.data(), shift.data(), mean.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::size_t c = i % kChannels;
      const float first = leaky(x[i] * scale[c] + shift[c]);
      EXPECT_FLOAT_EQ(plain[i], leaky(x[i]));
      EXPECT_NEAR(affine[i], first, 1e-6);
      EXPECT_NEAR(mean[i], 0.5F * (first + leaky(other[i] * scale[c] + shift[c])), 1e-6);
    }
  });
}

TEST(Rows, SumsAreWeightedByRowAndAboutACentre) {
  OnEachTarget([] {
    std::mt19937 random(6);
    for (const int channels : {16, 64, 80}) {
      constexpr int kRows = 11;
      const auto c = static_cast<std::size_t>(channels);
      const std::vector<float> x = RandomFloats(kRows * c, random);
      const std::vector<float> centre = RandomFloats(c, random);
      const std::array<float, 3> weights{1, 2, 3};
      for (const int power : {1, 2}) {
        std::vector<float> sum(c);
        BestRowKernels().sum(x.data(), kRows, channels, weights.data(), 3, centre.data(), power,
                             sum.data());
        for (std::size_t i = 0; i < c; ++i) {
          double expected = 0;
          for (std::size_t row = 0; row < kRows; ++row) {
            expected += weights[row % 3] * std::pow(x[row * c + i] - centre[i], power);
          }
          ASSERT_NEAR(sum[i], expected, 1e-5);
        }
      }
    }
  });
}

TEST(Rows, ABlendIsBetweenTheTwo) {
  OnEachTarget([] {
    const std::vector<float> a(32, -1.0F), b(32, 3.0F);
    std::vector<float> y(32);
    BestRowKernels().blend(a.data(), b.data(), 0.25F, y.size(), false, y.data());
    for (const float value : y) EXPECT_FLOAT_EQ(value, 0);
    BestRowKernels().blend(a.data(), b.data(), 0.125F, y.size(), false, y.data());
    for (const float value : y) EXPECT_FLOAT_EQ(value, -0.5F);
    BestRowKernels().blend(a.data(), b.data(), 0.125F, y.size(), true, y.data());
    for (const float value : y) EXPECT_FLOAT_EQ(value, 0);
  });
}

// A filter of one channel through turn, one product per plane and turn_back is the convolution.
TEST(Rows, ATurnedTileIsAConvolutionOverTime) {
  OnEachTarget([] {
    std::mt19937 random(7);
    constexpr std::size_t kNodes = 2, kFrame = kNodes * 16;
    constexpr double g[3] = {0.7, -0.4, 0.3};
    const double of_plane[kTurned] = {g[0] / 4,
                                      -(g[0] + g[1] + g[2]) / 6,
                                      -(g[0] - g[1] + g[2]) / 6,
                                      g[0] / 24 + g[1] / 12 + g[2] / 6,
                                      g[0] / 24 - g[1] / 12 + g[2] / 6,
                                      g[2]};
    const std::vector<float> x = RandomFloats((kTile + 2) * kFrame, random);
    const std::vector<float> bias = RandomFloats(16, random);
    std::vector<float> planes(kTurned * kFrame);
    BestRowKernels().turn(x.data(), kFrame, planes.data(), kFrame);
    for (std::size_t i = 0; i < planes.size(); ++i) {
      planes[i] *= static_cast<float>(of_plane[i / kFrame]);
    }
    // Nothing added; y itself; another tensor's row for each node.
    const std::vector<float> other = RandomFloats(std::size_t{kTile} * 3 * 16, random);
    const std::array<int, kNodes> rows{2, 0};
    for (int frames = 1; frames <= kTile; ++frames) {
      for (const int way : {0, 1, 2}) {
        std::vector<float> y(kTile * kFrame, 5.0F);
        TurnedTile tile{planes.data(), kFrame, kNodes, 16, frames, bias.data()};
        tile.y = y.data();
        if (way == 1) {
          tile.add = y.data();
          tile.add_rows = kNodes;
        } else if (way == 2) {
          tile.add = other.data();
          tile.add_rows = 3;
          tile.add_row = rows.data();
        }
        BestRowKernels().turn_back(tile);
        for (std::size_t i = 0; i < y.size(); ++i) {
          const std::size_t t = i / kFrame, node = i % kFrame / 16, c = i % 16;
          double expected = 5;
          if (t < static_cast<std::size_t>(frames)) {
            if (way == 0) expected = 0;
            if (way == 2) expected = other[(t * 3 + static_cast<std::size_t>(rows[node])) * 16 + c];
            expected += bias[c];
            for (std::size_t tap = 0; tap < 3; ++tap) expected += g[tap] * x[i + tap * kFrame];
          }
          ASSERT_NEAR(y[i], expected, 1e-5) << frames << ", " << way << ", " << i;
        }
      }
    }
  });
}

TEST(Rows, SomeColumnsOfAProductAreThoseOfTheWhole) {
  OnEachTarget([] {
    std::mt19937 random(8);
    Case c({20}, 80, 9, random);
    RowProduct product{&c.packed, c.terms, c.rows};
    product.y = c.y.data();
    product.stride = c.Stride();
    BestRowKernels().product(product);
    std::vector<float> some(static_cast<std::size_t>(c.rows) * 48, 0.0F);
    product.y = some.data();
    product.stride = 48;
    product.first_column = 32;
    product.columns = 48;
    BestRowKernels().product(product);
    for (int row = 0; row < c.rows; ++row) {
      for (int column = 0; column < 48; ++column) {
        ASSERT_EQ(some[static_cast<std::size_t>(row * 48 + column)],
                  c.y[static_cast<std::size_t>(row * c.Stride() + 32 + column)]);
      }
    }
  });
}

TEST(Rows, ANumberThatIsNoneStays) {
  OnEachTarget([] {
    for (const bool relu : {false, true}) {
      const std::array<int, 1> depths{1};
      PackedColumns packed(depths, 1);
      packed.At(0, 0, 0) = 1;
      const float x = std::numeric_limits<float>::quiet_NaN();
      const RowTerm term{&x, 1};
      std::vector<float> y(kRowPanel);
      RowProduct product{&packed, {&term, 1}, 1};
      product.relu = relu;
      product.y = y.data();
      product.stride = kRowPanel;
      BestRowKernels().product(product);
      EXPECT_TRUE(std::isnan(y[0])) << relu;
    }
  });
}

}  // namespace
}  // namespace styled::net

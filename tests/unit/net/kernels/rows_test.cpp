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

// The kernels of every SIMD target that this machine supports, compared with plain loops in double.
#include "model/net/kernels/kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/net/kernels/each_target.h"

namespace styled::net {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct alignas(64) Line {
  float values[16];
};

// Random floats at a 64-byte boundary with nothing behind them, so that sanitizers detect a read
// beyond.
class Aligned {
 public:
  explicit Aligned(std::size_t size) : lines_((size + 15) / 16) {}
  Aligned(std::size_t size, float bound, std::mt19937& random) : Aligned(size) {
    std::uniform_real_distribution<float> uniform(-bound, bound);
    for (std::size_t i = 0; i < size; ++i) data()[i] = uniform(random);
  }
  float* data() { return lines_[0].values; }
  const float* data() const { return lines_[0].values; }
  float& operator[](std::size_t i) { return data()[i]; }
  float operator[](std::size_t i) const { return data()[i]; }

 private:
  std::vector<Line> lines_;
};

TEST(Kernels, EachTargetHasItsOwn) {
  std::set<std::string> names;
  std::size_t targets = 0;
  OnEachTarget([&] {
    ++targets;
    names.insert(BestKernels().target);
  });
  EXPECT_GE(targets, 1U);
  EXPECT_EQ(names.size(), targets);
  EXPECT_TRUE(names.contains(BestKernels().target));  // the best is selected again
  RecordProperty("targets", testing::PrintToString(names));
}

// The weight that a product reads from a packed matrix of `columns` columns, `together` of which
// share a number.
float Unpacked(const Aligned& packed, int columns, int together, int row, int column) {
  const int pairs = (columns + 1) / 2, panel = row / kPanelRows, in_panel = row % kPanelRows;
  const int groups = (columns + together - 1) / together, group = column / together;
  const auto* const begin = reinterpret_cast<const std::int8_t*>(packed.data()) +
                            panel * (pairs * 2 + groups * 4) * kPanelRows;
  const auto* const scales = reinterpret_cast<const float*>(begin + pairs * 2 * kPanelRows);
#ifdef __aarch64__  // four rows of a column, then of the next
  const int in_pair = (in_panel / 4 * 2 + column % 2) * 4 + in_panel % 4;
#else
  const int in_pair = in_panel * 2 + column % 2;
#endif
  return static_cast<float>(begin[column / 2 * kPanelRows * 2 + in_pair]) *
         scales[group * kPanelRows + in_panel];
}

// How far a packed weight may be from the one that it rounds, where the largest of its row is 1.
constexpr double kMostRounding = 0.501 / 127;

// The inputs as a product reads them.
std::vector<double> Read(const Aligned& x, Precision precision, int columns, int together) {
  std::vector<double> read(x.data(), x.data() + columns);
  if (precision != Precision::kInt8) return read;
  for (int first = 0; first < columns; first += together) {
    const int end = std::min(columns, first + together);
    float most = 0;
    for (int i = first; i < end; ++i) most = std::max(most, std::abs(x[i]));
    for (int i = first; i < end; ++i) {
      read[i] = most == 0
                    ? 0.0
                    : static_cast<double>(std::nearbyint(x[i] * (32767 / most))) * most / 32767;
    }
  }
  return read;
}

// Processed as fours, two and one; an LSTM layer and products of int8 take sixteen at a time.
constexpr int kInputs = 39;

// One product of `rows` x `columns` with several inputs: together, and each alone.
void CheckAffine(Precision precision, int rows, int columns, bool relu, std::mt19937& random) {
  const Kernels& kernels = BestKernels(precision);
  SCOPED_TRACE(std::to_string(rows) + " x " + std::to_string(columns));
  const int panels = PaddedRows(rows) / kPanelRows;
  Aligned weights(static_cast<std::size_t>(PaddedRows(rows)) * columns);
  Aligned dense(static_cast<std::size_t>(rows) * columns, 1, random);
  const bool rounded = kernels.pack != nullptr;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      weights[(row / kPanelRows * columns + column) * kPanelRows + row % kPanelRows] =
          dense[row * columns + column];
    }
  }
  std::vector<Aligned> x, bias, alone, together;
  for (int i = 0; i < kInputs; ++i) {
    x.emplace_back(columns, 1, random);
    bias.emplace_back(PaddedRows(rows), 1, random);
    alone.emplace_back(PaddedRows(rows));
    together.emplace_back(PaddedRows(rows));
  }
  if (rounded) {
    kernels.pack(weights.data(), panels, columns, kScaleColumns);
    for (int i = 0; i < rows * columns; ++i) {
      const float packed = Unpacked(weights, columns, kScaleColumns, i / columns, i % columns);
      ASSERT_NEAR(packed, dense[i], kMostRounding) << i;
      dense[i] = packed;
    }
  }
  std::vector<Operands> all;
  for (int i = 0; i < kInputs; ++i) {
    const Operands one{bias[i].data(), x[i].data(), alone[i].data()};
    kernels.affine(weights.data(), panels, columns, {&one, 1}, relu);
    all.push_back({bias[i].data(), x[i].data(), together[i].data()});
  }
  kernels.affine(weights.data(), panels, columns, all, relu);
  for (int i = 0; i < kInputs; ++i) {
    const std::vector<double> read = Read(x[i], precision, columns, kScaleColumns);
    for (int row = 0; row < rows; ++row) {
      double expected = bias[i][row];
      for (int column = 0; column < columns; ++column) {
        expected += static_cast<double>(dense[row * columns + column]) * read[column];
      }
      if (relu) expected = std::max(0.0, expected);
      ASSERT_NEAR(alone[i][row], expected, 2e-7 * (columns + 2)) << row;
      ASSERT_EQ(alone[i][row], together[i][row]) << row;
    }
  }
}

void CheckAffineOfAnySize(Precision precision) {
  SCOPED_TRACE(BestKernels(precision).target);
  std::mt19937 random(1);
  for (const int rows : {1, 15, 16, 17, 32, 33, 58, 64, 86, 128, 148, 161, 300}) {
    for (const int columns : {1, 2, 3, 5, 32, 58, 86, 128, 211}) {
      if (columns == 1 && precision == Precision::kInt8) continue;  // takes two or more
      CheckAffine(precision, rows, columns, (rows + columns) % 2 == 0, random);
    }
  }
}

TEST(Kernels, AffineOfAnySizeForOneInputAndForSeveral) {
  OnEachTarget([] { CheckAffineOfAnySize(Precision::kFloat32); });
}

TEST(Kernels, AffineOfInt8OfAnySize) {
  OnEachTarget([] { CheckAffineOfAnySize(Precision::kInt8); });
}

// Sums of whole numbers are exact, and targets round alike after them: the same bits. But SSE in a
// build without FMA rounds once more.
TEST(Kernels, ProductsOfInt8AreTheSameBitsOnEachTarget) {
  constexpr int kRows = 96, kColumns = 211, kPanels = kRows / kPanelRows;
  std::mt19937 random(6);
  const Aligned dense(kRows * kColumns, 1, random), x(kColumns, 1, random), bias(kRows, 1, random);
  std::vector<Aligned> results;
  OnEachTarget([&] {
    const Kernels& kernels = BestKernels(Precision::kInt8);
    Aligned weights = dense, y(kRows);
    kernels.pack(weights.data(), kPanels, kColumns, kScaleColumns);
    const Operands one{bias.data(), x.data(), y.data()};
    kernels.affine(weights.data(), kPanels, kColumns, {&one, 1}, false);
#if defined(__x86_64__) && !defined(__FMA__)
    if (std::string(kernels.target).find("SSE") != std::string::npos) return;
#endif
    results.push_back(y);
  });
  for (const Aligned& result : results) {
    for (int row = 0; row < kRows; ++row) EXPECT_EQ(result[row], results[0][row]) << row;
  }
}

// An overflow in an earlier layer must not become a pose.
TEST(Kernels, InputsOfInt8ThatAreNotFiniteGiveNoUsualNumber) {
  for (const float odd : {kInfinity, -kInfinity, kNan}) {
    for (const int at : {0, 5, 63, 69}) {
      OnEachTarget([=] {
        const Kernels& kernels = BestKernels(Precision::kInt8);
        std::mt19937 random(7);
        Aligned weights(kPanelRows * 70, 1, random), bias(kPanelRows), x(70, 1, random),
            y(kPanelRows);
        x[at] = odd;
        kernels.pack(weights.data(), 1, 70, kScaleColumns);
        const Operands one{bias.data(), x.data(), y.data()};
        kernels.affine(weights.data(), 1, 70, {&one, 1}, false);
        EXPECT_FALSE(std::abs(y[0]) < 1e30F) << odd << " at " << at << ", " << kernels.target;
      });
    }
  }
}

// The smallest and the largest numbers beside anything: no subnormal number, which would be slow,
// and none that is not finite.
TEST(Kernels, PackedWeightsAreNormalAndFinite) {
  const float numbers[] = {0.0F,    -0.0F, 1e-45F, -1e-40F,    2e-38F,
                           -2e-38F, 1.0F,  -1.0F,  3.4028e38F, -3.4028e38F};
  for (const float even : numbers) {
    for (const float odd : numbers) {
      Aligned weights(2 * kPanelRows);
      weights[0] = even;
      weights[kPanelRows] = odd;
      BestKernels(Precision::kInt8).pack(weights.data(), 1, 2, 2);
      const float largest = std::max(std::abs(even), std::abs(odd));
      for (const auto& [column, from] : {std::pair{0, even}, {1, odd}}) {
        const float packed = Unpacked(weights, 2, 2, 0, column);
        SCOPED_TRACE(testing::Message() << column << ", " << even << ' ' << odd);
        EXPECT_TRUE(std::isfinite(packed));
        EXPECT_NE(std::fpclassify(packed), FP_SUBNORMAL);
        EXPECT_NEAR(packed, from, std::max(1e-28, kMostRounding * largest));
      }
    }
  }
}

TEST(Kernels, StandardizeClampsAndReadsNotANumberAsTheMean) {
  constexpr float kLimit = 1000;
  OnEachTarget([] {
    SCOPED_TRACE(BestKernels().target);
    std::mt19937 random(2);
    for (int count = 1; count < 70; ++count) {
      std::vector<float> x(count);
      Aligned mean(count, 1, random), inverse(count, 10, random), u(count);
      const float odd[] = {0.3F, kInfinity, -kInfinity, kNan, 1e30F, -1e30F, 1e-40F, -2.0F};
      for (int i = 0; i < count; ++i) {
        inverse[i] = std::abs(inverse[i]) + 0.1F;
        x[i] = odd[(i + count) % std::size(odd)];
      }
      BestKernels().standardize(x.data(), mean.data(), inverse.data(), count, kLimit, u.data());
      for (int i = 0; i < count; ++i) {
        const double scaled = (static_cast<double>(x[i]) - mean[i]) * inverse[i];
        const double expected =
            std::isnan(scaled) ? 0.0 : std::clamp<double>(scaled, -kLimit, kLimit);
        ASSERT_NEAR(u[i], expected, 1e-5) << i << " of " << count;
      }
    }
  });
}

double Sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

// A layer and its input; the gates reach about +-`bound`.
template <int Units>
struct Layer {
  static constexpr int kRows = 4 * Units, kColumns = 2 * Units;
  Aligned dense, weights, bias, z, h, c;

  Layer(float bound, std::mt19937& random)
      : dense(kRows * kColumns, bound / Units, random),
        weights(kRows * kColumns),
        bias(kRows, bound, random),
        z(Units, 1, random),
        h(Units, 1, random),
        c(Units, std::min(bound, 5.0F), random) {
    // Gates in the order ifgo; the sigmoids' rows are halved.
    for (int row = 0; row < kRows; ++row) {
      const int to = LstmRow(row / Units, row % Units);
      for (int column = 0; column < kColumns; ++column) {
        weights[PackedMatrix<kRows, kColumns>::Index(to, column)] =
            (row / Units == 2 ? 1.0F : 0.5F) * dense[row * kColumns + column];
      }
    }
  }
  // Rounds the weights, and `dense` to what is read of them.
  void Pack(Precision precision) {
    BestKernels(precision).pack(weights.data(), kRows / kPanelRows, kColumns, Units);
    for (int row = 0; row < kRows; ++row) {
      const int at = LstmRow(row / Units, row % Units);
      for (int column = 0; column < kColumns; ++column) {
        dense[row * kColumns + column] =
            (row / Units == 2 ? 1.0F : 2.0F) * Unpacked(weights, kColumns, Units, at, column);
      }
    }
  }
  double Gate(Precision precision, int gate, int unit) {
    const std::vector<double> old_h = Read(h, precision, Units, Units);
    const std::vector<double> input = Read(z, precision, Units, Units);
    const int row = Units * gate + unit;
    double sum = bias[LstmRow(gate, unit)] * (gate == 2 ? 1.0 : 2.0);
    for (int column = 0; column < kColumns; ++column) {
      sum += static_cast<double>(dense[row * kColumns + column]) *
             (column < Units ? old_h[column] : input[column - Units]);
    }
    return sum;
  }
};

template <int Units>
void ExpectLayerOfTheEquations(Precision precision) {
  const Kernels& kernels = BestKernels(precision);
  SCOPED_TRACE(kernels.target);
  std::mt19937 random(3);
  for (const float bound : {0.01F, 1.0F, 5.0F, 30.0F, 1000.0F}) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      Layer<Units> layer(bound, random);
      if (kernels.pack != nullptr) layer.Pack(precision);
      std::vector<double> c, h;
      for (int unit = 0; unit < Units; ++unit) {
        c.push_back(Sigmoid(layer.Gate(precision, 1, unit)) * layer.c[unit] +
                    Sigmoid(layer.Gate(precision, 0, unit)) *
                        std::tanh(layer.Gate(precision, 2, unit)));
        h.push_back(Sigmoid(layer.Gate(precision, 3, unit)) * std::tanh(c.back()));
      }
      const LstmOperands state{layer.z.data(), layer.h.data(), layer.c.data()};
      kernels.lstm(Units, layer.weights.data(), layer.bias.data(), {&state, 1});
      // The rounding of the gates' sums grows with their size.
      const double tolerance = 4e-7 * std::max(1.0F, bound);
      for (int unit = 0; unit < Units; ++unit) {
        ASSERT_NEAR(layer.c[unit], c[unit], tolerance) << bound << ", unit " << unit;
        ASSERT_NEAR(layer.h[unit], h[unit], tolerance) << bound << ", unit " << unit;
      }
    }
  }
}

TEST(Kernels, LstmLayerIsThatOfTheEquations) {
  OnEachTarget([] {
    ExpectLayerOfTheEquations<32>(Precision::kFloat32);
    ExpectLayerOfTheEquations<64>(Precision::kFloat32);
  });
}

TEST(Kernels, RoundedLstmLayersAreThoseOfTheEquations) {
  OnEachTarget([] {
    ExpectLayerOfTheEquations<32>(Precision::kInt8);
    ExpectLayerOfTheEquations<64>(Precision::kInt8);
  });
}

template <int Units>
void ExpectStatesTogetherAsAlone(const Kernels& kernels) {
  SCOPED_TRACE(kernels.target);
  std::mt19937 random(5);
  Layer<Units> layer(2, random);
  if (kernels.pack != nullptr) {
    kernels.pack(layer.weights.data(), 4 * Units / kPanelRows, 2 * Units, Units);
  }
  std::vector<Aligned> z, h, c;
  std::vector<LstmOperands> all;
  for (int i = 0; i < kInputs; ++i) {
    z.emplace_back(Units, 1, random);
    h.emplace_back(Units, 1, random);
    c.emplace_back(Units, 2, random);
  }
  std::vector<Aligned> alone_h = h, alone_c = c;
  for (int i = 0; i < kInputs; ++i) {
    all.push_back({z[i].data(), h[i].data(), c[i].data()});
    const LstmOperands one{z[i].data(), alone_h[i].data(), alone_c[i].data()};
    kernels.lstm(Units, layer.weights.data(), layer.bias.data(), {&one, 1});
  }
  kernels.lstm(Units, layer.weights.data(), layer.bias.data(), all);
  for (int i = 0; i < kInputs; ++i) {
    for (int unit = 0; unit < Units; ++unit) {
      ASSERT_EQ(h[i][unit], alone_h[i][unit]) << i << ", unit " << unit;
      ASSERT_EQ(c[i][unit], alone_c[i][unit]) << i << ", unit " << unit;
    }
  }
}

TEST(Kernels, LstmStatesTogetherAreBitForBitThoseAlone) {
  OnEachTarget([] {
    ExpectStatesTogetherAsAlone<32>(BestKernels());
    ExpectStatesTogetherAsAlone<64>(BestKernels());
  });
}

TEST(Kernels, RoundedLstmStatesTogetherAreBitForBitThoseAlone) {
  OnEachTarget([] {
    ExpectStatesTogetherAsAlone<32>(BestKernels(Precision::kInt8));
    ExpectStatesTogetherAsAlone<64>(BestKernels(Precision::kInt8));
  });
}

// With open gates and zero weights, c' is tanh of the cell gate: only the approximation.
TEST(Kernels, TanhIsGoodToAFewUlpsEverywhere) {
  OnEachTarget([] {
    SCOPED_TRACE(BestKernels().target);
    std::vector<float> points{0, 1e-30F, 1e20F, kInfinity, 1e-6F};
    while (points.back() < 100) points.push_back(points.back() * 1.001F);
    double largest = 0, largest_relative = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      Aligned weights(128 * 64), bias(128), z(32), h(32), c(32);
      for (int unit = 0; unit < 32; ++unit) {
        bias[LstmRow(0, unit)] = 50;
        bias[LstmRow(2, unit)] = unit % 2 == 0 ? points[i] : -points[i];
        bias[LstmRow(3, unit)] = 50;
      }
      const LstmOperands state{z.data(), h.data(), c.data()};
      BestKernels().lstm(32, weights.data(), bias.data(), {&state, 1});
      const double expected = std::tanh(static_cast<double>(points[i]));
      for (int unit = 0; unit < 32; ++unit) {
        const double found = unit % 2 == 0 ? c[unit] : -c[unit];
        largest = std::max(largest, std::abs(found - expected));
        if (expected > 1e-20) {
          largest_relative = std::max(largest_relative, std::abs(found / expected - 1));
        }
      }
    }
    EXPECT_LT(largest, 4e-7);
    EXPECT_LT(largest_relative, 4e-7);
  });
}

TEST(Kernels, NormalizeGivesUnitQuaternionsAndIdentityForNone) {
  OnEachTarget([] {
    SCOPED_TRACE(BestKernels().target);
    std::mt19937 random(4);
    for (int count = 1; count < 25; ++count) {
      std::vector<float> q(4 * static_cast<std::size_t>(count)), unit(q.size());
      for (std::size_t i = 0; i < q.size(); ++i) {
        const float size = std::pow(10.0F, static_cast<float>(i / 4 % 11) - 5);
        q[i] = i / 4 % 5 == 3 ? 0 : size * (static_cast<float>(random() % 2000) / 1000 - 0.9995F);
      }
      BestKernels().normalize(q.data(), count, unit.data());
      for (std::size_t i = 0; i < q.size(); ++i) {
        double square = 0;
        for (std::size_t k = i / 4 * 4; k < i / 4 * 4 + 4; ++k) square += std::pow(q[k], 2.0);
        const double expected = square > 1e-12 ? q[i] / std::sqrt(square) : i % 4 == 3;
        ASSERT_NEAR(unit[i], expected, 2e-7) << i << " of " << count;
      }
    }
  });
}

}  // namespace
}  // namespace styled::net

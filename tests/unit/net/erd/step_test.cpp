// Network::Step compared with a scalar double-precision network written from FORMAT.md's equations;
// and its guarantees about branches, determinism and hostile input.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "tests/unit/net/erd/random_weights.h"
#include "tests/unit/net/kernels/each_target.h"

namespace styled::erd {
namespace {

using Doubles = std::vector<double>;

struct ReferenceOutput {
  Doubles rotations, velocities;
  double height;
};

// One performer's network, slow and simple; `branches` holds (h, c) per style and layer.
class Reference {
 public:
  explicit Reference(const WeightsFile& file)
      : style_count_(static_cast<int>(file.metadata["styles"].size())) {
    for (const NamedTensor& tensor : file.tensors) tensors_[tensor.name] = tensor;
    StartBranch(0);
  }

  // `active` maps style to alpha.
  void Step(const Features& x, int input_style, const std::map<int, double>& active,
            ReferenceOutput& reconstruction, ReferenceOutput& styled) {
    std::map<int, double> alive = active;
    if (input_style != 0) alive.emplace(input_style, 0.0);
    std::erase_if(branches_, [&](const auto& b) { return b.first != 0 && !alive.count(b.first); });

    Doubles u;
    for (int i = 0; i < 211; ++i) {
      const double scaled = (x[i] - Value("feature.mean", i)) / Value("feature.deviation", i);
      u.push_back(std::clamp(scaled, -4.0, 4.0));
    }
    for (int s = 0; s < style_count_; ++s) u.push_back(s == input_style ? 1 : 0);
    const Doubles z = Linear("encoder.1", Relu(Linear("encoder.0", u)));

    const Doubles neutral = RunBranch(0, 6, z);
    Doubles of_input = neutral;
    Doubles sum = neutral;
    Doubles target(style_count_, 0.0);
    double alphas = 0;
    for (const auto& [style, alpha] : alive) {
      if (!branches_.count(style)) StartBranch(style);
      const Doubles residual = RunBranch(style, 4, z);
      for (std::size_t i = 0; i < sum.size(); ++i) {
        sum[i] += alpha * residual[i];
        if (style == input_style) of_input[i] += residual[i];
      }
      target[style] = alpha;
      alphas += alpha;
    }
    target[0] = std::max(0.0, 1 - alphas);
    for (double& share : target) share /= target[0] == 0 ? alphas : 1;
    Doubles own(style_count_, 0.0);
    own[input_style] = 1;
    Decode(of_input, own, reconstruction);
    Decode(sum, target, styled);
  }

 private:
  double Value(const std::string& name, std::size_t i) const { return tensors_.at(name).values[i]; }

  Doubles Product(const std::string& name, const Doubles& x) const {
    const NamedTensor& tensor = tensors_.at(name);
    EXPECT_EQ(tensor.shape[1], static_cast<std::int64_t>(x.size())) << name;
    Doubles y(tensor.shape[0], 0.0);
    for (std::size_t row = 0; row < y.size(); ++row) {
      for (std::size_t column = 0; column < x.size(); ++column) {
        y[row] += tensor.values[row * x.size() + column] * x[column];
      }
    }
    return y;
  }
  Doubles Linear(const std::string& name, const Doubles& x) const {
    Doubles y = Product(name + ".weight", x);
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += Value(name + ".bias", i);
    return y;
  }
  static Doubles Relu(Doubles x) {
    for (double& value : x) value = std::max(0.0, value);
    return x;
  }
  static double Sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

  struct LayerState {
    Doubles h, c;
  };

  static std::string Name(int style, int layer) {
    return "recurrent." + std::to_string(style) + "." + std::to_string(layer);
  }
  void StartBranch(int style) {
    for (int layer = 0; layer < (style == 0 ? 6 : 4); ++layer) {
      const auto& h0 = tensors_.at(Name(style, layer) + ".h0").values;
      const auto& c0 = tensors_.at(Name(style, layer) + ".c0").values;
      branches_[style].push_back({{h0.begin(), h0.end()}, {c0.begin(), c0.end()}});
    }
  }
  Doubles RunBranch(int style, int layers, Doubles z) {
    for (int layer = 0; layer < layers; ++layer) {
      LayerState& state = branches_.at(style)[layer];
      const std::string name = Name(style, layer);
      const Doubles input = Product(name + ".input", z);
      const Doubles hidden = Product(name + ".hidden", state.h);
      const auto latent = static_cast<int>(z.size());
      const auto gate = [&](int block, int i) {
        const int row = latent * block + i;
        return input[row] + hidden[row] + Value(name + ".bias", row);
      };
      for (int i = 0; i < latent; ++i) {
        state.c[i] = Sigmoid(gate(1, i)) * state.c[i] + Sigmoid(gate(0, i)) * std::tanh(gate(2, i));
        state.h[i] = Sigmoid(gate(3, i)) * std::tanh(state.c[i]);
      }
      z = state.h;
    }
    return z;
  }
  void Decode(const Doubles& latent, const Doubles& target, ReferenceOutput& out) const {
    Doubles d = latent;
    d.insert(d.end(), target.begin(), target.end());
    for (int k = 0; k < 3; ++k) d = Relu(Linear("decoder." + std::to_string(k), d));
    const auto head = [&](const std::string& name, int begin) {
      Doubles y = Linear("head." + name, d);
      for (std::size_t i = 0; i < y.size(); ++i) {
        y[i] = y[i] * Value("feature.deviation", begin + i) + Value("feature.mean", begin + i);
      }
      return y;
    };
    out.rotations = head("rotation", 0);
    for (int joint = 0; joint < 21; ++joint) {
      double squares = 0;
      for (int i = 0; i < 4; ++i) squares += std::pow(out.rotations[4 * joint + i], 2);
      for (int i = 0; i < 4; ++i) out.rotations[4 * joint + i] /= std::sqrt(squares);
    }
    out.velocities = head("velocity", 147);
    out.height = head("height", 210)[0];
  }

  std::map<std::string, NamedTensor> tensors_;
  int style_count_;
  std::map<int, std::vector<LayerState>> branches_;
};

// Smooth random features, like those of motion: sums of sines.
Features FeaturesAt(int frame, unsigned seed = 7) {
  std::mt19937 random(seed);
  Features features;
  for (float& x : features) {
    const float phase = static_cast<float>(random() % 1000) * 0.00628F;
    const float rate = 0.02F + static_cast<float>(random() % 100) * 0.002F;
    x = 0.5F * std::sin(phase + rate * static_cast<float>(frame));
  }
  for (int joint = 0; joint < 21; ++joint) features[4 * joint + 3] += 0.8F;
  return features;
}

double Difference(const net::Decoded& a, const ReferenceOutput& b) {
  double largest = std::abs(a.hips_height_m - b.height);
  for (int joint = 0; joint < 21; ++joint) {
    for (int i = 0; i < 4; ++i) {
      const double x = a.rotations[joint].coeffs()[i];
      largest = std::max(largest, std::abs(x - b.rotations[4 * joint + i]));
    }
  }
  for (int i = 0; i < 63; ++i) {
    largest = std::max(largest, std::abs(a.velocities_m_s[i] - b.velocities[i]));
  }
  return largest;
}

double Difference(const net::Decoded& a, const net::Decoded& b) {
  ReferenceOutput other;
  other.height = b.hips_height_m;
  for (const body::Quat& q : b.rotations) {
    for (int i = 0; i < 4; ++i) other.rotations.push_back(q.coeffs()[i]);
  }
  other.velocities.assign(b.velocities_m_s.begin(), b.velocities_m_s.end());
  return Difference(a, other);
}

bool AllFinite(const net::Decoded& decoded) {
  bool finite = std::isfinite(decoded.hips_height_m);
  for (const body::Quat& q : decoded.rotations) {
    finite = finite && q.coeffs().allFinite() && std::abs(q.norm() - 1) < 1e-5F;
  }
  for (const float v : decoded.velocities_m_s) finite = finite && std::isfinite(v);
  return finite;
}

bool AllFinite(const State& state) {
  const auto finite = [](const BranchState& branch, int layers) {
    bool all = true;
    for (int l = 0; l < layers; ++l) all = all && (branch.h[l] + branch.c[l]).allFinite();
    return all;
  };
  bool all = finite(state.neutral, kNeutralLayers);
  for (int i = 0; i < kMaxBranches; ++i) {
    if (state.style[i] >= 0) all = all && finite(state.branch[i], kStyleLayers);
  }
  return all;
}

constexpr double kTolerance = 2e-6;  // float32 against double; measured: 1.5e-7

struct Command {
  int from_frame;
  int input_style;
  std::vector<net::StyleWeight> active;
};

// Runs the reference and the network of every SIMD target through `commands` for `frames`; returns
// the largest difference of any output.
template <Shape kShape = kPaper>
double CompareThrough(const std::vector<Command>& commands, int frames, unsigned seed) {
  const WeightsFile file = RandomWeights(6, seed, kShape);
  struct Run {
    std::shared_ptr<const ShapedNetwork<kShape>> network;
    StateOf<kShape> state;
  };
  std::vector<Run> runs;
  net::OnEachTarget([&] {
    const auto network = ShapedNetwork<kShape>::Parse(file.Bytes(), "random");
    EXPECT_TRUE(network.ok()) << network.status().message();
    network.value()->Start(runs.emplace_back(Run{network.value(), {}}).state);
  });
  EXPECT_FALSE(runs.empty());
  Reference reference(file);
  double largest = 0;
  std::size_t command = 0;
  for (int frame = 0; frame < frames; ++frame) {
    while (command + 1 < commands.size() && commands[command + 1].from_frame <= frame) ++command;
    const Command& now = commands[command];
    std::map<int, double> active;
    for (const net::StyleWeight& style : now.active) active[style.style] = style.weight;
    ReferenceOutput reconstruction, styled;
    const Features features = FeaturesAt(frame, seed);
    reference.Step(features, now.input_style, active, reconstruction, styled);
    for (Run& run : runs) {
      net::Prediction out;
      run.network->Step(features, now.input_style, now.active, run.state, out);
      largest = std::max({largest, Difference(out.reconstruction, reconstruction),
                          Difference(out.styled, styled)});
    }
  }
  return largest;
}

TEST(StepAgainstReference, NeutralAlone) {
  EXPECT_LT(CompareThrough({{0, 0, {}}}, 200, 1), kTolerance);
}

TEST(StepAgainstReference, OneStyle) {
  EXPECT_LT(CompareThrough({{0, 0, {{2, 1.0F}}}}, 1000, 2), kTolerance);
}

TEST(StepAgainstReference, PartialStrengthLeavesAShareToNeutral) {
  EXPECT_LT(CompareThrough({{0, 0, {{2, 0.4F}}}}, 200, 3), kTolerance);
}

TEST(StepAgainstReference, StrengthAboveOneIsNormalized) {
  EXPECT_LT(CompareThrough({{0, 0, {{1, 0.8F}, {3, 0.7F}}}}, 200, 4), kTolerance);
}

TEST(StepAgainstReference, MixOfFour) {
  const std::vector<net::StyleWeight> mix{{1, 0.3F}, {5, 0.1F}, {2, 0.2F}, {4, 0.25F}};
  EXPECT_LT(CompareThrough({{0, 0, mix}}, 200, 5), kTolerance);
}

TEST(StepAgainstReference, SwitchDropAndRestart) {
  EXPECT_LT(CompareThrough({{0, 0, {{1, 1.0F}}},
                            {40, 0, {{1, 0.5F}, {2, 0.5F}}},  // a second style begins
                            {60, 0, {{2, 1.0F}}},             // the first is dropped
                            {90, 0, {{1, 0.7F}, {2, 0.0F}}},  // restarts; weight 0: live
                            {110, 0, {{2, 1.0F}}},
                            {130, 0, {}},
                            {150, 0, {{3, 1.0F}, {1, 0.2F}}}},
                           200, 6),
            kTolerance);
}

TEST(StepAgainstReference, StyledInput) {
  EXPECT_LT(CompareThrough({{0, 3, {}},                        // to neutral
                            {50, 3, {{1, 1.0F}}},              // to another style
                            {100, 3, {{3, 0.6F}, {1, 0.4F}}},  // 3 is in the mix, too
                            {150, 0, {{1, 0.5F}}}},  // no input style any more: 3 is dropped
                           200, 7),
            kTolerance);
}

TEST(StepAgainstReference, AWideNetwork) {
  EXPECT_LT(CompareThrough<kWide>({{0, 0, {{2, 1.0F}}},
                                   {40, 0, {{1, 0.5F}, {2, 0.7F}}},
                                   {90, 3, {{3, 0.6F}, {1, 0.4F}}},
                                   {150, 0, {}}},
                                  200, 20),
            kTolerance);
}

TEST(StepAgainstReference, AnotherHistoryIsSeen) {
  // The comparison's negative control: the same network with one branch one frame older.
  const auto network = RandomNetwork(3, 8);
  const std::vector<net::StyleWeight> active{{1, 1.0F}};
  State a, b;
  network->Start(a);
  network->Start(b);
  net::Prediction out_a, out_b;
  network->Step(FeaturesAt(0), 0, active, a, out_a);
  network->Step(FeaturesAt(0), 0, {}, b, out_b);
  network->Step(FeaturesAt(1), 0, active, a, out_a);
  network->Step(FeaturesAt(1), 0, active, b, out_b);
  EXPECT_GT(Difference(out_a.styled, out_b.styled), 100 * kTolerance);
  EXPECT_EQ(Difference(out_a.reconstruction, out_b.reconstruction), 0);
}

TEST(Step, TwoRunsAreBitIdentical) {
  const auto network = RandomNetwork(4, 9);
  std::vector<net::Prediction> runs[2];
  for (auto& run : runs) {
    State state;
    network->Start(state);
    for (int frame = 0; frame < 100; ++frame) {
      const std::vector<net::StyleWeight> active{{1 + frame / 40, 0.9F}, {3, 0.2F}};
      run.emplace_back();
      network->Step(FeaturesAt(frame), 0, active, state, run.back());
    }
  }
  for (int frame = 0; frame < 100; ++frame) {
    EXPECT_EQ(Difference(runs[0][frame].styled, runs[1][frame].styled), 0);
    EXPECT_EQ(Difference(runs[0][frame].reconstruction, runs[1][frame].reconstruction), 0);
  }
}

// More performers than are processed at a time: without a style, in one, in several, switching, and
// with an input style.
template <Shape kShape>
void ExpectTogetherAsAlone(const ShapedNetwork<kShape>& network) {
  constexpr int kPerformers = 21;
  std::vector<StateOf<kShape>> alone(kPerformers), together(kPerformers);
  std::vector<net::Prediction> out_alone(kPerformers), out_together(kPerformers);
  for (auto& state : alone) network.Start(state);
  for (auto& state : together) network.Start(state);
  for (int frame = 0; frame < 12; ++frame) {
    std::vector<Features> features;
    std::vector<std::vector<net::StyleWeight>> active(kPerformers);
    for (int k = 0; k < kPerformers; ++k) {
      features.push_back(FeaturesAt(frame + 3 * k));
      for (int s = 0; s < k % 5; ++s) active[k].push_back({1 + (k + s + frame / 4) % 6, 0.4F});
    }
    std::vector<StepJobOf<kShape>> jobs;
    for (int k = 0; k < kPerformers; ++k) {
      const int own = k % 4 == 3 ? 2 : 0;
      network.Step(features[k], own, active[k], alone[k], out_alone[k]);
      jobs.push_back({&features[k], own, active[k], &together[k], &out_together[k]});
    }
    network.StepTogether(jobs);
    for (int k = 0; k < kPerformers; ++k) {
      ASSERT_EQ(Difference(out_alone[k].styled, out_together[k].styled), 0) << frame << " " << k;
      ASSERT_EQ(Difference(out_alone[k].reconstruction, out_together[k].reconstruction), 0);
      ASSERT_EQ(alone[k].style, together[k].style);
    }
  }
}

TEST(Step, TogetherIsBitForBitOneByOne) {
  net::OnEachTarget([] {
    ExpectTogetherAsAlone(*RandomNetwork(6, 19));
    ExpectTogetherAsAlone(*RandomWideNetwork(6, 19));
  });
}

TEST(Step, ACopiedStateGoesOnAlike) {
  const auto network = RandomNetwork(3, 10);
  const std::vector<net::StyleWeight> active{{1, 0.5F}, {2, 0.5F}};
  State state;
  network->Start(state);
  net::Prediction out, of_copy;
  for (int frame = 0; frame < 20; ++frame) network->Step(FeaturesAt(frame), 0, active, state, out);
  State copy = state;
  network->Step(FeaturesAt(20), 0, active, state, out);
  network->Step(FeaturesAt(20), 0, active, copy, of_copy);
  EXPECT_EQ(Difference(out.styled, of_copy.styled), 0);
}

TEST(Step, WithoutAStyleStyledIsTheReconstruction) {
  const auto network = RandomNetwork(3, 11);
  State state, other;
  network->Start(state);
  network->Start(other);
  net::Prediction none, zero;
  network->Step(FeaturesAt(0), 0, {}, state, none);
  EXPECT_EQ(Difference(none.styled, none.reconstruction), 0);
  const std::vector<net::StyleWeight> weight_zero{{1, 0.0F}};
  network->Step(FeaturesAt(0), 0, weight_zero, other, zero);
  EXPECT_EQ(Difference(zero.styled, none.styled), 0);
}

TEST(Step, ANetworkOfNeutralAloneRuns) {
  const auto network = RandomNetwork(1, 12);
  State state;
  network->Start(state);
  net::Prediction out;
  network->Step(FeaturesAt(0), 0, {}, state, out);
  EXPECT_TRUE(AllFinite(out.styled));
}

TEST(Step, BranchesLiveWhileNamed) {
  const auto network = RandomNetwork(6, 13);
  State state;
  network->Start(state);
  net::Prediction out;
  const auto alive = [&state](int style) {
    return std::count(state.style.begin(), state.style.end(), style);
  };
  EXPECT_EQ(alive(-1), kMaxBranches);
  network->Step(FeaturesAt(0), 0, std::vector<net::StyleWeight>{{2, 1.0F}, {4, 0.0F}}, state, out);
  EXPECT_EQ(alive(2), 1);
  EXPECT_EQ(alive(4), 1);
  network->Step(FeaturesAt(1), 5, std::vector<net::StyleWeight>{{2, 1.0F}}, state, out);
  EXPECT_EQ(alive(4), 0);
  EXPECT_EQ(alive(5), 1);
  network->Step(FeaturesAt(2), 0, {}, state, out);
  EXPECT_EQ(alive(-1), kMaxBranches);
}

TEST(Step, IgnoresStylesItLacksAndNeutral) {
  const auto network = RandomNetwork(3, 14);
  State state, other;
  network->Start(state);
  network->Start(other);
  net::Prediction out, expected;
  const std::vector<net::StyleWeight> odd{
      {0, 1.0F}, {-1, 1.0F}, {3, 1.0F}, {1, 0.5F}, {1 << 30, 1.0F}};
  network->Step(FeaturesAt(0), 0, odd, state, out);
  network->Step(FeaturesAt(0), 99, std::vector<net::StyleWeight>{{1, 0.5F}}, other, expected);
  EXPECT_EQ(Difference(out.styled, expected.styled), 0);
}

TEST(Step, IgnoresWhatComesAfterTheLimit) {
  const auto network = RandomNetwork(16, 15);
  State state;
  network->Start(state);
  net::Prediction out;
  std::vector<net::StyleWeight> all;
  for (int style = 1; style < 16; ++style) all.push_back({style, 0.1F});
  network->Step(FeaturesAt(0), 15, all, state, out);  // the input style has its own slot
  for (int i = 0; i < net::kMaxActive; ++i) EXPECT_EQ(state.style[i], 1 + i);
  EXPECT_EQ(state.style[net::kMaxActive], 15);
}

TEST(Step, WeightsAreClampedAndOfOneStyleAdded) {
  const auto network = RandomNetwork(3, 16);
  const auto styled = [&](const std::vector<net::StyleWeight>& active) {
    State state;
    network->Start(state);
    net::Prediction out;
    network->Step(FeaturesAt(0), 0, active, state, out);
    return out.styled;
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const net::Decoded most = styled({{1, net::kMaxStrength}});
  const net::Decoded none = styled({{1, 0.0F}});
  EXPECT_EQ(Difference(styled({{1, 1e9F}}), most), 0);
  EXPECT_EQ(Difference(styled({{1, kInfinity}}), most), 0);
  EXPECT_EQ(Difference(styled({{1, -1.0F}}), none), 0);
  EXPECT_EQ(Difference(styled({{1, kNan}}), none), 0);
  EXPECT_EQ(Difference(styled({{1, 0.25F}, {1, 0.5F}}), styled({{1, 0.75F}})), 0);
  EXPECT_GT(Difference(most, none), kTolerance);
}

TEST(Step, NoInputLeavesANonFiniteState) {
  const auto network = RandomNetwork(3, 17);
  const std::vector<net::StyleWeight> active{{1, 1.0F}, {2, 0.5F}};
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr float kHuge = std::numeric_limits<float>::max();
  constexpr float kTiny = std::numeric_limits<float>::denorm_min();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  State state;
  network->Start(state);
  net::Prediction out;
  int frame = 0;
  for (const float value :
       {0.0F, kTiny, 1e6F, -1e20F, kHuge, -kHuge, kInfinity, -kInfinity, kNan}) {
    for (int repeat = 0; repeat < 5; ++repeat) {
      Features features = FeaturesAt(frame++);
      for (int i = 0; i < kFeatureCount; i += 1 + repeat) features[i] = value;
      network->Step(features, repeat == 3 ? 2 : 0, active, state, out);
      EXPECT_TRUE(AllFinite(out.styled)) << value;
      EXPECT_TRUE(AllFinite(out.reconstruction)) << value;
      EXPECT_TRUE(AllFinite(state)) << value;
    }
  }
}

TEST(Step, RecoversFromANotANumberFrame) {
  // A frame of NaN counts as the mean; 300 frames later its effect has faded.
  const auto network = RandomNetwork(3, 18);
  const std::vector<net::StyleWeight> active{{1, 1.0F}};
  State state, undisturbed;
  network->Start(state);
  network->Start(undisturbed);
  net::Prediction out, expected;
  Features nothing;
  nothing.fill(std::numeric_limits<float>::quiet_NaN());
  network->Step(nothing, 0, active, state, out);
  network->Step(FeaturesAt(0), 0, active, undisturbed, expected);
  EXPECT_GT(Difference(out.styled, expected.styled), 1e-3);
  for (int frame = 1; frame < 300; ++frame) {
    network->Step(FeaturesAt(frame), 0, active, state, out);
    network->Step(FeaturesAt(frame), 0, active, undisturbed, expected);
  }
  EXPECT_LT(Difference(out.styled, expected.styled), 1e-3);
}

}  // namespace
}  // namespace styled::erd

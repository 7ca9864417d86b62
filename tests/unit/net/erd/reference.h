#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/unit/net/erd/random_weights.h"
#include "tests/unit/net/kernels/each_target.h"

// A scalar double-precision network, written from FORMAT.md's equations and not from the code that
// it is compared with.
namespace styled::erd {

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
    content_count_ = static_cast<int>(file.metadata["contents"].size());
    if (content_count_ > 0) {
      frame_s_ = 1 / file.metadata["rate_hz"].get<double>();
      rise_s_ = file.metadata["content_rise_s"].get<double>();
    }
    branches_[kRecognizer] = {StateOfLayer("recognizer.lstm", 0)};
  }

  // `active` maps style to alpha; `content`: as Network::Step's.
  void Step(const Features& x, int input_style, const std::map<int, double>& active,
            ReferenceOutput& reconstruction, ReferenceOutput& styled,
            int content = net::kContentRecognized) {
    if (frames_ == 0) StartBranch(0, content >= 0 ? content : content_count_);
    std::map<int, double> alive = active;
    if (input_style != 0) alive.emplace(input_style, 0.0);
    std::erase_if(branches_, [&](const auto& b) { return b.first > 0 && !alive.count(b.first); });

    Doubles u;
    for (int i = 0; i < 211; ++i) {
      const double scaled = (x[i] - Value("feature.mean", i)) / Value("feature.deviation", i);
      u.push_back(std::clamp(scaled, -4.0, 4.0));
    }
    const Doubles c = Content(u, content);
    for (int s = 0; s < style_count_; ++s) u.push_back(s == input_style ? 1 : 0);
    u.insert(u.end(), c.begin(), c.end());
    ++frames_;
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

  // P of the last frame.
  const Doubles& recognized() const { return recognized_; }

 private:
  static constexpr int kRecognizer = -1;  // its key in branches_

  struct LayerState {
    Doubles h, c;
  };

  // c of a frame.
  Doubles Content(const Doubles& u, int content) {
    Doubles c(static_cast<std::size_t>(content_count_), 0.0);
    if (c.empty()) return c;
    const Doubles z = Linear("recognizer.1", Relu(Linear("recognizer.0", u)));
    recognized_ = Linear("recognizer.head", RunLayer("recognizer.lstm", kRecognizer, 0, z));
    double sum = 0;
    for (double& share : recognized_) sum += share = std::exp(share);
    for (double& share : recognized_) share /= sum;
    if (content >= 0) c[static_cast<std::size_t>(content)] = 1;
    if (content != net::kContentRecognized) return c;
    const double certainty = 1 - std::exp(-frames_ * frame_s_ / rise_s_);
    for (std::size_t i = 0; i < c.size(); ++i) c[i] = certainty * recognized_[i];
    return c;
  }

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

  static std::string Name(int style, int layer) {
    return "recurrent." + std::to_string(style) + "." + std::to_string(layer);
  }
  // Row `row` of the initial states of a layer; absent tensors give nothing.
  LayerState StateOfLayer(const std::string& name, int row) const {
    const auto part = [&](const std::string& tensor) {
      const auto found = tensors_.find(tensor);
      if (found == tensors_.end()) return Doubles();
      const auto width = static_cast<std::ptrdiff_t>(found->second.shape.back());
      const auto begin = found->second.values.begin() + row * width;
      return Doubles(begin, begin + width);
    };
    return {part(name + ".h0"), part(name + ".c0")};
  }
  void StartBranch(int style, int row = 0) {
    for (int layer = 0; layer < (style == 0 ? 6 : 4); ++layer) {
      branches_[style].push_back(StateOfLayer(Name(style, layer), row));
    }
  }
  Doubles RunBranch(int style, int layers, Doubles z) {
    for (int layer = 0; layer < layers; ++layer) z = RunLayer(Name(style, layer), style, layer, z);
    return z;
  }
  Doubles RunLayer(const std::string& name, int branch, int layer, const Doubles& z) {
    LayerState& state = branches_.at(branch)[layer];
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
    return state.h;
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
  int content_count_ = 0, frames_ = 0;
  double frame_s_ = 0, rise_s_ = 1;
  Doubles recognized_;
};

// Smooth random features, like those of motion: sums of sines.
Features FeaturesAt(int frame, unsigned seed = 7);

// The largest difference of any number.
double Difference(const net::Decoded& a, const ReferenceOutput& b);
double Difference(const net::Decoded& a, const net::Decoded& b);

inline constexpr double kTolerance = 2e-6;  // float32 against double; measured: 1.5e-7

struct Command {
  int from_frame;
  int input_style;
  std::vector<net::StyleWeight> active;
  int content = net::kContentRecognized;
};

// Runs the reference and the network of every SIMD target through `commands` for `frames`; returns
// the largest difference of any output.
template <Shape kShape = kPaper>
double CompareThrough(const std::vector<Command>& commands, int frames, unsigned seed,
                      int contents = 0) {
  const WeightsFile file = contents > 0 ? RandomWeightsWithContents(6, contents, seed, kShape)
                                        : RandomWeights(6, seed, kShape);
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
    reference.Step(features, now.input_style, active, reconstruction, styled, now.content);
    for (Run& run : runs) {
      net::Prediction out;
      run.network->Step(features, now.input_style, now.active, run.state, out, now.content);
      largest = std::max({largest, Difference(out.reconstruction, reconstruction),
                          Difference(out.styled, styled)});
    }
  }
  return largest;
}

}  // namespace styled::erd

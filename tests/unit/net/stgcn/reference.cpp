#include "tests/unit/net/stgcn/reference.h"

#include <cmath>
#include <cstdlib>

#include "model/body/humanoid.h"

namespace styled::stgcn {
namespace {

using Row = std::vector<double>;

Clip Zeros(std::size_t frames, std::size_t nodes, std::size_t channels) {
  return Clip(frames, std::vector<Row>(nodes, Row(channels, 0.0)));
}

template <typename F>
Clip Each(Clip x, F f) {
  for (auto& frame : x) {
    for (Row& node : frame) {
      for (double& value : node) value = f(value);
    }
  }
  return x;
}
Clip PoolTime(const Clip& x) {
  Clip y = Zeros(x.size() / 2, x[0].size(), x[0][0].size());
  for (std::size_t t = 0; t < y.size(); ++t) {
    for (std::size_t v = 0; v < x[0].size(); ++v) {
      for (std::size_t c = 0; c < x[0][0].size(); ++c) {
        y[t][v][c] = (x[2 * t][v][c] + x[2 * t + 1][v][c]) / 2;
      }
    }
  }
  return y;
}

Clip UnpoolTime(const Clip& x) {
  Clip y = Zeros(2 * x.size(), x[0].size(), x[0][0].size());
  for (std::size_t t = 0; t < y.size(); ++t) {
    const double at = static_cast<double>(t) * static_cast<double>(x.size() - 1) /
                      static_cast<double>(y.size() - 1);
    const auto a = static_cast<std::size_t>(at);
    const std::size_t b = std::min(a + 1, x.size() - 1);
    const double share = at - static_cast<double>(a);
    for (std::size_t v = 0; v < x[0].size(); ++v) {
      for (std::size_t c = 0; c < x[0][0].size(); ++c) {
        y[t][v][c] = (1 - share) * x[a][v][c] + share * x[b][v][c];
      }
    }
  }
  return y;
}

// How many bones lie between a node and the centre.
int Distance(int level, int node) {
  const std::span<const int> parents = ParentsOf(level);
  int distance = 0;
  for (; parents[static_cast<std::size_t>(node)] >= 0; ++distance) {
    node = parents[static_cast<std::size_t>(node)];
  }
  return distance;
}

bool Neighbours(int level, int a, int b) {
  const std::span<const int> parents = ParentsOf(level);
  return parents[static_cast<std::size_t>(a)] == b || parents[static_cast<std::size_t>(b)] == a;
}

}  // namespace

Clip Relu(const Clip& x) {
  return Each(x, [](double v) { return v > 0 ? v : 0; });
}
Clip Leaky(const Clip& x) {
  return Each(x, [](double v) { return v > 0 ? v : 0.2 * v; });
}

Clip Sum(const Clip& a, const Clip& b) {  // (a + b) / sqrt 2
  Clip sum = a;
  for (std::size_t t = 0; t < a.size(); ++t) {
    for (std::size_t v = 0; v < a[t].size(); ++v) {
      for (std::size_t c = 0; c < a[t][v].size(); ++c) {
        sum[t][v][c] = (a[t][v][c] + b[t][v][c]) / std::sqrt(2.0);
      }
    }
  }
  return sum;
}

Clip PoolSpace(const Clip& x, int level) {
  const std::span<const int> clusters = ClustersOf(level);
  const auto nodes = static_cast<std::size_t>(kNodes[static_cast<std::size_t>(level) + 1]);
  Clip y = Zeros(x.size(), nodes, x[0][0].size());
  std::vector<double> members(nodes, 0.0);
  for (const int cluster : clusters) members[static_cast<std::size_t>(cluster)] += 1;
  for (std::size_t t = 0; t < x.size(); ++t) {
    for (std::size_t v = 0; v < clusters.size(); ++v) {
      const auto to = static_cast<std::size_t>(clusters[v]);
      for (std::size_t c = 0; c < x[t][v].size(); ++c) y[t][to][c] += x[t][v][c] / members[to];
    }
  }
  return y;
}

Clip UnpoolSpace(const Clip& x, int level) {  // to `level`
  const std::span<const int> clusters = ClustersOf(level);
  Clip y = Zeros(x.size(), clusters.size(), x[0][0].size());
  for (std::size_t t = 0; t < x.size(); ++t) {
    for (std::size_t v = 0; v < clusters.size(); ++v) {
      y[t][v] = x[t][static_cast<std::size_t>(clusters[v])];
    }
  }
  return y;
}

double Reference::Tensor::operator()(std::size_t a, std::size_t b, std::size_t c,
                                     std::size_t d) const {
  const std::array<std::size_t, 4> index{a, b, c, d};
  std::size_t at = 0;
  for (std::size_t i = 0; i < of.shape.size(); ++i) {
    at = at * static_cast<std::size_t>(of.shape[i]) + index[i];
  }
  return static_cast<double>(of.values[at]);
}

std::size_t Reference::Channels(const std::string& name) const {
  return static_cast<std::size_t>(file_.tensor(name).shape[0]);
}

Clip Reference::Linear(const Clip& x, const std::string& name) const {
  const Tensor weight = Get(name + ".weight");
  const std::size_t out = Channels(name + ".weight");
  Clip y = Zeros(x.size(), x[0].size(), out);
  for (std::size_t t = 0; t < x.size(); ++t) {
    for (std::size_t v = 0; v < x[0].size(); ++v) {
      for (std::size_t o = 0; o < out; ++o) {
        for (std::size_t i = 0; i < x[0][0].size(); ++i) y[t][v][o] += weight(o, i) * x[t][v][i];
      }
    }
  }
  return y;
}

// y_i = Σ_k Σ_j A_k[j, i] (W_k x_j + b_k) + node bias, the labels by distances to the centre.
Clip Reference::GraphConvolution(const Clip& x, const std::string& name, int level) const {
  Clip all = Linear(x, name);
  const std::size_t out = Channels(name + ".weight") / 3;
  const int nodes = kNodes[static_cast<std::size_t>(level)];
  const Tensor bias = Get(name + ".bias"), node_bias = Get(name + ".node_bias");
  Clip y = Zeros(x.size(), static_cast<std::size_t>(nodes), out);
  for (int i = 0; i < nodes; ++i) {
    int neighbours = 0;
    for (int j = 0; j < nodes; ++j) neighbours += Neighbours(level, i, j) ? 1 : 0;
    for (int j = 0; j < nodes; ++j) {
      if (j != i && !Neighbours(level, i, j)) continue;
      const int nearer = Distance(level, j) - Distance(level, i);
      const std::size_t k = j == i ? 0 : nearer < 0 ? 1 : 2;
      const double share = 1.0 / (1 + neighbours);
      for (std::size_t t = 0; t < x.size(); ++t) {
        for (std::size_t c = 0; c < out; ++c) {
          y[t][static_cast<std::size_t>(i)][c] +=
              share * (all[t][static_cast<std::size_t>(j)][k * out + c] + bias(k * out + c));
        }
      }
    }
    for (std::size_t t = 0; t < x.size(); ++t) {
      for (std::size_t c = 0; c < out; ++c) {
        y[t][static_cast<std::size_t>(i)][c] += node_bias(static_cast<std::size_t>(i), c);
      }
    }
  }
  return y;
}

Clip Reference::TimeConvolution(const Clip& x, const std::string& name) const {
  const Tensor weight = Get(name + ".weight"), bias = Get(name + ".bias");
  const std::size_t channels = x[0][0].size();
  Clip y = Zeros(x.size(), x[0].size(), channels);
  for (std::size_t t = 0; t < x.size(); ++t) {
    for (std::size_t v = 0; v < x[0].size(); ++v) {
      for (std::size_t o = 0; o < channels; ++o) {
        double sum = bias(o);
        for (std::size_t tap = 0; tap < 3; ++tap) {
          if (t + tap < 1 || t + tap > x.size()) continue;
          for (std::size_t i = 0; i < channels; ++i) {
            sum += weight(o, i, tap) * x[t + tap - 1][v][i];
          }
        }
        y[t][v][o] = sum;
      }
    }
  }
  return y;
}

Clip Reference::Normalized(const Clip& x, const std::vector<double>& scale,
                           const std::vector<double>& shift) const {
  Clip y = x;
  const double count = static_cast<double>(x.size() * x[0].size());
  for (std::size_t c = 0; c < x[0][0].size(); ++c) {
    double mean = 0, variance = 0;
    for (const auto& frame : x) {
      for (const Row& node : frame) mean += node[c] / count;
    }
    for (const auto& frame : x) {
      for (const Row& node : frame) variance += std::pow(node[c] - mean, 2) / count;
    }
    for (auto& frame : y) {
      for (Row& node : frame) {
        node[c] = scale[c] * (node[c] - mean) / std::sqrt(variance + 1e-5) + shift[c];
      }
    }
  }
  return y;
}

Clip Reference::InstanceNorm(const Clip& x, const std::string& name) const {
  std::vector<double> scale, shift;
  for (std::size_t c = 0; c < x[0][0].size(); ++c) {
    scale.push_back(Get(name + ".scale")(c));
    shift.push_back(Get(name + ".shift")(c));
  }
  return Normalized(x, scale, shift);
}

Clip Reference::AdaIn(const Clip& x, const std::string& name, const Code& code) const {
  const Row both = Dense({code.data(), code.data() + kCode}, name);
  const auto channels = static_cast<std::ptrdiff_t>(x[0][0].size());
  Row scale(both.begin(), both.begin() + channels), shift(both.begin() + channels, both.end());
  for (double& value : scale) value += 1;
  return Normalized(x, scale, shift);
}

Clip Reference::Encoder(const Clip& x, const std::string& name, int level, bool norms) const {
  Clip y = norms ? InstanceNorm(x, name + ".norm1") : x;
  y = GraphConvolution(Leaky(y), name + ".gconv1", level);
  y = TimeConvolution(Relu(PoolTime(PoolSpace(y, level))), name + ".tconv1");
  if (norms) y = InstanceNorm(y, name + ".norm2");
  y = GraphConvolution(Leaky(y), name + ".gconv2", level + 1);
  y = TimeConvolution(Relu(y), name + ".tconv2");
  return Sum(y, PoolTime(PoolSpace(Linear(x, name + ".skip"), level)));
}

Clip Reference::Decoder(const Clip& x, const std::string& name, int level, const Code& code) const {
  Clip y = GraphConvolution(Leaky(AdaIn(x, name + ".adain1", code)), name + ".gconv1", level);
  y = TimeConvolution(Relu(UnpoolTime(UnpoolSpace(y, level - 1))), name + ".tconv1");
  y = GraphConvolution(Leaky(AdaIn(y, name + ".adain2", code)), name + ".gconv2", level - 1);
  y = TimeConvolution(Relu(y), name + ".tconv2");
  return Sum(y, Linear(UnpoolTime(UnpoolSpace(x, level - 1)), name + ".skip"));
}

std::vector<double> Reference::Dense(const std::vector<double>& x, const std::string& name) const {
  const Tensor weight = Get(name + ".weight"), bias = Get(name + ".bias");
  Row y(Channels(name + ".weight"));
  for (std::size_t o = 0; o < y.size(); ++o) {
    y[o] = bias(o);
    for (std::size_t i = 0; i < x.size(); ++i) y[o] += weight(o, i) * x[i];
  }
  return y;
}

Clip Reference::Standardized(const std::vector<Features>& clip) const {
  const Tensor mean = Get("features.mean"), deviation = Get("features.deviation");
  Clip x = Zeros(clip.size(), body::kJointCount, kChannels);
  for (std::size_t t = 0; t < clip.size(); ++t) {
    for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
      for (std::size_t c = 0; c < kChannels; ++c) {
        x[t][joint][c] = (static_cast<double>(clip[t][joint * kChannels + c]) - mean(joint, c)) /
                         deviation(joint, c);
      }
    }
  }
  return x;
}

Clip Reference::WithBias(const Clip& x, const std::string& name) const {
  Clip y = Linear(x, name);
  const bool of_nodes = name != "g.out";
  for (auto& frame : y) {
    for (std::size_t v = 0; v < frame.size(); ++v) {
      for (std::size_t c = 0; c < frame[v].size(); ++c) {
        frame[v][c] += Get(name + ".bias")(c);
        if (of_nodes) frame[v][c] += Get(name + ".node_bias")(v, c);
      }
    }
  }
  return y;
}

std::vector<Features> Reference::Generate(const std::vector<Features>& clip,
                                          const Code& code) const {
  std::vector<Features> filled = clip;
  while (filled.size() % 4 != 0) filled.push_back(filled.back());
  Clip x = WithBias(Standardized(filled), "g.in");
  x = Encoder(Encoder(x, "g.enc1", 0, true), "g.enc2", 1, true);
  x = Decoder(Decoder(x, "g.dec1", 2, code), "g.dec2", 1, code);
  x = WithBias(x, "g.out");
  std::vector<Features> out(clip.size());
  const Tensor mean = Get("features.mean"), deviation = Get("features.deviation");
  for (std::size_t t = 0; t < out.size(); ++t) {
    for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
      for (std::size_t c = 0; c < kChannels; ++c) {
        const double value = x[t][joint][c] * deviation(joint, c) + mean(joint, c);
        out[t][joint * kChannels + c] = static_cast<float>(value);
      }
    }
    out[t][0] = out[t][2] = 0;  // the hips' x and z
  }
  return out;
}

Code Reference::EncodeStyle(const std::vector<Features>& clip, int domain) const {
  if (clip.size() != kReference) std::abort();
  Clip x = WithBias(Standardized(clip), "e.in");
  x = Leaky(Encoder(Encoder(x, "e.res1", 0, false), "e.res2", 1, false));
  const Tensor conv = Get("e.conv.weight"), bias = Get("e.conv.bias");
  Row trunk(x[0][0].size());
  for (std::size_t o = 0; o < trunk.size(); ++o) {
    double sum = bias(o);
    for (std::size_t i = 0; i < trunk.size(); ++i) {
      for (std::size_t t = 0; t < 16; ++t) {
        for (std::size_t v = 0; v < 5; ++v) sum += conv(o, i, t, v) * x[t][v][i];
      }
    }
    trunk[o] = sum > 0 ? sum : 0.2 * sum;
  }
  Row code(kCode);
  if (domain == kFreeHead) {
    code = Dense(trunk, "e.free");
  } else {
    const auto y = static_cast<std::size_t>(domain);
    for (std::size_t o = 0; o < code.size(); ++o) {
      code[o] = Get("e.heads.bias")(y, o);
      for (std::size_t i = 0; i < trunk.size(); ++i) {
        code[o] += Get("e.heads.weight")(y, o, i) * trunk[i];
      }
    }
  }
  return Eigen::Map<const Eigen::VectorXd>(code.data(), kCode).cast<float>();
}

Code Reference::MapNoise(const Noise& noise, int domain) const {
  const auto relu = [](Row x) {
    for (double& value : x) value = value > 0 ? value : 0;
    return x;
  };
  Row one_hot(file_.metadata["styles"].size(), 0.0);
  one_hot[static_cast<std::size_t>(domain)] = 1;
  Row both = relu(Dense({noise.data(), noise.data() + kNoise}, "f.noise"));
  const Row label = relu(Dense(one_hot, "f.label"));
  both.insert(both.end(), label.begin(), label.end());
  const Row code = Dense(relu(Dense(relu(Dense(both, "f.fc1")), "f.fc2")), "f.out");
  Code out;
  for (int i = 0; i < kCode; ++i) {
    out[i] = static_cast<float>(std::tanh(code[static_cast<std::size_t>(i)]));
  }
  return out;
}

}  // namespace styled::stgcn

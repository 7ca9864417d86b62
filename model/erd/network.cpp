#include "model/erd/network.h"

#include <algorithm>
#include <cctype>

#include "model/erd/weights.h"

namespace styled::erd {
namespace {

template <int Rows, int Columns>
void Apply(const Affine<Rows, Columns>& affine, const Vector<Columns>& x,
           Vector<Rows>& y) noexcept {
  y = affine.bias;
  y.noalias() += affine.weight * x;
}

// u = (x - mean) / deviation, kept finite.
void Standardize(const body::Features& features, const Vector<body::kFeatureCount>& mean,
                 const Vector<body::kFeatureCount>& deviation,
                 Vector<body::kFeatureCount>& u) noexcept {
  for (int i = 0; i < body::kFeatureCount; ++i) {
    const float x = (features[i] - mean[i]) / deviation[i];
    const float number = x == x ? x : 0.0F;
    u[i] = std::min(std::max(number, -kMaxStandardized), kMaxStandardized);
  }
}

// g = Wi z + Wh h + b;  c' = σ(f) c + σ(i) tanh(g);  h' = σ(o) tanh(c'), layer upon layer; `out` is
// the last h'. The sigmoids' halving is in the weights (weights.h).
template <std::size_t Layers>
void RunBranch(const std::array<LstmLayer, Layers>& layers, const Latent& z, BranchState& state,
               Latent& out) noexcept {
  Vector<2 * kLatent> input;
  input.head<kLatent>() = z;
  for (std::size_t l = 0; l < Layers; ++l) {
    input.tail<kLatent>() = state.h[l];
    Vector<kGates> gates;
    Apply(layers[l].gates, input, gates);
    gates = gates.array().tanh();
    const auto in = 0.5F * gates.segment<kLatent>(0).array() + 0.5F;
    const auto forget = 0.5F * gates.segment<kLatent>(kLatent).array() + 0.5F;
    const auto cell = gates.segment<kLatent>(2 * kLatent).array();
    const auto open = 0.5F * gates.segment<kLatent>(3 * kLatent).array() + 0.5F;
    state.c[l] = forget * state.c[l].array() + in * cell;
    state.h[l] = open * state.c[l].array().tanh();
    input.head<kLatent>() = state.h[l];
  }
  out = input.head<kLatent>();
}

template <std::size_t Layers>
void StartBranch(const std::array<LstmLayer, Layers>& layers, BranchState& state) noexcept {
  for (std::size_t l = 0; l < Layers; ++l) {
    state.h[l] = layers[l].h0;
    state.c[l] = layers[l].c0;
  }
}

// Which styles run in this step, each once. The input's own style rides along with weight 0.
struct Wanted {
  std::array<ActiveStyle, kMaxBranches> entry;
  int count = 0;

  ActiveStyle* Find(int style) noexcept {
    for (int i = 0; i < count; ++i) {
      if (entry[i].style == style) return &entry[i];
    }
    return nullptr;
  }
  void Add(int style, float weight, int limit) noexcept {
    const float clamped = weight > 0 ? std::min(weight, kMaxStrength) : 0.0F;  // NaN: 0
    if (ActiveStyle* known = Find(style)) {
      known->weight = std::min(known->weight + clamped, kMaxStrength);
    } else if (count < limit) {
      entry[count++] = {style, clamped};
    }
  }
};

// Drops the branches that are not wanted.
void DropBranches(Wanted& wanted, State& state) noexcept {
  for (int& style : state.style) {
    if (style >= 0 && wanted.Find(style) == nullptr) style = -1;
  }
}

// The slot of `style`, or -1.
int FindSlot(const State& state, int style) noexcept {
  const auto found = std::find(state.style.begin(), state.style.end(), style);
  return found == state.style.end() ? -1 : static_cast<int>(found - state.style.begin());
}

void ToDecoded(const Vector<kHeads>& heads, Decoded& out) noexcept {
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const Eigen::Vector4f q = heads.segment<4>(4 * joint);
    const float norm = q.norm();
    out.rotations[joint].coeffs() =
        norm > 1e-6F ? Eigen::Vector4f(q / norm) : Eigen::Vector4f(0, 0, 0, 1);
  }
  for (int i = 0; i < body::kVelocityFeatures; ++i) {
    out.velocities_m_s[i] = heads[body::kRotationFeatures + i];
  }
  out.hips_height_m = heads[kHeads - 1];
}

}  // namespace

Network::~Network() = default;

int Network::FindStyle(std::string_view name) const {
  const auto same = [name](std::string_view other) {
    return std::equal(
        name.begin(), name.end(), other.begin(), other.end(),
        [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
  };
  for (int s = 0; s < style_count(); ++s) {
    const StyleInfo& style = metadata_.styles[s];
    if (same(style.name) || std::any_of(style.aliases.begin(), style.aliases.end(), same)) return s;
  }
  return -1;
}

void Network::Start(State& state) const noexcept {
  StartBranch(weights_->neutral, state.neutral);
  state.style.fill(-1);
}

void Network::Step(const body::Features& features, int input_style,
                   std::span<const ActiveStyle> active, State& state,
                   StepOutput& out) const noexcept {
  const Weights& w = *weights_;
  const int style_count = this->style_count();
  const bool styled_input = input_style > 0 && input_style < style_count;
  if (!styled_input) input_style = 0;

  // 1. The branches that are to run.
  Wanted wanted;
  for (const ActiveStyle& style : active) {
    if (style.style > 0 && style.style < style_count) {
      wanted.Add(style.style, style.weight, kMaxActive);
    }
  }
  if (styled_input) wanted.Add(input_style, 0, kMaxBranches);
  DropBranches(wanted, state);

  // 2. z = W1 relu(W0 [u, S] + b0) + b1
  Vector<body::kFeatureCount> u;
  Standardize(features, w.mean, w.deviation, u);
  Vector<kEncoderWidth> e;
  Apply(w.encoder0, u, e);
  e = (e + w.encoder0_style.col(input_style)).cwiseMax(0.0F);
  Latent z;
  Apply(w.encoder1, e, z);

  // 3. z' = r_0(z) + Σ_s α_s r_s(z), and Ŝ's share of the decoder's first layer.
  Latent neutral;
  RunBranch(w.neutral, z, state.neutral, neutral);
  Latent reconstructed = neutral;
  Latent styled = neutral;
  Vector<kDecoderWidths[0]> target = Vector<kDecoderWidths[0]>::Zero();
  float sum = 0;
  for (int i = 0; i < wanted.count; ++i) {
    const ActiveStyle& style = wanted.entry[i];
    int slot = FindSlot(state, style.style);
    if (slot < 0) {
      slot = FindSlot(state, -1);
      state.style[slot] = style.style;
      StartBranch(w.styles[style.style - 1], state.branch[slot]);
    }
    Latent residual;
    RunBranch(w.styles[style.style - 1], z, state.branch[slot], residual);
    styled += style.weight * residual;
    if (style.style == input_style) reconstructed += residual;
    target += style.weight * w.decoder0_style.col(style.style);
    sum += style.weight;
  }
  target += std::max(0.0F, 1.0F - sum) * w.decoder0_style.col(0);
  if (sum > 1.0F) target /= sum;

  // 4. d = relu(D2 relu(D1 relu(D0 [z', Ŝ]))), then the heads, back from standardized.
  const auto decode = [&w](const Latent& latent, const Vector<kDecoderWidths[0]>& style_part,
                           Decoded& decoded) noexcept {
    Vector<kDecoderWidths[0]> d0;
    Apply(w.decoder0, latent, d0);
    d0 = (d0 + style_part).cwiseMax(0.0F);
    Vector<kDecoderWidths[1]> d1;
    Apply(w.decoder1, d0, d1);
    d1 = d1.cwiseMax(0.0F);
    Vector<kDecoderWidths[2]> d2;
    Apply(w.decoder2, d1, d2);
    d2 = d2.cwiseMax(0.0F);
    Vector<kHeads> heads;
    Apply(w.heads, d2, heads);
    heads = heads.cwiseProduct(w.heads_deviation) + w.heads_mean;
    ToDecoded(heads, decoded);
  };
  decode(reconstructed, w.decoder0_style.col(input_style), out.reconstruction);
  if (wanted.count == 0) {
    out.styled = out.reconstruction;
  } else {
    decode(styled, target, out.styled);
  }
}

}  // namespace styled::erd

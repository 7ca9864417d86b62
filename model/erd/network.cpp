#include "model/erd/network.h"

#include <algorithm>
#include <cctype>

#include "model/erd/weights.h"

namespace styled::erd {
namespace {

template <int Rows, int Columns>
void Apply(const Kernels& kernels, const PackedMatrix<Rows, Columns>& weight,
           std::span<const Operands> inputs, bool relu) noexcept {
  kernels.affine(weight.data(), PaddedRows(Rows) / kPanelRows, Columns, inputs, relu);
}

// Layer upon layer; gives the last h'.
template <std::size_t Layers>
const float* RunBranch(const Kernels& kernels, const std::array<LstmLayer, Layers>& layers,
                       const float* z, BranchState& state) noexcept {
  for (std::size_t l = 0; l < Layers; ++l) {
    float* const h = state.h[l].data();
    kernels.lstm(layers[l].weight.data(), layers[l].bias.data(), z, h, state.c[l].data());
    z = h;
  }
  return z;
}

template <std::size_t Layers>
void StartBranch(const std::array<LstmLayer, Layers>& layers, BranchState& state) noexcept {
  for (std::size_t l = 0; l < Layers; ++l) {
    std::copy(layers[l].h0.begin(), layers[l].h0.end(), state.h[l].data());
    std::copy(layers[l].c0.begin(), layers[l].c0.end(), state.c[l].data());
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

// The decoder's way from one latent to the heads.
struct Decoding {
  PackedVector<kLatent> latent;
  const float* style_bias;  // of the first layer
  PackedVector<kDecoderWidths[0]> d0;
  PackedVector<kDecoderWidths[1]> d1;
  PackedVector<kDecoderWidths[2]> d2;
  PackedVector<kHeads> heads;
};

// One layer for one or two latents. No `bias`: each latent's own.
template <int Rows, int Columns>
void Decode(const Kernels& kernels, const PackedMatrix<Rows, Columns>& weight, const float* bias,
            PackedVector<Columns> Decoding::*from, PackedVector<Rows> Decoding::*to, bool relu,
            std::span<Decoding> decodings) noexcept {
  std::array<Operands, 2> operands;
  for (std::size_t i = 0; i < decodings.size(); ++i) {
    Decoding& decoding = decodings[i];
    operands[i] = {bias != nullptr ? bias : decoding.style_bias, (decoding.*from).data(),
                   (decoding.*to).data()};
  }
  Apply(kernels, weight, std::span(operands).first(decodings.size()), relu);
}

// y += factor x
template <int Rows>
void AddTo(PackedVector<Rows>& y, float factor, const float* x) noexcept {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
}

void ToDecoded(const Kernels& kernels, const PackedVector<kHeads>& heads, Decoded& out) noexcept {
  static_assert(sizeof(out.rotations) == body::kRotationFeatures * sizeof(float));
  kernels.normalize(heads.data(), body::kJointCount, out.rotations[0].coeffs().data());
  const float* const velocities = heads.data() + body::kRotationFeatures;
  std::copy_n(velocities, body::kVelocityFeatures, out.velocities_m_s.begin());
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
  const Kernels& kernels = *w.kernels;
  PackedVector<body::kFeatureCount> u;
  PackedVector<kEncoderWidth> e;
  PackedVector<kLatent> z;
  kernels.standardize(features.data(), w.mean.data(), w.inverse_deviation.data(),
                      body::kFeatureCount, kMaxStandardized, u.data());
  Apply(kernels, w.encoder0, {{{w.encoder0_bias[input_style].data(), u.data(), e.data()}}}, true);
  Apply(kernels, w.encoder1.weight, {{{w.encoder1.bias.data(), e.data(), z.data()}}}, false);

  // 3. z' = r_0(z) + Σ_s α_s r_s(z), and Ŝ's share of the decoder's first layer.
  std::array<Decoding, 2> decodings;
  Decoding& reconstruction = decodings[0];
  Decoding& styled = decodings[1];
  const float* const neutral = RunBranch(kernels, w.neutral, z.data(), state.neutral);
  std::copy_n(neutral, kLatent, reconstruction.latent.begin());
  std::copy_n(neutral, kLatent, styled.latent.begin());
  reconstruction.style_bias = w.decoder0_bias[input_style].data();
  PackedVector<kDecoderWidths[0]> target;
  styled.style_bias = target.data();
  target.fill(0);
  float sum = 0;
  for (int i = 0; i < wanted.count; ++i) {
    const ActiveStyle& style = wanted.entry[i];
    int slot = FindSlot(state, style.style);
    if (slot < 0) {
      slot = FindSlot(state, -1);
      state.style[slot] = style.style;
      StartBranch(w.styles[style.style - 1], state.branch[slot]);
    }
    const float* const residual =
        RunBranch(kernels, w.styles[style.style - 1], z.data(), state.branch[slot]);
    AddTo(styled.latent, style.weight, residual);
    if (style.style == input_style) AddTo(reconstruction.latent, 1, residual);
    AddTo(target, style.weight, w.decoder0_bias[style.style].data());
    sum += style.weight;
  }
  AddTo(target, std::max(0.0F, 1.0F - sum), w.decoder0_bias[0].data());
  if (sum > 1.0F) {
    for (float& value : target) value /= sum;
  }

  // 4. d = relu(D2 relu(D1 relu(D0 [z', Ŝ]))), then the heads; both latents at once.
  const std::span latents = std::span(decodings).first(wanted.count == 0 ? 1 : 2);
  using D = Decoding;
  Decode(kernels, w.decoder0, nullptr, &D::latent, &D::d0, true, latents);
  Decode(kernels, w.decoder1.weight, w.decoder1.bias.data(), &D::d0, &D::d1, true, latents);
  Decode(kernels, w.decoder2.weight, w.decoder2.bias.data(), &D::d1, &D::d2, true, latents);
  Decode(kernels, w.heads.weight, w.heads.bias.data(), &D::d2, &D::heads, false, latents);
  ToDecoded(kernels, reconstruction.heads, out.reconstruction);
  if (wanted.count == 0) {
    out.styled = out.reconstruction;
  } else {
    ToDecoded(kernels, styled.heads, out.styled);
  }
}

}  // namespace styled::erd

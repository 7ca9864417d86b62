#include "model/net/erd/network.h"

#include <algorithm>
#include <bitset>

#include "model/net/erd/content.h"
#include "model/net/erd/weights.h"

namespace styled::erd {
namespace {

using net::Decoded;
using net::kMaxActive;
using net::kMaxStrength;
using net::kMaxStyles;
using net::LstmOperands;
using net::Operands;
using net::Prediction;
using net::StyleWeight;

template <Shape kShape, std::size_t Layers>
void StartBranch(const std::array<LstmLayer<kShape.latent>, Layers>& layers,
                 BranchStateOf<kShape>& state) noexcept {
  for (std::size_t l = 0; l < Layers; ++l) {
    std::copy(layers[l].h0.begin(), layers[l].h0.end(), state.h[l].data());
    std::copy(layers[l].c0.begin(), layers[l].c0.end(), state.c[l].data());
  }
}

// The styles that run in this step, each once. The input style's branch runs with weight 0.
struct Wanted {
  std::array<StyleWeight, kMaxBranches> entry;
  int count = 0;

  StyleWeight* Find(int style) noexcept {
    for (int i = 0; i < count; ++i) {
      if (entry[i].style == style) return &entry[i];
    }
    return nullptr;
  }
  void Add(int style, float weight, int limit) noexcept {
    const float clamped = weight > 0 ? std::min(weight, kMaxStrength) : 0.0F;  // also for NaN
    if (StyleWeight* known = Find(style)) {
      known->weight = std::min(known->weight + clamped, kMaxStrength);
    } else if (count < limit) {
      entry[count++] = {style, clamped};
    }
  }
};

// Drops the branches that this step does not use.
template <Shape kShape>
void DropBranches(Wanted& wanted, StateOf<kShape>& state) noexcept {
  for (int& style : state.style) {
    if (style >= 0 && wanted.Find(style) == nullptr) style = -1;
  }
}

// The slot of `style`, or -1.
template <Shape kShape>
int FindSlot(const StateOf<kShape>& state, int style) noexcept {
  const auto found = std::find(state.style.begin(), state.style.end(), style);
  return found == state.style.end() ? -1 : static_cast<int>(found - state.style.begin());
}

// Brings a branch's state into the second-level cache, while the encoder runs: a crowd's states are
// larger than the caches.
template <Shape kShape>
void Prefetch(const BranchStateOf<kShape>& state, std::size_t layers) noexcept {
  constexpr std::size_t kFloats = 16;  // of a cache line
  for (std::size_t layer = 0; layer < layers; ++layer) {
    for (std::size_t unit = 0; unit < kShape.latent; unit += kFloats) {
      __builtin_prefetch(state.h[layer].data() + unit, 1, 2);
      __builtin_prefetch(state.c[layer].data() + unit, 1, 2);
    }
  }
}

// The decoder's intermediate results from one latent to the heads.
template <Shape kShape>
struct Decoding {
  PackedVector<kShape.latent> latent;
  const float* style_bias;  // of the first layer
  PackedVector<kShape.decoder[0]> d0;
  PackedVector<kShape.decoder[1]> d1;
  PackedVector<kShape.decoder[2]> d2;
  PackedVector<kHeads> heads;
};

// One performer's intermediate results.
template <Shape kShape>
struct Scratch {
  Wanted wanted;
  int input_style = 0;
  std::array<int, kMaxBranches> slot;  // of each wanted style's branch, in the state
  PackedVector<kFeatureCount> u;
  PackedVector<kShape.encoder> content_bias;  // the encoder's first, with the content's part
  PackedVector<kShape.encoder> e;
  PackedVector<kShape.latent> z;
  Decoding<kShape> reconstruction, styled;
  PackedVector<kShape.decoder[0]> target;
};

// Runs the layers of one branch for all performers that use it.
template <Shape kShape, std::size_t Most>
struct BranchRun {
  std::array<LstmOperands, Most> operands;
  std::array<BranchStateOf<kShape>*, Most> states;
  std::size_t count = 0;

  void Add(const float* z, BranchStateOf<kShape>& state) noexcept {
    operands[count].z = z;
    states[count++] = &state;
  }
  // Leaves the result, the last layer's h, in each state.
  template <std::size_t Layers>
  void Run(const Kernels& kernels,
           const std::array<LstmLayer<kShape.latent>, Layers>& layers) noexcept {
    for (std::size_t l = 0; l < Layers; ++l) {
      for (std::size_t i = 0; i < count; ++i) {
        operands[i].h = states[i]->h[l].data();
        operands[i].c = states[i]->c[l].data();
      }
      kernels.lstm(kShape.latent, layers[l].weight.data(), layers[l].bias.data(),
                   std::span(operands).first(count));
      for (std::size_t i = 0; i < count; ++i) operands[i].z = operands[i].h;
    }
  }
};

// Computes one layer for all latents. Without `bias`, each latent uses its own style bias.
template <std::size_t Most, Shape kShape, int Rows, int Columns>
void Decode(const Kernels& kernels, const PackedMatrix<Rows, Columns>& weight, const float* bias,
            PackedVector<Columns> Decoding<kShape>::*from, PackedVector<Rows> Decoding<kShape>::*to,
            bool relu, std::span<Decoding<kShape>* const> decodings) noexcept {
  std::array<Operands, Most> operands;
  for (std::size_t i = 0; i < decodings.size(); ++i) {
    Decoding<kShape>& decoding = *decodings[i];
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

// z = W1 relu(W0 [u, S, c] + b0) + b1. As in all steps, one call serves all performers, so that
// each weight is read from memory once. The label S is constant per style and therefore part of the
// bias, and so is the content c of a network that takes one.
template <Shape kShape, std::size_t Most>
void Encode(const auto& w, std::span<const StepJobOf<kShape>> jobs,
            std::array<Scratch<kShape>, Most>& scratch) noexcept {
  const Kernels& kernels = *w.kernels;
  const std::size_t count = jobs.size();
  std::array<Operands, Most> operands;
  for (std::size_t k = 0; k < count; ++k) {
    Scratch<kShape>& own = scratch[k];
    kernels.standardize(jobs[k].features->data(), w.mean.data(), w.inverse_deviation.data(),
                        kFeatureCount, kMaxStandardized, own.u.data());
    operands[k] = {w.encoder0_bias[own.input_style].data(), own.u.data(), own.e.data()};
  }
  if (w.contents) {
    std::array<ContentJob<kShape>, Most> contents;
    for (std::size_t k = 0; k < count; ++k) {
      contents[k] = {scratch[k].u.data(), jobs[k].content, jobs[k].state, operands[k].bias,
                     &scratch[k].content_bias};
      operands[k].bias = scratch[k].content_bias.data();
    }
    AddContents<kShape>(kernels, *w.contents, std::span(contents).first(count));
  }
  Apply(kernels, w.encoder0, std::span(operands).first(count), true);
  for (std::size_t k = 0; k < count; ++k) {
    operands[k] = {w.encoder1.bias.data(), scratch[k].e.data(), scratch[k].z.data()};
  }
  Apply(kernels, w.encoder1.weight, std::span(operands).first(count), false);
}

void ToDecoded(const Kernels& kernels, const PackedVector<kHeads>& heads, Decoded& out) noexcept {
  static_assert(sizeof(out.rotations) == kRotationFeatures * sizeof(float));
  kernels.normalize(heads.data(), body::kJointCount, out.rotations[0].coeffs().data());
  const float* const velocities = heads.data() + kRotationFeatures;
  std::copy_n(velocities, kVelocityFeatures, out.velocities_m_s.begin());
  out.hips_height_m = heads[kHeads - 1];
}

}  // namespace

template <Shape kShape>
ShapedNetwork<kShape>::~ShapedNetwork() = default;

template <Shape kShape>
void ShapedNetwork<kShape>::Start(State& state) const noexcept {
  StartBranch<kShape>(weights_->neutral, state.neutral);
  state.style.fill(-1);
  if (weights_->contents) StartRecognizer(*weights_->contents, state.recognizer);
}

template <Shape kShape>
void ShapedNetwork<kShape>::Recognized(const State& state, std::span<float> shares) const noexcept {
  if (!weights_->contents) return;
  erd::Recognized(*weights_->kernels, *weights_->contents, state.recognizer, shares);
}

template <Shape kShape>
void ShapedNetwork<kShape>::Step(const Features& features, int input_style,
                                 std::span<const StyleWeight> active, State& state, Prediction& out,
                                 int content) const noexcept {
  const StepJob job{&features, input_style, active, &state, &out, content};
  StepSome<1>({&job, 1});
}

template <Shape kShape>
void ShapedNetwork<kShape>::StepTogether(std::span<const StepJob> jobs) const noexcept {
  if (jobs.size() == 1) return StepSome<1>(jobs);
  while (!jobs.empty()) {
    const std::size_t count = std::min(jobs.size(), net::kTogether);
    StepSome<net::kTogether>(jobs.first(count));
    jobs = jobs.subspan(count);
  }
}

template <Shape kShape>
template <std::size_t Most>
void ShapedNetwork<kShape>::StepSome(std::span<const StepJob> jobs) const noexcept {
  const Weights& w = *weights_;
  const Kernels& kernels = *w.kernels;
  const int style_count = this->style_count();
  const std::size_t count = jobs.size();
  std::array<Scratch<kShape>, Most> scratch;

  // 1. Find the branches to run. Unused branches are dropped first, so that each new one finds a
  // free slot; it starts from its learned state.
  for (std::size_t k = 0; k < count; ++k) {
    const StepJob& job = jobs[k];
    Scratch<kShape>& own = scratch[k];
    own.input_style = job.input_style > 0 && job.input_style < style_count ? job.input_style : 0;
    for (const StyleWeight& style : job.active) {
      if (style.style > 0 && style.style < style_count) {
        own.wanted.Add(style.style, style.weight, kMaxActive);
      }
    }
    if (own.input_style > 0) own.wanted.Add(own.input_style, 0, kMaxBranches);
    Prefetch<kShape>(job.state->neutral, kNeutralLayers);
    DropBranches(own.wanted, *job.state);
    for (int i = 0; i < own.wanted.count; ++i) {
      const int style = own.wanted.entry[i].style;
      int slot = FindSlot(*job.state, style);
      if (slot < 0) {
        slot = FindSlot(*job.state, -1);
        job.state->style[slot] = style;
        StartBranch<kShape>(w.styles[style - 1], job.state->branch[slot]);
      }
      own.slot[i] = slot;
      Prefetch<kShape>(job.state->branch[slot], kStyleLayers);
    }
  }

  // 2. Encode.
  Encode<kShape, Most>(w, jobs, scratch);

  // 3. Run the recurrent branches: z' = r_0(z) + Σ_s α_s r_s(z). Branches run style by style,
  // because performers in the same style share its weights. The reconstruction adds only the input
  // style's residual, in full. The target style Ŝ is a mixture, so its part of the decoder's first
  // layer is a mixture of biases.
  BranchRun<kShape, Most> neutral;
  for (std::size_t k = 0; k < count; ++k) neutral.Add(scratch[k].z.data(), jobs[k].state->neutral);
  neutral.Run(kernels, w.neutral);
  std::bitset<kMaxStyles> styles;
  for (std::size_t k = 0; k < count; ++k) {
    for (int i = 0; i < scratch[k].wanted.count; ++i) styles.set(scratch[k].wanted.entry[i].style);
  }
  for (int style = 1; style < style_count; ++style) {
    if (!styles.test(style)) continue;
    BranchRun<kShape, Most> run;
    for (std::size_t k = 0; k < count; ++k) {
      const int slot = FindSlot(*jobs[k].state, style);
      if (slot >= 0) run.Add(scratch[k].z.data(), jobs[k].state->branch[slot]);
    }
    run.Run(kernels, w.styles[style - 1]);
  }
  std::array<Decoding<kShape>*, 2 * Most> latents;
  std::size_t latent_count = 0;
  for (std::size_t k = 0; k < count; ++k) {
    Scratch<kShape>& own = scratch[k];
    const State& state = *jobs[k].state;
    const float* const of_neutral = state.neutral.h[kNeutralLayers - 1].data();
    std::copy_n(of_neutral, kShape.latent, own.reconstruction.latent.begin());
    std::copy_n(of_neutral, kShape.latent, own.styled.latent.begin());
    own.reconstruction.style_bias = w.decoder0_bias[own.input_style].data();
    own.styled.style_bias = own.target.data();
    own.target.fill(0);
    float sum = 0;
    for (int i = 0; i < own.wanted.count; ++i) {
      const StyleWeight& style = own.wanted.entry[i];
      const float* const residual = state.branch[own.slot[i]].h[kStyleLayers - 1].data();
      AddTo(own.styled.latent, style.weight, residual);
      if (style.style == own.input_style) AddTo(own.reconstruction.latent, 1, residual);
      AddTo(own.target, style.weight, w.decoder0_bias[style.style].data());
      sum += style.weight;
    }
    // Neutral has the weight that the styles leave to 1; a sum above 1 is normalized.
    AddTo(own.target, std::max(0.0F, 1.0F - sum), w.decoder0_bias[0].data());
    if (sum > 1.0F) {
      for (float& value : own.target) value /= sum;
    }
    latents[latent_count++] = &own.reconstruction;
    if (own.wanted.count > 0) latents[latent_count++] = &own.styled;
  }

  // 4. Decode: d = relu(D2 relu(D1 relu(D0 [z', Ŝ]))), then the heads, for all latents in one call
  // per layer. Without a style the styled pose is the reconstruction, so that one latent suffices.
  const auto decodings = std::span<Decoding<kShape>* const>(latents).first(latent_count);
  using D = Decoding<kShape>;
  Decode<2 * Most, kShape>(kernels, w.decoder0, nullptr, &D::latent, &D::d0, true, decodings);
  Decode<2 * Most, kShape>(kernels, w.decoder1.weight, w.decoder1.bias.data(), &D::d0, &D::d1, true,
                           decodings);
  Decode<2 * Most, kShape>(kernels, w.decoder2.weight, w.decoder2.bias.data(), &D::d1, &D::d2, true,
                           decodings);
  Decode<2 * Most, kShape>(kernels, w.heads.weight, w.heads.bias.data(), &D::d2, &D::heads, false,
                           decodings);
  for (std::size_t k = 0; k < count; ++k) {
    Prediction& out = *jobs[k].out;
    ToDecoded(kernels, scratch[k].reconstruction.heads, out.reconstruction);
    if (scratch[k].wanted.count == 0) {
      out.styled = out.reconstruction;
    } else {
      ToDecoded(kernels, scratch[k].styled.heads, out.styled);
    }
  }
}

template class ShapedNetwork<kPaper>;
template class ShapedNetwork<kWide>;

}  // namespace styled::erd

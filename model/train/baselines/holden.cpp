#include <Eigen/Core>
#include <cstdio>

#include "model/train/baselines/baseline.h"

namespace styled::train::baselines {
namespace {

using st_gcn::kWindowFrames;
using stgcn::kFeatureCount;
using torch::Tensor;
namespace nn = torch::nn;

constexpr long kHidden = 256, kKernel = 25;  // as in the paper
constexpr double kDropout = 0.25;            // of the input, in training
constexpr double kSparsity = 0.01;           // weight of the hidden units' mean absolute value
constexpr double kRate = 5e-4;
// The descent of the hidden units: steps of Adam, and their size over the units' deviation.
constexpr int kSteps = 100;
constexpr float kStep = 0.05F, kBeta1 = 0.9F, kBeta2 = 0.99F;

using Hidden = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;  // [256, n]

// One layer: convolution, ReLU, and the larger of each two frames; its inverse repeats frames.
struct AutoEncoderImpl : nn::Module {
  AutoEncoderImpl()
      : encoder(
            register_module("encoder", nn::Conv1d(nn::Conv1dOptions(kFeatureCount, kHidden, kKernel)
                                                      .padding(kKernel / 2)
                                                      .padding_mode(torch::kReplicate)))),
        decoder(
            register_module("decoder", nn::Conv1d(nn::Conv1dOptions(kHidden, kFeatureCount, kKernel)
                                                      .padding(kKernel / 2)
                                                      .padding_mode(torch::kReplicate)))) {}
  Tensor Encode(const Tensor& x) { return torch::max_pool1d(torch::relu(encoder(x)), 2); }
  Tensor Decode(const Tensor& h) { return decoder(torch::repeat_interleave(h, 2, 2)); }
  nn::Conv1d encoder, decoder;
};
TORCH_MODULE(AutoEncoder);

Hidden GramOf(const Hidden& hidden) {
  return hidden * hidden.transpose() / static_cast<float>(hidden.cols());
}

// Moves the hidden units of a clip towards a Gram matrix: Adam on
//   |H - C|² / |C|² + weight |G(H) - G|² / |G|², from H = C.
Hidden Descend(const Hidden& content, const Hidden& gram, float weight) {
  const float scale = std::sqrt(content.array().square().mean());
  if (!(scale > 0)) return content;
  const float of_content = 2 / content.squaredNorm();
  const float of_gram =
      4 * weight / (static_cast<float>(content.cols()) * std::max(1e-12F, gram.squaredNorm()));
  Hidden h = content;
  Hidden first = Hidden::Zero(h.rows(), h.cols());
  Hidden second = first;
  float decay1 = 1;
  float decay2 = 1;
  for (int i = 0; i < kSteps; ++i) {
    const Hidden error = GramOf(h) - gram;
    Hidden gradient = of_content * (h - content);
    gradient.noalias() += of_gram * (error * h);
    first = kBeta1 * first + (1 - kBeta1) * gradient;
    second.array() = kBeta2 * second.array() + (1 - kBeta2) * gradient.array().square();
    decay1 *= kBeta1;
    decay2 *= kBeta2;
    const float rate = kStep * scale * (1 - static_cast<float>(i) / kSteps);
    h.array() -=
        rate * (first.array() / (1 - decay1)) / ((second.array() / (1 - decay2)).sqrt() + 1e-12F);
  }
  return h;
}

class Holden final : public Baseline {
 public:
  Holden(const Material& material, double style_weight, std::uint64_t seed)
      : Baseline(material, seed), style_weight_(static_cast<float>(style_weight)) {}

  Tensor CodeOf(const Tensor& clip) const override {
    const Hidden gram = GramOf(HiddenOf(clip));
    return torch::from_blob(const_cast<float*>(gram.data()), {gram.size()}).clone();
  }
  Tensor Styled(const Tensor& clip, const Tensor& code) const override {
    const Tensor flat = code.contiguous();
    const Hidden gram = Eigen::Map<const Hidden>(flat.data_ptr<float>(), kHidden, kHidden);
    Hidden h = Descend(HiddenOf(clip), gram, style_weight_);
    const Tensor hidden = torch::from_blob(h.data(), {1, h.rows(), h.cols()}).clone();
    return net_->Decode(hidden).squeeze(0);
  }
  Tensor Own(const Tensor& clip) const override {
    return net_->Decode(net_->Encode(clip.unsqueeze(0))).squeeze(0);
  }

 protected:
  nn::Module& networks() override { return *net_; }
  void Train(const Budget& budget) override;

 private:
  Hidden HiddenOf(const Tensor& clip) const {
    const Tensor hidden = net_->Encode(clip.unsqueeze(0)).squeeze(0).contiguous();
    return Eigen::Map<const Hidden>(hidden.data_ptr<float>(), hidden.size(0), hidden.size(1));
  }

  const float style_weight_;
  mutable AutoEncoder net_;
};

void Holden::Train(const Budget& budget) {
  st_gcn::Sampler sampler(material_.store,
                          {.domains = static_cast<int>(material_.model.styles.size()),
                           .contents = material_.contents,
                           .seed = seed_});
  torch::optim::Adam adam(net_->parameters(), torch::optim::AdamOptions(kRate));
  Tensor error;
  Tensor sparsity;
  const auto step = [&](double progress) {
    for (auto& group : adam.param_groups()) {
      static_cast<torch::optim::AdamOptions&>(group.options()).lr(kRate * (1 - 0.9 * progress));
    }
    std::vector<st_gcn::Window> windows;
    for (const st_gcn::Sample& sample : sampler.Next(budget.batch)) {
      windows.push_back(sample.source);
    }
    const Tensor x =
        material_.store.Read(windows).view({-1, kWindowFrames, kFeatureCount}).transpose(1, 2);
    const Tensor hidden = net_->Encode(torch::dropout(x, kDropout, true));
    error = (net_->Decode(hidden) - x).square().mean();
    sparsity = hidden.abs().mean();
    adam.zero_grad();
    (error + kSparsity * sparsity).backward();
    adam.step();
  };
  const auto state = [&] {
    char text[64];
    std::snprintf(text, sizeof text, "error %.4f, sparsity %.3f", error.item<double>(),
                  sparsity.item<double>());
    return std::string(text);
  };
  Iterate(budget, step, state);
}

}  // namespace

double HoldenMacs() {
  const double frames = kWindowFrames;
  const double layers = 2 * frames * kKernel * kFeatureCount * kHidden;
  const double step = 2 * frames / 2 * kHidden * kHidden;  // the Gram matrix and its gradient
  return layers + kSteps * step;
}

std::unique_ptr<Baseline> MakeHolden(const Material& material, double style_weight,
                                     std::uint64_t seed) {
  return std::make_unique<Holden>(material, style_weight, seed);
}

}  // namespace styled::train::baselines

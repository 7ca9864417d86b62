#include <random>

#include "model/train/baselines/baseline.h"

namespace styled::train::baselines {
namespace {

using st_gcn::kWindowFrames;
using st_gcn::Window;
using stgcn::kFeatureCount;
using torch::Tensor;
namespace nn = torch::nn;
namespace functional = torch::nn::functional;

constexpr long kCode = 64;
constexpr double kSlope = 0.2;  // of the leaky ReLU
// Weights of the losses. Content consistency is an L1 over standardized features.
constexpr double kContent = 10, kAdversarial = 1, kTriplet = 0.3, kPenalty = 1;
constexpr double kMargin = 1;  // of the triplet loss
constexpr int kPenaltyEvery = 4;
constexpr double kMapRate = 4e-4, kCriticRate = 2e-4;

nn::Conv1d Conv(long in, long out, long kernel, long stride) {
  return nn::Conv1d(nn::Conv1dOptions(in, out, kernel)
                        .stride(stride)
                        .padding((kernel - stride + 1) / 2)
                        .padding_mode(torch::kReplicate));
}

Tensor Leaky(const Tensor& x) { return torch::leaky_relu(x, kSlope); }

// Norm of each sample and channel over time, then an affine function of the code.
struct AdainImpl : nn::Module {
  explicit AdainImpl(long channels)
      : affine(register_module("affine", nn::Linear(kCode, 2 * channels))) {}
  Tensor forward(const Tensor& x, const Tensor& code) {
    const std::vector<Tensor> scale_shift = affine(code).unsqueeze(2).chunk(2, 1);
    return (1 + scale_shift[0]) * torch::instance_norm(x, {}, {}, {}, {}, true, 0, 1e-5, false) +
           scale_shift[1];
  }
  nn::Linear affine;
};
TORCH_MODULE(Adain);

struct GeneratorImpl : nn::Module {
  explicit GeneratorImpl(long c)
      : in1(register_module("in1", Conv(kFeatureCount, c, 8, 2))),
        in2(register_module("in2", Conv(c, 2 * c, 8, 2))),
        content1(register_module("content1", Conv(2 * c, 2 * c, 3, 1))),
        content2(register_module("content2", Conv(2 * c, 2 * c, 3, 1))),
        style1(register_module("style1", Conv(2 * c, 2 * c, 3, 1))),
        style2(register_module("style2", Conv(2 * c, 2 * c, 3, 1))),
        out1(register_module("out1", Conv(2 * c, c, 7, 1))),
        out2(register_module("out2", Conv(c, kFeatureCount, 7, 1))),
        adain1(register_module("adain1", Adain(2 * c))),
        adain2(register_module("adain2", Adain(2 * c))),
        adain3(register_module("adain3", Adain(c))) {}

  // [B, 147, T] to [B, 2c, T/4]: the content, without its style.
  Tensor Encode(const Tensor& x) {
    const auto norm = [](const Tensor& y) {
      return torch::instance_norm(y, {}, {}, {}, {}, true, 0, 1e-5, false);
    };
    const Tensor y = Leaky(norm(in2(Leaky(norm(in1(x))))));
    return y + norm(content2(Leaky(norm(content1(y)))));
  }
  Tensor Decode(const Tensor& content, const Tensor& code) {
    Tensor y = content + adain2(style2(Leaky(adain1(style1(content), code))), code);
    y = Leaky(adain3(out1(torch::repeat_interleave(y, 2, 2)), code));
    return out2(torch::repeat_interleave(y, 2, 2));
  }

  nn::Conv1d in1, in2, content1, content2, style1, style2, out1, out2;
  Adain adain1, adain2, adain3;
};
TORCH_MODULE(Generator);

// Style encoder and critic: [B, 147, T] to [B, 2c], and a last layer.
struct TrunkImpl : nn::Module {
  TrunkImpl(long c, long out)
      : conv1(register_module("conv1", Conv(kFeatureCount, c, 8, 2))),
        conv2(register_module("conv2", Conv(c, 2 * c, 8, 2))),
        conv3(register_module("conv3", Conv(2 * c, 2 * c, 3, 1))),
        head(register_module("head", nn::Linear(2 * c, out))) {}
  Tensor forward(const Tensor& x) {
    return head(Leaky(conv3(Leaky(conv2(Leaky(conv1(x)))))).mean(2));
  }
  nn::Conv1d conv1, conv2, conv3;
  nn::Linear head;
};
TORCH_MODULE(Trunk);

struct NetworksImpl : nn::Module {
  NetworksImpl(long c, long styles)
      : generator(register_module("generator", Generator(c))),
        encoder(register_module("encoder", Trunk(c, kCode))),
        critic(register_module("critic", Trunk(c, styles))) {}
  Generator generator;
  Trunk encoder, critic;
};
TORCH_MODULE(Networks);

// The logit of each sample's own style.
Tensor Of(const Tensor& logits, const Tensor& style) {
  return logits.gather(1, style.unsqueeze(1)).squeeze(1);
}

class Aberman final : public Baseline {
 public:
  Aberman(const Material& material, int channels, std::uint64_t seed)
      : Baseline(material, seed),
        nets_(channels, static_cast<long>(material.model.styles.size())) {}

  Tensor CodeOf(const Tensor& clip) const override {
    return nets_->encoder(clip.unsqueeze(0)).flatten();
  }
  Tensor Styled(const Tensor& clip, const Tensor& code) const override {
    return nets_->generator->Decode(nets_->generator->Encode(clip.unsqueeze(0)), code.unsqueeze(0))
        .squeeze(0);
  }
  Tensor Own(const Tensor& clip) const override { return Styled(clip, CodeOf(clip)); }

 protected:
  nn::Module& networks() override { return *nets_; }
  void Train(const Budget& budget) override;

 private:
  mutable Networks nets_;
};

// Windows of the samples of a batch, [B, 147, 64].
struct Batch {
  Tensor source, like_source;     // another clip of the source's style
  Tensor reference1, reference2;  // of the target
  Tensor style, target;
};

class Batches {
 public:
  Batches(const Material& material, std::uint64_t seed)
      : store_(material.store),
        sampler_(material.store, {.domains = static_cast<int>(material.model.styles.size()),
                                  .contents = material.contents,
                                  .seed = seed}),
        random_(seed),
        clips_(material.model.styles.size()) {
    for (int clip = 0; clip < store_.clips(); ++clip) {
      clips_[static_cast<std::size_t>(store_.StyleOf(clip))].push_back(clip);
    }
  }

  Batch Next(int count) {
    std::vector<Window> source, like, first, second;
    std::vector<int64_t> style, target;
    for (const st_gcn::Sample& sample : sampler_.Next(count)) {
      source.push_back(sample.source);
      first.push_back(sample.reference1);
      second.push_back(sample.reference2);
      const std::vector<int>& alike = clips_[static_cast<std::size_t>(sample.domain)];
      const int clip = alike[random_() % alike.size()];
      const std::vector<int>& starts = store_.Starts(clip);
      like.push_back({clip, starts[random_() % starts.size()], sample.source.mirrored});
      style.push_back(sample.domain);
      target.push_back(sample.target);
    }
    const auto read = [this](const std::vector<Window>& windows) {
      return store_.Read(windows).view({-1, kWindowFrames, kFeatureCount}).transpose(1, 2);
    };
    return {read(source), read(like),           read(first),
            read(second), torch::tensor(style), torch::tensor(target)};
  }

 private:
  const st_gcn::WindowStore& store_;
  st_gcn::Sampler sampler_;
  std::mt19937_64 random_;
  std::vector<std::vector<int>> clips_;  // by style
};

// One training: the losses and optimizers of both sides.
class Training {
 public:
  Training(NetworksImpl& nets, int batch, Batches batches)
      : nets_(nets),
        batch_size_(batch),
        batches_(std::move(batches)),
        generator_adam_(Made(nets), Options(kMapRate)),
        critic_adam_(nets.critic->parameters(), Options(kCriticRate)) {}

  void Step(double progress) {
    const double decay = 1 - 0.8 * progress * progress;  // as st-gcn's: to a fifth
    SetRate(generator_adam_, kMapRate * decay);
    SetRate(critic_adam_, kCriticRate * decay);
    const Batch batch = batches_.Next(batch_size_);
    const Tensor content = nets_.generator->Encode(batch.source);
    const Tensor code = nets_.encoder(batch.reference1);
    const Tensor fake = nets_.generator->Decode(content, code);
    StepCritic(batch, fake.detach());
    StepGenerator(batch, content, code, fake);
  }

  std::string State() const {
    char text[128];
    std::snprintf(text, sizeof text, "content %.3f, adversarial %.2f, triplet %.2f, critic %.2f",
                  content_loss_.item<double>(), adversarial_loss_.item<double>(),
                  triplet_loss_.item<double>(), critic_loss_.item<double>());
    return text;
  }

 private:
  static std::vector<Tensor> Made(const NetworksImpl& nets) {
    std::vector<Tensor> made = nets.generator->parameters();
    const std::vector<Tensor> encoder = nets.encoder->parameters();
    made.insert(made.end(), encoder.begin(), encoder.end());
    return made;
  }
  static torch::optim::AdamOptions Options(double rate) {
    return torch::optim::AdamOptions(rate).betas({0.5, 0.99}).weight_decay(1e-4);
  }
  static void SetRate(torch::optim::Adam& adam, double rate) {
    for (auto& group : adam.param_groups()) {
      static_cast<torch::optim::AdamOptions&>(group.options()).lr(rate);
    }
  }

  void StepCritic(const Batch& batch, const Tensor& fake) {
    const bool penalize = iteration_++ % kPenaltyEvery == 0;
    const Tensor real = batch.reference1.detach().requires_grad_(penalize);
    const Tensor real_logit = Of(nets_.critic(real), batch.target);
    critic_loss_ = functional::softplus(-real_logit).mean() +
                   functional::softplus(Of(nets_.critic(fake), batch.target)).mean();
    Tensor loss = critic_loss_;
    if (penalize) {
      const Tensor slope =
          torch::autograd::grad({real_logit.sum()}, {real}, {}, {}, /*create_graph=*/true)[0];
      loss = loss + kPenalty * kPenaltyEvery * 0.5 * slope.square().sum({1, 2}).mean();
    }
    critic_adam_.zero_grad();
    loss.backward();
    critic_adam_.step();
  }

  void StepGenerator(const Batch& batch, const Tensor& content, const Tensor& code,
                     const Tensor& fake) {
    adversarial_loss_ = functional::softplus(-Of(nets_.critic(fake), batch.target)).mean();
    const Tensor own = nets_.generator->Decode(content, nets_.encoder(batch.like_source));
    content_loss_ = (own - batch.source).abs().mean();
    // A code is nearer to another code of its style than to the source's.
    const Tensor alike = nets_.encoder(batch.reference2);
    const Tensor other = nets_.encoder(batch.source);
    const Tensor apart = (batch.style != batch.target).to(torch::kFloat);
    triplet_loss_ =
        (torch::relu((code - alike).norm(2, 1) - (code - other).norm(2, 1) + kMargin) * apart)
            .mean();
    generator_adam_.zero_grad();
    (kContent * content_loss_ + kAdversarial * adversarial_loss_ + kTriplet * triplet_loss_)
        .backward();
    generator_adam_.step();
  }

  NetworksImpl& nets_;
  int batch_size_;
  Batches batches_;
  torch::optim::Adam generator_adam_, critic_adam_;
  Tensor content_loss_, adversarial_loss_, triplet_loss_, critic_loss_;
  long iteration_ = 0;
};

void Aberman::Train(const Budget& budget) {
  Training training(*nets_, budget.batch, Batches(material_, seed_));
  Iterate(
      budget, [&](double progress) { training.Step(progress); }, [&] { return training.State(); });
}

}  // namespace

double AbermanMacs(int channels) {
  const double c = channels;
  const double half = kWindowFrames / 2.0;
  const double quarter = kWindowFrames / 4.0;
  const double blocks = 4 * quarter * 3 * 2 * c * 2 * c;  // content and style
  return half * 8 * kFeatureCount * c + quarter * 8 * c * 2 * c + blocks + half * 7 * 2 * c * c +
         kWindowFrames * 7.0 * c * kFeatureCount + kCode * 2 * (2 * c + 2 * c + c);
}

int AbermanChannels(double macs) {
  int channels = 1;
  while (AbermanMacs(channels) < macs) ++channels;
  return macs - AbermanMacs(channels - 1) < AbermanMacs(channels) - macs ? channels - 1 : channels;
}

std::unique_ptr<Baseline> MakeAberman(const Material& material, int channels, std::uint64_t seed) {
  return std::make_unique<Aberman>(material, channels, seed);
}

}  // namespace styled::train::baselines

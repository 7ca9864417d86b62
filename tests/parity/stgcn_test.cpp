// Our networks of the family st-gcn against the training framework's, with weights that went
// through the trainer's writer and our reader.
#include <gtest/gtest.h>

#include "model/net/stgcn/code_space.h"
#include "model/net/stgcn/network.h"
#include "tests/parity/stgcn_torch.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/net/stgcn/random_weights.h"

namespace styled::parity {
namespace {

using torch::Tensor;

constexpr float kTolerance = 1e-4F;  // of standardized features and of codes
constexpr int64_t kDomains = 3;

// A width, and the normalization of its graph convolutions.
using Kind = std::pair<int64_t, stgcn::Normalization>;

class StgcnParity : public testing::TestWithParam<Kind> {
 protected:
  StgcnParity() {
    auto loaded = stgcn::Network::Load(file_);
    EXPECT_TRUE(loaded.ok()) << loaded.status().message();
    network_ = loaded.value();
  }
  // The largest difference of two clips, in deviations.
  float Largest(const std::vector<stgcn::Features>& a,
                const std::vector<stgcn::Features>& b) const {
    const float* const deviation = pair_.deviation.data_ptr<float>();
    float largest = 0;
    for (std::size_t t = 0; t < a.size(); ++t) {
      for (std::size_t i = 0; i < stgcn::kFeatureCount; ++i) {
        const float difference = std::abs(a[t][i] - b[t][i]) / deviation[i];
        if (!(difference <= largest)) largest = difference;  // also NaN
      }
    }
    return largest;
  }
  std::vector<stgcn::Features> Ours(const std::vector<stgcn::Features>& clip,
                                    const stgcn::Code& code) {
    std::vector<stgcn::Features> out(clip.size());
    network_->Encode(clip, content_, scratch_);
    network_->Decode(content_, code, out, scratch_);
    return out;
  }

  support::TemporaryFolder folder_;
  std::string file_ = folder_ / "weights.safetensors";
  StgcnPair pair_{kDomains, GetParam().first, static_cast<uint64_t>(GetParam().first), file_,
                  GetParam().second};
  // By subsets the sums of a layer have up to three terms of weight 1, and rounding grows with
  // them: measured 1.4e-4.
  const float tolerance_ =
      GetParam().second == stgcn::Normalization::kSubset ? 3 * kTolerance : kTolerance;
  std::shared_ptr<const stgcn::Network> network_;
  stgcn::Network::Content content_;
  stgcn::Scratch scratch_;
};

stgcn::Code ToCode(const Tensor& code) {
  return Eigen::Map<const stgcn::Code>(code.contiguous().data_ptr<float>());
}

TEST_P(StgcnParity, TheGeneratorOfAnyLength) {
  float worst = 0;
  for (const int frames : {8, 9, 10, 11, 64, 65, 128, 257, 300}) {
    const std::vector<stgcn::Features> clip = stgcn::WalkFeatures(frames, network_->features());
    const Tensor code = torch::randn({1, stgcn::kCode});
    const auto ours = Ours(clip, ToCode(code));
    const float largest = Largest(ours, pair_.Generate(clip, code));
    EXPECT_LT(largest, tolerance_) << frames;
    worst = std::max(worst, largest);
    EXPECT_GT(Largest(ours, pair_.Generate(clip, -code)), 100 * kTolerance) << frames;
  }
  std::printf("width %d: largest difference %.1e deviations\n", network_->width(),
              static_cast<double>(worst));
}

TEST_P(StgcnParity, TheStyleEncoderWithEveryHead) {
  const torch::NoGradGuard no_grad;
  const train::st_gcn::Encoder& encoder = pair_.networks.encoder;
  const std::vector<stgcn::Features> clip =
      stgcn::WalkFeatures(stgcn::kReference, network_->features());
  const Tensor features = encoder.Features(pair_.graph, pair_.Standardized(clip));
  for (int64_t domain = 0; domain < kDomains; ++domain) {
    const Tensor expected = encoder.Code(features, torch::tensor({domain}));
    const stgcn::Code found =
        network_->space().EncodeStyle(clip, static_cast<int>(domain), scratch_);
    EXPECT_LT((found - ToCode(expected)).cwiseAbs().maxCoeff(), tolerance_) << domain;
    EXPECT_GT(expected.abs().max().item<float>(), 0.1F);
  }
  const stgcn::Code free = network_->space().EncodeStyle(clip, stgcn::kFreeHead, scratch_);
  EXPECT_LT((free - ToCode(encoder.FreeCode(features))).cwiseAbs().maxCoeff(), tolerance_);
}

TEST_P(StgcnParity, TheMappingNetwork) {
  const torch::NoGradGuard no_grad;
  for (int64_t domain = 0; domain < kDomains; ++domain) {
    const Tensor z = torch::randn({1, stgcn::kNoise});
    const stgcn::Code found = network_->space().MapNoise(
        Eigen::Map<const stgcn::Noise>(z.data_ptr<float>()), static_cast<int>(domain));
    const Tensor expected = pair_.networks.mapping(z, torch::tensor({domain}));
    EXPECT_LT((found - ToCode(expected)).cwiseAbs().maxCoeff(), kTolerance) << domain;
  }
}

INSTANTIATE_TEST_SUITE_P(Widths, StgcnParity,
                         testing::Values(Kind{16, stgcn::Normalization::kNeighbours},
                                         Kind{32, stgcn::Normalization::kNeighbours},
                                         Kind{48, stgcn::Normalization::kNeighbours},
                                         Kind{64, stgcn::Normalization::kNeighbours},
                                         Kind{16, stgcn::Normalization::kSubset},
                                         Kind{64, stgcn::Normalization::kSubset}));

}  // namespace
}  // namespace styled::parity

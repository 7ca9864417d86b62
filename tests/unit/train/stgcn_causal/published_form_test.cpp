#include "model/train/stgcn_causal/published_form.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "model/body/pose.h"
#include "model/net/stgcn/features.h"

namespace styled::train::st_gcn_causal {
namespace {

using body::kJointCount;
using stgcn::Features;
using stgcn::kChannels;
using torch::Tensor;

class PublishedFormTest : public testing::Test {
 protected:
  PublishedFormTest() {
    for (int i = 0; i < stgcn::kFeatureCount; ++i) {
      const int channel = i % kChannels;
      statistics_.mean[static_cast<std::size_t>(i)] = channel == 6 ? 0.9F : 0.1F;
      statistics_.deviation[static_cast<std::size_t>(i)] = channel < 3 ? 0.5F : 0.2F;
    }
  }

  body::Pose RandomPose(float size) {
    std::normal_distribution<float> normal;
    body::Pose pose;
    pose.hips_position_m = body::Vec3(0, 1 + 0.1F * normal(random_), 0);
    for (auto& q : pose.rotations) {
      q = body::Exp(size * body::Vec3(normal(random_), normal(random_), normal(random_)));
    }
    return pose;
  }

  // With heading 0, as a window of one frame; rotations on the hemisphere of the mean.
  Tensor Standardized(const body::Pose& pose) const {
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    Tensor out = torch::empty({1, 1, kJointCount, kChannels});
    float* at = out.data_ptr<float>();
    for (int joint = 0; joint < kJointCount; ++joint) {
      const auto j = static_cast<std::size_t>(joint);
      Features::value_type raw[kChannels];
      const body::Vec3 position =
          world.positions_m[j] - body::Vec3(pose.hips_position_m.x(), 0, pose.hips_position_m.z());
      Eigen::Vector4f q = world.rotations[j].coeffs();
      const Eigen::Map<const Eigen::Vector4f> mean(statistics_.mean.data() + kChannels * j + 3);
      if (q.dot(mean) < 0) q = -q;
      std::copy_n(position.data(), 3, raw);
      std::copy_n(q.data(), 4, raw + 3);
      for (std::size_t c = 0; c < kChannels; ++c, ++at) {
        const std::size_t i = kChannels * j + c;
        *at = (raw[c] - statistics_.mean[i]) / statistics_.deviation[i];
      }
    }
    return out;
  }

  std::mt19937 random_{3};
  st_gcn::Statistics statistics_;
};

TEST_F(PublishedFormTest, IsTheChangeOnThePerformersOwnPose) {
  const PublishedForm form(statistics_);
  for (int round = 0; round < 5; ++round) {
    const body::Pose in = RandomPose(0.5F), rec = RandomPose(0.5F), sty = RandomPose(0.5F);
    body::Pose expected;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const body::Quat between = rec.rotations[j].slerp(0.5F, in.rotations[j]);
      expected.rotations[j] = in.rotations[j] * between.conjugate() * sty.rotations[j];
    }
    expected.hips_position_m.y() =
        in.hips_position_m.y() - rec.hips_position_m.y() + sty.hips_position_m.y();
    const auto basis = form.BasisOf(Standardized(in), Standardized(rec));
    const Tensor published = form(basis, Standardized(sty));
    EXPECT_LT((published - Standardized(expected)).abs().max().item<double>(), 1e-4);
  }
}

TEST_F(PublishedFormTest, WithoutAnErrorAndAChangeItIsThePerformersPose) {
  const PublishedForm form(statistics_);
  const Tensor in = Standardized(RandomPose(0.6F));
  EXPECT_LT((form(form.BasisOf(in, in), in) - in).abs().max().item<double>(), 1e-4);
  const Tensor other = Standardized(RandomPose(0.6F));  // the control
  EXPECT_GT((form(form.BasisOf(in, in), other) - in).abs().max().item<double>(), 0.1);
}

TEST_F(PublishedFormTest, HasAGradient) {
  const PublishedForm form(statistics_);
  const auto basis = form.BasisOf(Standardized(RandomPose(0.5F)), Standardized(RandomPose(0.5F)));
  Tensor sty = Standardized(RandomPose(0.5F)).requires_grad_(true);
  form(basis, sty).narrow(-1, 0, 3).square().sum().backward();
  EXPECT_TRUE(torch::isfinite(sty.grad()).all().item<bool>());
  EXPECT_GT(sty.grad().narrow(-1, 3, 4).abs().max().item<double>(), 1e-3);
  EXPECT_EQ(sty.grad().select(-2, 5).narrow(-1, 0, 3).abs().max().item<double>(), 0)
      << "positions follow from rotations";
}

// Against a loop over frames and joints with Eigen.
TEST_F(PublishedFormTest, TheLaterChangeIsTheTeachersOfThen) {
  const PublishedForm form(statistics_);
  std::vector<Tensor> rec, sty, expected;
  std::vector<body::Pose> recs, stys;
  constexpr int kFrames = 6;
  for (int t = 0; t < kFrames; ++t) {
    recs.push_back(RandomPose(0.4F));
    stys.push_back(recs.back());
    for (auto& q : stys.back().rotations) {
      q = q * body::Exp(body::Vec3(0.1F, 0.2F * static_cast<float>(t), -0.1F));
    }
    rec.push_back(Standardized(recs.back()));
    sty.push_back(Standardized(stys.back()));
  }
  constexpr float kGain = 1.5F;
  for (int t = 0; t < kFrames; ++t) {
    const auto now = static_cast<std::size_t>(t);
    const auto then = static_cast<std::size_t>(std::min(t + 2, kFrames - 1));
    body::Pose pose = recs[now];
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const body::Quat change = recs[then].rotations[j].conjugate() * stys[then].rotations[j];
      pose.rotations[j] = pose.rotations[j] * body::Exp(kGain * body::Log(change));
    }
    expected.push_back(Standardized(pose));
  }
  const Tensor later = form.Later(torch::cat(rec, 1), torch::cat(sty, 1), 2, kGain);
  const auto rotations = [](const Tensor& window) {
    return window.narrow(-1, stgcn::kPositionChannels, stgcn::kRotationChannels);
  };
  EXPECT_LT((rotations(later) - rotations(torch::cat(expected, 1))).abs().max().item<double>(),
            1e-4);
  const Tensor same = form.Later(torch::cat(rec, 1), torch::cat(sty, 1), 0, 1);
  EXPECT_LT((same - torch::cat(sty, 1)).abs().max().item<double>(), 1e-4);
  // Between two frames: both by halves. The positions are linear in the frames.
  const Tensor one = form.Later(torch::cat(rec, 1), torch::cat(sty, 1), 1, 1);
  const Tensor half = form.Later(torch::cat(rec, 1), torch::cat(sty, 1), 0.5, 1);
  const auto positions = [](const Tensor& window) {
    return window.narrow(-1, 0, stgcn::kPositionChannels);
  };
  EXPECT_LT((positions(half) - 0.5 * (positions(same) + positions(one))).abs().max().item<double>(),
            1e-5);
}

}  // namespace
}  // namespace styled::train::st_gcn_causal

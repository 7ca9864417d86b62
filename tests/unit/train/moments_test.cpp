#include "model/train/erd/moments.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/unit/train/walker.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

constexpr int kLength = 25;

TrainingClip Clip(int source, int style, int content, float bend_rad) {
  TrainingClip clip = Walker(100);
  clip.source = source;
  clip.style = style;
  clip.content = content;
  for (body::Pose& pose : clip.poses) {
    pose.rotations[body::kSpine] =
        pose.rotations[body::kSpine] * body::Exp(body::Vec3(bend_rad, 0, 0));
  }
  return clip;
}

StyleEffects Effects(const std::vector<TrainingClip>& clips) {
  return MeasureEffects(clips, 2, 2, kLength, 4, erd::FeatureParameters());
}

TEST(Moments, AnEffectIsMeasuredWithinAFolder) {
  // The second folder's performer bends forward in neutral and style alike: no effect.
  const StyleEffects one = Effects({Clip(0, 0, 0, 0), Clip(0, 1, 0, 0.5F)});
  const StyleEffects two = Effects({Clip(0, 0, 0, 0), Clip(0, 1, 0, 0.5F), Clip(1, 0, 0, 0.3F)});
  const StyleEffects none = Effects({Clip(0, 0, 0, 0), Clip(1, 1, 0, 0.5F)});
  const Tensor shift =
      one.moments[1][0].narrow(0, erd::kPositionBegin, erd::kPositionFeatures).view({-1, 3});
  EXPECT_GT(shift[body::kHead].norm().item<double>(), 0.1);
  EXPECT_LT(shift[body::kLeftFoot].norm().item<double>(), 0.01) << "no leg was bent";
  EXPECT_TRUE(torch::equal(one.moments, two.moments));
  EXPECT_EQ(one.known[1][0].item<float>(), 1.0F);
  EXPECT_EQ(one.known[1][1].item<float>(), 0.0F) << "no clip of that content";
  EXPECT_EQ(none.known[1][0].item<float>(), 0.0F) << "the folders share no cell";
  EXPECT_EQ(one.moments[0].abs().max().item<float>(), 0.0F);
}

// The means and deviations of r (times 0.3 m) and p over each window, mirrored ones too, in the
// mean; then styled less neutral.
TEST(Moments, AnEffectIsADifferenceOfMeansAndDeviations) {
  const TrainingClip neutral = Clip(0, 0, 0, 0), styled = Clip(0, 1, 0, 0.5F);
  const auto moments = [](const TrainingClip& clip, int place) {
    std::array<double, 2> sum{};
    int windows = 0;
    std::vector<float> window(static_cast<std::size_t>(kLength) * erd::kFeatureCount);
    for (int start = 0; start + kLength <= 100; start += kLength / 2) {
      for (const bool mirrored : {false, true}) {
        FillWindow(clip, start, kLength, mirrored, false, {}, {.features = window.data()});
        const auto at = [&](int t) {
          return (place < erd::kRotationFeatures ? 0.3 : 1.0) *
                 window[static_cast<std::size_t>(t * erd::kFeatureCount + place)];
        };
        double mean = 0, square = 0;
        for (int t = 0; t < kLength; ++t) mean += at(t) / kLength;
        for (int t = 0; t < kLength; ++t) square += std::pow(at(t) - mean, 2) / kLength;
        sum[0] += mean;
        sum[1] += std::sqrt(square + 1e-6);
        ++windows;
      }
    }
    return std::array{sum[0] / windows, sum[1] / windows};
  };
  const Tensor effect = Effects({neutral, styled}).moments[1][0];
  for (int place = 0; place < kEffectFeatures; ++place) {
    const auto was = moments(neutral, place), is = moments(styled, place);
    EXPECT_NEAR(effect[place].item<double>(), is[0] - was[0], 1e-5) << place;
    EXPECT_NEAR(effect[kEffectFeatures + place].item<double>(), is[1] - was[1], 1e-5) << place;
  }
}

// A generator that can only shift a cell: descends on the loss and must arrive at the wanted shift
// while the windows keep their differences.
TEST(Moments, TheLossLeadsTheMeansToWhatIsWanted) {
  torch::manual_seed(3);
  const StyleEffects wanted{torch::zeros({2, 2, 2 * kEffectFeatures}), torch::ones({2, 2, 1})};
  wanted.moments[1][0].narrow(0, erd::kPositionBegin, 63).fill_(0.2);
  wanted.moments[1][1].narrow(0, erd::kPositionBegin, 63).fill_(-0.1);
  Moments moments(wanted, torch::kCPU);
  Tensor shift = torch::zeros({2, kEffectFeatures}, torch::requires_grad());
  const Tensor style = torch::ones({6}, torch::kInt64);
  const Tensor content = torch::tensor({0, 0, 0, 1, 1, 1});
  for (int i = 0; i < 600; ++i) {
    const Tensor in = torch::randn({kLength, 6, kEffectFeatures});
    const Tensor own =
        0.3 * torch::randn({1, 6, kEffectFeatures});  // a window's own way of doing it
    const Tensor loss = moments.Loss(in, in + own + shift.index_select(0, content), style, content,
                                     torch::ones({6}));
    const Tensor gradient = torch::autograd::grad({loss}, {shift})[0];
    const torch::NoGradGuard no_grad;
    shift -= 0.02 * gradient;
  }
  EXPECT_NEAR(shift[0].narrow(0, erd::kPositionBegin, 63).mean().item<double>(), 0.2, 0.02);
  EXPECT_NEAR(shift[1].narrow(0, erd::kPositionBegin, 63).mean().item<double>(), -0.1, 0.02);
  EXPECT_LT(moments.Distance().item<double>(), 0.3);
}

TEST(Moments, WindowsThatDoNotCountChangeNothing) {
  const StyleEffects wanted{torch::ones({2, 2, 2 * kEffectFeatures}), torch::ones({2, 2, 1})};
  Moments moments(wanted, torch::kCPU);
  const Tensor before = moments.Save();
  const Tensor x = torch::randn({kLength, 3, kEffectFeatures});
  const Tensor loss = moments.Loss(x, 2 * x, torch::ones({3}, torch::kInt64),
                                   torch::zeros({3}, torch::kInt64), torch::zeros({3}));
  EXPECT_EQ(loss.item<double>(), 0.0);
  EXPECT_TRUE(torch::equal(moments.Save(), before));
}

TEST(Moments, SaveAndRestoreAreExact) {
  const StyleEffects wanted{torch::ones({2, 2, 2 * kEffectFeatures}), torch::ones({2, 2, 1})};
  Moments one(wanted, torch::kCPU);
  Moments other(wanted, torch::kCPU);
  const Tensor style = torch::ones({3}, torch::kInt64);
  const Tensor x = torch::randn({kLength, 3, kEffectFeatures});
  const auto step = [&](Moments& moments) {
    return moments.Loss(x, 2 * x, style, style, torch::ones({3})).item<double>();
  };
  for (int i = 0; i < 20; ++i) step(one);
  other.Restore(one.Save());
  EXPECT_EQ(step(one), step(other));
}

}  // namespace
}  // namespace styled::train::style_erd

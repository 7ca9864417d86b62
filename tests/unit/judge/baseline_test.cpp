#include <gtest/gtest.h>

#include "model/net/load.h"
#include "model/train/judge/data.h"
#include "tests/support/temporary_folder.h"

namespace styled::judge {
namespace {

constexpr float kBent_rad = 0.3F;

// Ten frames with the head rotated by `turn_rad`, and the spine bent if `style` is 1.
train::TrainingClip ArmClip(int style, int content, float turn_rad) {
  train::TrainingClip clip;
  clip.style = style;
  clip.content = content;
  clip.poses.resize(10);
  for (body::Pose& pose : clip.poses) {
    pose.rotations[body::kHead] = body::Exp(body::Vec3(0, turn_rad, 0));
    if (style == 1) pose.rotations[body::kSpine] = body::Exp(body::Vec3(kBent_rad, 0, 0));
  }
  return clip;
}

// The constant offset, written as weights, gives the same output as the baseline itself.
TEST(Baseline, WrittenAsWeightsStylesAsItself) {
  Data data;
  data.manifest.name = "bending";
  data.manifest.licence = "CC0-1.0";
  data.manifest.styles = {{"neutral", {}, {}}, {"bent", {}, {"stooped"}}};
  data.manifest.contents = {"left", "right"};
  data.train = {ArmClip(0, 0, 0.4F), ArmClip(0, 1, -0.4F), ArmClip(1, 0, 0.4F),
                ArmClip(1, 1, -0.4F)};
  data.inputs = {ArmClip(0, 0, 0.2F).poses};
  data.contents = {0};

  const support::TemporaryFolder folder;
  const std::string file = folder / "offset.safetensors";
  const Status written = WriteBaseline(data, file);
  ASSERT_TRUE(written.ok()) << written.message();
  const auto network = net::Load(file);
  ASSERT_TRUE(network.ok()) << network.status().message();
  EXPECT_EQ(network.value()->model().licence, "CC0-1.0");
  EXPECT_EQ(net::FindStyle(network.value()->model().styles, "stooped"), 1);

  const auto stream = network.value()->MakeStream();
  const net::StyleWeight bent{1, 1.0F};
  net::Prediction out;
  const net::StepJob job{&data.inputs[0][0], 0, {&bent, 1}, stream.get(), &out};
  network.value()->Step({&job, 1});
  const std::vector<Transferred> baseline = ApplyBaseline(data);
  ASSERT_EQ(baseline.size(), 1U);
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    EXPECT_LT(baseline[0].output[0].rotations[joint].angularDistance(out.styled.rotations[joint]),
              2e-3F)
        << joint;
  }
  const float bend_rad = out.styled.rotations[body::kSpine].angularDistance(body::Quat::Identity());
  EXPECT_NEAR(bend_rad, kBent_rad, 2e-3F);
}

}  // namespace
}  // namespace styled::judge

#include "model/train/erd/clip_teacher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>

#include "model/body/heading.h"
#include "tests/unit/train/walker.h"

namespace styled::train::style_erd {
namespace {

constexpr int kClipFrames = 25;
constexpr float kBend_rad = 0.3F, kRise_m = 0.02F;

// Style k bends the left elbow by k times kBend_rad more than the input has, and the hips rise by k
// times kRise_m, a hundredth more in each frame; from an input style it first takes that away. Its
// reconstruction has every joint off by `off_rad` and the hips by a metre.
class Bender final : public net::ClipStylizer {
 public:
  Bender() { model_.styles = {{"neutral", {}}, {"bent", {}}, {"very bent", {}}}; }
  const net::Model& model() const noexcept override { return model_; }
  int least_frames() const noexcept override { return 1; }
  net::StyleCode MakeCode(const net::StyleRequest& request) const override {
    return {static_cast<float>(request.sources.front().style)};
  }
  net::NearestStyle Nearest(const net::StyleCode& /*code*/) const override { return {}; }
  std::unique_ptr<net::ClipStream> MakeStream(const net::StyleCode& code, int input_style,
                                              net::Extent /*extent*/) const override {
    return std::make_unique<Bent>(code[0] - static_cast<float>(input_style), off_rad_);
  }
  net::Model& mutable_model() { return model_; }
  void BeOffBy(float off_rad) { off_rad_ = off_rad; }

 private:
  class Bent final : public net::ClipStream {
   public:
    Bent(float amount, float off_rad) : amount_(amount), off_rad_(off_rad) {}
    void Add(const body::Pose& pose) override {
      net::Prediction& out = done_.emplace_back();
      out.heading_rad = 0.4F;
      out.styled.rotations = pose.rotations;
      out.styled.rotations[body::kHips] = body::Yaw(-out.heading_rad) * pose.rotations[body::kHips];
      out.styled.rotations[body::kLeftLowerArm] =
          pose.rotations[body::kLeftLowerArm] * body::Exp(body::Vec3(0, amount_ * kBend_rad, 0));
      out.styled.hips_height_m =
          pose.hips_position_m.y() + amount_ * kRise_m * (1 + 0.01F * static_cast<float>(frame_++));
      out.reconstruction.rotations = pose.rotations;
      out.reconstruction.rotations[body::kHips] = out.styled.rotations[body::kHips];
      for (body::Quat& rotation : out.reconstruction.rotations) {
        rotation = rotation * body::Exp(body::Vec3(off_rad_, 0, 0));
      }
      out.reconstruction.hips_height_m = pose.hips_position_m.y() + 1;
    }
    void End() override {}
    bool Pop(net::Prediction& out) override {
      if (done_.empty()) return false;
      out = done_.front();
      done_.pop_front();
      return true;
    }

   private:
    float amount_, off_rad_;
    int frame_ = 0;
    std::deque<net::Prediction> done_;
  };

  net::Model model_;
  float off_rad_ = 0.05F;
};

class AClipTeacher : public testing::Test {
 protected:
  AClipTeacher() {
    manifest_.styles.resize(3);
    manifest_.styles[0].name = "neutral";
    manifest_.styles[1].name = "odd";
    manifest_.styles[2].name = "bent";
    for (int style = 0; style < 3; ++style) {
      clips_.push_back(Walker(60, static_cast<float>(style)));
      clips_.back().style = style;
    }
  }
  Result<ClipTeacher> Make(const std::vector<std::string>& taught = {"", "bent"},
                           double rate_hz = 30) {
    return ClipTeacher::Make(network_, manifest_, clips_, rate_hz, taught);
  }
  static Sampler::Window WindowOf(int clip) {
    Sampler::Window window;
    window.clip = clip;
    window.start = 10;
    return window;
  }
  static body::Vec3 Turn(const ClipTeacher::Changes& changes, int t, int window, int joint) {
    const torch::Tensor q = changes.rotations[t][window][joint].contiguous();
    return body::Log(body::Quat(q.data_ptr<float>()));
  }

  clip::Manifest manifest_;
  std::vector<TrainingClip> clips_;
  Bender network_;
};

TEST_F(AClipTeacher, ChangesTheInputIntoItsOwnOutput) {
  const Result<ClipTeacher> teacher = Make();
  ASSERT_TRUE(teacher.ok()) << teacher.status().message();
  // Neutral to bent, bent to neutral, neutral to a style that is not taught.
  const ClipTeacher::Changes changes =
      teacher.value().Of({WindowOf(0), WindowOf(2), WindowOf(0)},
                         {.input = {0, 2, 0}, .target = {2, 0, 1}}, kClipFrames);
  for (int t = 0; t < kClipFrames; ++t) {
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const float bend = joint == body::kLeftLowerArm ? kBend_rad : 0.0F;
      EXPECT_NEAR((Turn(changes, t, 0, joint) - body::Vec3(0, bend, 0)).norm(), 0, 1e-3) << joint;
      EXPECT_NEAR((Turn(changes, t, 1, joint) + body::Vec3(0, bend, 0)).norm(), 0, 1e-3) << joint;
      EXPECT_NEAR(Turn(changes, t, 2, joint).norm(), 0, 1e-3) << joint;
    }
    const float rise_m = kRise_m * (1 + 0.01F * static_cast<float>(10 + t));
    EXPECT_NEAR(changes.rise_m[t][0].item<float>(), rise_m, 1e-5);
    EXPECT_NEAR(changes.rise_m[t][1].item<float>(), -rise_m, 1e-5);
    EXPECT_EQ(changes.rise_m[t][2].item<float>(), 0.0F);
  }
}

// A clip that it does not know, as of another rig: its output would be another body.
TEST_F(AClipTeacher, TeachesItsChangeOfStyleWhereItCannotReconstruct) {
  EXPECT_EQ(Make().value().share_by_change(), 0);
  network_.BeOffBy(0.3F);
  const Result<ClipTeacher> teacher = Make();
  ASSERT_TRUE(teacher.ok());
  EXPECT_EQ(teacher.value().share_by_change(), 1);
  const ClipTeacher::Changes changes =
      teacher.value().Of({WindowOf(0)}, {.input = {0}, .target = {2}}, kClipFrames);
  EXPECT_NEAR((Turn(changes, 0, 0, body::kHead) - body::Vec3(-0.3F, 0, 0)).norm(), 0, 1e-3);
  EXPECT_NEAR(changes.rise_m[0][0].item<float>(), kRise_m * 1.1F - 1, 1e-4);
}

TEST_F(AClipTeacher, AMirroredWindowHasTheMirroredChange) {
  const Result<ClipTeacher> teacher = Make();
  ASSERT_TRUE(teacher.ok());
  Sampler::Window mirrored = WindowOf(0);
  mirrored.mirrored = true;
  const ClipTeacher::Changes changes =
      teacher.value().Of({mirrored}, {.input = {0}, .target = {2}}, kClipFrames);
  EXPECT_NEAR((Turn(changes, 3, 0, body::kRightLowerArm) - body::Vec3(0, -kBend_rad, 0)).norm(), 0,
              1e-3);
  EXPECT_NEAR(Turn(changes, 3, 0, body::kLeftLowerArm).norm(), 0, 1e-3);
  EXPECT_GT(changes.rise_m[3][0].item<float>(), kRise_m);
}

// Halfway between two frames, and no further than the clip's end.
TEST_F(AClipTeacher, WhatIsTaughtMayBeAheadOfTheInput) {
  const Result<ClipTeacher> teacher = Make();
  ASSERT_TRUE(teacher.ok());
  const ClipTeacher::Roles roles{.input = {0}, .target = {2}};
  Sampler::Window late = WindowOf(0);
  late.start = 60 - kClipFrames;
  for (const double lead : {0.0, 1.5, 2.0}) {
    const float rise =
        teacher.value().Of({WindowOf(0)}, roles, kClipFrames, lead).rise_m[0][0].item<float>();
    EXPECT_NEAR(rise, kRise_m * (1 + 0.01F * (10 + static_cast<float>(lead))), 1e-5) << lead;
    const float end =
        teacher.value().Of({late}, roles, kClipFrames, lead).rise_m[-1][0].item<float>();
    EXPECT_NEAR(end, kRise_m * (1 + 0.01F * 59), 1e-5) << lead;
  }
}

TEST_F(AClipTeacher, RefusesAnotherRate) {
  EXPECT_THAT(Make({"", "bent"}, 60).status().message(),
              testing::HasSubstr("works at 30 Hz, the run at 60"));
  network_.mutable_model().styles[0].name = "plain";
  EXPECT_TRUE(Make().ok()) << "its first style is neutral, whatever it is called";
}

}  // namespace
}  // namespace styled::train::style_erd

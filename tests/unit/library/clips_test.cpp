#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "model/clip/clip.h"
#include "model/feet/legs.h"
#include "model/library/styled.h"
#include "model/offline/learn_neutral.h"
#include "model/stylist/stylist.h"
#include "model/synthetic/performer.h"
#include "model/trial/trial.h"

namespace styled {
namespace {

using Clip = std::unique_ptr<styled_clip, decltype(&styled_free_clip)>;

struct Motion {
  std::vector<float> root, rotations;
};

// The synthetic performer in the arrays of a program.
class LibraryClipsTest : public testing::Test {
 protected:
  LibraryClipsTest() : skeleton_(feet::HumanoidBinding().skeleton()) {
    for (const std::string& name : skeleton_.names) names_.push_back(name.c_str());
    for (const int parent : skeleton_.parents) parents_.push_back(parent);
    for (const rig::Vec3& offset : skeleton_.offsets) {
      offsets_.insert(offsets_.end(), offset.begin(), offset.end());
    }
    body_ = {sizeof body_,    skeleton_.joint_count(),
             names_.data(),   parents_.data(),
             offsets_.data(), nullptr,
             nullptr,         nullptr};
  }
  static void SetUpTestSuite() {
    network_ = styled_load(STYLED_SHIPPED "/v2.safetensors", "float32", nullptr, 0);
    ASSERT_NE(network_, nullptr);
  }
  static void TearDownTestSuite() { styled_release(network_); }

  Motion MotionAt(double rate_hz, double seconds) const {
    static const rig::Binding binding = feet::HumanoidBinding();
    Motion motion;
    rig::RigPose pose(skeleton_);
    body::Pose canonical;
    for (int frame = 0; frame <= static_cast<int>(seconds * rate_hz); ++frame) {
      synthetic::Performer({.seed = 3}).Pose(frame / rate_hz, canonical);
      binding.Unbind(canonical, pose, pose);
      motion.root.insert(motion.root.end(), pose.translations[0].begin(),
                         pose.translations[0].end());
      for (const rig::Quat& q : pose.rotations) {
        motion.rotations.insert(motion.rotations.end(), q.coeffs().begin(), q.coeffs().end());
      }
    }
    return motion;
  }
  Clip Make(const Motion& motion, double rate_hz) const {
    char error[300] = "";
    styled_clip* const made =
        styled_make_clip(&body_, rate_hz, motion.root.size() / 3, motion.root.data(),
                         motion.rotations.data(), error, sizeof error);
    EXPECT_NE(made, nullptr) << error;
    return {made, styled_free_clip};
  }
  static Motion FramesOf(const Clip& clip) {
    const std::size_t frames = styled_clip_length(clip.get(), nullptr);
    const auto joints = static_cast<std::size_t>(styled_clip_body(clip.get())->joint_count);
    Motion motion{std::vector<float>(3 * frames), std::vector<float>(4 * frames * joints)};
    EXPECT_EQ(styled_clip_frames(clip.get(), motion.root.data(), motion.rotations.data()),
              STYLED_OK);
    return motion;
  }
  static std::string Restyle(const Clip& clip, const char* style) {
    char error[300] = "";
    const std::int32_t number = styled_find_style(network_, style);
    const float weight = 1;
    const int own = styled_restyle(network_, clip.get(), &number, &weight, 1, error, sizeof error);
    EXPECT_EQ(own, *error == '\0' ? 0 : STYLED_ERROR_FAILED);
    return error;
  }
  // The largest angle between rotations of two motions, degrees; of `b` every `step`-th frame.
  double Apart_deg(const Motion& a, const Motion& b, std::size_t step = 1) const {
    const std::size_t row = 4 * names_.size();
    double apart = 0;
    for (std::size_t i = 0; i < a.rotations.size(); i += 4) {
      const std::size_t j = i / row * row * step + i % row;
      const rig::Quat one(Eigen::Map<const Eigen::Vector4f>(&a.rotations[i]));
      const rig::Quat other(Eigen::Map<const Eigen::Vector4f>(&b.rotations[j]));
      apart = std::max(apart, 57.29577951308232 * one.angularDistance(other));
    }
    return apart;
  }

  static inline styled_network* network_ = nullptr;
  rig::Skeleton skeleton_;
  std::vector<const char*> names_;
  std::vector<std::int32_t> parents_;
  std::vector<float> offsets_;
  styled_body body_;
};

// A performer who was taught the same neutral does the same, bit for bit.
TEST_F(LibraryClipsTest, AClipIsRestyledAsAPerformerWhoseNeutralIsKnown) {
  const Motion motion = MotionAt(60, 4);
  const Clip clip = Make(motion, 60), same = Make(motion, 60);
  double rate_hz = 0;
  EXPECT_EQ(styled_clip_length(clip.get(), &rate_hz), 241U);
  EXPECT_EQ(rate_hz, 60);
  EXPECT_EQ(FramesOf(clip).rotations, motion.rotations);
  styled_performer* const performer =
      styled_create(network_, styled_clip_body(clip.get()), nullptr, 0);
  ASSERT_NE(performer, nullptr);
  ASSERT_EQ(styled_learn(performer, clip.get()), STYLED_OK);
  const std::int32_t style = styled_find_style(network_, "elderly");
  const float weight = 1;
  ASSERT_EQ(styled_set(performer, &style, &weight, 1, 0), STYLED_OK);
  Motion live = motion;
  for (std::size_t i = 0; i < live.root.size() / 3; ++i) {
    float* const root = &live.root[3 * i];
    float* const rotations = &live.rotations[4 * names_.size() * i];
    const auto time_ns = static_cast<std::int64_t>(static_cast<double>(i) / 60 * 1e9);
    EXPECT_EQ(styled_frame(performer, time_ns, root, rotations, root, rotations, nullptr),
              STYLED_OK);
  }
  styled_destroy(performer);
  const Clip copy{styled_copy_clip(clip.get()), styled_free_clip};
  EXPECT_EQ(Restyle(clip, "elderly"), "");
  EXPECT_EQ(FramesOf(copy).rotations, motion.rotations);
  EXPECT_EQ(Restyle(copy, "elderly"), "");
  EXPECT_EQ(FramesOf(copy).rotations, FramesOf(clip).rotations);
  const Motion styled = FramesOf(clip);
  EXPECT_EQ(styled.rotations, live.rotations);
  EXPECT_EQ(styled.root, live.root);
  EXPECT_GT(Apart_deg(styled, motion), 10);
  const std::int32_t none = 0;
  EXPECT_EQ(styled_restyle(network_, same.get(), &none, &weight, 0, nullptr, 0), 0);
  EXPECT_EQ(FramesOf(same).rotations, motion.rotations) << "without a style it is the same";
}

TEST_F(LibraryClipsTest, ASlowClipGetsFramesInBetween) {
  const Clip slow = Make(MotionAt(10, 4), 10), fast = Make(MotionAt(30, 4), 30);
  Restyle(slow, "elderly");
  Restyle(fast, "elderly");
  EXPECT_LT(Apart_deg(FramesOf(slow), FramesOf(fast), 3), 8);
}

TEST_F(LibraryClipsTest, AClipGoesThroughAFile) {
  const Clip clip = Make(MotionAt(60, 1), 60);
  const std::string file = testing::TempDir() + "library_clip.bvh";
  char error[300] = "";
  ASSERT_EQ(styled_write_clip(clip.get(), file.c_str(), error, sizeof error), STYLED_OK) << error;
  const Clip read{styled_read_clip(file.c_str(), nullptr, error, sizeof error), styled_free_clip};
  ASSERT_NE(read, nullptr) << error;
  const styled_body& body = *styled_clip_body(read.get());
  ASSERT_EQ(body.joint_count, body_.joint_count);
  for (std::size_t j = 0; j < names_.size(); ++j) EXPECT_STREQ(body.names[j], names_[j]);
  EXPECT_LT(Apart_deg(FramesOf(clip), FramesOf(read)), 0.1);
  const auto shown = std::find_if(body.joints, body.joints + 22, [](const char* text) {
    return text == nullptr || std::string(text) == "leftUpperArm=leftUpperArm";
  });
  EXPECT_NE(*shown, nullptr);
  const char* const wrong[] = {"leftUpperArm=nosuch", nullptr};
  EXPECT_EQ(styled_read_clip(file.c_str(), wrong, error, sizeof error), nullptr);
  EXPECT_EQ(std::string(error).rfind(file + ": joints.leftUpperArm: the rig has no joint", 0), 0U)
      << error;
  std::filesystem::remove(file);
  EXPECT_EQ(styled_read_clip(file.c_str(), nullptr, error, sizeof error), nullptr);
  EXPECT_NE(std::string(error).find(file), std::string::npos) << error;
  EXPECT_EQ(styled_write_clip(clip.get(), "/nowhere/a.bvh", error, sizeof error),
            STYLED_ERROR_FAILED);
  EXPECT_NE(std::string(error).find("/nowhere/a.bvh"), std::string::npos) << error;
}

// Where neither names nor toes tell left from right.
TEST_F(LibraryClipsTest, JointsAreGivenByHand) {
  std::vector<std::string> plain;
  for (std::size_t j = 0; j < names_.size(); ++j) plain.push_back("bone" + std::to_string(j));
  for (std::size_t j = 0; j < names_.size(); ++j) names_[j] = plain[j].c_str();
  for (std::size_t j = 0; j < names_.size(); ++j) {
    if (skeleton_.names[j].ends_with("Toes")) offsets_[3 * j + 2] = 0;
  }
  char error[300] = "";
  EXPECT_EQ(styled_create(network_, &body_, error, sizeof error), nullptr);
  EXPECT_NE(std::string(error).find("give one side by hand"), std::string::npos) << error;
  const auto at = std::find(skeleton_.names.begin(), skeleton_.names.end(), "leftUpperArm");
  const std::string text =
      "leftUpperArm=" + plain[static_cast<std::size_t>(at - skeleton_.names.begin())];
  const char* const joints[] = {text.c_str(), nullptr};
  body_.joints = joints;
  styled_performer* const performer = styled_create(network_, &body_, error, sizeof error);
  EXPECT_NE(performer, nullptr) << error;
  styled_destroy(performer);
  const char* const odd[] = {"leftUpperArm", nullptr};
  body_.joints = odd;
  EXPECT_EQ(styled_create(network_, &body_, error, sizeof error), nullptr);
  EXPECT_EQ(std::string(error).rfind("joints: ", 0), 0U) << error;
}

TEST_F(LibraryClipsTest, APerformerIsCalibrated) {
  styled_performer* const performer = styled_create(network_, &body_, nullptr, 0);
  ASSERT_NE(performer, nullptr);
  for (const float seconds : {-1.0F, 0.5F, 61.0F, std::nanf("")}) {
    EXPECT_EQ(styled_calibrate(performer, seconds), STYLED_ERROR_ARGUMENT);
  }
  EXPECT_EQ(styled_calibrate(performer, 2), STYLED_OK);
  std::vector<char> before(styled_save(performer, nullptr, 0)), after(before.size());
  styled_save(performer, before.data(), before.size());
  EXPECT_EQ(styled_calibrate(performer, 0), STYLED_OK);
  styled_save(performer, after.data(), after.size());
  EXPECT_NE(before, after);
  EXPECT_EQ(styled_learn(performer, nullptr), STYLED_ERROR_ARGUMENT);
  styled_destroy(performer);
}

// The style of an example: the performer restyled in a style of the weights, beside their own way.
class LibraryLikeTest : public LibraryClipsTest {
 protected:
  using Network = std::unique_ptr<styled_network, decltype(&styled_release)>;
  LibraryLikeTest() {
    const std::int32_t style = styled_find_style(open_.get(), "zombie");
    const float weight = 1;
    EXPECT_EQ(styled_restyle(open_.get(), example_.get(), &style, &weight, 1, nullptr, 0), 0);
  }
  Network Like(const char* name, const Clip& example, const Clip& neutral) {
    styled_network* const made =
        styled_like(open_.get(), name, example.get(), neutral.get(), error_.data(), error_.size());
    EXPECT_EQ(made == nullptr, error_[0] != '\0');
    return {made, styled_release};
  }
  // Another take of the performer in the last style of a network.
  Motion InLast(const Network& network) const {
    const Clip clip = Make(MotionAt(60, 3), 60);
    const std::int32_t style = styled_style_count(network.get()) - 1;
    const float weight = 1;
    EXPECT_EQ(styled_restyle(network.get(), clip.get(), &style, &weight, 1, nullptr, 0), 0);
    return FramesOf(clip);
  }

  Network open_{styled_load(STYLED_SHIPPED "/open.safetensors", "float32", nullptr, 0),
                styled_release};
  Clip own_ = Make(MotionAt(60, 6), 60), example_ = Make(MotionAt(60, 6), 60);
  std::array<char, 300> error_{};
};

TEST_F(LibraryLikeTest, AnExampleBecomesTheLastStyle) {
  const Network made = Like("mine", example_, own_);
  ASSERT_NE(made, nullptr) << error_.data();
  const int count = styled_style_count(open_.get());
  EXPECT_EQ(styled_style_count(made.get()), count + 1);
  EXPECT_EQ(styled_find_style(made.get(), "mine"), count);
  EXPECT_EQ(styled_find_style(open_.get(), "mine"), -1) << "the network itself stays as it is";
  EXPECT_STREQ(styled_style_name(made.get(), 1), styled_style_name(open_.get(), 1));
  EXPECT_STREQ(styled_style_licence(made.get(), count), "that of the example");
  const Network none = Like("mine", own_, own_);
  ASSERT_NE(none, nullptr) << error_.data();
  const Motion own = MotionAt(60, 3);
  const double nothing_deg = Apart_deg(InLast(none), own), shown_deg = Apart_deg(InLast(made), own);
  EXPECT_GT(shown_deg, 20);
  EXPECT_LT(nothing_deg, shown_deg / 4) << "an example that is the performer's own way";
}

TEST_F(LibraryLikeTest, APerformerContinuesWithTheNewStyle) {
  const Network made = Like("mine", example_, own_), again = Like("mine", example_, own_);
  ASSERT_NE(made, nullptr) << error_.data();
  const Motion motion = MotionAt(60, 4);
  const auto create = [&] {
    return std::unique_ptr<styled_performer, decltype(&styled_destroy)>(
        styled_create(open_.get(), &body_, nullptr, 0), styled_destroy);
  };
  const auto first = create(), second = create();
  const std::int32_t old = styled_find_style(open_.get(), "zombie");
  const float weight = 1;
  std::vector<float> root(3), one(4 * names_.size()), other(one);
  for (std::size_t i = 0; i < motion.root.size() / 3; ++i) {
    if (i == 60) {
      for (const auto* performer : {&first, &second}) {
        ASSERT_EQ(styled_set(performer->get(), &old, &weight, 1, 0.1F), STYLED_OK);
      }
    }
    if (i == 120) {
      ASSERT_EQ(styled_adopt(second.get(), made.get()), STYLED_OK);
      ASSERT_EQ(styled_adopt(second.get(), made.get()), STYLED_OK) << "a second time";
    }
    if (i == 180) {
      const std::int32_t last = styled_style_count(made.get()) - 1;
      EXPECT_EQ(styled_set(first.get(), &last, &weight, 1, 0.1F), STYLED_ERROR_ARGUMENT);
      EXPECT_EQ(styled_set(second.get(), &last, &weight, 1, 0.1F), STYLED_OK);
    }
    const auto time_ns = static_cast<std::int64_t>(static_cast<double>(i) / 60 * 1e9);
    const float* const pose = &motion.rotations[4 * names_.size() * i];
    ASSERT_EQ(styled_frame(first.get(), time_ns, &motion.root[3 * i], pose, root.data(), one.data(),
                           nullptr),
              STYLED_OK);
    ASSERT_EQ(styled_frame(second.get(), time_ns, &motion.root[3 * i], pose, root.data(),
                           other.data(), nullptr),
              STYLED_OK);
    if (i < 180) ASSERT_EQ(one, other) << i;
  }
  EXPECT_NE(one, other);
  // A state belongs to the network; the same example of the same name makes the same one.
  std::vector<char> state(styled_save(second.get(), nullptr, 0));
  styled_save(second.get(), state.data(), state.size());
  EXPECT_EQ(styled_restore(first.get(), state.data(), state.size()), STYLED_ERROR_STATE);
  const auto third = create();
  ASSERT_EQ(styled_adopt(third.get(), again.get()), STYLED_OK);
  EXPECT_EQ(styled_restore(third.get(), state.data(), state.size()), STYLED_OK);
  EXPECT_EQ(styled_adopt(third.get(), open_.get()), STYLED_ERROR_ARGUMENT) << "not back";
  EXPECT_EQ(styled_adopt(third.get(), network_), STYLED_ERROR_ARGUMENT) << "other weights";
  EXPECT_EQ(styled_adopt(nullptr, made.get()), STYLED_ERROR_ARGUMENT);
}

TEST_F(LibraryLikeTest, WhatMakesNoStyleIsSaid) {
  const std::string long_name(33, 'a');
  const Clip none{nullptr, styled_free_clip};
  const Clip brief = Make(MotionAt(60, 0), 60);
  struct Case {
    const char* name;
    const Clip* example;
    const char* reason;
  };
  for (const Case& one :
       {Case{"zombie", &example_, "name: found \"zombie\", which the network has"},
        Case{"", &example_, "name: found none"}, Case{nullptr, &example_, "name: found none"},
        Case{long_name.c_str(), &example_, "name: expected at most 32 bytes"},
        Case{"a\nb", &example_, "name: expected at most 32 bytes"},
        Case{"mine", &none, "expected a network and an example"},
        Case{"mine", &brief, "example: found "}}) {
    EXPECT_EQ(Like(one.name, *one.example, none), nullptr);
    EXPECT_THAT(error_.data(), testing::HasSubstr(one.reason));
  }
  EXPECT_EQ(styled_like(network_, "mine", example_.get(), nullptr, error_.data(), error_.size()),
            nullptr);
  EXPECT_THAT(error_.data(), testing::HasSubstr("have no style encoder"));
}

TEST_F(LibraryClipsTest, WhatIsWrongIsSaid) {
  const Motion motion = MotionAt(30, 1);
  const auto fault = [&](const Motion& given, double rate_hz, std::size_t frames) {
    char error[300] = "";
    EXPECT_EQ(styled_make_clip(&body_, rate_hz, frames, given.root.data(), given.rotations.data(),
                               error, sizeof error),
              nullptr);
    return std::string(error);
  };
  EXPECT_EQ(fault(motion, 30, 0),
            "frames: found none, expected at least one, with root and "
            "rotations");
  EXPECT_EQ(fault(motion, 0.5, 3), "rate: found 0.500000 Hz, expected 1 to 1000");
  EXPECT_EQ(fault(motion, std::nan(""), 3), "rate: found nan Hz, expected 1 to 1000");
  Motion broken = motion;
  broken.rotations[4 * names_.size() + 4] = 2;
  EXPECT_EQ(fault(broken, 30, 3), "frame 1: joint 1: the rotation is not of unit length");
  broken.root[2] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(fault(broken, 30, 3), "frame 0: the root is not finite");
  body_.size = offsetof(styled_body, joints);  // a program of version 0.1.0
  const Clip clip = Make(motion, 30);
  EXPECT_EQ(Restyle(clip, "nosuch"),
            "styles: expected 0 to 4 different ones but neutral, with weights of 0 to 1.5 that sum "
            "to at most 1.5");
  EXPECT_EQ(FramesOf(clip).rotations, motion.rotations);
  EXPECT_EQ(styled_clip_length(nullptr, nullptr), 0U);
  EXPECT_EQ(styled_clip_body(nullptr), nullptr);
  EXPECT_EQ(styled_restyle(network_, nullptr, nullptr, nullptr, 0, nullptr, 0),
            STYLED_ERROR_FAILED);
  styled_free_clip(nullptr);
}

}  // namespace
}  // namespace styled

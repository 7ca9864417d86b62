#include <gtest/gtest.h>
#include <malloc.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "model/feet/legs.h"
#include "model/library/styled.h"
#include "model/rig/bind_body.h"
#include "model/stylist/stylist.h"
#include "model/synthetic/performer.h"
#include "model/trial/trial.h"
#include "tests/support/count_new.h"

extern "C" const char* PlainC(const char* weights);

namespace styled {
namespace {

const std::string kWeights = STYLED_SHIPPED "/v2.safetensors";
constexpr std::int64_t kFrame_ns = 1'000'000'000 / 120;

struct Frame {
  std::vector<float> root, rotations;
};

// A body and poses in the arrays of a program.
class LibraryTest : public testing::Test {
 protected:
  LibraryTest() : skeleton_(feet::HumanoidBinding().skeleton()) {
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
  ~LibraryTest() override { styled_release(network_); }

  styled_network* Network() {
    char error[200] = "";
    if (network_ == nullptr) network_ = styled_load(kWeights.c_str(), nullptr, error, sizeof error);
    EXPECT_NE(network_, nullptr) << error;
    return network_;
  }
  styled_performer* Performer() {
    char error[200] = "";
    styled_performer* const performer = styled_create(Network(), &body_, error, sizeof error);
    EXPECT_NE(performer, nullptr) << error;
    return performer;
  }
  void Choose(styled_performer* performer, const char* style) {
    const std::int32_t number = styled_find_style(Network(), style);
    const float weight = 1;
    ASSERT_EQ(styled_set(performer, &number, &weight, 1, 0.1F), STYLED_OK);
  }
  rig::RigPose PoseAt(int frame) const {
    static const rig::Binding binding = feet::HumanoidBinding();
    rig::RigPose pose(skeleton_);
    body::Pose canonical;
    synthetic::Performer({.seed = 3}).Pose(frame / 120.0, canonical);
    binding.Unbind(canonical, pose, pose);
    return pose;
  }
  static Frame FrameOf(const rig::RigPose& pose) {
    Frame frame{{pose.translations[0].begin(), pose.translations[0].end()}, {}};
    for (const rig::Quat& q : pose.rotations) {
      frame.rotations.insert(frame.rotations.end(), q.coeffs().begin(), q.coeffs().end());
    }
    return frame;
  }
  Frame Step(styled_performer* performer, int frame, std::uint32_t* flags = nullptr) const {
    Frame styled = FrameOf(PoseAt(frame));
    EXPECT_EQ(
        styled_frame(performer, frame * kFrame_ns, styled.root.data(), styled.rotations.data(),
                     styled.root.data(), styled.rotations.data(), flags),
        STYLED_OK);
    return styled;
  }

  rig::Skeleton skeleton_;
  std::vector<const char*> names_;
  std::vector<std::int32_t> parents_;
  std::vector<float> offsets_;
  styled_body body_;
  styled_network* network_ = nullptr;
};

TEST_F(LibraryTest, StylesHaveNamesAndLicences) {
  const int count = styled_style_count(Network());
  EXPECT_GT(count, 6);
  EXPECT_STREQ(styled_style_name(Network(), 0), "neutral");
  EXPECT_STREQ(styled_style_name(Network(), styled_find_style(Network(), "Elderly")), "elderly");
  EXPECT_NE(std::string(styled_style_licence(Network(), 1)), "");
  EXPECT_NE(std::string(styled_style_credit(Network(), 1)), "");
  EXPECT_EQ(styled_style_name(Network(), count), nullptr);
  EXPECT_EQ(styled_style_licence(Network(), -1), nullptr);
  EXPECT_EQ(styled_find_style(Network(), "odd"), -1);
  EXPECT_STRNE(styled_version(), "");
}

// The stylist is what the daemon calls for each frame.
TEST_F(LibraryTest, FramesAreThoseOfTheStylistBitForBit) {
  auto network = trial::Load(kWeights, net::Precision::kInt8);
  auto bound = rig::BindBody({.skeleton = skeleton_, .rest = {}});
  ASSERT_TRUE(network.ok() && bound.ok()) << bound.status().message();
  stylist::Stylist stylist(network.value(), bound.value().binding, {});
  stylist::Output out(skeleton_);
  stylist::Settings settings;
  settings.mix[0] = {net::FindStyle(network.value()->model().styles, "elderly"), 1};
  stylist.Set(settings);
  styled_performer* const performer = Performer();
  Choose(performer, "elderly");
  double turned_deg = 0;
  for (int frame = 0; frame < 600; ++frame) {
    const rig::RigPose pose = PoseAt(frame);
    std::uint32_t flags = 0;
    const Frame styled = Step(performer, frame, &flags);
    stylist.Process(frame * kFrame_ns, pose, out);
    EXPECT_EQ(flags, out.flags) << frame;
    for (std::size_t j = 0; j < pose.rotations.size(); ++j) {
      constexpr double kDegrees = 57.29577951308232;
      const rig::Quat q(Eigen::Map<const Eigen::Vector4f>(&styled.rotations[4 * j]));
      EXPECT_EQ(q.coeffs(), out.rig.rotations[j].coeffs()) << frame << ", joint " << j;
      turned_deg = std::max(turned_deg, kDegrees * q.angularDistance(pose.rotations[j]));
    }
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(styled.root[i], out.rig.translations[0][i]) << frame;
    }
  }
  EXPECT_GT(turned_deg, 10);  // not the performer's own
  styled_destroy(performer);
}

TEST_F(LibraryTest, WithoutAStyleFramesAreThePerformersOwnBitForBit) {
  styled_performer* const performer = Performer();
  for (int frame = 0; frame < 30; ++frame) {
    std::uint32_t flags = 0;
    const Frame styled = Step(performer, frame, &flags), own = FrameOf(PoseAt(frame));
    EXPECT_EQ(styled.root, own.root);
    EXPECT_EQ(styled.rotations, own.rotations);
    EXPECT_NE(flags & STYLED_FLAG_BYPASS, 0U);
  }
  styled_destroy(performer);
}

TEST_F(LibraryTest, ASavedPerformerContinuesBitForBit) {
  styled_performer* const one = Performer();
  styled_performer* const other = Performer();
  Choose(one, "active");
  for (int frame = 0; frame < 200; ++frame) Step(one, frame);
  std::vector<char> state(styled_save(one, nullptr, 0));
  EXPECT_EQ(styled_save(one, state.data(), state.size()), state.size());
  EXPECT_EQ(styled_restore(other, state.data(), state.size()), STYLED_OK);
  for (int frame = 200; frame < 320; ++frame) {
    const Frame a = Step(one, frame), b = Step(other, frame);
    EXPECT_EQ(a.root, b.root) << frame;
    EXPECT_EQ(a.rotations, b.rotations) << frame;
  }
  state.pop_back();
  EXPECT_EQ(styled_restore(other, state.data(), state.size()), STYLED_ERROR_STATE);
  EXPECT_EQ(styled_restore(other, "", 0), STYLED_ERROR_STATE);
  state.push_back(0);
  styled_save(one, state.data(), state.size());
  std::swap(names_[1], names_[2]);  // the same joints in another order
  styled_performer* const another = styled_create(Network(), &body_, nullptr, 0);
  if (another != nullptr) {
    EXPECT_EQ(styled_restore(another, state.data(), state.size()), STYLED_ERROR_STATE);
  }
  std::swap(names_[1], names_[2]);
  styled_network* const rough = styled_load(kWeights.c_str(), "float32", nullptr, 0);
  styled_performer* const foreign = styled_create(rough, &body_, nullptr, 0);
  EXPECT_EQ(styled_restore(foreign, state.data(), state.size()), STYLED_ERROR_STATE);
  EXPECT_EQ(styled_restore(other, state.data(), state.size()), STYLED_OK);
  styled_reset(other);
  styled_destroy(another);
  styled_destroy(foreign);
  styled_release(rough);
  Step(other, 0);  // as new
  styled_destroy(one);
  styled_destroy(other);
}

TEST_F(LibraryTest, FramesAllocateNothing) {
  styled_performer* const performer = Performer();
  Choose(performer, "elderly");
  std::vector<Frame> frames;
  for (int frame = 0; frame < 240; ++frame) frames.push_back(FrameOf(PoseAt(frame)));
  int calls = 0;
  {
    const support::CountNew count;
    for (int frame = 0; frame < 240; ++frame) {
      Frame& f = frames[static_cast<std::size_t>(frame)];
      (void)styled_frame(performer, frame * kFrame_ns, f.root.data(), f.rotations.data(),
                         f.root.data(), f.rotations.data(), nullptr);
    }
    const std::int32_t style = 1;
    const float weight = 0.5F;
    (void)styled_set(performer, &style, &weight, 1, 0.3F);
    (void)styled_reset(performer);
    calls = count.calls();
  }
  EXPECT_EQ(calls, 0);
  styled_destroy(performer);
}

TEST_F(LibraryTest, AThousandPerformersComeAndGo) {
  for (int i = 0; i < 10; ++i) styled_destroy(Performer());
  const std::size_t before = mallinfo2().uordblks;
  for (int i = 0; i < 1000; ++i) {
    styled_performer* const performer = Performer();
    Step(performer, 0);
    styled_destroy(performer);
  }
  EXPECT_LT(mallinfo2().uordblks, before + 100'000);  // bytes; a performer has half a megabyte
}

// A network may be released before its performers.
TEST_F(LibraryTest, APerformerKeepsTheNetwork) {
  styled_performer* const performer = Performer();
  Choose(performer, "elderly");
  styled_release(network_);
  network_ = nullptr;
  for (int frame = 0; frame < 10; ++frame) {
    const Frame styled = Step(performer, frame);
    EXPECT_TRUE(std::isfinite(styled.root[0]));
  }
  styled_destroy(performer);
}

TEST_F(LibraryTest, WhatIsWrongIsSaid) {
  const auto fault = [&](auto change) {
    styled_body body = body_;
    change(body);
    char error[300] = "";
    EXPECT_EQ(styled_create(Network(), &body, error, sizeof error), nullptr);
    return std::string(error);
  };
  EXPECT_EQ(fault([](styled_body& body) { body.joint_count = 0; }),
            "body: found 0 joints, expected 1 to 256");
  EXPECT_EQ(fault([](styled_body& body) { body.size = 8; }),
            "body: found size 8, expected " + std::to_string(sizeof(styled_body)));
  EXPECT_EQ(fault([](styled_body& body) { body.names = nullptr; }),
            "body: found NULL, expected names, parents and offsets");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> bad(offsets_.size(), nan);
  EXPECT_EQ(fault([&](styled_body& body) { body.offsets = bad.data(); }),
            "body: joint 0: offset is not finite");
  std::vector<std::int32_t> loop = parents_;
  loop[1] = 5;
  EXPECT_EQ(fault([&](styled_body& body) { body.parents = loop.data(); }),
            "body: joint 1: parent 5, expected an earlier joint");
  EXPECT_NE(std::string(PlainC(kWeights.c_str())).find("leftUpperArm"), std::string::npos)
      << PlainC(kWeights.c_str());
  char error[300] = "", cut[10] = "";
  EXPECT_EQ(styled_load("/nowhere.safetensors", nullptr, error, sizeof error), nullptr);
  EXPECT_NE(std::string(error).find("/nowhere.safetensors"), std::string::npos) << error;
  EXPECT_EQ(styled_load(kWeights.c_str(), "int4", error, sizeof error), nullptr);
  EXPECT_STREQ(error, "precision: found \"int4\", expected int8 or float32");
  EXPECT_EQ(styled_load(kWeights.c_str(), "int4", cut, sizeof cut), nullptr);
  EXPECT_STREQ(cut, "precision");
  EXPECT_EQ(styled_create(nullptr, &body_, nullptr, 0), nullptr);
}

TEST_F(LibraryTest, AbsurdCallsAreRefusedAndChangeNothing) {
  styled_performer* const performer = Performer();
  styled_performer* const undisturbed = Performer();
  Choose(performer, "elderly");
  Choose(undisturbed, "elderly");
  Frame frame = FrameOf(PoseAt(0));
  const auto at = [&](std::int64_t time_ns) {
    Frame out = frame;
    return styled_frame(performer, time_ns, frame.root.data(), frame.rotations.data(),
                        out.root.data(), out.rotations.data(), nullptr);
  };
  for (int i = 0; i < 60; ++i) {
    Step(performer, i);
    Step(undisturbed, i);
    EXPECT_EQ(at(i * kFrame_ns), STYLED_ERROR_TIME);
    EXPECT_EQ(at(-1), STYLED_ERROR_TIME);
    EXPECT_EQ(at(std::numeric_limits<std::int64_t>::max()), STYLED_ERROR_ARGUMENT);
    const std::int32_t style = 99, same[] = {1, 1};
    const float weight = 1, large = 2, nan = std::nanf(""), halves[] = {0.5F, 0.5F};
    EXPECT_EQ(styled_set(performer, &style, &weight, 1, 0), STYLED_ERROR_ARGUMENT);
    EXPECT_EQ(styled_set(performer, same, halves, 2, 0), STYLED_ERROR_ARGUMENT);
    EXPECT_EQ(styled_set(performer, same, &large, 1, 0), STYLED_ERROR_ARGUMENT);
    EXPECT_EQ(styled_set(performer, same, &nan, 1, 0), STYLED_ERROR_ARGUMENT);
    EXPECT_EQ(styled_set(performer, same, &weight, 1, -1), STYLED_ERROR_ARGUMENT);
    EXPECT_EQ(styled_set(performer, same, halves, 5, 0), STYLED_ERROR_ARGUMENT);
    EXPECT_EQ(styled_set(performer, nullptr, nullptr, 1, 0), STYLED_ERROR_ARGUMENT);
    EXPECT_EQ(styled_frame(performer, i, nullptr, nullptr, nullptr, nullptr, nullptr),
              STYLED_ERROR_ARGUMENT);
  }
  EXPECT_EQ(Step(performer, 60).rotations, Step(undisturbed, 60).rotations);
  styled_destroy(performer);
  styled_destroy(undisturbed);
  styled_destroy(nullptr);
  styled_release(nullptr);
}

// Joints that are not finite are held, and the rest goes through.
TEST_F(LibraryTest, AFrameOfNoNumbersIsHeld) {
  styled_performer* const performer = Performer();
  Choose(performer, "elderly");
  for (int i = 0; i < 20; ++i) Step(performer, i);
  Frame frame = FrameOf(PoseAt(20));
  frame.rotations.assign(frame.rotations.size(), std::nanf(""));
  std::uint32_t flags = 0;
  EXPECT_EQ(styled_frame(performer, 20 * kFrame_ns, frame.root.data(), frame.rotations.data(),
                         frame.root.data(), frame.rotations.data(), &flags),
            STYLED_OK);
  EXPECT_NE(flags & STYLED_FLAG_HELD, 0U);
  for (const float number : frame.rotations) EXPECT_TRUE(std::isfinite(number));
  styled_destroy(performer);
}

}  // namespace
}  // namespace styled

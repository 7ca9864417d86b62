// The performer's neutral within the stylist: what the network sees, and what is published.
#include <gtest/gtest.h>

#include "model/base/checkpoint_bytes.h"
#include "model/rig/dialects.h"
#include "model/stylist/stylist.h"
#include "model/synthetic/performer.h"
#include "tests/unit/body/random_pose.h"

namespace styled::stylist {
namespace {

using body::Pose;

struct NoState final : net::Stream {
  std::span<const std::byte> memory() const noexcept override { return {}; }
};

// Reproduces each pose, and turns the head in style 1. Remembers what it saw last.
class Seeing final : public net::Stylizer {
 public:
  explicit Seeing(bool knows_reference) {
    for (const char* const name : {"neutral", "nod", "own"}) {
      model_.styles.emplace_back().name = name;
    }
    if (!knows_reference) return;
    auto& reference = model_.reference.emplace();
    // A performer who stoops; the others are the built-in one.
    reference.standing.rotations[body::kSpine] = body::Exp(body::Vec3(0.2F, 0, 0));
    reference.walking = reference.running = reference.standing;
  }
  const net::Model& model() const noexcept override { return model_; }
  std::unique_ptr<net::Stream> MakeStream() const override { return std::make_unique<NoState>(); }
  void Start(net::Stream& /*stream*/) const noexcept override {}
  void Carry(net::Stream& /*stream*/, Checkpoint& /*c*/) const noexcept override {}
  void Step(std::span<const net::StepJob> jobs) const noexcept override {
    for (const net::StepJob& job : jobs) {
      seen = *job.pose;
      job.out->reconstruction.rotations = job.pose->rotations;
      job.out->reconstruction.velocities_m_s.fill(0);
      job.out->reconstruction.hips_height_m = job.pose->hips_position_m.y();
      job.out->styled = job.out->reconstruction;
      for (const net::StyleWeight& style : job.styles) {
        if (style.style != 1) continue;
        body::Quat& head = job.out->styled.rotations[body::kHead];
        head = head * body::Exp(body::Vec3(0.3F * style.weight, 0, 0));
      }
    }
  }
  mutable Pose seen;

 private:
  net::Model model_;
};

class NeutralOfAStylist : public testing::Test {
 protected:
  NeutralOfAStylist() {
    options_.feet = options_.ground = options_.knees = false;
    settings_.mix[0] = {1, 1.0F};
    settings_.transition_s = 0;
  }
  Stylist Make() {
    Stylist stylist(network_, binding_, options_);
    stylist.Set(settings_);
    return stylist;
  }
  // Seconds [from, to) of a walk.
  void Walk(Stylist& stylist, double from_s, double to_s) {
    synthetic::Performer performer(
        {.seed = 1, .script = synthetic::ParseScript("walk:60").value()});
    const rig::Skeleton& skeleton = binding_->skeleton();
    rig::RigPose in(skeleton);
    for (int i = 0; i < static_cast<int>(to_s * 120); ++i) {
      Pose pose;
      performer.Pose(i / 120.0, pose);
      if (i < static_cast<int>(from_s * 120)) continue;
      binding_->Unbind(pose, rest_, in);
      stylist.Process(std::llround(1e9 * i / 120), in, out_);
    }
  }
  // By how much the spine that the network saw last differs from the performer's own, and from the
  // reference's.
  double SeenSpine_rad() const {
    return body::Angle_rad(network_->seen.rotations[body::kSpine],
                           out_.canonical_input.rotations[body::kSpine]);
  }
  double OffTheReference_rad() const {
    return body::Angle_rad(network_->seen.rotations[body::kSpine],
                           network_->model().reference->walking.rotations[body::kSpine]);
  }

  std::shared_ptr<Seeing> network_ = std::make_shared<Seeing>(true);
  rig::Skeleton skeleton_ = [] {
    rig::Skeleton skeleton;
    for (int j = 0; j < body::kJointCount; ++j) {
      skeleton.names.emplace_back(body::kHumanoid[static_cast<std::size_t>(j)].name);
      skeleton.parents.push_back(body::kHumanoid[static_cast<std::size_t>(j)].parent);
      skeleton.offsets.push_back(body::Offset(j));
    }
    return skeleton;
  }();
  std::shared_ptr<const rig::Binding> binding_ =
      std::make_shared<const rig::Binding>(rig::BindDialect(skeleton_, "canonical").value());
  rig::RigPose rest_{skeleton_};
  Options options_;
  Settings settings_;
  Output out_{skeleton_};
};

TEST_F(NeutralOfAStylist, TheNetworkSeesAStrangerAsItsOwnPerformer) {
  Stylist stylist = Make();
  Walk(stylist, 0, 5);
  EXPECT_GT(SeenSpine_rad(), 0.1);
  EXPECT_LT(OffTheReference_rad(), 0.05);
  EXPECT_TRUE(stylist.has_neutral());
  EXPECT_GT(stylist.neutral().learned(), 0.8F);
}

TEST_F(NeutralOfAStylist, ThePublishedPoseIsTheirOwnTurnedByTheStyle) {
  Stylist stylist = Make();
  Walk(stylist, 0, 5);
  for (std::size_t j = 0; j < body::kJointCount; ++j) {
    const double turned =
        body::Angle_rad(out_.canonical_input.rotations[j], out_.canonical.rotations[j]);
    EXPECT_NEAR(turned, j == body::kHead ? 0.3 : 0, 1e-3) << body::kHumanoid[j].name;
  }
}

// The paper's output is the network's own pose: the carriage is put back before it is published.
TEST_F(NeutralOfAStylist, TheAbsoluteOutputHasTheirCarriage) {
  settings_.absolute = true;
  Stylist stylist = Make();
  Walk(stylist, 0, 5);
  EXPECT_LT(body::Angle_rad(out_.canonical_input.rotations[body::kSpine],
                            out_.canonical.rotations[body::kSpine]),
            0.02);
}

TEST_F(NeutralOfAStylist, IsNotTakenOutWhereNobodyAsksForIt) {
  options_.neutral = false;
  Stylist off = Make();
  Walk(off, 0, 5);
  EXPECT_LT(SeenSpine_rad(), 1e-6);
  EXPECT_FALSE(off.has_neutral());
  options_.neutral = true;
  network_ = std::make_shared<Seeing>(false);
  Stylist unknown = Make();
  Walk(unknown, 0, 5);
  EXPECT_LT(SeenSpine_rad(), 1e-6);
  EXPECT_FALSE(unknown.has_neutral());
}

TEST_F(NeutralOfAStylist, IsNotLearnedFromAPerformerInAStyle) {
  settings_.input_style = 2;
  Stylist stylist = Make();
  Walk(stylist, 0, 5);
  EXPECT_LT(SeenSpine_rad(), 1e-6);
  EXPECT_EQ(stylist.neutral().learned(), 0);
}

TEST_F(NeutralOfAStylist, ARestartKeepsItAndAnotherStylistTakesItOver) {
  Stylist stylist = Make();
  Walk(stylist, 0, 5);
  stylist.Reset();
  Walk(stylist, 5, 5.1);
  EXPECT_GT(SeenSpine_rad(), 0.1);
  EXPECT_LT(OffTheReference_rad(), 0.05);
  Stylist other = Make();
  other.Know(stylist.Tell());
  Walk(other, 5, 5.1);
  EXPECT_GT(SeenSpine_rad(), 0.1);
  EXPECT_LT(OffTheReference_rad(), 0.05);
  other.ForgetNeutral();
  EXPECT_EQ(other.neutral().learned(), 0);
}

TEST_F(NeutralOfAStylist, IsPartOfACheckpoint) {
  Stylist stylist = Make(), other = Make();
  Walk(stylist, 0, 3);
  const auto bytes = CheckpointBytes([&](Checkpoint& c) { stylist.Carry(c); });
  Checkpoint reader = Checkpoint::From(bytes);
  other.Carry(reader);
  ASSERT_TRUE(reader.complete());
  Walk(stylist, 3, 4);
  const Pose seen = network_->seen;
  Walk(other, 3, 4);
  for (std::size_t j = 0; j < body::kJointCount; ++j) {
    EXPECT_EQ(network_->seen.rotations[j].coeffs(), seen.rotations[j].coeffs());
  }
}

}  // namespace
}  // namespace styled::stylist

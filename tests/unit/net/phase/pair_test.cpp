// A style of two networks (several.h): the phase family has it in gaits, another one otherwise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/net/several.h"
#include "tests/unit/net/phase/made.h"

namespace styled::net {
namespace {

using testing::IsEmpty;

// A network whose code is one number: the turn of the head about X.
class HeadSpace final : public StyleSpace {
 public:
  int least_frames() const noexcept override { return 10; }
  StyleCode MakeCode(const StyleRequest& request) const override {
    return {request.sources.front().reference.empty() ? 0.0F : 0.5F};
  }
  NearestStyle Nearest(const StyleCode&) const override { return {}; }
};
struct HeadStream final : Stream {
  std::span<const std::byte> memory() const noexcept override { return {}; }
};
class Head final : public Stylizer {
 public:
  Head() {
    model_.family = "head";
    model_.styles = {{.name = "neutral"}};
    turns_ = {0};
  }
  const Model& model() const noexcept override { return model_; }
  const StyleSpace* space() const noexcept override { return &space_; }
  std::shared_ptr<const Stylizer> With(int number, const StyleInfo& style,
                                       const StyleCode& code) const override {
    auto with = std::make_shared<Head>();
    with->model_ = model_;
    with->turns_ = turns_;
    const auto at = static_cast<std::size_t>(number);
    with->model_.styles.resize(std::max(at + 1, turns_.size()));
    with->turns_.resize(with->model_.styles.size());
    with->model_.styles[at] = style;
    with->turns_[at] = code[0];
    return with;
  }
  std::shared_ptr<const Stylizer> Retired(int) const override { return std::make_shared<Head>(); }
  std::unique_ptr<Stream> MakeStream() const override { return std::make_unique<HeadStream>(); }
  void Start(Stream&) const noexcept override {}
  void Step(std::span<const StepJob> jobs) const noexcept override {
    for (const StepJob& job : jobs) {
      float turn = 0;
      for (const StyleWeight& style : job.styles) {
        turn += style.weight * turns_[static_cast<std::size_t>(style.style)];
      }
      job.out->reconstruction.rotations = job.pose->rotations;
      job.out->reconstruction.velocities_m_s.fill(0);
      job.out->reconstruction.hips_height_m = 1;
      job.out->styled = job.out->reconstruction;
      auto& head = job.out->styled.rotations[body::kHead];
      head = head * body::Exp({turn, 0, 0});
    }
  }

 private:
  Model model_;
  HeadSpace space_;
  std::vector<float> turns_;
};

class PairTest : public testing::Test {
 protected:
  StyleCode CodeOf(const std::vector<body::Pose>& example, const std::string& network = "") {
    StyleRequest request;
    request.sources = {{.style = -1, .seed = {}, .reference = example, .weight = 1}};
    request.network = network;
    return both_->space()->MakeCode(request);
  }
  // The turns of head and left elbow that the style of `code` makes of the last pose.
  std::pair<float, float> Turns(const std::vector<body::Pose>& poses, const StyleCode& code) {
    const auto number = static_cast<int>(both_->model().styles.size());
    const auto network = both_->With(number, {.name = "made"}, code);
    const auto stream = network->MakeStream();
    network->Start(*stream);
    const StyleWeight made{number, 1};
    const neutral::Reference& reference = *network->model().reference;
    neutral::Neutral neutral;
    Prediction out;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      neutral.Follow(poses[i], i == 0 ? 0 : 1 / 30.0F, true, reference);
      const Performer performer{&poses[i], &neutral, &reference, 0, 0};
      const StepJob job{&poses[i], 0, {&made, 1}, stream.get(), &out, {}, &performer};
      network->Step({&job, 1});
    }
    const auto turn = [&](body::Joint joint) {
      return body::Log(out.reconstruction.rotations[joint].conjugate() *
                       out.styled.rotations[joint]);
    };
    return {turn(body::kHead).x(), -turn(body::kLeftLowerArm).y()};
  }

  std::shared_ptr<const Stylizer> both_ =
      Combine({{"head", std::make_shared<const Head>()}, {"open", phase::TestStylizer()}}).value();
};

TEST_F(PairTest, AWalkIsAPairAndOtherMotionIsNot) {
  const StyleCode walk = CodeOf(phase::StyledWalk(8));
  EXPECT_EQ(walk.size(), phase::kCodeSize + 1);
  EXPECT_TRUE(both_->space()->IsCode(walk));
  EXPECT_EQ(CodeOf(gait::Perform("wave-left:60", 4, 30)).size(), 1U);
  EXPECT_EQ(CodeOf(std::vector<body::Pose>(60)).size(), phase::kCodeSize) << "a pose";
  EXPECT_EQ(CodeOf(phase::StyledWalk(8), "open").size(), phase::kCodeSize);
  EXPECT_EQ(CodeOf(phase::StyledWalk(8), "phase").size(), phase::kCodeSize) << "by its family";
  EXPECT_EQ(CodeOf(phase::StyledWalk(8), "head").size(), 1U);
  EXPECT_THAT(CodeOf(phase::StyledWalk(8), "none-such"), IsEmpty());
}

TEST_F(PairTest, WhoWalksHasThePhasesStyleAndWhoStandsTheOther) {
  const StyleCode code = CodeOf(phase::StyledWalk(8));
  const auto [head, elbow] = Turns(gait::Perform("walk:60", 6, 30), code);
  EXPECT_NEAR(head, 0, 0.08);
  EXPECT_NEAR(elbow, phase::kElbow_rad, 0.1);
  const auto [still_head, still_elbow] = Turns(gait::Perform("stand:60", 6, 30), code);
  EXPECT_NEAR(still_head, 0.5, 0.01);
  EXPECT_NEAR(still_elbow, 0, 0.01);
}

TEST_F(PairTest, OnlyThePhasesPartIsPortable) {
  const StyleCode code = CodeOf(phase::StyledWalk(8));
  EXPECT_EQ(both_->space()->Portable(code).size(), phase::kCodeSize);
  EXPECT_THAT(both_->space()->Portable(CodeOf(phase::StyledWalk(8), "head")), IsEmpty());
}

TEST_F(PairTest, MeansAndDifferencesArePartByPart) {
  const StyleSpace& space = *both_->space();
  const StyleCode pair = CodeOf(phase::StyledWalk(8)), alone = CodeOf(phase::StyledWalk(8), "open");
  EXPECT_EQ(space.Mean(pair, pair, 0.5F).size(), pair.size());
  EXPECT_EQ(space.Mean(alone, CodeOf(phase::StyledWalk(8), "head"), 0.5F).size(), pair.size());
  EXPECT_EQ(space.Difference(pair, alone).size(), alone.size());
  EXPECT_THAT(space.Difference(alone, CodeOf(phase::StyledWalk(8), "head")), IsEmpty());
}

TEST_F(PairTest, ADesignBelongsToThePhases) {
  const StyleSpace& space = *both_->space();
  EXPECT_EQ(space.Design({}, {{"stoop", 20}}).value().size(), phase::kCodeSize);
  EXPECT_EQ(space.Design(CodeOf(phase::StyledWalk(8)), {{"stoop", 20}}).value().size(),
            phase::kCodeSize);
  EXPECT_FALSE(space.Design(CodeOf(phase::StyledWalk(8), "head"), {{"stoop", 20}}).ok());
  EXPECT_FALSE(space.sliders().empty());
}

TEST_F(PairTest, APlaceMayHoldStylesOfDifferentNetworksInTurn) {
  const auto number = static_cast<int>(both_->model().styles.size());
  const auto first = both_->With(number, {.name = "made"}, CodeOf(phase::StyledWalk(8), "head"));
  const auto second = first->With(number, {.name = "made"}, CodeOf(phase::StyledWalk(8)));
  const auto third = second->With(number, {.name = "made"}, CodeOf(phase::StyledWalk(8), "open"));
  EXPECT_EQ(first->model().styles.back().model, "head");
  EXPECT_EQ(second->model().styles.back().model, "open");
  EXPECT_EQ(third->model().styles.size(), first->model().styles.size());
}

}  // namespace
}  // namespace styled::net

#include "model/net/phase/stylizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/feet/legs.h"
#include "model/stylist/stylist.h"
#include "tests/unit/net/phase/made.h"

namespace styled::phase {
namespace {

using testing::HasSubstr;

// The synthetic performer through the stylist.
class PhaseStylizerTest : public testing::Test {
 protected:
  struct Run {
    std::vector<stylist::Output> frames;
  };

  std::vector<stylist::Output> Style(const std::vector<body::Pose>& poses, double rate_hz,
                                     const std::shared_ptr<const net::Stylizer>& network,
                                     float weight = 1) {
    stylist::Options options;
    options.feet = options.ground = options.knees = false;
    stylist::Stylist stylist(network, binding_, options);
    stylist::Settings settings;
    settings.mix[0] = {1, weight};
    settings.transition_s = 0;
    stylist.Set(settings);
    std::vector<stylist::Output> frames;
    rig::RigPose in(binding_->skeleton());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      binding_->Unbind(poses[i], in, in);
      stylist::Output& out = frames.emplace_back(binding_->skeleton());
      stylist.Process(static_cast<std::int64_t>(1e9 * static_cast<double>(i) / rate_hz), in, out);
    }
    return frames;
  }

  // The mean and the largest rotation between what was styled and what was wanted, of both arms,
  // degrees, from `from_s` on.
  static std::pair<double, double> Off_deg(const std::vector<stylist::Output>& frames,
                                           const std::vector<body::Pose>& wanted, double rate_hz,
                                           double from_s) {
    double sum = 0, most = 0, count = 0;
    for (auto i = static_cast<std::size_t>(from_s * rate_hz); i < frames.size(); ++i) {
      for (const int joint : {body::kLeftUpperArm, body::kLeftLowerArm, body::kRightLowerArm}) {
        const auto j = static_cast<std::size_t>(joint);
        const auto off = static_cast<double>(
            wanted[i].rotations[j].angularDistance(frames[i].canonical.rotations[j]));
        sum += off;
        most = std::max(most, off);
        ++count;
      }
    }
    return {sum / count * 57.3, most * 57.3};
  }

  std::shared_ptr<const rig::Binding> binding_ =
      std::make_shared<const rig::Binding>(feet::HumanoidBinding());
};

TEST_F(PhaseStylizerTest, AWrittenFileIsReadAsItsFamily) {
  const net::Model& model = TestStylizer()->model();
  EXPECT_EQ(model.family, "phase");
  ASSERT_TRUE(model.reference && model.reference->gaits);
  EXPECT_GT(model.styles[1].walk_mps, 0.5F);
  EXPECT_GT(model.styles[1].walk_spm, 60);
}

TEST_F(PhaseStylizerTest, AFileWithoutANeutralIsRefused) {
  const support::TemporaryFolder folder;
  const auto error = [&](const net::Model& model, const phase::Style& neutral) {
    const std::filesystem::path file = folder / "phase.safetensors";
    EXPECT_TRUE(Write(file, model, {ToCode(neutral), ToCode(TestNeutral())}).ok());
    return net::Load(file).status().message();
  };
  net::Model without = TestModel();
  without.reference.reset();
  EXPECT_THAT(error(without, TestNeutral()), HasSubstr("key 'reference'"));
  EXPECT_THAT(error(TestModel(), StyleOfScript("walk:60", 5)),
              HasSubstr("row 0, the neutral: expected a walk and a run"));
}

// At each rate, the whole arms of the example's walk, its phase included.
TEST_F(PhaseStylizerTest, AWalkBecomesTheExamplesWalkAtAnyRate) {
  for (const float rate_hz : {24.0F, 30.0F, 60.0F, 120.0F, 240.0F}) {
    const std::vector<body::Pose> walk = gait::Perform("walk:60", 8, rate_hz);
    const auto frames = Style(walk, rate_hz, TestStylizer());
    const auto [mean, most] = Off_deg(frames, StyledWalk(8, rate_hz), rate_hz, 3);
    EXPECT_LT(mean, 2.5) << rate_hz;
    EXPECT_LT(most, 8) << rate_hz;
    const auto [plain, unused] = Off_deg(frames, walk, rate_hz, 3);
    EXPECT_GT(plain, 20) << rate_hz;
  }
}

TEST_F(PhaseStylizerTest, WithoutAGaitThePostureRemains) {
  const std::vector<body::Pose> stand = gait::Perform("stand:60", 5, 60);
  const auto frames = Style(stand, 60, TestStylizer());
  const body::Quat& own = stand.back().rotations[body::kRightLowerArm];
  const body::Quat& shown = frames.back().canonical.rotations[body::kRightLowerArm];
  EXPECT_NEAR(body::Log(own.conjugate() * shown).y(), kElbow_rad, 0.1);
  // What depends on the phase is gone: nothing moves beyond what the performer moves.
  const std::size_t j = body::kLeftUpperArm;
  const auto turn = [&](std::size_t i) {
    return body::Log(stand[i].rotations[j].conjugate() * frames[i].canonical.rotations[j]);
  };
  EXPECT_LT((turn(240) - turn(290)).norm(), 0.02);
}

TEST_F(PhaseStylizerTest, AnArmThatDoesSomethingOfItsOwnIsLeftToIt) {
  std::vector<body::Pose> walk = gait::Perform("walk:60", 6, 60);
  for (std::size_t i = 240; i < walk.size(); ++i) {  // straight up
    walk[i].rotations[body::kLeftUpperArm] = body::Exp({0, 0, 1.5F});
  }
  const auto frames = Style(walk, 60, TestStylizer());
  const auto turn = [&](std::size_t i, int joint) {
    const auto j = static_cast<std::size_t>(joint);
    return body::Log(walk[i].rotations[j].conjugate() * frames[i].canonical.rotations[j]).norm();
  };
  EXPECT_GT(turn(200, body::kLeftLowerArm), 0.5);
  EXPECT_LT(turn(330, body::kLeftLowerArm), 0.15);
  EXPECT_GT(turn(330, body::kRightLowerArm), 0.5);
}

TEST_F(PhaseStylizerTest, WeightsScaleTheChange) {
  const std::vector<body::Pose> walk = gait::Perform("walk:60", 6, 60);
  const auto frames = Style(walk, 60, TestStylizer(), 0.5F);
  const auto j = static_cast<std::size_t>(body::kRightLowerArm);
  const body::Vec3 turn =
      body::Log(walk.back().rotations[j].conjugate() * frames.back().canonical.rotations[j]);
  EXPECT_NEAR(turn.y(), kElbow_rad / 2, 0.06);
}

TEST_F(PhaseStylizerTest, AnExampleIsOneMoreStyle) {
  net::StyleRequest request;
  const std::vector<body::Pose> example = StyledWalk(6);
  request.sources = {{.style = -1, .seed = {}, .reference = example, .weight = 1}};
  const auto base = TestStylizer();
  const auto with = base->With(2, {.name = "made"}, base->space()->MakeCode(request));
  EXPECT_EQ(with->model().styles[2].name, "made");
  EXPECT_GT(with->model().styles[2].walk_mps, 0.5F);
  EXPECT_TRUE(with->SharesStreams(*base));
  EXPECT_TRUE(with->Retired(2)->model().styles[2].retired);
}

TEST_F(PhaseStylizerTest, AStreamContinuesFromItsCheckpoint) {
  const auto network = TestStylizer();
  const auto one = network->MakeStream(), other = network->MakeStream();
  network->Start(*one);
  network->Start(*other);
  const net::StyleWeight bent{1, 1};
  const auto step = [&](net::Stream& stream, const body::Pose& pose) {
    net::Prediction out;
    const net::StepJob job{&pose, 0, {&bent, 1}, &stream, &out};
    network->Step({&job, 1});
    return out.styled.rotations;
  };
  for (const body::Pose& pose : gait::Perform("wave-left:60", 3, 30)) step(*one, pose);
  std::vector<std::byte> bytes(4096);
  Checkpoint write = Checkpoint::Into(bytes);
  network->Carry(*one, write);
  ASSERT_TRUE(write.ok());
  Checkpoint read = Checkpoint::From(std::span(bytes).first(write.size()));
  network->Carry(*other, read);
  ASSERT_TRUE(read.complete());
  const body::Pose next = gait::Perform("wave-left:60", 4, 30).back();
  const auto a = step(*one, next), b = step(*other, next);
  for (std::size_t j = 0; j < a.size(); ++j) EXPECT_EQ(a[j].coeffs(), b[j].coeffs());
}

}  // namespace
}  // namespace styled::phase

// A whole training in small: the synthetic performer in two manners, some minutes of motion, judges
// of its own. The judges must distinguish the trained styles; without training the same checks must
// fail.

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <map>

#include "model/clip/clip.h"
#include "model/synthetic/performer.h"
#include "model/train/erd/recipe.h"
#include "model/train/judge/validation.h"
#include "model/train/trainer.h"

namespace styled::train {
namespace {

using synthetic::Motion;

constexpr double kRate_hz = 30;
constexpr double kSeconds = 24;

// The other manner: stooped, the arms swing half as far and a little away from the body.
body::Pose Stooped(body::Pose pose) {
  const auto bend = [&pose](int joint, float x_rad, float z_rad) {
    pose.rotations[joint] = pose.rotations[joint] * body::Exp(body::Vec3(x_rad, 0, z_rad));
  };
  for (const int arm : {body::kLeftLowerArm, body::kRightLowerArm}) {
    pose.rotations[arm] = body::Exp(body::Log(pose.rotations[arm]) * 0.5F);
  }
  bend(body::kSpine, 0.35F, 0);
  bend(body::kChest, 0.25F, 0);
  bend(body::kHead, -0.3F, 0);
  bend(body::kLeftUpperArm, 0, 0.3F);
  bend(body::kRightUpperArm, 0, -0.3F);
  return pose;
}

class Smoke : public testing::Test {
 protected:
  void SetUp() override {
    root_ = std::filesystem::temp_directory_path() / ("styled_smoke_" + std::to_string(::getpid()));
    std::filesystem::create_directories(root_ / "clips");
    std::uint64_t k = 0;
    for (const std::string manner : {"upright", "stooped"}) {
      for (const Motion motion : {Motion::kWalk, Motion::kWaveRight}) {
        const std::string content = motion == Motion::kWalk ? "walk" : "wave";
        for (int take = 1; take <= 2; ++take) {
          synthetic::Performer human(synthetic::Vary(7, ++k, {{motion, 60}}));
          clip::Clip clip;
          clip.skeleton = synthetic::MakeSkeleton({});
          clip.rate_hz = kRate_hz;
          for (int i = 0; i < static_cast<int>(kSeconds * kRate_hz); ++i) {
            body::Pose pose;
            human.Pose(i / kRate_hz, pose);
            if (manner == "stooped") pose = Stooped(pose);
            rig::RigPose frame(clip.skeleton);
            frame.translations[0] = pose.hips_position_m;
            frame.rotations.assign(pose.rotations.begin(), pose.rotations.end());
            clip.frames.push_back(frame);
          }
          const auto file =
              root_ / "clips" / (content + "_" + manner + "_" + std::to_string(take) + ".bvh");
          ASSERT_TRUE(clip::WriteBvh(clip, file).ok());
        }
      }
    }
    std::ofstream manifest(root_ / "manifest.toml");
    manifest << R"(
name = "two manners"
licence = "none"
neutral = "upright"
styles = [ { name = "upright", labels = ["upright"] }, { name = "stooped", labels = ["stooped"] } ]
contents = [ { name = "walk", labels = ["walk"] }, { name = "wave", labels = ["wave"] } ]
)";
    for (const auto& [split, time] : {std::pair{"train", "[0.0, 0.6]"},
                                      {"judge", "[0.6, 0.8]"},
                                      {"validation", "[0.8, 1.0]"}}) {
      manifest
          << "[[clips]]\npattern = \"clips/{content}_{style}_{take}.bvh\"\nrig = \"canonical\"\n"
          << "split = \"" << split << "\"\ntime = " << time << "\n";
    }
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  // The figures of a run of so many iterations.
  std::map<std::string, double> Figures(const judge::Validator& judge, const std::string& out,
                                        int iterations) {
    RunConfig run;
    run.manifest = root_ / "manifest.toml";
    run.data = root_;
    run.out = root_ / out;
    run.device = "cpu";
    run.iterations = iterations;
    run.monitor_every = 100000;
    run.log_every = 250;
    style_erd::Config config;
    config.classifier_iterations = 100;
    config.per_style = 6;
    config.w_smooth = 4;
    config.w_penalty = 40;
    const auto recipe = style_erd::MakeRecipe(run, config);
    EXPECT_TRUE(recipe.ok()) << recipe.status().message();
    if (!recipe.ok()) return {};
    const Status trained = Train(run, *recipe.value());
    EXPECT_TRUE(trained.ok()) << trained.message();
    const auto figures = judge.Measure(run.out / "weights.safetensors");
    EXPECT_TRUE(figures.ok()) << figures.status().message();
    std::map<std::string, double> named;
    for (const auto& [name, value] : figures.value()) {
      named[name] = value;
      std::cout << out << ": " << name << " " << value << std::endl;
    }
    return named;
  }

  std::filesystem::path root_;
};

TEST_F(Smoke, TrainingLearnsAMannerAndAnUntrainedNetworkHasNone) {
  judge::JudgeSettings settings;
  settings.iterations = 250;
  auto judge = judge::Validator::Make(root_ / "manifest.toml", root_, root_ / "judges", settings);
  ASSERT_TRUE(judge.ok()) << judge.status().message();
  EXPECT_TRUE(judge.value().Claim(root_ / "claimed", false).ok());
  EXPECT_TRUE(judge.value().Claim(root_ / "claimed", true).ok());
  std::ofstream(root_ / "claimed" / "judges.sha256") << "00ff\n";
  EXPECT_NE(judge.value().Claim(root_ / "claimed", true).message().find("judges of SHA-256 00ff"),
            std::string::npos)
      << "a curve is of one set of judges";
  EXPECT_TRUE(judge.value().Claim(root_ / "claimed", false).ok()) << "a new run";
  auto trained = Figures(judge.value(), "trained", 1200);
  EXPECT_GE(trained["sra"], 0.9);
  EXPECT_GE(trained["cra"], 0.9);
  EXPECT_GE(trained["cosine"], 0.8);
  EXPECT_LT(Figures(judge.value(), "untrained", 1)["sra"], 0.9);
}

}  // namespace
}  // namespace styled::train

// How much of what a network shows of a style is published: no stage after it may lose a part
// unseen. On a clip of the training's performers and on one of a stranger.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "model/clip/bind_clip.h"
#include "model/clip/clip.h"
#include "model/stylist/stylist.h"
#include "model/trial/trial.h"
#include "tests/unit/trial/data_folder.h"

namespace styled::stylist {
namespace {

// The rotation of a limb's joints by a style, rad: the mean over time, which is a pose, and the
// rest, the movement. Root mean squares over joints and frames.
struct Figures {
  PerLimb pose{}, movement{};
};

struct PublishedStyle : testing::Test {
  void SetUp() override {
    auto loaded = trial::Load(STYLED_SHIPPED "/v2.safetensors");
    ASSERT_TRUE(loaded.ok());
    network = loaded.value();
  }

  Figures Restyle(const clip::Clip& clip, const std::shared_ptr<const rig::Binding>& binding,
                  int style, const Options& options) const {
    Stylist stylist(network, binding, options);
    Settings settings;
    settings.mix[0] = {style, 1};
    settings.transition_s = 0;
    stylist.Set(settings);
    Output out(binding->skeleton());
    using Turns = Eigen::Matrix<float, 3, body::kJointCount>;
    std::vector<Turns> turns;
    Turns mean = Turns::Zero();
    for (std::size_t frame = 0; frame < clip.frames.size(); ++frame) {
      stylist.Process(std::llround(1e9 * static_cast<double>(frame) / kRate_hz), clip.frames[frame],
                      out);
      if (static_cast<double>(frame) < kRate_hz) continue;  // it sets in
      Turns& turn = turns.emplace_back();
      for (int joint = 0; joint < body::kJointCount; ++joint) {
        const auto j = static_cast<std::size_t>(joint);
        turn.col(joint) =
            body::Log(out.canonical_input.rotations[j].conjugate() * out.canonical.rotations[j]);
      }
      mean += turn;
    }
    mean /= static_cast<float>(turns.size());
    Figures figures;
    PerLimb joints{};
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const auto limb = static_cast<std::size_t>(LimbOf(body::PartOf(joint)));
      ++joints[limb];
      figures.pose[limb] += mean.col(joint).squaredNorm();
      for (const Turns& turn : turns) {
        figures.movement[limb] +=
            (turn.col(joint) - mean.col(joint)).squaredNorm() / static_cast<float>(turns.size());
      }
    }
    for (std::size_t limb = 0; limb < joints.size(); ++limb) {
      figures.pose[limb] = std::sqrt(figures.pose[limb] / joints[limb]);
      figures.movement[limb] = std::sqrt(figures.movement[limb] / joints[limb]);
    }
    return figures;
  }

  // The least that is left, over six styles, of what the network shows by itself: over both arms,
  // the trunk, and both legs.
  void ExpectLeft(const std::string& file, const PerLimb& pose, const PerLimb& movement) const {
    if (!std::filesystem::exists(DataFolder(STYLED_DATA_DEFAULT) / file)) {
      GTEST_SKIP() << "skipped, no data in " << DataFolder(STYLED_DATA_DEFAULT)
                   << " (set STYLED_DATA)";
    }
    const auto read = clip::ReadBvh(DataFolder(STYLED_DATA_DEFAULT) / file);
    ASSERT_TRUE(read.ok());
    clip::Clip clip = clip::Resample(read.value(), kRate_hz);
    const auto bound = clip::BindClip(clip);
    ASSERT_TRUE(bound.ok()) << bound.status().message();
    const auto binding = std::make_shared<const rig::Binding>(bound.value().binding);
    Options bare;
    bare.change_tau_s = bare.posture = 0;
    bare.limb_gate = bare.knees = bare.ground = bare.feet = false;
    for (const char* name :
         {"active", "elderly", "exhausted", "feminine", "masculine", "youthful"}) {
      const int style = net::FindStyle(network->model().styles, name);
      const Figures whole = Restyle(clip, binding, style, bare);
      const Figures published = Restyle(clip, binding, style, Options());
      std::string line = std::string(name) + ", left of pose and movement:";
      for (std::size_t limb = 0; limb < kLimbCount; ++limb) {
        const float of_pose = published.pose[limb] / whole.pose[limb];
        const float of_movement = published.movement[limb] / whole.movement[limb];
        char text[64];
        std::snprintf(text, sizeof text, " %s %.2f %.2f", std::string(kLimbNames[limb]).c_str(),
                      static_cast<double>(of_pose), static_cast<double>(of_movement));
        line += text;
        EXPECT_GT(of_pose, pose[limb]) << name << ", " << kLimbNames[limb];
        EXPECT_GT(of_movement, movement[limb]) << name << ", " << kLimbNames[limb];
      }
      std::printf("%s\n", line.c_str());
    }
  }

  std::shared_ptr<const net::Stylizer> network;
};

TEST_F(PublishedStyle, OfTheTrainingsPerformersIsWhatTheNetworkShows) {
  ExpectLeft("samples/dataset-2_walk_normal_001.bvh", {0.9F, 0.9F, 0.9F, 0.8F, 0.8F},
             {0.9F, 0.9F, 0.9F, 0.7F, 0.7F});
}

TEST_F(PublishedStyle, OfAStrangerIsNearlyWhatTheNetworkShows) {
  ExpectLeft("xia/neutral_01_000.bvh", {0.9F, 0.9F, 0.9F, 0.55F, 0.55F},
             {0.9F, 0.9F, 0.9F, 0.7F, 0.7F});
}

}  // namespace
}  // namespace styled::stylist

// The gate of limbs on real clips: known acts pass, unknown ones keep the performer's own motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "model/clip/clip.h"
#include "model/rig/dialects.h"
#include "model/stylist/stylist.h"
#include "model/trial/trial.h"
#include "tests/unit/trial/data_folder.h"

namespace styled::stylist {
namespace {

constexpr int kFeminine = 6;

std::filesystem::path Data() { return DataFolder(STYLED_DATA_DEFAULT) / "samples"; }

struct LimbGateOnClips : testing::Test {
  void SetUp() override {
    if (!std::filesystem::exists(Data())) {
      GTEST_SKIP() << "skipped, no data in " << Data() << " (set STYLED_DATA)";
    }
    auto loaded = trial::Load(STYLED_SHIPPED "/v2.safetensors");
    ASSERT_TRUE(loaded.ok());
    network = loaded.value();
  }

  // The rotation of each limb's joints by a style, rad in the mean over joints and frames, with the
  // gate; that as a share of the rotation without it; and the least of its style that a limb shows.
  struct Shown {
    PerLimb turned_rad, left, least{1, 1, 1, 1, 1};
  };
  Shown Restyle(const std::string& name) {
    const auto read = clip::ReadBvh(Data() / name);
    EXPECT_TRUE(read.ok());
    const clip::Clip clip = clip::Resample(read.value(), kRate_hz);
    auto bound = rig::BindDialect(clip.skeleton);
    EXPECT_TRUE(bound.ok());
    const auto binding = std::make_shared<const rig::Binding>(std::move(bound.value()));
    std::array<PerLimb, 2> turned{};
    Shown shown;
    for (const bool gate : {false, true}) {
      Options options;
      options.limb_gate = gate;
      options.posture = 0;  // it turns arms against the chest
      Stylist stylist(network, binding, options);
      Settings settings;
      settings.mix[0] = {kFeminine, 1};
      stylist.Set(settings);
      Output out(binding->skeleton());
      for (std::size_t frame = 0; frame < clip.frames.size(); ++frame) {
        stylist.Process(std::llround(1e9 * static_cast<double>(frame) / kRate_hz),
                        clip.frames[frame], out);
        for (std::size_t limb = 0; limb < shown.least.size(); ++limb) {
          if (gate) shown.least[limb] = std::min(shown.least[limb], out.limb_weights[limb]);
        }
        for (int joint = 0; joint < body::kJointCount; ++joint) {
          const auto j = static_cast<std::size_t>(joint);
          turned[gate ? 1 : 0][static_cast<std::size_t>(LimbOf(body::PartOf(joint)))] +=
              body::Log(out.canonical_input.rotations[j].conjugate() * out.canonical.rotations[j])
                  .norm();
        }
      }
    }
    PerLimb joints{};
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      ++joints[static_cast<std::size_t>(LimbOf(body::PartOf(joint)))];
    }
    for (std::size_t limb = 0; limb < joints.size(); ++limb) {
      shown.turned_rad[limb] =
          turned[1][limb] / (joints[limb] * static_cast<float>(clip.frames.size()));
      shown.left[limb] = turned[1][limb] / turned[0][limb];
    }
    return shown;
  }

  std::shared_ptr<const net::Stylizer> network;
};

TEST_F(LimbGateOnClips, KnownActsKeepTheirStyle) {
  for (const char* name :
       {"dataset-1_walk_normal_001.bvh", "dataset-2_walk_normal_001.bvh",
        "dataset-2_walk-turn-left_normal_001.bvh", "dataset-2_raise-up-right-hand_normal_001.bvh",
        "dataset-2_wave-both-hands_normal_001.bvh"}) {
    const Shown shown = Restyle(name);
    for (std::size_t limb = 0; limb < shown.left.size(); ++limb) {
      EXPECT_GE(shown.left[limb], 0.95F) << name << " " << kLimbNames[limb];
      EXPECT_GT(shown.turned_rad[limb], 0.05F) << name << " " << kLimbNames[limb];
    }
  }
}

TEST_F(LimbGateOnClips, PunchesAndKicksAreThePerformersOwn) {
  for (const char* name : {"dataset-1_punch_normal_001.bvh", "dataset-1_kick_normal_001.bvh"}) {
    const Shown shown = Restyle(name);
    for (const Limb arm : {Limb::kLeftArm, Limb::kRightArm}) {
      const auto limb = static_cast<std::size_t>(arm);
      EXPECT_LT(shown.least[limb], 0.1F) << name << " " << kLimbNames[limb];
      EXPECT_LT(shown.left[limb], 0.8F) << name << " " << kLimbNames[limb];
    }
  }
}

}  // namespace
}  // namespace styled::stylist

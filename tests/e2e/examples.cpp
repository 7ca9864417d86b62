#include "tests/e2e/examples.h"

#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "model/clip/clip.h"
#include "sim/player/performer_motion.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::support {

std::string CausalWeights(const std::string& file) {
  const std::vector<std::byte> bytes = stgcn_causal::RandomWeights(4, 16, 1).Bytes();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return file;
}

std::string WalkBvh(double rate_hz, double seconds) {
  return MotionBvh(synthetic::Motion::kWalk, rate_hz, seconds);
}

std::string HangingWalkBvh(double rate_hz, double seconds) {
  clip::Clip clip = clip::ParseBvh(WalkBvh(rate_hz, seconds), "walk").value();
  rig::Skeleton& skeleton = clip.skeleton;
  // Of the zero pose's joints, from the T-pose's.
  std::vector<rig::Quat> world(skeleton.names.size(), rig::Quat::Identity());
  int turned = 0;
  for (std::size_t j = 0; j < world.size(); ++j) {
    const int parent = skeleton.parents[j];
    if (parent >= 0) world[j] = world[static_cast<std::size_t>(parent)];
    const rig::Quat above = world[j];
    for (const auto& [name, down_rad] :
         {std::pair("leftUpperArm", -1.48F), std::pair("rightUpperArm", 1.48F)}) {
      if (skeleton.names[j] != name) continue;
      world[j] = world[j] * rig::Quat(Eigen::AngleAxisf(down_rad, rig::Vec3::UnitZ()));
      ++turned;
    }
    if (parent >= 0) {
      skeleton.offsets[j] = above * skeleton.offsets[j];
      for (rig::RigPose& frame : clip.frames) {
        frame.translations[j] = above * frame.translations[j];
        frame.rotations[j] = above * frame.rotations[j] * world[j].conjugate();
      }
    }
  }
  EXPECT_EQ(turned, 2);
  return clip::FormatBvh(clip);
}

std::string MotionBvh(synthetic::Motion motion_of, double rate_hz, double seconds) {
  const TemporaryFolder folder;
  synthetic::Options options;
  options.script = {{motion_of, 60}};
  player::PerformerMotion motion(std::move(options), {}, rate_hz);
  const std::string file = folder / "walk.bvh";
  EXPECT_TRUE(player::WriteMotion(motion, seconds, rate_hz, file).ok());
  return ReadText(file);
}

std::vector<std::string> StylesOf(const Daemon& daemon) {
  ControlClient control(daemon.control);
  v1::Request request;
  request.mutable_list();
  const v1::Reply reply = control.Ask(request);
  std::vector<std::string> names;
  for (const auto& style : reply.list().styles()) names.push_back(style.name());
  return names;
}

}  // namespace styled::support

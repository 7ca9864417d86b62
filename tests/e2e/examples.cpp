#include "tests/e2e/examples.h"

#include <gtest/gtest.h>

#include <fstream>

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

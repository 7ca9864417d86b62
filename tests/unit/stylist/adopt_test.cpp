// A stylist whose network gets another style continues as if it had had that style from the start.
#include <gtest/gtest.h>

#include "model/body/humanoid.h"
#include "model/feet/legs.h"
#include "model/net/load.h"
#include "model/stylist/stylist.h"
#include "model/synthetic/performer.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::stylist {
namespace {

constexpr int kFrames = 240, kAdopted = 100;
constexpr double kRate_hz = 120;

Settings In(int style) {
  Settings settings;
  settings.mix[0] = {style, 1};
  settings.transition_s = 0.2F;
  return settings;
}

TEST(Adopt, TheMotionIsThatOfANetworkThatHadTheStyleFromTheStart) {
  const auto loaded = net::Parse(stgcn_causal::RandomWeights(3, 16, 1).Bytes(), "random");
  ASSERT_TRUE(loaded.ok()) << loaded.status().message();
  const auto plain = loaded.value();
  net::StyleRequest half;
  half.sources = {{.style = 1, .weight = 0.5F}, {.style = 2, .weight = 0.5F}};
  const auto more = plain->With(3, {.name = "half"}, plain->space()->MakeCode(half));

  const auto binding = std::make_shared<const rig::Binding>(feet::HumanoidBinding());
  Stylist adopting(plain, binding, {}), knowing(more, binding, {});
  adopting.Set(In(1));
  knowing.Set(In(1));
  synthetic::Options options;
  options.script = {{synthetic::Motion::kWalk, 10}};
  synthetic::Performer performer(std::move(options));
  const rig::RigPose rest(binding->skeleton());
  rig::RigPose in(binding->skeleton());
  Output found(binding->skeleton()), expected(binding->skeleton());
  body::Pose pose;
  for (int frame = 0; frame < kFrames; ++frame) {
    if (frame == kAdopted) {
      adopting.Adopt(more);
      adopting.Set(In(3));
      knowing.Set(In(3));
    }
    performer.Pose(frame / kRate_hz, pose);
    binding->Unbind(pose, rest, in);
    const auto time_ns = static_cast<std::int64_t>(frame * (1e9 / kRate_hz));
    adopting.Process(time_ns, in, found);
    knowing.Process(time_ns, in, expected);
    ASSERT_EQ(found.flags, expected.flags) << frame;
    for (std::size_t j = 0; j < found.rig.rotations.size(); ++j) {
      ASSERT_EQ(found.rig.rotations[j].coeffs(), expected.rig.rotations[j].coeffs()) << frame;
    }
    ASSERT_EQ(found.rig.translations[0], expected.rig.translations[0]) << frame;
  }
  ASSERT_EQ(found.in_force_count, 1);
  EXPECT_EQ(found.in_force[0].style, 3);
  EXPECT_EQ(found.flags & kBypass, 0U);
}

}  // namespace
}  // namespace styled::stylist

#include "sim/rigs/rig_stream.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <string_view>

#include "proto/rigs/slimevr/udp.h"
#include "sim/player/performer_motion.h"
#include "tests/unit/sim/fakes.h"

namespace styled::rigs {
namespace {

using faults::Fault;
using player::testing::FakeLink;

// Keeps the frames to encode; its datagrams are the frames' indices.
class FakeRig final : public Rig {
 public:
  struct Seen {
    double time_s;
    std::vector<std::vector<int>> unseen;  // joints of each performer
  };

  explicit FakeRig(std::vector<Seen>& seen) : seen_(seen) {}
  void Encode(const Frame& frame, const Send& send) override {
    Seen& seen = seen_.emplace_back(Seen{frame.time_s, {}});
    for (const body::Pose& pose : frame.poses) {
      auto& unseen = seen.unseen.emplace_back();
      for (int j = 0; j < body::kJointCount; ++j) {
        if (std::isnan(pose.rotations[static_cast<std::size_t>(j)].w())) unseen.push_back(j);
      }
    }
    send(std::as_bytes(std::span(&frame.index, 1)));
  }
  std::string default_address() const override { return "udp://127.0.0.1:1"; }

 private:
  std::vector<Seen>& seen_;
};

struct PlayedRig {
  std::vector<FakeRig::Seen> seen;
  std::vector<std::vector<std::uint64_t>> sent;  // frames' indices, tick by tick
  faults::Counts counts{};

  std::uint64_t fault(Fault f) const { return counts[static_cast<std::size_t>(f)]; }
};

PlayedRig Play(int ticks, std::string_view spec) {
  constexpr double kRate_hz = 50;
  PlayedRig played;
  const auto script = synthetic::ParseScript("walk:3").value();
  std::vector<std::unique_ptr<player::Motion>> motions;
  for (std::uint64_t k = 0; k < 2; ++k) {
    motions.push_back(std::make_unique<player::PerformerMotion>(
        synthetic::Vary(1, k, script), synthetic::Proportions(), kRate_hz));
  }
  auto stream = RigStream::Make(std::make_unique<FakeRig>(played.seen), std::move(motions),
                                kRate_hz, faults::Parse(spec).value());
  EXPECT_TRUE(stream.ok());
  for (int i = 0; i < ticks; ++i) {
    FakeLink link;
    EXPECT_NE(stream.value()->Tick(link), player::Sender::Step::kError);
    auto& indices = played.sent.emplace_back();
    for (const auto& bytes : link.sent) {
      std::memcpy(&indices.emplace_back(), bytes.data(), sizeof(std::uint64_t));
    }
  }
  played.counts = stream.value()->faults().counts();
  return played;
}

TEST(RigStream, SendsABurstAtOnceAndInOrder) {
  const PlayedRig played = Play(1000, "burst=0.03,burst-frames=4");
  std::uint64_t next = 0, bursts = 0;
  for (const auto& indices : played.sent) {
    for (const std::uint64_t index : indices) EXPECT_EQ(index, next++);
    if (indices.size() <= 1) continue;
    EXPECT_EQ(indices.size(), 4U);
    ++bursts;
  }
  EXPECT_GT(bursts, 10U);
  EXPECT_LE(bursts, played.fault(Fault::kBurst));
  EXPECT_GE(bursts + 1, played.fault(Fault::kBurst));  // the last may be under way
}

TEST(RigStream, ClockDriftsAndStepsInTheRigsTime) {
  const PlayedRig exact = Play(500, "loss=0.1"), drifting = Play(500, "drift-ppm=-300");
  for (std::size_t i = 0; i < 500; ++i) {
    EXPECT_EQ(exact.seen[i].time_s, static_cast<double>(i) / 50);
    EXPECT_NEAR(drifting.seen[i].time_s, static_cast<double>(i) / 50 * 0.9997, 1e-9);
  }
  const PlayedRig stepping = Play(500, "step=0.02,step-s=7");
  EXPECT_GT(stepping.fault(Fault::kStep), 0U);
  EXPECT_NEAR(stepping.seen[499].time_s,
              499.0 / 50 + 7 * static_cast<double>(stepping.fault(Fault::kStep)), 1e-9);
}

TEST(RigStream, OccludesOneJointOfOnePerformerForItsFrames) {
  const PlayedRig played = Play(3000, "occlude=0.001,occlude-frames=15,seed=6");
  std::uint64_t joint_frames = 0;
  for (const auto& seen : played.seen) {
    for (const auto& joints : seen.unseen) {
      joint_frames += joints.size();
      for (const int joint : joints) EXPECT_GT(joint, 0);  // the hips are always seen
    }
  }
  // No two of this seed's overlap in a joint.
  EXPECT_GT(played.fault(Fault::kOcclude), 0U);
  EXPECT_EQ(joint_frames, 15 * played.fault(Fault::kOcclude));
}

TEST(RigStream, NanOccludesForOneFrame) {
  const PlayedRig played = Play(1000, "nan=0.1");
  std::uint64_t joint_frames = 0;
  for (const auto& seen : played.seen) {
    for (const auto& joints : seen.unseen) joint_frames += joints.size();
  }
  EXPECT_GT(joint_frames, 0U);
  EXPECT_EQ(joint_frames, played.fault(Fault::kNan));
}

// A tracker out of reach is silent; those below it in the body are not.
TEST(SlimeVrStandIn, SendsNothingForAnUnseenJointAndTheOthersAsEver) {
  auto made = Make("slimevr", {{"sim"}, 100, 1, {"no-reset"}});
  ASSERT_TRUE(made.ok()) << made.status().message();
  std::array<std::byte, 64> greeting;
  const std::size_t size = slimevr::EncodeAnswer(slimevr::Greeting{}, greeting);
  made.value()->Receive(std::span(greeting).first(size), [](std::span<const std::byte>) {});
  std::array<body::Pose, 1> poses, whole;
  std::map<int, std::array<float, 4>> last;
  for (body::Quat& q : whole[0].rotations) q = body::Quat(0.8F, 0.6F, 0, 0);
  poses = whole;
  const auto sensors = [&](std::uint64_t index) {
    std::set<int> sent;
    made.value()->Encode({index, static_cast<double>(index) / 100, poses, whole},
                         [&sent, &last](std::span<const std::byte> bytes) {
                           const auto datagram = std::make_unique<slimevr::Datagram>();
                           ASSERT_EQ(slimevr::Decode(bytes, *datagram), slimevr::UdpResult::kOk);
                           for (std::size_t i = 0; i < datagram->count; ++i) {
                             const auto* r = std::get_if<slimevr::Rotation>(&datagram->packets[i]);
                             if (r == nullptr) continue;
                             sent.insert(r->sensor);
                             const auto& q = r->orientation.rotation;
                             const auto [seen, first] = last.emplace(r->sensor, q);
                             EXPECT_EQ(seen->second, q);  // whatever is unseen above it
                           }
                         });
    return sent;
  };
  const std::set<int> all = sensors(0);
  EXPECT_EQ(all.size(), 13U);
  poses[0].rotations[body::kLeftUpperArm].coeffs().setConstant(
      std::numeric_limits<float>::quiet_NaN());
  std::set<int> others = all;
  others.erase(3);  // of the left upper arm
  EXPECT_EQ(sensors(1), others);
  poses = whole;
  EXPECT_EQ(sensors(2), all);
}

}  // namespace
}  // namespace styled::rigs

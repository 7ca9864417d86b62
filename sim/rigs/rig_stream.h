#pragma once

#include <memory>
#include <vector>

#include "model/rig/binding.h"
#include "sim/player/motion.h"
#include "sim/player/sender.h"
#include "sim/rigs/rig.h"

namespace styled::rigs {

// Retargets motions of any skeletons to the canonical humanoid and sends them through a simulated
// rig, with faults. A fault applies to all datagrams of a frame, except damage, which applies to
// one of them. One thread. Pinned by tests/unit/sim/rig_stream_test.cpp.
class RigStream final : public player::Sender {
 public:
  // `motions`: one per performer of the rig. `props`: as the rig's options have them. Errors: a
  // skeleton that cannot be bound.
  static Result<std::unique_ptr<RigStream>> Make(
      std::unique_ptr<Rig> rig, std::vector<std::unique_ptr<player::Motion>> motions,
      double rate_hz, const faults::Spec& spec, std::vector<player::PropSpec> props = {});

  // The end of any motion ends the stream; a new body starts a new session.
  Step Tick(player::Link& link) override;
  Status Flush(player::Link& link) override;
  int performers() const override { return static_cast<int>(motions_.size()); }
  const faults::Faults& faults() const override { return faults_; }
  double NextDelay_s() override { return faults_.DrawJitter_s(); }

  // The canonical poses of the last frame.
  std::span<const body::Pose> poses() const { return poses_; }

 private:
  using Datagrams = std::vector<std::vector<std::byte>>;
  struct Held {
    std::uint64_t due_tick;
    Datagrams datagrams;
  };
  struct Occlusion {
    std::uint32_t performer, joint, frames_left;
  };

  RigStream(std::unique_ptr<Rig> rig, std::vector<std::unique_ptr<player::Motion>> motions,
            double rate_hz, const faults::Spec& spec);
  Status Bind(std::size_t k);
  Step Advance();
  void Restart();
  void Occlude(faults::Fault fault);
  Status SendFrame(faults::Fault fault, player::Link& link);
  Status SendAll(const Datagrams& datagrams, player::Link& link);
  Status SendHeld(player::Link& link, bool all);
  void Damage(faults::Fault fault, Datagrams& datagrams);
  std::uint64_t Ticks(double milliseconds) const;

  std::unique_ptr<Rig> rig_;
  std::vector<std::unique_ptr<player::Motion>> motions_;
  std::vector<std::unique_ptr<rig::Binding>> bindings_;
  std::vector<body::Pose> poses_, whole_;  // whole_: without the occlusions
  std::vector<player::PropSpec> props_;
  rig::RigPose source_;
  double rate_hz_;
  faults::Faults faults_;
  std::vector<Held> held_;
  std::vector<std::byte> received_;
  std::uint64_t frame_index_ = 0, tick_ = 0, silent_until_tick_ = 0;
  std::uint64_t burst_end_tick_ = 0;  // frames produced before this tick are sent at it
  std::vector<Occlusion> occlusions_;
};

}  // namespace styled::rigs

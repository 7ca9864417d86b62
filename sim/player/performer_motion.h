#pragma once

#include <filesystem>

#include "model/synthetic/performer.h"
#include "sim/player/motion.h"

namespace styled::player {

// The synthetic performer as a rig: skeleton "canonical" with its own proportions, in metres, with
// an identity rest pose. Endless.
class PerformerMotion final : public Motion {
 public:
  PerformerMotion(synthetic::Options options, const synthetic::Proportions& proportions,
                  double rate_hz);

  const RigBody& body() const override { return body_; }
  Step Next(rig::RigPose& pose) override;

 private:
  synthetic::Performer performer_;
  body::Pose canonical_;
  RigBody body_;
  double rate_hz_;
  float scale_;
  std::uint64_t frame_ = 0;
};

// Writes `seconds` of an endless motion to a BVH file in centimetres (with metres_per_unit 1, a
// length of 1 in the body is written as 100).
Status WriteMotion(Motion& motion, double seconds, double rate_hz,
                   const std::filesystem::path& file);

}  // namespace styled::player

#pragma once

#include <filesystem>

#include "model/synthetic/performer.h"
#include "sim/player/motion.h"

namespace styled::player {

// The synthetic performer as a rig: skeleton "canonical" of its own proportions, in metres, with
// identity rest. Endless.
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

// `seconds` of a motion that does not end before as a BVH file in centimetres (a length of 1 m in
// the body is 100 there where metres_per_unit is 1).
Status WriteMotion(Motion& motion, double seconds, double rate_hz,
                   const std::filesystem::path& file);

}  // namespace styled::player

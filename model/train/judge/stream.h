#pragma once

#include <memory>
#include <span>
#include <vector>

#include "model/base/status.h"
#include "model/body/pose.h"
#include "model/net/stylizer.h"
#include "model/stylist/stylist.h"

namespace styled::judge {

using Poses = std::vector<body::Pose>;

// The rate at which weights are judged, as live: recorded clips are converted to it with
// clip::ResamplePoses, styled frame by frame, and every fourth frame goes to the judges.
inline constexpr double kStreamRate_hz = 120.0;
inline constexpr int kStreamPerJudge = 4;

// Every kStreamPerJudge-th pose.
Poses Thin(std::span<const body::Pose> poses);

// Settings for one style at full strength, without a fade.
stylist::Settings OneStyle(int style, bool absolute);

// The stylist's output for `input` (at `rate_hz`) as one session. `switches` take effect at their
// frames, which must be in ascending order. `known`, unless null, is the performer's neutral, which
// the stylist gets before the first frame.
struct Switch {
  std::size_t frame = 0;
  stylist::Settings settings;
};
Poses StyleStream(const std::shared_ptr<const net::Stylizer>& network,
                  const std::shared_ptr<const rig::Binding>& binding,
                  const stylist::Options& options, std::span<const Switch> switches,
                  std::span<const body::Pose> input, double rate_hz = kStreamRate_hz,
                  const neutral::Known* known = nullptr);
// The neutral that a stylist learns from such an input, unstyled. Empty for a network without a
// reference and without Options::neutral, as in Stylist::Tell.
neutral::Known LearnNeutral(const std::shared_ptr<const net::Stylizer>& network,
                            const std::shared_ptr<const rig::Binding>& binding,
                            const stylist::Options& options, std::span<const body::Pose> input,
                            double rate_hz = kStreamRate_hz);

// The baseline that a network must beat: a constant rotation per joint.
struct ConstantOffset {
  std::array<body::Quat, body::kJointCount> offset;
  body::Pose Apply(const body::Pose& pose) const;  // grounded like the stylist's output
};

// Clips played back to back as one performer: each is rotated and moved so that it begins at its
// predecessor's end; the last and first `blend` frames overlap.
struct Chain {
  struct Part {
    int clip = 0;           // index into the clips given
    std::size_t begin = 0;  // frames that belong to this clip alone: first, and one past the last
    std::size_t end = 0;
  };
  Poses poses;
  std::vector<Part> parts;
};
// Repeats `clips` in turn until `seconds` have passed, then plays each once more. Clips shorter
// than 3 * blend are skipped. The rate is that of the clips.
Chain ChainClips(std::span<const Poses> clips, double rate_hz, double seconds, int blend);

}  // namespace styled::judge

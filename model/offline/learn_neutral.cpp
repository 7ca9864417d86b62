#include "model/offline/learn_neutral.h"

#include <cstddef>

namespace styled::offline {

neutral::Known LearnNeutral(const clip::Clip& clip, const rig::Binding& binding,
                            const neutral::Reference& reference) {
  neutral::Neutral neutral;
  body::Pose pose;
  const auto dt_s = static_cast<float>(1 / clip.rate_hz);
  for (std::size_t i = 0; i < clip.frames.size(); ++i) {
    binding.Bind(clip.frames[i], pose);
    neutral.Follow(pose, i == 0 ? 0 : dt_s, true, reference);
  }
  return neutral.Tell(reference);
}

}  // namespace styled::offline

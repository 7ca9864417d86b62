#pragma once

#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/rig/skeleton.h"

namespace styled::player {

using rig::RigBody;

// The motion of one performer at the player's rate, frame after frame. One thread; may read files.
class Motion {
 public:
  enum class Step {
    kPose,     // `pose` is the next frame
    kNewBody,  // body() has changed: a new session begins with the next call
    kEnd,      // there is no more
    kError     // error() says why
  };

  virtual ~Motion() = default;
  virtual const RigBody& body() const = 0;
  // `pose` is resized to body().
  virtual Step Next(rig::RigPose& pose) = 0;
  virtual Status error() const { return Status::Ok(); }
};

}  // namespace styled::player

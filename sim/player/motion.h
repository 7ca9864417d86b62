#pragma once

#include "model/base/status.h"
#include "model/rig/skeleton.h"

namespace styled::player {

using rig::RigBody;

// The motion of one performer, frame by frame at the player's rate. One thread; may read files.
class Motion {
 public:
  enum class Step {
    kPose,     // `pose` is the next frame
    kNewBody,  // body() has changed: the next call starts a new session
    kEnd,      // the motion has ended
    kError     // see error()
  };

  virtual ~Motion() = default;
  virtual const RigBody& body() const = 0;
  // `pose` is resized to body().
  virtual Step Next(rig::RigPose& pose) = 0;
  virtual Status error() const { return Status::Ok(); }
};

}  // namespace styled::player

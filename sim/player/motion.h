#pragma once

#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/rig/skeleton.h"

namespace styled::player {

// What a rig tells of its skeleton: the fields of the Body message.
struct RigBody {
  rig::Skeleton skeleton;       // units and axes of the rig
  std::vector<rig::Quat> rest;  // world rotations in the T-pose; empty = the dialect knows them
  float metres_per_unit = 0;    // 0 = unknown
  std::string dialect = "auto";
};

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

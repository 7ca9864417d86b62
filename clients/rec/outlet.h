#pragma once

#include "model/base/status.h"
#include "proto/recording/recording.pb.h"

namespace styled::rec {

// A destination that a recording is played to. One thread; calls may block.
class Outlet {
 public:
  virtual ~Outlet() = default;
  // Passes a record that precedes the played part. An outlet keeps only what the played part
  // depends on: the bodies.
  virtual void Note(const recording::Record& record) = 0;
  // Plays a record that is due. An error ends playback.
  virtual Status Play(const recording::Record& record) = 0;
  // Called at least every 20 ms while no record is due.
  virtual void Idle() {}
  // The recording starts again (--loop).
  virtual void Restart() = 0;
  // Called after the last record.
  virtual void Finish() {}
};

}  // namespace styled::rec

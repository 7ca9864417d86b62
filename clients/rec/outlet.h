#pragma once

#include "model/base/status.h"
#include "proto/recording/recording.pb.h"

namespace styled::rec {

// Where a recording is played to. One thread; calls may block.
class Outlet {
 public:
  virtual ~Outlet() = default;
  // A record before the part that is played: only what the part cannot be understood without (the
  // bodies) is kept of it.
  virtual void Note(const recording::Record& record) = 0;
  // A record that is due. Errors end the playing.
  virtual Status Take(const recording::Record& record) = 0;
  // Time passes: called at least every 20 ms.
  virtual void Idle() {}
  // The recording begins again.
  virtual void Restart() = 0;
  // The last record was played.
  virtual void Finish() {}
};

}  // namespace styled::rec

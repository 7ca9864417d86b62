#pragma once

#include <cstdint>

#include "daemon/perform/performance.h"
#include "daemon/pipeline/dependencies.h"
#include "daemon/pipeline/stats.h"
#include "daemon/runtime/wall_offset.h"
#include "proto/styled/v1/journal.pb.h"

namespace styled::pipeline {

// The pipeline's work that is due by time: silence, repeated bodies, statistics, log lines.
// Pipeline thread; allocates if something is due.
class Timers {
 public:
  // All must outlive it.
  Timers(const Dependencies& dependencies, Performance& performance, Stats& stats)
      : dependencies_(dependencies), performance_(performance), stats_(stats) {}

  // Does the work that is due. `drained`: no frames wait in a source. `batch_ns`: when the last
  // batch was read. Returns the number of actions.
  int DoWork(std::int64_t now_ns, bool drained, std::int64_t batch_ns);
  // When DoWork is due again, at the latest.
  std::int64_t NextDeadline_ns(std::int64_t batch_ns) const;
  // Whether a frame is about to arrive.
  bool Expects(std::int64_t now_ns) const;

 private:
  // Does the work that is due for one performer.
  int DoPerformer(Performer& performer, std::int64_t now_ns, bool drained);
  std::int64_t Prepare_ns(const Performer& performer, std::int64_t batch_ns) const;
  void Prepare(Performer& performer, std::int64_t now_ns, std::int64_t batch_ns);
  int IdleAll(std::int64_t now_ns);
  void Idle(Performer& performer, std::int64_t now_ns, std::int64_t least_period_ns);
  bool Stays(const Performer& performer) const;
  void LogFacing(Performer& performer);
  int LogLayers(std::int64_t now_ns);
  void LogStray(std::int64_t now_ns);
  void LogCalibrated();
  void CheckWallClock();

  const Dependencies dependencies_;
  Performance& performance_;
  Stats& stats_;
  v1::Silence silence_;            // of this turn
  std::size_t first_to_idle_ = 0;  // the performer who is next where not all have their turn
  runtime::WallWatch wall_watch_;
  // The last sentence that the log has of each source whose data reach no performer.
  std::vector<std::string> stray_;
};

}  // namespace styled::pipeline

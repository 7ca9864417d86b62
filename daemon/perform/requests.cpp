#include "daemon/perform/requests.h"

#include "daemon/perform/calibration.h"
#include "daemon/perform/checkpoints.h"
#include "daemon/perform/explain.h"

namespace styled::pipeline {

bool PerformRequest(const v1::Request& request,
                    const std::vector<std::unique_ptr<source::Transport>>& transports,
                    Performance& performance, v1::Reply& reply) {
  Roster& roster = performance.roster;
  const std::int64_t now_ns = performance.clock.Now_ns();
  Performer* changed = nullptr;
  switch (request.command_case()) {
    case v1::Request::kCalibrate:
      changed = Calibrate(request, transports, roster, now_ns, reply);
      break;
    case v1::Request::kTakeCheckpoint:
      TakeCheckpoint(request, roster, now_ns, performance.clock.Wall_ns(), reply);
      return true;
    case v1::Request::kExplain:
      Explain(request, performance, reply);
      return true;
    case v1::Request::kRestoreCheckpoint:
      changed = RestoreCheckpoint(request, roster, performance.layers, now_ns, reply);
      if (changed == nullptr) return true;
      performance.events.Log(Event::Level::kInfo,
                             changed->profile.id + ": restored from a checkpoint");
      break;
    default:
      return performance.commands.Apply(request, reply);
  }
  if (changed == nullptr) return true;
  changed->outputs.SendBodies(performance.publisher);
  performance.commands.MarkChanged();
  return true;
}

}  // namespace styled::pipeline

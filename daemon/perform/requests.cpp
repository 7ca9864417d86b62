#include "daemon/perform/requests.h"

#include "daemon/looks/refusal.h"
#include "daemon/perform/calibration.h"
#include "daemon/perform/checkpoints.h"
#include "daemon/perform/explain.h"

namespace styled::pipeline {

namespace {

// The performer has other bodies or another state from the next frame on.
void Changed(Performer& performer, Performance& performance, v1::Reply& reply) {
  v1::Applied& applied = *reply.add_applied();
  applied.set_performer(performer.profile.id);
  applied.set_first_sequence(performer.profile.next_sequence);
  performer.outputs.SendBodies(performance.publisher);
  performance.commands.MarkChanged();
}

}  // namespace

bool PerformRequest(const v1::Request& request,
                    const std::vector<std::unique_ptr<source::Transport>>& transports,
                    Performance& performance, v1::Reply& reply) {
  Roster& roster = performance.roster;
  const std::int64_t now_ns = performance.clock.Now_ns();
  reply.set_id(request.id());
  Status status = Status::Ok();
  switch (request.command_case()) {
    case v1::Request::kCalibrate: {
      const auto calibrated = Calibrate(request, transports, roster, now_ns, reply);
      status = calibrated.status();
      if (calibrated.ok()) Changed(*calibrated.value(), performance, reply);
      break;
    }
    case v1::Request::kTakeCheckpoint: {
      auto taken = TakeCheckpoint(request.performer(), roster, now_ns, performance.clock.Wall_ns());
      status = taken.status();
      if (taken.ok()) reply.mutable_checkpoint()->Swap(&taken.value());
      break;
    }
    case v1::Request::kRestoreCheckpoint: {
      const auto restored =
          RestoreCheckpoint(request.performer(), request.restore_checkpoint().checkpoint(), roster,
                            performance.layers, now_ns);
      status = restored.status();
      if (!restored.ok()) break;
      Changed(*restored.value(), performance, reply);
      performance.events.Log(Event::Level::kInfo,
                             restored.value()->profile.id + ": restored from a checkpoint");
      break;
    }
    case v1::Request::kExplain:
      status =
          Explain(request.performer(), request.explain(), performance, *reply.mutable_explain());
      if (!status.ok()) reply.clear_explain();
      break;
    default:
      return performance.commands.Apply(request, reply);
  }
  FillReply(status, reply);
  return true;
}

}  // namespace styled::pipeline

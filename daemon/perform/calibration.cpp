#include "daemon/perform/calibration.h"

#include "daemon/looks/refusal.h"
#include "model/base/text.h"

namespace styled::pipeline {
Result<Performer*> Calibrate(const v1::Request& request,
                             const std::vector<std::unique_ptr<source::Transport>>& transports,
                             Roster& roster, std::int64_t now_ns, v1::Reply& reply) {
  Profile* const profile = roster.FindProfile(request.performer());
  Performer* const performer = profile == nullptr ? nullptr : roster.LiveOf(*profile);
  if (performer == nullptr) {
    return Refused(v1::CODE_UNKNOWN_PERFORMER, "performer \"" + Printable(request.performer(), 80) +
                                                   "\": expected one that is present");
  }
  const v1::Calibrate& calibrate = request.calibrate();
  if (!v1::Calibrate::Pose_IsValid(calibrate.pose()) ||
      !v1::Calibrate::Sensors_IsValid(calibrate.sensors())) {
    return Refused(v1::CODE_OUT_OF_RANGE,
                   "calibrate: expected a pose of 0 or 1, sensors of 0 to 2");
  }
  const auto place = static_cast<std::size_t>(performer->source);
  source::Transport* const transport =  // null: a pipeline without sockets
      place < transports.size() ? transports[place].get() : nullptr;
  if (calibrate.neutral()) {
    if (Status status = performer->CalibrateNeutral(calibrate); !status.ok()) return status;
  } else if (transport != nullptr && transport->has_sensors()) {
    if (calibrate.clear()) {
      return Refused(v1::CODE_OUT_OF_RANGE,
                     "calibrate: clear: a rig of sensors has no rest pose to forget; expected the "
                     "next calibration, which replaces the last");
    }
    const Status status =
        transport->Calibrate(static_cast<source::Calibration>(calibrate.sensors()), now_ns);
    if (!status.ok()) return Refused(v1::CODE_NOT_READY, status.message());
  } else {
    auto calibrated = performer->Calibrate(calibrate, roster.config(), now_ns);
    if (!calibrated.ok()) return calibrated.status();
    if (!calibrate.clear()) *reply.mutable_calibrate() = std::move(calibrated.value());
  }
  profile->configured = true;
  return performer;
}

}  // namespace styled::pipeline

#include "daemon/perform/calibration.h"

#include "model/base/text.h"

namespace styled::pipeline {
namespace {

Performer* Applied(Profile& profile, Performer& performer, v1::Reply& reply) {
  profile.configured = true;
  auto& applied = *reply.add_applied();
  applied.set_performer(profile.id);
  applied.set_first_sequence(profile.next_sequence);
  return &performer;
}

}  // namespace

Performer* Calibrate(const v1::Request& request,
                     const std::vector<std::unique_ptr<source::Transport>>& transports,
                     Roster& roster, std::int64_t now_ns, v1::Reply& reply) {
  const auto refuse = [&reply](v1::Code code, std::string reason) -> Performer* {
    reply.set_code(code);
    reply.set_reason(std::move(reason));
    return nullptr;
  };
  reply.set_id(request.id());
  Profile* const profile = roster.FindProfile(request.performer());
  Performer* const performer = profile == nullptr ? nullptr : roster.LiveOf(*profile);
  if (performer == nullptr) {
    return refuse(v1::CODE_UNKNOWN_PERFORMER, "performer \"" + Printable(request.performer(), 80) +
                                                  "\": expected one that is present");
  }
  const v1::Calibrate& calibrate = request.calibrate();
  if (!v1::Calibrate::Pose_IsValid(calibrate.pose()) ||
      !v1::Calibrate::Sensors_IsValid(calibrate.sensors())) {
    return refuse(v1::CODE_OUT_OF_RANGE, "calibrate: expected a pose of 0 or 1, sensors of 0 to 2");
  }
  if (calibrate.neutral()) {
    reply.set_code(performer->CalibrateNeutral(calibrate, reply));
    if (reply.code() != v1::CODE_OK) return nullptr;
    return Applied(*profile, *performer, reply);
  }
  source::Transport& transport = *transports[static_cast<std::size_t>(performer->source)];
  if (transport.has_sensors()) {
    const Status status =
        transport.Calibrate(static_cast<source::Calibration>(calibrate.sensors()), now_ns);
    if (!status.ok()) return refuse(v1::CODE_NOT_READY, status.message());
    reply.set_code(v1::CODE_OK);
  } else {
    reply.set_code(performer->Calibrate(calibrate, roster.config(), now_ns, reply));
    if (reply.code() != v1::CODE_OK) return nullptr;
  }
  return Applied(*profile, *performer, reply);
}

}  // namespace styled::pipeline

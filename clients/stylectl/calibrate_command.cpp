// calibrate.
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "clients/stylectl/cli.h"
#include "clients/stylectl/commands.h"

namespace styled::stylectl {
namespace {

constexpr float kSloppy_deg = 15;  // above this, an accepted calibration gets a warning

struct CalibrateArguments {
  std::string pose = "t", sensors = "full";
  int countdown_s = 3;
  bool forget = false;
  bool neutral = false;
  float seconds = 5;
};

v1::Calibrate ToRequest(const CalibrateArguments& arguments) {
  v1::Calibrate request;
  request.set_clear(arguments.forget);
  request.set_neutral(arguments.neutral);
  if (arguments.neutral) request.set_seconds(arguments.seconds);
  request.set_pose(arguments.pose == "n" ? v1::Calibrate::POSE_N : v1::Calibrate::POSE_T);
  request.set_sensors(arguments.sensors == "full"  ? v1::Calibrate::SENSORS_FULL
                      : arguments.sensors == "yaw" ? v1::Calibrate::SENSORS_YAW
                                                   : v1::Calibrate::SENSORS_MOUNTING);
  return request;
}

void ReportJson(Session& session, const v1::CalibrateReply& reply) {
  nlohmann::json object{{"ok", true}, {"performer", session.performer}};
  if (!reply.worst_joint().empty()) {
    object["worst_joint"] = reply.worst_joint();
    object["worst_degrees"] = reply.worst_degrees();
    object["left_handed"] = reply.left_handed();
  }
  session.out << object.dump() << "\n";
}

void ReportText(Session& session, const v1::CalibrateReply& reply, bool forgotten) {
  session.out << session.performer << (forgotten ? ": calibration forgotten" : ": calibrated");
  if (!reply.worst_joint().empty()) {
    session.out << "; " << reply.worst_joint() << " stood farthest off, by "
                << std::lround(reply.worst_degrees()) << " degrees";
    if (reply.worst_degrees() > kSloppy_deg) {
      session.out << ": this error will be in every pose from now on; better stand straight "
                     "and calibrate again";
    }
    if (reply.left_handed()) session.out << "; the rig's axes are left-handed and are mirrored";
  }
  session.out << "\n";
}

// Requests the row of the session's performer; empty if the performer has left.
client::CallStatus QueryNeutral(Session& session, std::optional<v1::NeutralStats>& neutral) {
  neutral.reset();
  v1::StatusReply status;
  client::CallStatus asked = session.control().Status(&status);
  if (!asked.ok()) return asked;
  for (const auto& performer : status.stats().performers()) {
    if (performer.performer() == session.performer && performer.has_neutral()) {
      neutral = performer.neutral();
    }
  }
  return asked;
}

// Waits until the performer has been observed, and reports the result.
int AwaitNeutral(Session& session, float seconds) {
  session.err << session.performer << ": stand, then walk, in your own way, for " << seconds
              << " s\n";
  std::optional<v1::NeutralStats> neutral;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<float>(seconds + 5);
  do {
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
    const client::CallStatus asked = QueryNeutral(session, neutral);
    if (!asked.ok()) return session.Fail(asked);
  } while (neutral && neutral->calibrates_s() > 0 && std::chrono::steady_clock::now() < end);
  const bool done = neutral && neutral->calibrated();
  if (session.json) {
    session.out << nlohmann::json{{"ok", done},
                                  {"performer", session.performer},
                                  {"body_s", neutral ? neutral->body_s() : 0},
                                  {"arms_s", neutral ? neutral->arms_s() : 0}}
                       .dump()
                << "\n";
    return done ? kExitOk : kExitRefused;
  }
  if (!done) {
    session.err
        << session.performer
        << ": hardly stood or walked meanwhile, so nothing is calibrated; their neutral continues "
           "to be learned\n";
    return kExitRefused;
  }
  session.out << session.performer << ": calibrated; stood or walked for "
              << std::lround(neutral->body_s()) << " s";
  if (neutral->arms_s() == 0)
    session.out << ", but never with hanging arms, so these are not calibrated";
  session.out << "\n";
  return kExitOk;
}

int Calibrate(Session& session, const CalibrateArguments& arguments) {
  for (int left_s = arguments.forget ? 0 : arguments.countdown_s; left_s > 0; --left_s) {
    session.err << left_s << "... " << std::flush;
    std::this_thread::sleep_for(std::chrono::seconds(1));
    if (left_s == 1) session.err << "now\n";
  }
  v1::CalibrateReply reply;
  const client::CallStatus status =
      session.control().Calibrate(session.performer, ToRequest(arguments), &reply);
  if (!status.ok()) return session.Fail(status);
  if (arguments.neutral && !arguments.forget) return AwaitNeutral(session, arguments.seconds);
  if (session.json) {
    ReportJson(session, reply);
  } else {
    ReportText(session, reply, arguments.forget);
  }
  return kExitOk;
}

}  // namespace

void DeclareCalibrate(Session& session) {
  const auto arguments = std::make_shared<CalibrateArguments>();
  CLI::App* calibrate = session.AddOnline(
      "calibrate",
      "set the rest pose of a performer's rig from their present pose, or learn their own way to "
      "stand and walk",
      [&session, arguments] { return Calibrate(session, *arguments); });
  session.AddPerformer(calibrate, true, false);
  CLI::Option* pose =
      calibrate
          ->add_option("--pose", arguments->pose, "t: arms sideways, palms down; n: arms hanging")
          ->check(CLI::IsMember({"t", "n"}))
          ->capture_default_str();
  calibrate
      ->add_option("--sensors", arguments->sensors,
                   "for rigs of sensors: full (mounting and heading), yaw (heading), mounting")
      ->check(CLI::IsMember({"full", "yaw", "mounting"}))
      ->capture_default_str();
  calibrate->add_option("--countdown", arguments->countdown_s, "seconds to take up the pose")
      ->check(CLI::Range(0, 60))
      ->capture_default_str();
  CLI::Option* neutral = calibrate->add_flag(
      "--neutral", arguments->neutral,
      "instead of the rest pose, learn how they stand and walk without a style");
  neutral->excludes(pose);
  calibrate
      ->add_option("--seconds", arguments->seconds, "with --neutral: how long they stand and walk")
      ->check(CLI::Range(1, 60))
      ->needs(neutral)
      ->capture_default_str();
  calibrate->add_flag("--clear,--forget", arguments->forget, "remove the calibration")
      ->excludes(pose);
}

}  // namespace styled::stylectl

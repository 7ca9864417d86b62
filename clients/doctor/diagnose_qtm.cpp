// Qualisys: the daemon connects to QTM, which then streams.
#include "clients/doctor/examination.h"

namespace styled::doctor {
namespace {

std::string TheSettings() {
  return "In QTM: Project Options, Processing, Real-time actions: solve skeletons. ";
}

}  // namespace

void Examination::Qtm(const SourceFacts& source) {
  if (facts_.daemon_answers() && !source.in_daemon &&
      source.expected.origin == ExpectedSource::Origin::kConfig) {
    Port(source);
    return;
  }
  if (HasLivePerformer(source) || !source.qtm) return;
  const QtmAnswers& answers = *source.qtm;
  const std::string server = ToString(answers.server);
  const auto fail = [&](Step step, const char* code, const std::string& what,
                        const std::string& why, const std::string& change) {
    Report(Severity::kProblem, step, &source, code, what, why, change);
  };
  if (!answers.error.empty()) {
    return fail(Step::kPort, "qtm_no_server", Label(source) + " names no QTM server.",
                answers.error + ".",
                "Set server = \"ADDRESS\" of the machine that QTM runs on (port 22223).");
  }
  if (!answers.connected) {
    return fail(Step::kArrival, "qtm_no_connection",
                "QTM of " + Label(source) + " cannot be reached at " + server + ".",
                answers.refused.empty() ? "The connection is not answered." : answers.refused + ".",
                "Check that QTM runs there with a project open, that Project Options, Real-Time "
                "Output has the base port 22222 (ours is the next one, 22223), and that the "
                "firewall of that machine lets TCP port " +
                    std::to_string(answers.server.port) + " pass. Does ping " +
                    answers.server.host + " work?");
  }
  if (!answers.greeted) {
    const bool full = answers.text.find("Max number") != std::string::npos;
    return fail(Step::kFormat, full ? "qtm_full" : "qtm_no_greeting",
                full ? "QTM at " + server + " has no room for another client."
                     : "The program at " + server + " does not greet like QTM.",
                answers.text.empty()
                    ? answers.refused.empty() ? "It sent nothing." : answers.refused + "."
                    : "It sent: " + answers.text,
                full ? "QTM takes ten clients: close one of the others."
                     : "The port must be QTM's little-endian one: the base port and 1, as a rule "
                       "22223 (22222 and 22224 are different ports).");
  }
  if (answers.minor == 0) {
    return fail(Step::kVersion, "unusable_version",
                "QTM at " + server + " speaks none of QTM RT 1.19 to 1.25.",
                answers.text.empty() ? "" : "It answered: " + answers.text,
                "Skeletons need QTM 2019 or later: update it.");
  }
  if (!answers.skeletons_answered || answers.skeletons == 0) {
    return fail(Step::kSkeleton, "no_skeleton", "QTM at " + server + " has no skeleton.",
                !answers.text.empty()        ? "It answered: " + answers.text
                : answers.skeletons_answered ? "Its answer lists none."
                                             : "It did not answer the request for its skeletons.",
                "In QTM calibrate a skeleton of the performer. " + TheSettings());
  }
  if (answers.frames == 0) {
    return fail(Step::kArrival, "nothing_arrives", "QTM at " + server + " streams no frames.",
                answers.no_measurement ? "It reports that there is no data."
                                       : "None arrived in " + Seconds(facts_.seconds) + ".",
                "Start a measurement's preview (New), or open a file and choose Play, Play with "
                "real-time output.");
  }
  if (answers.seen_frames == 0) {
    return fail(Step::kSkeleton, "no_skeleton", "QTM at " + server + " sees no skeleton.",
                std::to_string(answers.frames) + " frames arrived, none of them with a skeleton.",
                TheSettings() + "The performer must be in the volume with all markers on.");
  }
  if (source.in_daemon) {
    fail(Step::kFrames, "no_frames",
         Label(source) + ": QTM streams skeletons, but no performer appears.", "",
         "The daemon's log names what it waits for; joints that it does not know can be named with "
         "joints =.");
  }
}

}  // namespace styled::doctor

// Steps "format" to "frames": the data that arrives, and how the daemon uses it.
#include <array>

#include "clients/doctor/examination.h"

namespace styled::doctor {
namespace {

constexpr double kBodyPeriod_s = 1;  // interval at which styled's own senders repeat the skeleton

std::string CountsOf(std::uint64_t part, std::uint64_t all) {
  return std::to_string(part) + " of " + std::to_string(all);
}

}  // namespace

bool Examination::Content(const SourceFacts& source, const Evidence& evidence) {
  const ExpectedSource& expected = source.expected;
  const Tally& tally = evidence.tally;
  if (expected.format == Format::kUnknown) return true;
  if (tally.Count() == 0) return CountersOfContent(source, evidence);
  const std::string name(Row(expected.format).name);
  const std::uint64_t own = tally.Count(expected.format);
  if (own > 0) {
    if (10 * (tally.Count() - own) > own) {
      Report(Severity::kWarning, Step::kFormat, &source, "mixed_formats",
             "Beside " + name + ", other data arrives at " + PlaceOf(expected) + ".",
             CountsOf(tally.Count() - own, tally.Count()) + " datagrams, from " +
                 evidence.Senders() + ": " + tally.Kinds(Format::kUnknown) +
                 tally.Kinds(tally.MainFormat()) + ".",
             "Send each format to a port of its own.");
    }
    return Use(source, tally);
  }
  const Format found = tally.MainFormat();
  const std::string why = std::to_string(tally.Count()) + " datagrams from " + evidence.Senders() +
                          ": " + tally.Kinds(found) + ".";
  if (found == Format::kUnknown) {
    Report(Severity::kProblem, Step::kFormat, &source, "unknown_format",
           "The data for " + Label(source) + " at " + PlaceOf(expected) + " is not " + name +
               ", nor any other format that the daemon accepts.",
           why, "Check the sender's output settings. " + InTheSender(expected));
    return false;
  }
  std::string key = MergeInto(found);
  if (!key.empty()) key = " with " + key.substr(1);  // within the sentence
  Report(Severity::kProblem, Step::kFormat, &source, "wrong_format",
         std::string(Row(found).name) + " arrives at " + PlaceOf(expected) + ", but " +
             Label(source) + " is of type \"" + expected.type + "\" (" + name + ").",
         why,
         "Set type = \"" + std::string(TypeFor(found, expected.stream)) + "\" for " +
             expected.name + key + " and restart the daemon, or switch the sender to " + name +
             ".");
  return false;
}

// Whether the datagrams contain poses.
bool Examination::Use(const SourceFacts& source, const Tally& tally) {
  const Format format = source.expected.format;
  const std::string name(Row(format).name);
  const std::uint64_t own = tally.Count(format);
  const auto count = [&](Verdict verdict) { return tally.Count(format, verdict); };
  const std::uint64_t damaged = count(Verdict::kDamaged);
  if (damaged > 0) {
    const bool most = 2 * damaged >= own;
    Report(
        most ? Severity::kProblem : Severity::kWarning, Step::kFormat, &source, "damaged",
        CountsOf(damaged, own) + " datagrams of " + name + " for " + Label(source) +
            " are damaged.",
        "Refused as: " + tally.Kinds(format, Verdict::kDamaged) + ".",
        "Something on the way truncates or changes them, or the sender has another version: check "
        "relays and VPNs in between, and update sender and daemon.");
    if (most) return false;
  }
  if (count(Verdict::kPose) + count(Verdict::kCut) > 0) {
    const bool never = count(Verdict::kSkeleton) + count(Verdict::kCut) == 0;
    const bool needs = format == Format::kNative && facts_.seconds >= 2 * kBodyPeriod_s;
    if (!never || !needs || HasLivePerformer(source)) return true;
    NoSkeleton(source, std::to_string(count(Verdict::kPose)) + " frames and no skeleton in " +
                           Seconds(facts_.seconds) + ".");
    return false;
  }
  if (count(Verdict::kUseless) > 0) {
    const std::string kinds = tally.Kinds(format, Verdict::kUseless);
    const bool version = kinds.find("version") != std::string::npos;
    Report(Severity::kProblem, Step::kVersion, &source,
           version ? "unusable_version" : "unusable_mode",
           name + " arrives for " + Label(source) + ", but in a " + (version ? "version" : "mode") +
               " that the daemon cannot use.",
           "It sends: " + kinds + ".", InTheSender(source.expected));
    return false;
  }
  // A tracker that searches for a server sends nothing else until it has found one.
  if (format == Format::kSlimeVr && !source.in_daemon) return true;
  Report(
      Severity::kProblem, Step::kVersion, &source, "no_pose",
      name + " arrives for " + Label(source) + ", but no poses.",
      "It sends: " + tally.Kinds(format) + ".",
      format == Format::kSlimeVr
          ? "The trackers do not send rotations: check their sensors, and whether another server "
            "answers them."
          : InTheSender(source.expected));
  return false;
}

void Examination::NoSkeleton(const SourceFacts& source, const std::string& why) {
  Report(
      Severity::kProblem, Step::kSkeleton, &source, "no_skeleton",
      "Frames arrive for " + Label(source) + ", but not the skeleton that they belong to.", why,
      "The sender must send the skeleton at its start and once a second: restart the sender. If it "
      "is a program of your own, it must send a Body before its frames (proto/styled/v1/WIRE.md).");
}

// The daemon holds the port, so that its bytes cannot be read here: this uses the daemon's
// counters.
bool Examination::CountersOfContent(const SourceFacts& source, const Evidence& evidence) {
  const std::string name(Row(source.expected.format).name);
  const bool native = source.expected.format == Format::kNative;
  const auto grown = [&](std::initializer_list<const char*> names) {
    std::uint64_t sum = 0;
    for (const char* counter : names) sum += GrownOf(source, counter);
    return sum;
  };
  const std::uint64_t foreign = grown({"source.bad_magic"});
  const std::uint64_t version = grown({"source.bad_version"});
  const std::uint64_t malformed = grown({"source.malformed"});
  const std::uint64_t damaged =
      grown({"source.too_short", "source.too_long", "source.length_mismatch", "source.bad_checksum",
             "source.bad_reserved", "source.bad_kind", "source.no_session"}) +
      (native ? malformed : 0);
  const std::uint64_t half = (evidence.arrived + 1) / 2;
  const std::string counted =
      " (the daemon's count, minus the part that other sources may explain)";
  const std::string see = " With sudo, doctor sees the datagrams themselves and names the format.";
  if (foreign >= half || (!native && malformed >= half)) {
    const std::uint64_t not_ours = native ? foreign : malformed;
    Report(Severity::kProblem, Step::kFormat, &source, "wrong_format",
           "The data for " + Label(source) + " at " + PlaceOf(source.expected) + " is not " + name +
               ".",
           CountsOf(not_ours, evidence.arrived) + " datagrams were not understood" + counted + ".",
           "Set the type of " + source.expected.name + " to what the rig sends, or the rig to " +
               name + "." + see);
    return false;
  }
  if (version >= half) {
    Report(
        Severity::kProblem, Step::kVersion, &source, "unusable_version",
        name + " arrives for " + Label(source) + ", but in a version that the daemon cannot use.",
        CountsOf(version, evidence.arrived) + " datagrams" + counted + ".",
        "Bring sender and daemon to the same version.");
    return false;
  }
  const std::uint64_t bad = damaged + (native ? 0 : malformed);
  if (bad == 0) return true;
  Report(bad >= half ? Severity::kProblem : Severity::kWarning, Step::kFormat, &source, "damaged",
         CountsOf(bad, evidence.arrived) + " datagrams for " + Label(source) + " are damaged.",
         "Refused by the daemon" + counted + "; stylectl status names the reasons.",
         "Something on the way truncates or changes them: check relays and VPNs in between." + see);
  return bad < half;
}

// Valid datagrams arrive; this checks whether they result in frames.
void Examination::Frames(const SourceFacts& source, const Evidence& evidence) {
  if (HasLivePerformer(source) || RefusesPerformers(source)) return;
  struct Cause {
    const char* counter;
    Step step;
    const char* code;
    const char* what;
    const char* change;
  };
  static constexpr std::array<Cause, 10> kCauses{{
      {"pipeline.before_body", Step::kSkeleton, "no_skeleton", "", ""},
      {"pipeline.bodies_refused", Step::kSkeleton, "skeleton_refused", "the skeleton is refused",
       "The daemon's log says why (joints that cannot be found, wrong "
       "numbers); correct the rig's skeleton, or its dialect."},
      {"pipeline.wrong_body", Step::kSkeleton, "skeleton_mismatch",
       "frames name another skeleton than the one sent", "Restart the sender."},
      {"pipeline.wrong_size", Step::kSkeleton, "skeleton_mismatch",
       "frames have another number of joints than the skeleton", "Restart the sender."},
      {"pipeline.performers_refused", Step::kFrames, "too_many_performers",
       "there are too many performers already",
       "Raise performers.max_performers, or stop senders "
       "that are not needed."},
      {"pipeline.second_sender", Step::kFrames, "second_sender",
       "another sender is the same performer",
       "Stop one of them, or give it another performer's "
       "name."},
      {"source.bad_name", Step::kFrames, "bad_name", "the performer's name is not allowed",
       "Names have 1 to 32 of A-Z a-z 0-9 _ -."},
      {"pipeline.old_time", Step::kFrames, "clock_stands",
       "the sender's clock does not advance from frame to frame",
       "Restart the sender; if it plays a "
       "recording, let it run."},
      {"source.incomplete", Step::kFrames, "incomplete",
       "frames come in parts, and parts are missing",
       "Datagrams are lost on the way: use a cable, or let the rig send smaller ones. Or the rig "
       "sends only a part of the body: the daemon's log counts the parts of each frame."},
      {"source.ignored", Step::kVersion, "no_pose", "the data contains no pose",
       "Let the rig send poses, and all its streams to one port."},
  }};
  if (Row(source.expected.format).face_only && GrownOf(source, "source.incomplete") > 0) {
    return Report(Severity::kProblem, Step::kFrames, &source, "no_face",
                  Label(source) + ": no frames, because the phone's camera sees no face.",
                  "source.incomplete grew.",
                  "Let the camera see the whole face, lit from the front.");
  }
  for (const Cause& cause : kCauses) {
    const std::uint64_t count = GrownOf(source, cause.counter);
    if (2 * count < evidence.arrived || count == 0) continue;
    const std::string why = std::string(cause.counter) + " grew by " + std::to_string(count) +
                            " while " + std::to_string(evidence.arrived) + " datagrams arrived.";
    if (cause.code == std::string("no_skeleton")) return NoSkeleton(source, why);
    return Report(Severity::kProblem, cause.step, &source, cause.code,
                  Label(source) + ": no frames, because " + cause.what + ".", why, cause.change);
  }
  std::string maybe;  // counters that grew, of this source or another
  for (const Cause& cause : kCauses) {
    const std::string counter = cause.counter;
    if (counter == "pipeline.bodies_refused" || counter == "source.incomplete") continue;
    if (2 * facts_.Grown(counter) < evidence.arrived || facts_.Grown(counter) == 0) continue;
    maybe += (maybe.empty() ? "" : ", ") + counter;
  }
  // These counters grow more slowly than datagrams arrive: once per second, or once per frame of
  // several datagrams.
  for (const Cause& cause : kCauses) {
    const std::string counter = cause.counter;
    if (counter != "pipeline.bodies_refused" && counter != "source.incomplete") continue;
    if (GrownOf(source, counter) == 0) {
      if (facts_.Grown(counter) > 0) maybe += (maybe.empty() ? "" : ", ") + counter;
      continue;
    }
    return Report(Severity::kProblem, cause.step, &source, cause.code,
                  Label(source) + ": no frames, because " + cause.what + ".", counter + " grew.",
                  cause.change);
  }
  const bool trackers = source.expected.format == Format::kSlimeVr;
  const bool parts = source.expected.format == Format::kVmc && source.expected.merge_into.empty();
  Report(
      Severity::kProblem, Step::kFrames, &source, trackers ? "needs_reset" : "no_frames",
      Label(source) + " receives " + std::string(Row(source.expected.format).name) +
          ", but no performer appears.",
      std::to_string(evidence.arrived) + " datagrams arrived in " + Seconds(facts_.seconds) + "." +
          (maybe.empty()
               ? ""
               : " Counters that grew, of this source or of another that receives: " + maybe + "."),
      trackers
          ? "Assign each tracker to a joint in the source's `trackers`, and do a full reset in the "
            "T-pose; the daemon's log names what is missing."
      : parts ? "If it sends only hands or a face: name in the source the performer that they "
                "belong, "
                "merge_into = \"SOURCE.NAME\", and restart the daemon. Otherwise restart the "
                "sender: the "
                "daemon's log names what it waits for."
              : "The daemon's log names what it waits for; restart the sender.");
}

}  // namespace styled::doctor

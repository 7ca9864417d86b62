// OptiTrack: the client asks the server first; frames arrive by a multicast group.

#include "clients/doctor/examination.h"

namespace styled::doctor {

void Examination::NatNet(const SourceFacts& source) {
  if (facts_.daemon_answers() && !source.in_daemon &&
      source.expected.origin == ExpectedSource::Origin::kConfig) {
    Port(source);
    return;
  }
  if (HasLivePerformer(source)) return;
  if (!source.natnet) return Unasked(source);
  if (!Server(source)) return;
  const NatNetAnswers& answers = *source.natnet;
  if (answers.multicast) {
    if (!Group(source)) return;
  } else if (answers.frames.Count() == 0) {
    return Report(
        Severity::kProblem, Step::kArrival, &source, "nothing_arrives",
        "The NatNet server answers, but sends no frames.",
        "It streams to each client separately (unicast), and none arrived in " +
            Seconds(facts_.seconds) + ".",
        std::string(Row(Format::kNatNet).in_the_sender) + " Motive must be live or playing.");
  }
  if (source.in_daemon) {
    Report(Severity::kProblem, Step::kFrames, &source, "no_frames",
           Label(source) + ": the server streams skeletons, but no performer appears.", "",
           "The daemon's log names what it waits for. Name the server's address there, and the "
           "interface: server = , interface = .");
  }
}

// The daemon reports which server it asks, but not by which interface it expects the frames; only
// its configuration file names that.
void Examination::Unasked(const SourceFacts& source) {
  if (!source.in_daemon || !source.received) return;
  const std::string ask =
      "Give the daemon's file: stylectl doctor --config styled.toml; then doctor asks the server "
      "itself. ";
  if (*source.received > 0) {
    return Report(Severity::kProblem, Step::kFrames, &source, "no_frames",
                  Label(source) + ": the NatNet server at " + ToString(source.expected.listen) +
                      " answers, but no performer appears.",
                  std::to_string(*source.received) + " datagrams came from it.",
                  ask + std::string(Row(Format::kNatNet).in_the_sender));
  }
  Report(Severity::kProblem, Step::kArrival, &source, "nothing_arrives",
         "Nothing arrives for " + Label(source) + " from its NatNet server at " +
             ToString(source.expected.listen) + ": it does not answer the daemon.",
         "The daemon received nothing in " + Seconds(facts_.seconds) + ".",
         ask + "See that server = names the machine that Motive runs on. " +
             std::string(Row(Format::kNatNet).in_the_sender));
}

bool Examination::Server(const SourceFacts& source) {
  const NatNetAnswers& answers = *source.natnet;
  const auto fail = [&](Step step, const char* code, const std::string& what,
                        const std::string& why, const std::string& change) {
    Report(Severity::kProblem, step, &source, code, what, why, change);
    return false;
  };
  if (!answers.error.empty()) {
    return fail(
        Step::kPort, "natnet_no_server", Label(source) + " names no NatNet server.",
        answers.error + ".",
        "Set server = \"ADDRESS\" of the machine that Motive runs on, as its Streaming pane "
        "shows it under Local Interface.");
  }
  const std::string server = ToString(answers.server);
  if (!answers.answered) {
    std::string why = "It did not answer a connection request.";
    for (const Flow* flow : Flows()) {
      if (flow->tally.MainFormat() != Format::kNatNet) continue;
      explained_.push_back(flow);
      why += " NatNet arrives from " + flow->from.host + ", though.";
      break;
    }
    return fail(Step::kArrival, "natnet_no_answer",
                "The NatNet server of " + Label(source) + " at " + server + " does not answer.",
                why,
                "See that Motive runs there, with Broadcast Frame Data on and that address as its "
                "Local Interface, and that the firewall of that machine lets UDP ports 1510 and "
                "1511 pass. Does ping " +
                    answers.server.host + " work?");
  }
  const std::string version =
      std::to_string(answers.version.major) + "." + std::to_string(answers.version.minor);
  if (answers.version < natnet::kOldest) {
    return fail(Step::kVersion, "unusable_version",
                answers.name + " at " + server + " speaks NatNet " + version +
                    "; the daemon accepts 2.7 and later.",
                "", "Update Motive to 1.7 or later.");
  }
  if (!answers.model_answered || !answers.model_read) {
    return fail(Step::kSkeleton, "no_skeleton",
                answers.name + " at " + server + " does not report its skeletons.",
                answers.model_answered ? "Its model could not be read."
                                       : "It did not answer the request for its model.",
                "In Motive switch Streaming off and on again; if that does not help, restart it.");
  }
  if (answers.skeletons == 0) {
    return fail(
        Step::kSkeleton, "no_skeleton", answers.name + " at " + server + " tracks no skeleton.",
        "Its model has " + std::to_string(answers.rigid_bodies) + " rigid bodies and no skeleton.",
        "In Motive create a skeleton (or let the performer into the volume), and in "
        "Streaming switch Skeletons on.");
  }
  return true;
}

bool Examination::Group(const SourceFacts& source) {
  const NatNetAnswers& answers = *source.natnet;
  const std::string group = answers.group.empty() ? source.expected.group : answers.group;
  const std::string place = ToString({group, answers.data_port});
  const Interface* chosen = FindInterface(facts_.interfaces, source.group_interface);
  Tally tally;
  for (const Flow* flow : Flows()) {
    const bool ours = chosen == nullptr || flow->interface == chosen->name;
    if (flow->to.host == group && ours) tally.Add(flow->tally);
  }
  if (tally.Count(Format::kNatNet) > 0) {
    const bool bare = tally.Count(Format::kNatNet, Verdict::kPose) == 0 &&
                      tally.Count(Format::kNatNet, Verdict::kUseless) > 0;
    if (!bare) return true;
    Report(Severity::kProblem, Step::kSkeleton, &source, "no_skeleton",
           "Frames of " + place + " arrive, but without a skeleton.",
           tally.Kinds(Format::kNatNet) + ".",
           "In Motive: Streaming: Skeletons on; the performer must be tracked.");
    return false;
  }
  if (GroupElsewhere(source, group)) return false;
  if (chosen != nullptr && !chosen->multicast && !chosen->loopback) {
    Report(Severity::kProblem, Step::kArrival, &source, "interface_no_multicast",
           "Frames are sent to the group " + place + ", and " + chosen->name +
               " does not accept multicast.",
           "The interface has no MULTICAST flag.",
           "ip link set " + chosen->name +
               " multicast on, or set interface = to the one that the "
               "cameras' network is on, or switch Motive to Unicast.");
    return false;
  }
  if (Filtered(source, answers.data_port)) return false;
  Report(Severity::kProblem, Step::kArrival, &source, "nothing_arrives",
         "The NatNet server answers, but nothing of its group " + place + " arrives.",
         "Listened on every interface for " + Seconds(facts_.seconds) + "." +
             (chosen == nullptr ? " There is no route to the group." : ""),
         "In Motive the Local Interface must be the network that this machine is on, not loopback. "
         "Switches with IGMP snooping need a querier, and wireless networks often drop groups: try "
         "Transmission Type Unicast.");
  return false;
}

// The group's frames arrive on an interface on which the daemon does not listen.
bool Examination::GroupElsewhere(const SourceFacts& source, const std::string& group) {
  for (const Flow* flow : Flows()) {
    if (flow->to.host != group || flow->tally.Count(Format::kNatNet) == 0) continue;
    explained_.push_back(flow);
    const Interface* chosen = FindInterface(facts_.interfaces, source.group_interface);
    const std::string name = chosen == nullptr ? "no interface" : chosen->name;
    Report(Severity::kProblem, Step::kArrival, &source, "multicast_elsewhere",
           "Frames of the group " + ToString(flow->to) + " come by " + flow->interface + ", but " +
               Label(source) + " listens on " + name + ".",
           std::to_string(flow->datagrams) + " datagrams from " + flow->from.host + ".",
           "Set interface = \"" + flow->interface + "\" for " + source.expected.name +
               " and restart the daemon.");
    return true;
  }
  return false;
}

}  // namespace styled::doctor

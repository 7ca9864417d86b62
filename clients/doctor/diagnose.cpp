#include "clients/doctor/diagnose.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "clients/doctor/examination.h"

namespace styled::doctor {

std::uint64_t ValueOf(const v1::StatusReply& status, const std::string& counter) {
  for (const auto& row : status.stats().counters()) {
    if (row.name() == counter) return row.value();
  }
  return 0;
}

std::uint64_t Facts::Grown(const std::string& counter) const {
  if (!daemon_answers()) return 0;
  const std::uint64_t before = ValueOf(daemon.before, counter);
  const std::uint64_t after = ValueOf(daemon.after, counter);
  return after > before ? after - before : 0;
}

const char* Name(Step step) {
  constexpr std::array<const char*, 8> kNames{"daemon",  "port",     "arrival", "format",
                                              "version", "skeleton", "frames",  "subscribers"};
  return kNames[static_cast<std::size_t>(step)];
}

const char* Name(Severity severity) {
  constexpr std::array<const char*, 3> kNames{"problem", "warning", "note"};
  return kNames[static_cast<std::size_t>(severity)];
}

std::string PlaceOf(const Endpoint& endpoint, bool stream) {
  return ToString(endpoint) + (stream ? "/tcp" : "/udp");
}

std::string PlaceOf(const ExpectedSource& expected) {
  return PlaceOf(expected.listen, expected.stream);
}

std::string Seconds(double seconds) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g s", seconds);
  return text.data();
}

std::vector<Finding> Diagnose(const Facts& facts) { return Examination(facts).Run(); }

std::vector<Finding> Examination::Run() {
  Daemon();
  for (const SourceFacts& source : facts_.sources) Source(source);
  Silent();
  Unclaimed();
  Performers();
  Clock();
  Standby();
  Losses();
  Counters();
  Listeners();
  std::ranges::stable_sort(findings_, {}, &Finding::severity);
  return std::move(findings_);
}

void Examination::Report(Severity severity, Step step, const SourceFacts* source, std::string code,
                         std::string what, std::string why, std::string change) {
  findings_.push_back({severity, step, std::move(code), source == nullptr ? "" : Label(*source),
                       std::move(what), std::move(why), std::move(change)});
}

void Examination::Daemon() {
  const DaemonFacts& daemon = facts_.daemon;
  const auto say = [&](const char* code, const std::string& what, const std::string& why,
                       const std::string& change) {
    Report(Severity::kProblem, Step::kDaemon, nullptr, code, what, why, change);
  };
  if (daemon.state == DaemonFacts::State::kAnswers) {
    if (!daemon.remote) return;
    return Report(Severity::kNote, Step::kDaemon, nullptr, "remote_daemon",
                  "The daemon at " + daemon.endpoint + " is on another machine.",
                  "Only its counters can be read from here, not its ports.",
                  "Run stylectl doctor on that machine to see more.");
  }
  if (daemon.state == DaemonFacts::State::kGarbled) {
    return say("not_a_daemon", "The program at " + daemon.endpoint + " is not a styled daemon.",
               daemon.holder ? "The port is held by " + Holder(*daemon.holder) + "." : "",
               "Give the daemon's control address with --endpoint; it is in styled.toml "
               "under [control] address.");
  }
  if (!daemon.elsewhere.empty()) {
    constexpr std::size_t kShown = 6;
    std::string places;
    for (std::size_t i = 0; i < std::min(daemon.elsewhere.size(), kShown); ++i) {
      places.append(i == 0 ? "" : ", ").append(ToString(daemon.elsewhere[i].local));
    }
    if (daemon.elsewhere.size() > kShown) places += ", ...";
    return say("wrong_control_endpoint",
               "A styled daemon runs, but its control socket is not at " + daemon.endpoint + ".",
               Holder(daemon.elsewhere.front()) + " listens on TCP " + places + ".",
               "Ask there: stylectl --endpoint tcp://HOST:PORT doctor, or set STYLED_CONTROL. "
               "The address is in styled.toml under [control] address.");
  }
  if (daemon.holder) {
    return say("control_taken", "No styled daemon answers at " + daemon.endpoint + ".",
               "The port is held by " + Holder(*daemon.holder) + ", which does not answer us.",
               "Stop that program, or give the daemon another [control] address and stylectl the "
               "same with --endpoint.");
  }
  say("no_daemon", "No styled daemon answers at " + daemon.endpoint + ".",
      "No program named styled listens on this machine.",
      "Start it: styled --config styled.toml (as a service: systemctl start styled). If it does "
      "not "
      "stay up, its log says why.");
}

void Examination::Source(const SourceFacts& source) {
  if (!source.expected.network || (facts_.daemon.remote && !source.in_daemon)) return;
  if (source.expected.format == Format::kNatNet) return NatNet(source);
  if (source.expected.format == Format::kQtm) return Qtm(source);
  if (!Port(source)) return;
  const Evidence evidence = EvidenceOf(source);
  if (!Arrival(source, evidence)) return;
  if (!Content(source, evidence)) return;
  // A face or fingers are merged into a performer of another source, whose frames are checked
  // there.
  const bool is_part = !source.expected.merge_into.empty();
  if (source.in_daemon && !is_part) Frames(source, evidence);
  if (source.stray.empty()) return;
  Report(Severity::kProblem, Step::kFrames, &source, "not_merged",
         Label(source) + " arrives, and no performer gets it.",
         "The daemon says: " + source.stray + ".",
         "Start the rig of the performer that it names, or set merge_into of the source to one who "
         "is here, and restart the daemon. A phone without a rig is a performer of its own where "
         "the rig's [[source]] is left out.");
}

// Reports a source from which the daemon receives nothing, whatever the previous steps found. Not
// if another source of the same name receives, or if a problem of that name is already reported.
void Examination::Silent() {
  for (const SourceFacts& source : facts_.sources) {
    if (!source.in_daemon || source.received.value_or(1) > 0) continue;
    const bool other = std::ranges::any_of(facts_.sources, [&](const SourceFacts& twin) {
      return twin.expected.name == source.expected.name && twin.received.value_or(0) > 0;
    });
    const bool reported = std::ranges::any_of(findings_, [&](const Finding& f) {
      return f.severity == Severity::kProblem &&
             (f.source == source.expected.name || f.source.starts_with(source.expected.name + "/"));
    });
    if (other || reported) continue;
    const std::string at = Row(source.expected.format).asks_server ? " from " : " at ";
    const std::string place = source.expected.network ? at + PlaceOf(source.expected) : "";
    Report(Severity::kProblem, Step::kArrival, &source, "nothing_arrives",
           "Nothing arrives for " + Label(source) + place + ".",
           "The daemon received nothing of it in " + Seconds(facts_.seconds) + ".",
           source.expected.network
               ? InTheSender(source.expected)
               : "See that the device is plugged in and switched on; the daemon's "
                 "log names what it waits for.");
  }
}

// Reports formats that arrive although no source uses them.
void Examination::Unclaimed() {
  if (facts_.one_source) return;
  const bool assumed = std::ranges::all_of(facts_.sources, [](const SourceFacts& source) {
    return source.expected.origin == ExpectedSource::Origin::kAssumed;
  });
  for (const Flow* flow : Flows()) {
    const Format format = flow->tally.MainFormat();
    if (format == Format::kUnknown || Claimed(*flow) ||
        std::ranges::find(explained_, flow) != explained_.end()) {
      continue;
    }
    const bool expected = std::ranges::any_of(facts_.sources, [format](const SourceFacts& source) {
      return source.expected.format == format;
    });
    const bool trouble = std::ranges::any_of(
        findings_, [](const Finding& f) { return f.severity == Severity::kProblem; });
    if (expected || !trouble) continue;
    explained_.push_back(flow);
    const std::string place = format == Format::kNatNet
                                  ? "server = \"" + flow->from.host + "\""
                                  : "listen = \"0.0.0.0:" + std::to_string(flow->to.port) + "\"";
    Report(assumed ? Severity::kProblem : Severity::kNote, Step::kPort, nullptr, "no_source",
           std::string(Row(format).name) + " arrives at " + PlaceOf(flow->to, flow->stream) +
               ", where no source listens.",
           std::to_string(flow->datagrams) + " datagrams from " + flow->from.host + ": " +
               flow->tally.Kinds(format) + ".",
           "Add to styled.toml and restart the daemon:\n[[source]]\nname = \"rig\"\ntype = \"" +
               std::string(TypeFor(format, flow->stream)) + "\"\n" + place + MergeInto(format));
  }
}

// The key that a source of that format needs in addition, because it has no body: the performer
// that gets the face, where several are live.
std::string Examination::MergeInto(Format format) const {
  if (!Row(format).face_only) return "";
  const auto& performers = facts_.daemon.after.stats().performers();
  const auto live = std::ranges::find_if(performers, &v1::PerformerStats::live);
  if (std::ranges::count_if(performers, &v1::PerformerStats::live) < 2) return "";
  return "\nmerge_into = \"" + live->performer() + "\"";
}

void Examination::Losses() {
  const auto warn = [&](const char* counter, const char* code, const std::string& what,
                        const std::string& change) {
    const std::uint64_t count = facts_.Grown(counter);
    if (count == 0) return;
    Report(Severity::kWarning, Step::kFrames, nullptr, code, std::to_string(count) + " " + what,
           std::string(counter) + " grew while we listened.", change);
  };
  KernelDrops();
  warn("pipeline.lost", "lost_on_the_way",
       "datagrams were lost between the rig and the daemon" + Losers() + ".",
       "Use a cable, or a wireless network of its own; look at switches and at the sender's load.");
  warn("pipeline.backlog_dropped", "too_slow", "frames were too late and were skipped.",
       "The network delivers in bursts (use a cable), or the machine is overloaded: end other "
       "programs, set realtime.priority = 20.");
  warn("source.takeovers_refused", "takeover_refused",
       "greetings for a live tracker were refused: they came from another address.",
       "Two trackers have one MAC, or another sender imitates one: the daemon's log names both "
       "addresses.");
  warn(
      "source.table_full", "too_many_trackers",
      "greetings of trackers were refused: there is no room for more.",
      "Name yours in the source's trackers: those have reserved places. The daemon's log names one "
      "that was refused.");
  warn("source.tcp_refused", "too_many_connections",
       "connections were refused: all max_connections are sending.",
       "Raise max_connections, or stop senders that are not needed.");
  const bool reported = std::ranges::any_of(findings_, [](const Finding& f) {
    return f.code == "second_sender" || f.code == "performer_refused";
  });
  if (reported || TwoPhones()) return;
  warn("pipeline.second_sender", "second_sender",
       "datagrams were refused: two senders send the same performer.",
       "Stop one of them, or give it another performer's name.");
}

// The performers whose datagrams were lost, ", of rig.anna and rig.ben"; "": none is known.
std::string Examination::Losers() const {
  std::string names;
  const auto& before = facts_.daemon.before.stats().performers();
  for (const auto& now : facts_.daemon.after.stats().performers()) {
    const auto then = std::ranges::find(before, now.performer(), &v1::PerformerStats::performer);
    if (then == before.end() || now.lost() <= then->lost()) continue;
    names.append(names.empty() ? ", of " : " and ").append(now.performer());
  }
  return names;
}

// Two senders for a source that is merged into a performer, e.g. two phones on one port: the first
// one's face is shown, and no name of a performer tells them apart.
bool Examination::TwoPhones() {
  if (facts_.Grown("pipeline.second_sender") == 0) return false;
  const SourceFacts* found = nullptr;
  for (const SourceFacts& source : facts_.sources) {
    const bool merged =
        Row(source.expected.format).face_only || !source.expected.merge_into.empty();
    if (!merged || source.received.value_or(0) == 0) continue;
    const bool several = EvidenceOf(source).Senders().find(',') != std::string::npos;
    if (several || GrownOf(source, "pipeline.second_sender") > 0) found = &source;
  }
  if (found == nullptr) return false;
  const ExpectedSource& expected = found->expected;
  const std::string hosts = EvidenceOf(*found).Senders();
  const std::string whose = expected.merge_into.empty() ? "one performer" : expected.merge_into;
  Report(Severity::kWarning, Step::kFrames, found, "second_sender",
         "Two senders send to " + Label(*found) + " at " + PlaceOf(expected) +
             ": only the first is shown on " + whose + ".",
         hosts.empty() ? "pipeline.second_sender grew while we listened."
                       : "Datagrams came from " + hosts + ".",
         "Give each a source of its own: another [[source]] with its own port in listen, and with "
         "merge_into its own performer; let the second one send there. Or stop it.");
  return true;
}

// The kernel's socket table names the source that lost datagrams; the daemon's counter only gives a
// total.
void Examination::KernelDrops() {
  const auto say = [this](const SourceFacts* source, std::uint64_t count) {
    const std::string whose = source == nullptr ? "a source" : Label(*source);
    Report(
        Severity::kWarning, Step::kFrames, source, "kernel_drops",
        "The kernel dropped " + std::to_string(count) + " datagrams for " + whose +
            ": the receive buffer was full.",
        source == nullptr ? "source.kernel_dropped grew while we listened."
                          : "Its socket's drops grew while we listened.",
        "Raise receive_buffer_bytes and, where the daemon is not root's, the system's limit (the "
        "command below, as root). Give the daemon a core: realtime.priority = 20.\n"
        "sysctl -w net.core.rmem_max=8388608");
  };
  bool reported = false;
  for (const SourceFacts& source : facts_.sources) {
    if (!source.in_daemon || source.drops == 0) continue;
    say(&source, source.drops);
    reported = true;
  }
  const std::uint64_t counted = facts_.Grown("source.kernel_dropped");
  if (!reported && counted > 0) say(nullptr, counted);
}

// The last step: whether clients receive the daemon's messages, and whether a style is set.
void Examination::Listeners() {
  if (!facts_.daemon_answers()) return;
  const v1::Stats& stats = facts_.daemon.after.stats();
  int live = 0, bypassed = 0;
  for (const auto& performer : stats.performers()) {
    if (!performer.live()) continue;
    ++live;
    bypassed += performer.look().mix().empty() || performer.look().strength() == 0 ? 1 : 0;
  }
  if (live == 0) return;
  if (ValueOf(facts_.daemon.after, "publish.subscriptions") == 0) {
    Report(Severity::kNote, Step::kSubscribers, nullptr, "no_subscriber",
           "No client has subscribed to the daemon.", "publish.subscriptions is 0.",
           "Start a client (stylemon shows the frames); give it the address under [publish]. From "
           "another machine that address must not be loopback.");
  }
  if (bypassed == live) {
    Report(Severity::kNote, Step::kFrames, nullptr, "bypass",
           "Every performer is in bypass: the motion is published unchanged.", "",
           "Set a style: stylectl set '*' --style NAME (stylectl list shows them).");
  }
}

std::string Examination::Evidence::Senders() const {
  std::vector<std::string> hosts;
  for (const Flow* flow : flows) {
    if (std::ranges::find(hosts, flow->from.host) == hosts.end()) hosts.push_back(flow->from.host);
  }
  std::string out;
  for (const auto& host : hosts) out.append(out.empty() ? "" : ", ").append(host);
  return out;
}

Examination::Evidence Examination::EvidenceOf(const SourceFacts& source) const {
  Evidence out;
  for (const auto* flows : {&facts_.heard, &facts_.seen}) {
    if (!out.flows.empty()) break;
    for (const Flow& flow : *flows) {
      if (!Reaches(flow, source.expected)) continue;
      out.flows.push_back(&flow);
      out.tally.Add(flow.tally);
    }
  }
  out.arrived = source.received ? *source.received : out.tally.Count();
  return out;
}

std::uint64_t Examination::GrownOf(const SourceFacts& source, const std::string& counter) const {
  std::uint64_t all = 0;  // datagrams of all sources, whether examined or not
  const auto& before = facts_.daemon.before.sources();
  const auto& after = facts_.daemon.after.sources();
  for (int i = 0; i < std::min(before.size(), after.size()); ++i) {
    all += after[i].received() - before[i].received();
  }
  std::uint64_t examined = 0;
  for (const SourceFacts& one : facts_.sources) examined += one.received.value_or(0);
  const std::uint64_t others = std::max(all, examined) - source.received.value_or(0);
  const std::uint64_t grown = facts_.Grown(counter);
  return grown > others ? grown - others : 0;
}

std::string Examination::InTheSender(const ExpectedSource& expected) {
  if (expected.format == Format::kIFacialMocap && !expected.server.empty()) {
    return "The daemon asks the phone at " + expected.server +
           " (`server` of the source) to send: see that this is the phone's address, that the "
           "phone "
           "is in this machine's network, and that the app is open.";
  }
  return doctor::InTheSender(expected.format, expected.stream);
}

std::vector<const Flow*> Examination::Flows() const {
  std::vector<const Flow*> out;
  out.reserve(facts_.heard.size() + facts_.seen.size());
  for (const Flow& flow : facts_.heard) out.push_back(&flow);
  for (const Flow& flow : facts_.seen) {
    const bool known = std::ranges::any_of(facts_.heard, [&flow](const Flow& heard) {
      return !heard.stream && heard.to == flow.to && heard.from.host == flow.from.host;
    });
    if (!known) out.push_back(&flow);
  }
  return out;
}

bool Examination::Reaches(const Flow& flow, const ExpectedSource& expected) {
  if (flow.stream != expected.stream || flow.to.port != expected.listen.port) return false;
  if (expected.listen.host == "::") return true;
  const bool v6 = flow.to.host.find(':') != std::string::npos;
  return expected.listen.host == flow.to.host || (expected.listen.host == "0.0.0.0" && !v6);
}

bool Examination::Claimed(const Flow& flow) const {
  return std::ranges::any_of(facts_.sources, [&flow](const SourceFacts& source) {
    return source.expected.origin != ExpectedSource::Origin::kOption &&
           Reaches(flow, source.expected);
  });
}

bool Examination::HasLivePerformer(const SourceFacts& source) const {
  if (!facts_.daemon_answers()) return false;
  const auto& performers = facts_.daemon.after.stats().performers();
  return std::any_of(performers.begin(), performers.end(), [&](const auto& performer) {
    return performer.live() && performer.performer().starts_with(source.expected.name + ".");
  });
}

bool Examination::TwinWorks(const SourceFacts& source) const {
  if (HasLivePerformer(source)) return true;
  return std::ranges::any_of(facts_.sources, [&](const SourceFacts& other) {
    return &other != &source && other.expected.name == source.expected.name &&
           EvidenceOf(other).arrived > 0;
  });
}

std::string Examination::Label(const SourceFacts& source) const {
  const auto same = std::ranges::count_if(facts_.sources, [&](const SourceFacts& other) {
    return other.expected.name == source.expected.name;
  });
  return same > 1 ? source.expected.name + "/" + source.expected.type : source.expected.name;
}

std::string Examination::OwnAddresses() const {
  std::string out;
  for (const Interface& interface : facts_.interfaces) {
    if (!interface.up || interface.loopback) continue;
    for (const auto& address : interface.addresses) {
      out.append(out.empty() ? "" : ", ").append(address + " (" + interface.name + ")");
    }
  }
  return out.empty() ? "none but loopback: no network is up" : out;
}

}  // namespace styled::doctor

// Steps "port" and "arrival": whether datagrams reach the address on which the source listens.
#include <algorithm>

#include "clients/doctor/examination.h"

namespace styled::doctor {
namespace {

// Whether `socket` prevents the source from binding its port.
bool InTheWay(const BoundSocket& socket, const ExpectedSource& expected) {
  return socket.stream == expected.stream && socket.local.port == expected.listen.port &&
         (IsWildcard(socket.local.host) || IsWildcard(expected.listen.host) ||
          socket.local.host == expected.listen.host);
}

}  // namespace

bool Examination::Port(const SourceFacts& source) {
  const ExpectedSource& expected = source.expected;
  const auto fail = [&](const char* code, const std::string& what, const std::string& why,
                        const std::string& change) {
    Report(Severity::kProblem, Step::kPort, &source, code, what, why, change);
    return false;
  };
  const std::string& host = expected.listen.host;
  const bool here = IsWildcard(host) || FindInterface(facts_.interfaces, host) != nullptr ||
                    IsLoopback(host) || facts_.daemon.remote || Row(expected.format).asks_server;
  if (!here) {
    return fail(
        "address_not_here",
        Label(source) + " listens on " + host + ", which is not an address of this machine.",
        "It has " + OwnAddresses() + ".",
        "Set listen = \"0.0.0.0:" + std::to_string(expected.listen.port) +
            "\" (every interface), or one of these addresses.");
  }
  if (source.in_daemon) return true;
  if (facts_.daemon_answers() && expected.origin == ExpectedSource::Origin::kConfig) {
    return fail(
        "source_not_in_daemon",
        "The running daemon has no source " + Label(source) + " on " + PlaceOf(expected) + ".",
        "It was started with another configuration, or before this one was written.",
        "Restart the daemon with this file: sources are read at the start only.");
  }
  for (const BoundSocket& holder : source.holders) {
    if (!InTheWay(holder, expected)) continue;
    const bool other_styled = holder.program == "styled";
    return fail("port_taken",
                PlaceOf(expected) + ", where " + Label(source) + " is to listen, is taken by " +
                    Holder(holder) + ".",
                "That program has " + PlaceOf(holder.local, holder.stream) +
                    "; two cannot have the same port.",
                other_styled ? "Another daemon has it: stop that one, or ask it with --endpoint."
                             : "End that program, or set another port here and in the sender.");
  }
  if (source.port && source.port->kind == PortState::Kind::kRefused) {
    return fail("port_refused", "The system refuses to listen on " + PlaceOf(expected) + ".",
                source.port->why + ".",
                expected.listen.port < 1024
                    ? "Ports below 1024 are reserved for root: use another one."
                    : "Use another port or address.");
  }
  return true;
}

bool Examination::Arrival(const SourceFacts& source, const Evidence& evidence) {
  if (evidence.arrived > 0) return !Filtered(source, source.expected.listen.port);
  if (TwinWorks(source)) return false;
  if (facts_.daemon.remote) {
    Nothing(source);
    return false;
  }
  if (WrongAddress(source) || WrongPort(source)) return false;
  if (Filtered(source, source.expected.listen.port)) return false;
  Nothing(source);
  return false;
}

// Datagrams reach this machine and the right port, but at an address on which the source does not
// listen.
bool Examination::WrongAddress(const SourceFacts& source) {
  const ExpectedSource& expected = source.expected;
  for (const Flow* flow : Flows()) {
    if (flow->stream != expected.stream || flow->to.port != expected.listen.port) continue;
    if (Claimed(*flow) || flow->tally.MainFormat() != expected.format) continue;
    explained_.push_back(flow);
    const bool loopback = IsLoopback(expected.listen.host);
    Report(Severity::kProblem, Step::kArrival, &source, "wrong_address",
           std::string(Row(expected.format).name) + " arrives at " +
               PlaceOf(flow->to, flow->stream) + ", but " + Label(source) + " listens on " +
               PlaceOf(expected) + " only.",
           std::to_string(flow->datagrams) + " datagrams from " + flow->from.host +
               (flow->interface.empty() ? "" : " by " + flow->interface) + "." +
               (loopback ? " A loopback address only receives from programs on this machine." : ""),
           "Set listen = \"0.0.0.0:" + std::to_string(expected.listen.port) + "\" for " +
               source.expected.name + " and restart the daemon.");
    return true;
  }
  return false;
}

// Datagrams reach this machine, but at another port or by the other protocol (UDP, TCP).
bool Examination::WrongPort(const SourceFacts& source) {
  const ExpectedSource& expected = source.expected;
  if (expected.format == Format::kUnknown) return false;
  for (const Flow* flow : Flows()) {
    if (flow->tally.MainFormat() != expected.format || Claimed(*flow)) continue;
    explained_.push_back(flow);
    const bool protocol = flow->stream != expected.stream;
    const std::string port = std::to_string(flow->to.port);
    Report(
        Severity::kProblem, Step::kArrival, &source, protocol ? "wrong_protocol" : "wrong_port",
        std::string(Row(expected.format).name) + " arrives at " + PlaceOf(flow->to, flow->stream) +
            ", but " + Label(source) + " listens on " + PlaceOf(expected) + ".",
        std::to_string(flow->datagrams) + " datagrams from " + flow->from.host + ", none at " +
            PlaceOf(expected) + ".",
        protocol ? "Switch the sender to " + std::string(expected.stream ? "TCP" : "UDP") +
                       ", or set type = \"" + std::string(TypeFor(expected.format, flow->stream)) +
                       "\" for " + expected.name + " and restart the daemon."
                 : "Send to port " + std::to_string(expected.listen.port) + ", or set listen = \"" +
                       ToString({expected.listen.host, flow->to.port}) + "\" for " + expected.name +
                       " and restart the daemon (port " + port + ").");
    return true;
  }
  return false;
}

// Datagrams reach the interface, but a packet filter keeps them from programs.
bool Examination::Filtered(const SourceFacts& source, std::uint16_t at) {
  const ExpectedSource& expected = source.expected;
  const auto reaches = [&](const Flow& flow) { return Reaches(flow, expected); };
  const auto seen = std::ranges::find_if(facts_.seen, reaches);
  const bool heard = std::ranges::any_of(facts_.heard, reaches) || source.received.value_or(0) > 0;
  const bool listened = source.in_daemon
                            ? source.received.has_value()
                            : source.port && source.port->kind == PortState::Kind::kHeard;
  const bool stopped = seen != facts_.seen.end() && listened && !heard;
  const bool dropped = source.firewall.verdict == Firewall::Verdict::kDropped;
  if (heard || (!stopped && !dropped)) return false;
  const std::string port = std::to_string(at);
  const std::string protocol = expected.stream ? "tcp" : "udp";
  std::string why;
  if (stopped) {
    explained_.push_back(&*seen);
    why = std::to_string(seen->datagrams) + " datagrams from " + seen->from.host + " came to " +
          seen->interface + ", and none of them to a program. ";
  }
  why += dropped ? "Rule: " + source.firewall.rule + "."
                 : "No known rule drops them; the kernel's reverse path filter may, too "
                   "(sysctl net.ipv4.conf.all.rp_filter).";
  Report(Severity::kProblem, Step::kArrival, &source, "firewall_drops",
         "This machine's firewall drops datagrams to its port " + port + "/" + protocol + ".", why,
         "Open the port, as root, by the program that this machine's firewall is set with:\n"
         "ufw allow " +
             port + "/" + protocol + "\nfirewall-cmd --add-port=" + port + "/" + protocol +
             "\nnft insert rule inet filter input " + protocol + " dport " + port + " accept");
  return true;
}

void Examination::Nothing(const SourceFacts& source) {
  const ExpectedSource& expected = source.expected;
  // Unclaimed() reports once which data arrives instead.
  if (expected.origin == ExpectedSource::Origin::kAssumed && !Flows().empty()) return;
  // Among sources that share a name, one that receives is enough; so only one is reported as
  // silent.
  std::string places = PlaceOf(expected);
  for (const SourceFacts& other : facts_.sources) {
    if (&other == &source || other.expected.name != expected.name) continue;
    if (&other < &source) return;
    places += " and " + PlaceOf(other.expected);
  }
  const bool may_drop = source.firewall.verdict == Firewall::Verdict::kDepends;
  std::string why = "Nothing arrived in " + Seconds(facts_.seconds) + ", and no " +
                    std::string(Row(expected.format).name) + " on any other examined port.";
  if (may_drop) why += " The firewall may drop it: " + source.firewall.rule + ".";
  std::string change;
  if (IsLoopback(expected.listen.host)) {
    change =
        "Loopback only receives from programs on this machine. If the sender is on another one, "
        "set "
        "listen = \"0.0.0.0:" +
        std::to_string(expected.listen.port) +
        "\" and restart the "
        "daemon. ";
  }
  const std::string to = IsWildcard(expected.listen.host) ? OwnAddresses() : expected.listen.host;
  change += "The sender must send to " + to + ", port " + std::to_string(expected.listen.port) +
            (expected.stream ? " (TCP). " : " (UDP). ") + InTheSender(expected);
  if (!facts_.firewall.empty() && !IsLoopback(expected.listen.host)) {
    change += " The firewall could not be examined (" + facts_.firewall +
              "): sudo nft list ruleset shows it; with sudo, doctor reads it and also sees data "
              "that arrives at the interfaces.";
  }
  Report(Severity::kProblem, Step::kArrival, &source, "nothing_arrives",
         "Nothing arrives for " + expected.name + " at " + places + ".", why, change);
}

}  // namespace styled::doctor

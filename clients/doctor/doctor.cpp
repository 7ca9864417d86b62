#include "clients/doctor/doctor.h"

#include <google/protobuf/stubs/logging.h>
#include <unistd.h>

#include <algorithm>
#include <set>
#include <utility>

#include "clients/cpp/control.h"
#include "clients/doctor/capture.h"

namespace styled::doctor {
namespace {

constexpr double kCall_s = 1.5;  // time for a NatNet server to reply
constexpr std::string_view kTcp = "tcp://";

// The TCP address of the daemon's control socket; empty for ipc endpoints and host names.
std::optional<Endpoint> TcpOf(const std::string& endpoint) {
  if (!endpoint.starts_with(kTcp)) return std::nullopt;
  auto parsed = ParseEndpoint(std::string_view(endpoint).substr(kTcp.size()));
  if (parsed && parsed->host == "localhost") parsed->host = "127.0.0.1";
  return parsed && IsNumeric(parsed->host) ? parsed : std::nullopt;
}

class Examiner {
 public:
  explicit Examiner(const Options& options) : options_(options) {}

  Result<Facts> Run() {
    facts_.interfaces = ListInterfaces();
    facts_.seconds = options_.seconds;
    Status status = ReadConfig();
    if (!status.ok()) return status;
    status = QueryDaemon();
    if (!status.ok()) return status;
    status = ChooseSources();
    if (!status.ok()) return status;
    probe_.emplace(facts_.interfaces);
    CallNatNetServers();
    CallQtmServers();
    OpenPorts();
    OpenCapture();
    // Read the status again, since the NatNet calls and opening the ports took time.
    (void)Ask(facts_.daemon.before);
    const auto before = ListSockets();
    probe_->Run(options_.seconds);
    (void)Ask(facts_.daemon.after);
    facts_.heard = probe_->heard().flows();
    facts_.seen = probe_->seen().flows();
    CheckHolders(before, ListSockets());
    CountReceived();
    CheckFirewall();
    return std::move(facts_);
  }

 private:
  Status ReadConfig() {
    facts_.daemon.endpoint = options_.endpoint;
    if (options_.config.empty()) return Status::Ok();
    facts_.from_file = true;
    auto settings = ReadSettings(options_.config);
    if (!settings.ok()) return settings.status();
    configured_ = std::move(settings.value().sources);
    const std::string& control = settings.value().control;
    const auto place = TcpOf(control);
    const bool any_port = place && place->port == 0;
    if (options_.endpoint_given || control.empty() || any_port) return Status::Ok();
    // A socket bound to every interface is reachable by loopback.
    const bool everywhere = place && IsWildcard(place->host);
    facts_.daemon.endpoint =
        everywhere ? std::string(kTcp) + ToString({"127.0.0.1", place->port}) : control;
    return Status::Ok();
  }

  client::CallStatus Ask(v1::StatusReply& reply) {
    if (control_ == nullptr || !facts_.daemon_answers()) return {};
    return control_->Status(&reply);
  }

  Status QueryDaemon() {
    DaemonFacts& daemon = facts_.daemon;
    auto control =
        client::Control::Connect({daemon.endpoint, options_.timeout, options_.curve, {}});
    if (!control.ok()) return control.status();
    control_ = std::move(control.value());
    const auto place = TcpOf(daemon.endpoint);
    const auto answer = control_->Status(&daemon.after);
    daemon.before = daemon.after;
    using Kind = client::CallStatus::Kind;
    if (answer.ok()) daemon.state = DaemonFacts::State::kAnswers;
    if (answer.kind() == Kind::kGarbled) daemon.state = DaemonFacts::State::kGarbled;
    const bool here =
        !place || IsLoopback(place->host) || FindInterface(facts_.interfaces, place->host);
    daemon.remote = answer.ok() && !here;
    if (answer.ok()) return Status::Ok();
    for (BoundSocket& socket : ListSockets()) {
      if (!socket.stream) continue;
      if (place && socket.local.port == place->port) {
        daemon.holder = socket;
      } else if (socket.program == "styled") {
        daemon.elsewhere.push_back(std::move(socket));
      }
    }
    return Status::Ok();
  }

  // Chooses the sources: those of the daemon; in addition, or without a daemon, those of the file;
  // otherwise those of a daemon without configuration. Sources of --listen are added.
  Status ChooseSources() {
    for (const auto& info : facts_.daemon.after.sources()) {
      SourceFacts& source = AddSource(
          MakeExpected(ExpectedSource::Origin::kDaemon, info.name(), info.type(), info.listen()));
      source.in_daemon = true;
      source.expected.merge_into = info.merge_into();
      source.stray = info.stray();
    }
    for (const ExpectedSource& expected : configured_) AddConfigured(expected);
    for (const auto& text : options_.listen) {
      auto expected = ParseListen(text);
      if (!expected.ok()) return Status::Error("--listen " + expected.status().message());
      const ExpectedSource& asked = expected.value();
      const bool known = std::ranges::any_of(facts_.sources, [&asked](const SourceFacts& source) {
        return source.expected.stream == asked.stream && source.expected.listen == asked.listen;
      });
      if (!known) AddSource(asked);
    }
    if (facts_.sources.empty()) {
      for (const ExpectedSource& expected : AssumedSources()) AddSource(expected);
    }
    if (options_.source.empty()) return Status::Ok();
    facts_.one_source = true;
    std::string known;
    for (const auto& source : facts_.sources) known += " " + source.expected.name;
    std::erase_if(facts_.sources, [this](const SourceFacts& source) {
      return source.expected.name != options_.source;
    });
    if (!facts_.sources.empty()) return Status::Ok();
    return Status::Error("--source " + options_.source + ": no such source; there are" + known);
  }

  // The daemon reports less than the file contains; a source of the daemon is not listed twice.
  void AddConfigured(const ExpectedSource& expected) {
    for (SourceFacts& source : facts_.sources) {
      const ExpectedSource& known = source.expected;
      const bool port = expected.listen.port == 0 || expected.listen.port == known.listen.port;
      if (!source.in_daemon || known.name != expected.name || known.type != expected.type ||
          !port) {
        continue;
      }
      const Endpoint listen = known.listen;
      source.expected = expected;
      source.expected.origin = ExpectedSource::Origin::kDaemon;
      source.expected.listen = listen;
      return;
    }
    // An old daemon reports no sources; then those of the file are assumed.
    AddSource(expected).in_daemon =
        facts_.daemon_answers() && facts_.daemon.after.sources().empty();
  }

  SourceFacts& AddSource(const ExpectedSource& expected) {
    facts_.sources.emplace_back().expected = expected;
    return facts_.sources.back();
  }

  void CallNatNetServers() {
    bool called = false;
    for (SourceFacts& source : facts_.sources) {
      if (source.expected.format != Format::kNatNet || facts_.daemon.remote) continue;
      // Only the file states the interface, and whether a group is used.
      if (source.in_daemon && source.expected.server.empty()) continue;
      auto call = MakeNatNetCall(source.expected.server, source.natnet.emplace());
      if (call.ok()) {
        probe_->Add(std::move(call.value()));
        called = true;
      } else {
        source.natnet->error = call.status().message();
      }
    }
    if (called) probe_->Run(kCall_s);
    std::set<std::pair<std::string, std::uint16_t>> groups;
    for (SourceFacts& source : facts_.sources) {
      if (!source.natnet) continue;
      const std::string group =
          source.natnet->group.empty() ? source.expected.group : source.natnet->group;
      if (!source.natnet->answered) source.natnet->multicast = source.expected.multicast;
      const std::string& chosen = source.expected.interface;
      source.group_interface = chosen.empty() ? RouteTo(group) : chosen;
      groups.emplace(group, source.natnet->data_port);
    }
    if (groups.empty() && !facts_.daemon_answers()) {
      groups.emplace(ExpectedSource().group, natnet::kDataPort);
    }
    for (const auto& [group, port] : groups) (void)probe_->Join(group, port);
  }

  // They are queried while we listen.
  void CallQtmServers() {
    for (SourceFacts& source : facts_.sources) {
      if (source.expected.format != Format::kQtm || facts_.daemon.remote) continue;
      auto call = MakeQtmCall(source.expected.listen, source.qtm.emplace());
      if (call.ok()) {
        probe_->Add(std::move(call.value()));
      } else {
        source.qtm->error = call.status().message();
      }
    }
  }

  // Opens the sources' own ports and the usual ports of all formats.
  void OpenPorts() {
    if (facts_.daemon.remote) return;
    std::set<std::pair<bool, std::uint16_t>> opened;
    for (SourceFacts& source : facts_.sources) {
      const ExpectedSource& expected = source.expected;
      if (!expected.network || expected.listen.port == 0 || Row(expected.format).asks_server)
        continue;
      const bool v6 = expected.listen.host.find(':') != std::string::npos;
      if (opened.emplace(expected.stream, expected.listen.port).second) {
        source.port = probe_->Open(expected.stream, expected.listen.port, v6);
        states_[{expected.stream, expected.listen.port}] = *source.port;
      } else {
        source.port = states_[{expected.stream, expected.listen.port}];
      }
    }
    for (int f = 0; f < static_cast<int>(Format::kCount); ++f) {
      const auto format = static_cast<Format>(f);
      for (const std::uint16_t port : Row(format).ports) {
        if (port == 0 || Row(format).asks_server) continue;
        if (opened.emplace(false, port).second) (void)probe_->Open(false, port, false);
      }
    }
    for (const auto& [stream, port] : opened) ports_.insert(port);
  }

  void OpenCapture() {
    if (facts_.daemon.remote || !options_.capture) {
      facts_.capture = "not asked for";
      return;
    }
    auto listeners = MakeCapture(facts_.interfaces, ports_);
    if (!listeners.ok()) {
      facts_.capture = listeners.status().message();
      return;
    }
    for (auto& listener : listeners.value()) probe_->Add(std::move(listener));
  }

  void CheckHolders(const std::vector<BoundSocket>& before, const std::vector<BoundSocket>& after) {
    for (SourceFacts& source : facts_.sources) {
      const ExpectedSource& expected = source.expected;
      if (Row(expected.format).asks_server) continue;  // its address is not on this machine
      for (const BoundSocket& socket : after) {
        if (socket.stream != expected.stream || socket.local.port != expected.listen.port) continue;
        if (socket.pid == getpid()) continue;
        source.holders.push_back(socket);
        const auto earlier = std::ranges::find(before, socket.inode, &BoundSocket::inode);
        source.drops += socket.drops - (earlier == before.end() ? 0 : earlier->drops);
      }
    }
  }

  void CountReceived() {
    const auto& before = facts_.daemon.before.sources();
    const auto& after = facts_.daemon.after.sources();
    for (SourceFacts& source : facts_.sources) {
      for (int i = 0; source.in_daemon && i < std::min(before.size(), after.size()); ++i) {
        const auto endpoint = ParseEndpoint(after[i].listen());
        if (after[i].name() != source.expected.name || after[i].type() != source.expected.type ||
            (endpoint && *endpoint != source.expected.listen)) {
          continue;
        }
        source.received = after[i].received() - before[i].received();
        // The daemon's own count, because another machine's sockets cannot be examined.
        const std::uint64_t drops = after[i].kernel_dropped() - before[i].kernel_dropped();
        source.drops = std::max(source.drops, drops);
      }
    }
  }

  void CheckFirewall() {
    const Firewall firewall = Firewall::Read();
    facts_.firewall = firewall.why();
    if (!firewall.readable()) return;
    for (SourceFacts& source : facts_.sources) {
      const ExpectedSource& expected = source.expected;
      Firewall::Packet packet{expected.stream, expected.listen.port, "", ""};
      if (IsLoopback(expected.listen.host)) packet.interface = "lo";
      if (source.natnet) {
        packet.port = source.natnet->data_port;
        packet.destination = source.natnet->group.empty() ? expected.group : source.natnet->group;
      }
      source.firewall = firewall.Judge(packet);
    }
  }

  const Options& options_;
  Facts facts_;
  std::vector<ExpectedSource> configured_;
  std::unique_ptr<client::Control> control_;
  std::optional<Probe> probe_;
  std::set<std::uint16_t> ports_;
  std::map<std::pair<bool, std::uint16_t>, PortState> states_;
};

}  // namespace

Result<Facts> Examine(const Options& options) {
  // Malformed input is reported by the doctor, not logged.
  google::protobuf::SetLogHandler(nullptr);
  return Examiner(options).Run();
}

}  // namespace styled::doctor

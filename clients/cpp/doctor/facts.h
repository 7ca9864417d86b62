#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/doctor/firewall.h"
#include "clients/cpp/doctor/interfaces.h"
#include "clients/cpp/doctor/natnet_call.h"
#include "clients/cpp/doctor/probe.h"
#include "clients/cpp/doctor/settings.h"
#include "clients/cpp/doctor/sockets.h"
#include "clients/cpp/doctor/traffic.h"
#include "proto/styled/v1/control.pb.h"

// All that was found out, before anybody judges it.
namespace styled::doctor {

struct DaemonFacts {
  enum class State {
    kAnswers,
    kSilent,  // nobody answers
    kGarbled  // something answers that is no daemon of ours
  };
  State state = State::kSilent;
  std::string endpoint;
  bool remote = false;                // on another machine: its ports cannot be looked at
  v1::StatusReply before, after;      // kAnswers: around the listening
  std::optional<BoundSocket> holder;  // of the endpoint's TCP port on this machine
  // TCP ports on which programs called styled listen, where the endpoint is none of theirs.
  std::vector<BoundSocket> elsewhere;
};

struct SourceFacts {
  Wanted wanted;
  bool in_daemon = false;                 // a running daemon has this source
  std::optional<std::uint64_t> received;  // by the daemon while we listened
  std::optional<PortState> port;          // none: not looked at
  std::vector<BoundSocket> holders;       // other programs' sockets on the port
  std::uint64_t drops = 0;                // of those, while we listened
  Firewall::Judgement firewall;
  std::optional<NatNetAnswers> natnet;
  std::vector<GroupState> groups;
  std::string group_interface;  // that the daemon joins the group on; "" = there is no route
};

struct Facts {
  double seconds = 0;  // of listening
  DaemonFacts daemon;
  bool from_file = false;  // --config was given
  std::vector<SourceFacts> sources;
  std::vector<Interface> interfaces;
  std::vector<Flow> heard;  // on our own sockets
  std::vector<Flow> seen;   // on the interfaces; see `capture`
  std::string capture;      // "": worked; else why not
  std::string firewall;     // "": readable; else why not

  bool daemon_answers() const { return daemon.state == DaemonFacts::State::kAnswers; }
  // By how much a counter of the daemon grew while we listened; 0 where there is no daemon.
  std::uint64_t Grown(const std::string& counter) const;
};

}  // namespace styled::doctor

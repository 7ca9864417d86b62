#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/doctor/firewall.h"
#include "clients/doctor/interfaces.h"
#include "clients/doctor/natnet_call.h"
#include "clients/doctor/probe.h"
#include "clients/doctor/qtm_call.h"
#include "clients/doctor/settings.h"
#include "clients/doctor/sockets.h"
#include "clients/doctor/traffic.h"
#include "proto/styled/v1/control.pb.h"

// The results of the examination, before their evaluation.
namespace styled::doctor {

struct DaemonFacts {
  enum class State {
    kAnswers,
    kSilent,  // no reply
    kGarbled  // a reply, but not from a styled daemon
  };
  State state = State::kSilent;
  std::string endpoint;
  bool remote = false;            // on another machine: its ports cannot be examined
  v1::StatusReply before, after;  // for kAnswers: before and after listening
  // The socket that holds the endpoint's TCP port on this machine.
  std::optional<BoundSocket> holder;
  // Listening TCP sockets of programs named `styled`, if none of them is at the endpoint.
  std::vector<BoundSocket> elsewhere;
};

struct SourceFacts {
  ExpectedSource expected;
  bool in_daemon = false;                 // the running daemon has this source
  std::optional<std::uint64_t> received;  // by the daemon, during listening
  std::string stray;                      // v1::SourceInfo.stray
  std::optional<PortState> port;          // empty: not examined
  std::vector<BoundSocket> holders;       // sockets of other programs on the port
  std::uint64_t drops = 0;                // of `holders`, during listening
  Firewall::Judgement firewall;
  std::optional<NatNetAnswers> natnet;
  std::optional<QtmAnswers> qtm;
  std::vector<GroupState> groups;
  std::string group_interface;  // on which the daemon joins the group; "" = no route
};

struct Facts {
  double seconds = 0;  // duration of listening
  DaemonFacts daemon;
  bool from_file = false;  // --config was given
  std::vector<SourceFacts> sources;
  bool one_source = false;  // of --source: there may be others
  std::vector<Interface> interfaces;
  std::vector<Flow> heard;  // on this program's sockets
  std::vector<Flow> seen;   // captured at the interfaces; see `capture`
  std::string capture;      // "": capturing worked; otherwise the reason why not
  std::string firewall;     // "": the rules were readable; otherwise the reason why not

  bool daemon_answers() const { return daemon.state == DaemonFacts::State::kAnswers; }
  // Growth of a daemon's counter during listening; 0 without a daemon.
  std::uint64_t Grown(const std::string& counter) const;
};

}  // namespace styled::doctor

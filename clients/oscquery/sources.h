#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/oscquery/mdns.h"
#include "model/base/status.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::oscquery {

// A source of the daemon that other programs can find.
struct Source {
  std::string name, type;     // as in the configuration
  std::string address;        // where it listens; numeric
  std::uint16_t port = 0;     // UDP
  std::vector<Place> places;  // at which others reach it
  friend bool operator==(const Source&, const Source&) = default;
};

struct Plan {
  std::vector<Source> sources;       // to announce
  std::vector<std::string> notices;  // sources that are not, and why; one sentence each
};

// The sources of VMC and of VRChat's trackers among those of the reply. One that listens on
// loopback is not announced: no address that others could use reaches it. Of a source that listens
// on all addresses, the IPv4 ones are announced. Pinned by tests/unit/oscquery/sources_test.cpp.
Plan MakePlan(const v1::StatusReply& status);

// Refuses a control endpoint of another machine, or two endpoints: mDNS announces this machine, and
// the sources must listen here. May resolve a name.
Status CheckLocal(const std::string& control);

}  // namespace styled::oscquery

#pragma once

#include <netinet/in.h>

#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "model/base/status.h"

namespace styled::config {

// Whether every [[source]] can be opened, as far as its text tells: names, addresses, and the keys
// of its type. Errors begin with the key, "source.0.listen: ". Opens nothing.
Status CheckSources(const std::vector<Source>& sources);

// The first row of `source.trackers` that is no tracker's id (proto/rigs/slimevr/tracker_id.h), no
// joint of the canonical humanoid, or names one of them again. Errors begin with "trackers: ".
// Pinned by tests/unit/slimevr/tracker_rig_test.cpp.
Status CheckTrackers(const std::vector<Tracker>& trackers);

// `source.server`, an IPv4 HOST[:PORT], in network byte order; without a port NatNet's command
// port. Errors begin with "server: ".
Result<sockaddr_in> ParseServer(const std::string& text);
// `source.group`, an IPv4 multicast address. Errors begin with "group: ".
Result<in_addr> ParseGroup(const std::string& text);

}  // namespace styled::config

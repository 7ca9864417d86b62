#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "model/base/status.h"
#include "proto/rigs/types.h"

namespace styled::config {

// A source of a type that sends only a face, without `merge_into` and with the body "auto", gets
// merge_into kOnlyPerformer if another source has performers; else its body stands.
void AssignFaces(std::vector<Source>& sources);

// Checks names, addresses, and the keys of each [[source]]'s type, as far as the text alone allows;
// opens nothing. Errors begin with the key, e.g. "source.0.listen: ".
Status CheckSources(const std::vector<Source>& sources);

// Refuses the first row of `source.trackers` whose id is not a tracker's id
// (proto/rigs/slimevr/tracker_id.h), whose part is not a joint of the canonical humanoid, or that
// repeats an id or a part. Errors begin with "trackers: ". Pinned by
// tests/unit/slimevr/tracker_rig_test.cpp.
Status CheckTrackers(const std::vector<Tracker>& trackers);
// The same for rigs whose devices have names: VMC's serials, 1 to 64 bytes of UTF-8, and the names
// of a source of type "vrchat" (daemon/source/rigs/vrchat.h). Pinned by
// tests/unit/vrchat/translator_test.cpp.
Status CheckDevices(const std::vector<Tracker>& trackers, const rigs::RigType& rig);

// Parses `source.server`, an IPv4 HOST[:PORT], into network byte order. Errors begin with
// "server: ".
Result<sockaddr_in> ParseServer(const std::string& text, std::uint16_t default_port);
// Parses `source.group`, an IPv4 multicast address. Errors begin with "group: ".
Result<in_addr> ParseGroup(const std::string& text);

}  // namespace styled::config

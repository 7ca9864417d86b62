#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"

namespace styled::oscquery {

// A program that receives OSC. All texts are the program's own: not safe for a terminal, except for
// `trouble` (model/base/text.h: Printable).
struct Receiver {
  std::string name;
  std::string host;                    // "pc.local"
  std::string address;                 // for OSC; numeric, IPv4
  std::uint16_t port = 0;              // UDP
  std::vector<std::string> addresses;  // OSC addresses that it takes, if its tree is known
  std::string trouble;                 // why its tree is not known; "": it is
};

// Whether it takes an OSC address at or below `path`, e.g. "/VMC/Ext".
bool HasPath(const Receiver& receiver, std::string_view path);

// Reads the two answers of an OSCQuery server at `http_address` into `receiver`: address and port
// for OSC, and the addresses that can be written (at most 4,096, 32 deep). Where HOST_INFO has no
// usable address or port, those of the server count, by the proposal. Errors are about the texts
// alone. Pure; pinned by tests/unit/oscquery/find_test.cpp.
Status ReadAnswers(const std::string& host_info, const std::string& tree,
                   const std::string& http_address, std::uint16_t http_port, Receiver& receiver);

// Finds all receivers in the network: by mDNS, then each one's tree by HTTP, in parallel and for at
// most two seconds. Sorted by name. Blocks, for about a second, at most `timeout` and those two.
// Errors: no avahi-daemon; the text names the cure.
Result<std::vector<Receiver>> FindReceivers(std::chrono::milliseconds timeout);

// The receiver named `name`, else the only one whose name begins so; letters match in either case.
// The error lists the names that there are.
Result<Receiver> Choose(const std::vector<Receiver>& receivers, const std::string& name);

}  // namespace styled::oscquery

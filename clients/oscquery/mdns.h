#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "model/base/status.h"

// mDNS and DNS-SD (RFC 6762, RFC 6763) through avahi-daemon, which answers for all programs of a
// machine. OSCQuery's servers are services of type _oscjson._tcp, OSC's receivers of _osc._udp.
namespace styled::oscquery {

// An address of this machine, and the index of its network interface.
struct Place {
  unsigned interface = 0;
  std::string address;  // numeric
  friend bool operator==(const Place&, const Place&) = default;
};

// An OSCQuery server and its OSC receiver, under one name. It is a host, too, with the addresses at
// which both are reached, so that they are announced in one packet: programs that do not ask for
// the address of a host by itself, as VRChat's, find it there.
struct Announcement {
  std::string name;
  std::uint16_t http_port = 0, osc_port = 0;
  std::vector<Place> places;  // at least one
  friend bool operator==(const Announcement&, const Announcement&) = default;
};

// Announces services on a thread of its own, so that an avahi-daemon that does not answer delays
// nothing. When avahi-daemon starts (again), or gives the machine another name, all of them are
// announced again; the destructor withdraws them. Any thread may call. Pinned by
// tests/witness/oscquery.
class Advertiser {
 public:
  struct State {
    std::string trouble;  // why nothing is announced, and the cure; "": all is
    // For each announced service the name in force: another one where a different program in the
    // network already has the name.
    std::map<std::string, std::string> names;
  };

  Advertiser();
  ~Advertiser();
  Advertiser(const Advertiser&) = delete;
  Advertiser& operator=(const Advertiser&) = delete;

  void Set(std::vector<Announcement> announcements);  // from now on exactly these; names differ
  State state() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A service in the network. Its texts are its owner's.
struct Sighting {
  std::string name;
  bool has_tree = false;  // _oscjson._tcp, else _osc._udp
  std::string host;       // "pc.local"
  std::string address;    // numeric, IPv4
  std::uint16_t port = 0;
};

// Lists the services of both types: those with an IPv4 address, at most 256, each once. Blocks
// until the network has answered, about a second, at most `timeout`. The error names the cure.
Result<std::vector<Sighting>> Browse(std::chrono::milliseconds timeout);

}  // namespace styled::oscquery

#include "clients/oscquery/sources.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>

#include <algorithm>
#include <utility>

#include "clients/doctor/address.h"
#include "clients/oscquery/tree.h"

namespace styled::oscquery {
namespace {

// The places at which a socket of this address is reached; none if the machine lacks it.
std::vector<Place> PlacesOf(const std::string& host) {
  std::vector<Place> places;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return places;
  const bool any = doctor::IsWildcard(host);
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || (one->ifa_flags & IFF_UP) == 0) continue;
    const auto family = one->ifa_addr->sa_family;
    if (family != AF_INET && (family != AF_INET6 || any)) continue;
    sockaddr_storage address{};
    const auto* bytes = reinterpret_cast<const char*>(one->ifa_addr);
    const std::size_t size = family == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6);
    std::copy(bytes, bytes + size, reinterpret_cast<char*>(&address));
    const std::string numeric = doctor::FromSocket(address).host;
    if (any || numeric == host) places.push_back({if_nametoindex(one->ifa_name), numeric});
  }
  freeifaddrs(all);
  return places;
}

}  // namespace

Plan MakePlan(const v1::StatusReply& status) {
  Plan plan;
  for (const v1::SourceInfo& info : status.sources()) {
    if (MethodsOf(info.type()).empty()) continue;
    const auto endpoint = doctor::ParseEndpoint(info.listen());
    const std::string who = info.name() + " (" + info.type() + ", " + info.listen() + ")";
    if (!endpoint) {
      plan.notices.push_back(who + " is not announced: expected ADDRESS:PORT");
    } else if (doctor::IsLoopback(endpoint->host)) {
      plan.notices.push_back(who +
                             " is not announced: only programs of this machine reach it; for "
                             "others set its `listen` to \"0.0.0.0:" +
                             std::to_string(endpoint->port) + "\"");
    } else if (auto places = PlacesOf(endpoint->host); places.empty()) {
      plan.notices.push_back(who + " is not announced: no interface has that address");
    } else {
      plan.sources.push_back(
          {info.name(), info.type(), endpoint->host, endpoint->port, std::move(places)});
    }
  }
  return plan;
}

Status CheckLocal(const std::string& control) {
  if (control.find(',') != std::string::npos) {
    return Status::Error("--control " + control +
                         " names two daemons; expected the one of this machine");
  }
  constexpr std::string_view kTcp = "tcp://";
  if (!control.starts_with(kTcp)) return Status::Ok();
  std::string host = control.substr(kTcp.size(), control.rfind(':') - kTcp.size());
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  addrinfo* all = nullptr;
  // A name that does not resolve is reported by the first request.
  if (getaddrinfo(host.c_str(), nullptr, nullptr, &all) != 0) return Status::Ok();
  bool local = false;
  for (const addrinfo* one = all; one != nullptr; one = one->ai_next) {
    sockaddr_storage address{};
    const auto* bytes = reinterpret_cast<const char*>(one->ai_addr);
    std::copy(bytes, bytes + one->ai_addrlen, reinterpret_cast<char*>(&address));
    const std::string numeric = doctor::FromSocket(address).host;
    local = local || doctor::IsWildcard(numeric) || doctor::IsLoopback(numeric) ||
            !PlacesOf(numeric).empty();
  }
  freeaddrinfo(all);
  if (local) return Status::Ok();
  return Status::Error("--control " + control +
                       " is another machine's, and mDNS announces the address of this machine; run "
                       "styleoscquery there");
}

}  // namespace styled::oscquery

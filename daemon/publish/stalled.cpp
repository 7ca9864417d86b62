#include "daemon/publish/stalled.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <sstream>
#include <utility>

namespace styled::publish {
namespace {

template <typename Number>
bool ReadHex(std::string_view text, Number& number) {
  const auto end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number, 16);
  return error == std::errc() && at == end;
}

// "0100007F:1B59", or the same form for IPv6: words in the machine's byte order.
std::string AddressOf(std::string_view text) {
  const std::size_t colon = text.find(':');
  std::uint16_t port = 0;
  if (colon == std::string_view::npos || !ReadHex(text.substr(colon + 1), port)) return "";
  std::array<std::uint32_t, 4> words{};
  const std::size_t count = colon / 8;
  if (colon % 8 != 0 || (count != 1 && count != 4)) return "";
  for (std::size_t i = 0; i < count; ++i) {
    if (!ReadHex(text.substr(8 * i, 8), words[i])) return "";
  }
  std::array<char, INET6_ADDRSTRLEN> shown{};
  inet_ntop(count == 1 ? AF_INET : AF_INET6, words.data(), shown.data(), shown.size());
  const std::string host = shown.data();
  return (count == 1 ? host : "[" + host + "]") + ":" + std::to_string(port);
}

std::string ReadTable(const char* file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

bool Contains(const std::vector<std::string>& all, const std::string& one) {
  return std::ranges::find(all, one) != all.end();
}

}  // namespace

std::vector<std::string> FindStalled(std::string_view table, std::uint16_t port) {
  constexpr std::string_view kEstablished = "01";
  constexpr unsigned kWindowProbe = 4;  // the number of the timer that runs while the window is
                                        // closed
  constexpr unsigned kRepetitions = 3;  // unanswered repetitions after which the other machine is
                                        // considered gone
  std::vector<std::string> stalled;
  std::istringstream lines{std::string(table)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string number, local, remote, state, queues, timer, repetitions;
    if (!(words >> number >> local >> remote >> state >> queues >> timer >> repetitions)) continue;
    std::uint16_t local_port = 0;
    std::uint32_t waiting = 0;
    unsigned kind = 0, repeated = 0;
    const std::size_t colon = local.find(':');
    if (state != kEstablished || colon == std::string::npos ||
        !ReadHex(std::string_view(local).substr(colon + 1), local_port) || local_port != port ||
        !ReadHex(std::string_view(queues).substr(0, queues.find(':')), waiting) ||
        !ReadHex(std::string_view(timer).substr(0, timer.find(':')), kind) ||
        !ReadHex(std::string_view(repetitions), repeated)) {
      continue;
    }
    if (waiting == 0 || (kind != kWindowProbe && repeated < kRepetitions)) continue;
    stalled.push_back(AddressOf(remote));
  }
  return stalled;
}

StalledSubscribers::StalledSubscribers(std::string_view endpoint) {
  if (!endpoint.starts_with("tcp://")) return;
  const std::string_view port = endpoint.substr(endpoint.rfind(':') + 1);
  (void)std::from_chars(port.data(), port.data() + port.size(), port_);
}

void StalledSubscribers::Look(std::vector<std::string>& fresh,
                              std::vector<std::string>& recovered) {
  if (port_ == 0) return;
  std::vector<std::string> stalled = FindStalled(ReadTable("/proc/net/tcp"), port_);
  for (std::string& address : FindStalled(ReadTable("/proc/net/tcp6"), port_)) {
    stalled.push_back(std::move(address));
  }
  Judge(std::move(stalled), fresh, recovered);
}

void StalledSubscribers::Judge(std::vector<std::string> stalled, std::vector<std::string>& fresh,
                               std::vector<std::string>& recovered) {
  for (const std::string& address : stalled) {
    if (!Contains(last_, address) || Contains(stalled_, address)) continue;
    stalled_.push_back(address);
    fresh.push_back(address);
  }
  for (auto it = stalled_.begin(); it != stalled_.end();) {
    if (Contains(stalled, *it) || Contains(last_, *it)) {
      ++it;
      continue;
    }
    recovered.push_back(*it);
    it = stalled_.erase(it);
  }
  last_ = std::move(stalled);
}

}  // namespace styled::publish

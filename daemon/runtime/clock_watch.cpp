#include "daemon/runtime/clock_watch.h"

#include <sys/socket.h>
#include <sys/timex.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace styled::runtime {
namespace {

constexpr int kDomains = 128;  // 0 .. 127; the rest is reserved

// First 0, the default; then 127, the domain of SMPTE ST 2059-2; then all others.
std::uint8_t DomainToTry(int number) {
  const int at = number % kDomains;
  return static_cast<std::uint8_t>(at == 0 ? 0 : at == 1 ? 127 : at - 1);
}

}  // namespace

ClockWatch::~ClockWatch() { Disconnect(); }

void ClockWatch::Update(std::int64_t now_ns) noexcept {
  ReadKernel();
  if (fd_ < 0 && !Connect()) {
    discipline_.ptp.reset();
    return;
  }
  ReadReplies(now_ns);
  if (domain_ && now_ns - answered_ns_ > kPatience_ns) {
    domain_.reset();
    discipline_.ptp.reset();
    heard_ = {};
    tried_ = 0;
  }
  Ask();
}

void ClockWatch::ReadKernel() noexcept {
  timex kernel{};
  const int state = ntp_adjtime(&kernel);
  discipline_.known = state >= 0;
  discipline_.locked = state >= 0 && state != TIME_ERROR && (kernel.status & STA_UNSYNC) == 0;
  discipline_.max_error_s = static_cast<double>(kernel.maxerror) * 1e-6;
}

bool ClockWatch::Connect() noexcept {
  if (!path_.empty()) return ConnectTo(path_.c_str());
  return std::ranges::any_of(kUsualSockets, [this](const char* path) { return ConnectTo(path); });
}

bool ClockWatch::ConnectTo(const char* path) noexcept {
  sockaddr_un server{};
  server.sun_family = AF_UNIX;
  if (std::strlen(path) >= sizeof server.sun_path) return false;
  std::strcpy(server.sun_path, path);
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  // The kernel gives an address without a file: replies come to it, and nothing is left behind.
  sockaddr_un own{};
  own.sun_family = AF_UNIX;
  if (bind(fd, reinterpret_cast<const sockaddr*>(&own), sizeof own.sun_family) != 0 ||
      connect(fd, reinterpret_cast<const sockaddr*>(&server), sizeof server) != 0) {
    close(fd);
    return false;
  }
  fd_ = fd;
  tried_ = 0;
  return true;
}

void ClockWatch::Disconnect() noexcept {
  if (fd_ >= 0) close(std::exchange(fd_, -1));
}

void ClockWatch::ReadReplies(std::int64_t now_ns) noexcept {
  constexpr int kMost = 64;  // requests per round: four data sets, and one per port
  std::array<std::byte, 1500> message;
  best_ = ptp::PortState::kNone;
  bool any = false;
  for (int i = 0; i < kMost; ++i) {
    const ssize_t size = recv(fd_, message.data(), message.size(), 0);
    if (size < 0) break;
    const auto reply = ptp::Read(std::span(message).first(static_cast<std::size_t>(size)));
    if (!reply) continue;
    domain_ = heard_.domain = reply->domain;
    Apply(*reply);
    any = true;
  }
  if (!any) return;
  answered_ns_ = now_ns;
  // Nothing is shown until all requests are answered.
  if (best_ == ptp::PortState::kNone || heard_.parent.leader == ptp::ClockIdentity{}) return;
  heard_.port = best_;
  discipline_.ptp = heard_;
}

void ClockWatch::Apply(const ptp::Reply& reply) noexcept {
  if (const auto* current = std::get_if<ptp::Current>(&reply.data)) heard_.current = *current;
  if (const auto* parent = std::get_if<ptp::Parent>(&reply.data)) heard_.parent = *parent;
  if (const auto* properties = std::get_if<ptp::TimeProperties>(&reply.data)) {
    heard_.properties = *properties;
  }
  // A clock with several ports is disciplined by at most one of them.
  if (const auto* port = std::get_if<ptp::Port>(&reply.data)) best_ = std::max(best_, port->state);
}

void ClockWatch::Ask() noexcept {
  using ptp::DataSet;
  if (domain_) {
    for (const DataSet data :
         {DataSet::kCurrent, DataSet::kParent, DataSet::kTimeProperties, DataSet::kPort}) {
      if (!Send(data, *domain_)) return;
    }
    return;
  }
  for (int i = 0; i < kDomainsAtOnce; ++i) {
    if (!Send(DataSet::kPort, DomainToTry(tried_++))) return;
  }
}

// Returns false if no more can be sent now.
bool ClockWatch::Send(ptp::DataSet data, std::uint8_t domain) noexcept {
  const auto request = ptp::Get(data, domain, sequence_++);
  if (send(fd_, request.data(), request.size(), MSG_NOSIGNAL) >= 0) return true;
  // A ptp4l that was restarted has another socket of the same name.
  if (errno != EAGAIN && errno != EWOULDBLOCK) Disconnect();
  return false;
}

}  // namespace styled::runtime

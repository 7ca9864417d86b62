#include "tests/e2e/nats/tcp_relay.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <list>
#include <utility>
#include <vector>

namespace styled::support {
namespace {

using RelayClock = std::chrono::steady_clock;

// The most that waits in a direction: 0.1 s of 40 MB/s.
constexpr std::size_t kMaxWaiting = std::size_t{4} << 20U;

sockaddr_in OnLoopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

void WithoutDelay(int fd) {
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

// One direction of a connection.
struct Flow {
  int from = -1, to = -1;
  std::deque<std::pair<RelayClock::time_point, std::string>> waiting;
  std::size_t bytes = 0;
  bool ended = false, broken = false;

  void Read(std::chrono::milliseconds delay) {
    std::array<char, 65536> buffer;
    while (!ended && bytes < kMaxWaiting) {
      const ssize_t size = recv(from, buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
      if (size <= 0) {
        ended = true;
        return;
      }
      waiting.emplace_back(RelayClock::now() + delay,
                           std::string(buffer.data(), static_cast<std::size_t>(size)));
      bytes += static_cast<std::size_t>(size);
    }
  }
  void Write() {
    while (!waiting.empty() && waiting.front().first <= RelayClock::now()) {
      std::string& next = waiting.front().second;
      const ssize_t size = send(to, next.data(), next.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
      if (size < 0) {
        broken = true;
        return;
      }
      bytes -= static_cast<std::size_t>(size);
      next.erase(0, static_cast<std::size_t>(size));
      if (next.empty()) waiting.pop_front();
    }
  }
  bool over() const { return broken || (ended && waiting.empty()); }
};

struct Connection {
  Flow there, back;
  ~Connection() {
    close(there.from);
    close(there.to);
  }
};

}  // namespace

TcpRelay::TcpRelay(const std::string& to, std::chrono::milliseconds delay_each_way)
    : to_(to),
      delay_(delay_each_way),
      listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  sockaddr_in address = OnLoopback(0);
  socklen_t size = sizeof address;
  EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(listen(listener_, 64), 0);
  getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
  port = std::to_string(ntohs(address.sin_port));
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

TcpRelay::~TcpRelay() {
  thread_ = {};
  close(listener_);
}

void TcpRelay::Run(const std::stop_token& stop) {
  std::list<Connection> all;
  while (!stop.stop_requested()) {
    const State state = state_;
    if (state == State::kClosed) all.clear();
    std::vector<pollfd> items{{listener_, POLLIN, 0}};
    auto wake = RelayClock::now() + std::chrono::milliseconds(5);
    if (state == State::kUp) {
      for (const Connection& c : all) {
        for (const Flow* const flow : {&c.there, &c.back}) {
          const bool room = !flow->ended && flow->bytes < kMaxWaiting;
          if (room) items.push_back({flow->from, POLLIN, 0});
          if (flow->waiting.empty()) continue;
          const auto due = flow->waiting.front().first;
          if (due <= RelayClock::now()) items.push_back({flow->to, POLLOUT, 0});
          wake = std::min(wake, std::max(due, RelayClock::now()));
        }
      }
    }
    const auto left =
        std::max(std::chrono::nanoseconds(0), std::chrono::nanoseconds(wake - RelayClock::now()));
    const timespec timeout{0, static_cast<long>(left.count())};
    ppoll(items.data(), items.size(), &timeout, nullptr);
    for (int fd = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC); fd >= 0;
         fd = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC)) {
      const int to = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const sockaddr_in address = OnLoopback(std::stoi(to_));
      if (state_ == State::kClosed ||
          connect(to, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        close(fd);
        close(to);
        continue;
      }
      WithoutDelay(fd);
      WithoutDelay(to);
      ++connections_;
      Connection& c = all.emplace_back();
      c.there.from = c.back.to = fd;
      c.there.to = c.back.from = to;
    }
    if (state_ != State::kUp) continue;
    for (Connection& c : all) {
      for (Flow* const flow : {&c.there, &c.back}) {
        flow->Read(delay_);
        flow->Write();
      }
    }
    all.remove_if([](const Connection& c) { return c.there.over() || c.back.over(); });
  }
}

}  // namespace styled::support

#include "tests/e2e/nats/raw_subscribers.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <optional>

namespace styled::support {
namespace {

using namespace std::string_literals;

constexpr int kEvents = 256;
constexpr std::size_t kReadBytes = 65536;
constexpr std::size_t kArrivals = 4'000'000;  // reserved, so that none is copied while it measures

bool SendAll(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t size = send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(size));
  }
  return true;
}

// Reads until `done` returns true.
template <typename Done>
bool ReceiveUntil(int fd, std::string& bytes, const Done& done) {
  std::array<char, 4096> buffer;
  while (!done(bytes)) {
    const ssize_t size = recv(fd, buffer.data(), buffer.size(), 0);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return false;
    bytes.append(buffer.data(), static_cast<std::size_t>(size));
  }
  return true;
}

std::string ZmtpCommand(const std::string& body) {
  return std::string(1, '\x04') + static_cast<char>(body.size()) + body;
}

std::string ZmtpReady() { return ZmtpCommand("\x05READY\x0bSocket-Type"s + "\0\0\0\x03SUB"s); }

std::string ZmtpGreeting() {
  std::string greeting(64, '\0');
  greeting[0] = '\xff';
  greeting[9] = '\x7f';
  greeting[10] = 3;
  greeting.replace(12, 4, "NULL");
  return greeting;
}

std::optional<std::uint64_t> Varint(std::string_view& bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(10, bytes.size()); ++i) {
    const auto byte = static_cast<unsigned char>(bytes[i]);
    value |= static_cast<std::uint64_t>(byte & 0x7FU) << (7 * i);
    if (byte >= 0x80U) continue;
    bytes.remove_prefix(i + 1);
    return value;
  }
  return std::nullopt;
}

// The fields of a Frame that are needed here: they are among the first, in order of their numbers.
struct Stamp {
  std::string_view performer;
  std::uint64_t sequence = 0, published_ns = 0;
};

std::optional<Stamp> Parse(std::string_view bytes) {
  Stamp stamp;
  while (!bytes.empty()) {
    const auto tag = Varint(bytes);
    if (!tag) return std::nullopt;
    std::uint64_t value = 0;
    switch (*tag & 7U) {
      case 0: {
        const auto read = Varint(bytes);
        if (!read) return std::nullopt;
        value = *read;
        break;
      }
      case 1:
      case 5: {
        const std::size_t size = (*tag & 7U) == 1 ? 8 : 4;
        if (bytes.size() < size) return std::nullopt;
        bytes.remove_prefix(size);
        break;
      }
      case 2: {
        const auto size = Varint(bytes);
        if (!size || *size > bytes.size()) return std::nullopt;
        if (*tag >> 3U == 1) stamp.performer = bytes.substr(0, *size);
        bytes.remove_prefix(*size);
        break;
      }
      default:
        return std::nullopt;
    }
    if (*tag >> 3U == 3) stamp.sequence = value;
    if (*tag >> 3U != 7) continue;
    stamp.published_ns = value;
    return stamp;
  }
  return std::nullopt;
}

std::size_t Number(std::string_view text) {
  std::size_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

}  // namespace

std::int64_t Monotonic_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

double RawResult::Quantile_ms(double q) const {
  if (latency_ms.empty()) return 0;
  return latency_ms[static_cast<std::size_t>(q * static_cast<double>(latency_ms.size() - 1))];
}

struct RawSubscribers::Socket {
  int fd = -1;
  std::uint32_t number = 0;
  std::string rest;    // bytes of a message that is not complete
  bool topic = false;  // ZMTP: the last part was a frame's topic
  ~Socket() {
    if (fd >= 0) close(fd);
  }
};

RawSubscribers::RawSubscribers(const RawOptions& options) : wire_(options.wire) {
  arrivals_.reserve(kArrivals);
  epoll_ = epoll_create1(EPOLL_CLOEXEC);
  for (int i = 0; i < options.count && ok(); ++i) {
    auto socket = std::make_unique<Socket>();
    socket->number = static_cast<std::uint32_t>(i);
    // A server that is busy with those before may not shake hands in time.
    int tries = 5;
    while (!Open(options, *socket) && ok() && --tries > 0) {
      close(socket->fd);
      socket->rest.clear();
    }
    if (tries == 0 || !ok()) {
      if (ok()) error_ = "subscriber " + std::to_string(i) + ": " + std::strerror(errno);
      return;
    }
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.ptr = socket.get();
    epoll_ctl(epoll_, EPOLL_CTL_ADD, socket->fd, &event);
    sockets_.push_back(std::move(socket));
    // Those before may have to answer pings by now.
    if (i == 0 && !options.stopped)
      thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
}

RawSubscribers::~RawSubscribers() {
  thread_ = {};
  sockets_.clear();
  if (epoll_ >= 0) close(epoll_);
}

bool RawSubscribers::Open(const RawOptions& options, Socket& socket) {
  socket.fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (options.stopped) {
    const int small = 1024;
    setsockopt(socket.fd, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  }
  const int on = 1;
  setsockopt(socket.fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  const timeval patience{10, 0};
  setsockopt(socket.fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(options.port)));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(socket.fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return false;
  }
  if (wire_ == Wire::kZmtp) {
    if (!SendAll(socket.fd, ZmtpGreeting()) ||
        !ReceiveUntil(socket.fd, socket.rest, [](const auto& b) { return b.size() >= 64; })) {
      return false;
    }
    socket.rest.erase(0, 64);
    std::string said = ZmtpReady();
    for (const std::string& topic : options.topics) {
      said += '\0';
      said += static_cast<char>(topic.size() + 1);
      said += '\x01' + topic;
    }
    return SendAll(socket.fd, said);
  }
  std::string said =
      "CONNECT {\"verbose\":false,\"pedantic\":false,\"headers\":true,\"protocol\":1,"
      "\"lang\":\"raw\",\"version\":\"0\",\"name\":\"bench\",\"user\":\"" +
      options.user + "\",\"pass\":\"" + options.user + "word\"}\r\n";
  int id = 0;
  for (const std::string& subject : options.topics) {
    said += "SUB " + subject + " " + std::to_string(++id) + "\r\n";
  }
  if (!SendAll(socket.fd, said + "PING\r\n")) return false;
  const auto answered = [](const std::string& bytes) {
    return bytes.find("\r\nPONG\r\n") != std::string::npos ||
           bytes.find("\r\n-ERR") != std::string::npos;
  };
  if (!ReceiveUntil(socket.fd, socket.rest, answered)) return false;
  const std::size_t refused = socket.rest.find("-ERR");
  if (refused == std::string::npos) return true;
  error_ = socket.rest.substr(refused, socket.rest.find('\r', refused) - refused);
  return false;
}

void RawSubscribers::Run(const std::stop_token& stop) {
  std::array<epoll_event, kEvents> events;
  while (!stop.stop_requested()) {
    const int count = epoll_wait(epoll_, events.data(), kEvents, 50);
    for (int i = 0; i < count; ++i) {
      auto& socket = *static_cast<Socket*>(events[static_cast<std::size_t>(i)].data.ptr);
      if (Read(socket)) continue;
      epoll_ctl(epoll_, EPOLL_CTL_DEL, socket.fd, nullptr);
      ++closed_;
    }
  }
}

bool RawSubscribers::Read(Socket& socket) {
  std::array<char, kReadBytes> buffer;
  const ssize_t size = recv(socket.fd, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return true;
  if (size <= 0) return false;
  now_ns_ = Monotonic_ns();
  std::string_view bytes(buffer.data(), static_cast<std::size_t>(size));
  if (!socket.rest.empty()) {
    socket.rest.append(bytes);
    bytes = socket.rest;
  }
  const std::scoped_lock lock(mutex_);
  const std::size_t used =
      wire_ == Wire::kNats ? ParseNats(socket, bytes) : ParseZmtp(socket, bytes);
  socket.rest = std::string(bytes.substr(used));
  return true;
}

std::size_t RawSubscribers::ParseNats(Socket& socket, std::string_view bytes) {
  std::size_t used = 0;
  for (;;) {
    const std::string_view left = bytes.substr(used);
    const std::size_t end = left.find("\r\n");
    if (end == std::string_view::npos) return used;
    const std::string_view line = left.substr(0, end);
    std::size_t payload = 0;
    if (line.starts_with("MSG ") || line.starts_with("HMSG ")) {
      payload = Number(line.substr(line.rfind(' ') + 1)) + 2;
      if (left.size() < end + 2 + payload) return used;
      std::size_t headers = 0;
      if (line.front() == 'H') {
        const std::string_view before = line.substr(0, line.rfind(' '));
        headers = Number(before.substr(before.rfind(' ') + 1));
      }
      AddFrame(socket, left.substr(end + 2 + headers, payload - 2 - headers));
    } else if (line == "PING") {
      SendAll(socket.fd, "PONG\r\n");
    }
    used += end + 2 + payload;
  }
}

std::size_t RawSubscribers::ParseZmtp(Socket& socket, std::string_view bytes) {
  std::size_t used = 0;
  for (;;) {
    const std::string_view left = bytes.substr(used);
    if (left.size() < 2) return used;
    const auto flags = static_cast<unsigned char>(left[0]);
    std::size_t size = static_cast<unsigned char>(left[1]), head = 2;
    if ((flags & 2U) != 0) {
      head = 9;
      if (left.size() < head) return used;
      size = 0;
      for (std::size_t i = 1; i < head; ++i) {
        size = size << 8U | static_cast<unsigned char>(left[i]);
      }
    }
    if (left.size() < head + size) return used;
    const std::string_view part = left.substr(head, size);
    used += head + size;
    if ((flags & 4U) != 0) {
      if (part.starts_with("\x04PING"s) && part.size() >= 7) {
        SendAll(socket.fd, ZmtpCommand("\x04PONG"s + std::string(part.substr(7))));
      }
      continue;
    }
    if ((flags & 1U) != 0) {
      socket.topic = part.starts_with("styled/");
    } else if (socket.topic) {
      AddFrame(socket, part);
      socket.topic = false;
    }
  }
}

void RawSubscribers::AddFrame(Socket& socket, std::string_view payload) {
  const auto stamp = Parse(payload);
  if (!stamp) return;
  ++frames_;
  last_ns_ = now_ns_;
  if (!storing_ || static_cast<std::int64_t>(stamp->published_ns) < begin_ns_) return;
  auto performer = performers_.find(stamp->performer);
  if (performer == performers_.end()) {
    performer = performers_.emplace(stamp->performer, performers_.size()).first;
  }
  arrivals_.push_back({socket.number, performer->second, stamp->sequence,
                       static_cast<std::int64_t>(stamp->published_ns), now_ns_});
}

void RawSubscribers::Begin() {
  const std::scoped_lock lock(mutex_);
  begin_ns_ = Monotonic_ns();
  storing_ = true;
}

RawResult RawSubscribers::Collect(double drain_s) {
  const std::int64_t end = Monotonic_ns();
  std::this_thread::sleep_for(std::chrono::duration<double>(drain_s));
  const std::scoped_lock lock(mutex_);
  storing_ = false;
  RawResult result;
  struct Seen {
    std::uint64_t last = 0, count = 0;
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, Seen> seen;  // of a subscriber and a performer
  std::map<std::uint32_t, std::pair<std::uint64_t, std::uint64_t>> range;  // of a performer
  for (const Arrival& a : arrivals_) {
    if (a.published_ns > end) continue;
    const auto latency_ms =
        static_cast<float>(1e-6 * static_cast<double>(a.arrived_ns - a.published_ns));
    result.latency_ms.push_back(latency_ms);
    float& worst_ms = result.worst_ms[static_cast<int>((a.arrived_ns - begin_ns_) / 1'000'000'000)];
    worst_ms = std::max(worst_ms, latency_ms);
    Seen& s = seen[{a.subscriber, a.performer}];
    if (a.sequence <= s.last) ++result.doubled;
    s.last = std::max(s.last, a.sequence);
    ++s.count;
    auto& [first, last] = range.try_emplace(a.performer, a.sequence, a.sequence).first->second;
    first = std::min(first, a.sequence);
    last = std::max(last, a.sequence);
  }
  result.delivered = result.latency_ms.size();
  std::uint64_t published = 0;
  for (const auto& [performer, numbers] : range) published += numbers.second - numbers.first + 1;
  result.lost = published * sockets_.size() + result.doubled - result.delivered;
  std::sort(result.latency_ms.begin(), result.latency_ms.end());
  arrivals_.clear();
  return result;
}

}  // namespace styled::support

#include "clients/cpp/reach.h"

#include <fcntl.h>
#include <grp.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <pwd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <sstream>
#include <string_view>
#include <utility>
#include <zmq.hpp>

#include "model/base/descriptor.h"

namespace styled::client {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::string_view kIpc = "ipc://", kTcp = "tcp://";

// Limit of bytes read in a handshake. ZeroMQ's longest has about 600; a peer that sends more is not
// a daemon.
constexpr std::size_t kMaxHeard = 4096;

int Left_ms(Clock::time_point deadline) {
  const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now());
  return static_cast<int>(std::max<std::int64_t>(0, left.count()));
}

// A connection for this file's purposes: bytes, until a deadline.
class Connection {
 public:
  explicit Connection(Clock::time_point deadline) : deadline_(deadline) {}

  // Returns 0 or the errno of connect(); ETIMEDOUT after the deadline.
  int Connect(int family, const sockaddr* address, socklen_t size) {
    fd_ = Descriptor(socket(family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    const int fd = fd_.get();
    if (fd < 0) return errno;
    if (connect(fd, address, size) == 0) return 0;
    if (errno != EINPROGRESS) return errno;
    if (!Wait(POLLOUT)) return ETIMEDOUT;
    int error = 0;
    socklen_t length = sizeof error;
    getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &length);
    return error;
  }

  // Sends a few bytes, for which the send buffer always has room.
  void Send(std::string_view bytes) const {
    (void)send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }

  // False if the peer closes, has sent more than kMaxHeard, or the deadline has passed. The
  // deadline is checked here, since poll() returns without a timeout as long as data is available.
  bool ReadMore() {
    std::array<char, 1024> bytes{};
    if (TooMuch() || Left_ms(deadline_) == 0 || !Wait(POLLIN)) return false;
    const ssize_t size = recv(fd_.get(), bytes.data(), bytes.size(), 0);
    closed_ = size <= 0;
    if (size > 0) read_.append(bytes.data(), static_cast<std::size_t>(size));
    return size > 0;
  }

  const std::string& read() const { return read_; }
  bool TooMuch() const { return read_.size() > kMaxHeard; }
  bool closed() const { return closed_; }
  int fd() const { return fd_.get(); }

 private:
  bool Wait(short event) const {
    pollfd waiting{fd_.get(), event, 0};
    return poll(&waiting, 1, Left_ms(deadline_)) > 0;
  }

  Clock::time_point deadline_;
  Descriptor fd_;
  std::string read_;
  bool closed_ = false;
};

std::string Because(int error) { return std::string(" (") + std::strerror(error) + ")"; }

std::string UserName(uid_t user) {
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> buffer{};
  getpwuid_r(user, &entry, buffer.data(), buffer.size(), &found);
  return found == nullptr ? "user " + std::to_string(user) : std::string(found->pw_name);
}

// The user of this process, as the subject of a sentence.
std::string OurUser() {
  const std::string name = UserName(geteuid());
  return name.starts_with("user ") ? name : "user " + name;
}

std::string GroupName(gid_t id) {
  group entry{};
  group* found = nullptr;
  std::array<char, 4096> buffer{};
  getgrgid_r(id, &entry, buffer.data(), buffer.size(), &found);
  return found == nullptr ? std::to_string(id) : std::string(found->gr_name);
}

std::string ModeText(const struct stat& about) {
  std::array<char, 8> mode{};
  std::snprintf(mode.data(), mode.size(), "%04o", about.st_mode & 07777U);
  return mode.data();
}

Reach Forbidden(const std::string& path, const struct stat& about) {
  return {Obstacle::kForbidden, OurUser() + " may not connect to " + path + ", which belongs to " +
                                    UserName(about.st_uid) + ", mode " + ModeText(about) +
                                    Because(EACCES)};
}

// Finds the first folder of `path` that denies access to this process.
Reach NoEntry(const std::string& path) {
  for (std::size_t slash = path.find('/', 1); slash != std::string::npos;
       slash = path.find('/', slash + 1)) {
    const std::string folder = path.substr(0, slash);
    struct stat about {};
    if (faccessat(AT_FDCWD, folder.c_str(), X_OK, AT_EACCESS) == 0 ||
        stat(folder.c_str(), &about) != 0) {
      continue;
    }
    std::string text = OurUser() + " may not enter " + folder + " (" + ModeText(about);
    // The group's permission helps only a user who may join that group.
    text += (about.st_mode & S_IXGRP) != 0
                ? ", group " + GroupName(about.st_gid) + "): join that group"
                : ", owner " + UserName(about.st_uid) + "): only its owner may";
    return {Obstacle::kNoEntry, text};
  }
  return {Obstacle::kNoEntry, OurUser() + " may not enter the folder of " + path + Because(EACCES)};
}

// Connects to an ipc path, or returns the obstacle.
Reach OpenPath(const std::string& path, Connection& connection) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path || path.front() == '@') {
    return {Obstacle::kNobody, "no program listens there"};
  }
  struct stat about {};
  if (stat(path.c_str(), &about) != 0) {
    if (errno == EACCES) return NoEntry(path);
    return {Obstacle::kNoFile, "there is no " + path + Because(errno)};
  }
  if (!S_ISSOCK(about.st_mode)) return {Obstacle::kNoSocket, path + " is not a socket"};
  std::memcpy(address.sun_path, path.data(), path.size());
  const int error =
      connection.Connect(AF_UNIX, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  if (error == 0) return {};
  if (error == EACCES || error == EPERM) return Forbidden(path, about);
  if (error == ECONNREFUSED) {
    return {Obstacle::kLeftBehind, path + " was left behind by a program that is gone"};
  }
  return {Obstacle::kNobody, "no reply from there" + Because(error)};
}

// Connects to HOST:PORT, or returns the obstacle.
Reach OpenHost(const std::string& host_and_port, Connection& connection) {
  const std::size_t colon = host_and_port.rfind(':');  // CheckEndpoint has verified it
  std::string host = host_and_port.substr(0, colon);
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_family = AF_INET;  // as ZeroMQ does
  if (host.size() > 2 && host.front() == '[') {
    host = host.substr(1, host.size() - 2);
    wanted.ai_family = AF_INET6;
  }
  wanted.ai_socktype = SOCK_STREAM;
  const int failed =
      getaddrinfo(host.c_str(), host_and_port.substr(colon + 1).c_str(), &wanted, &found);
  if (failed != 0) {
    return {Obstacle::kUnknownHost, "no machine is known by the name " + host + " (" +
                                        std::string(gai_strerror(failed)) + ")"};
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owned(found, freeaddrinfo);
  const int error = connection.Connect(found->ai_family, found->ai_addr, found->ai_addrlen);
  if (error == 0) return {};
  if (error == ECONNREFUSED)
    return {Obstacle::kNobody, "no program listens there" + Because(error)};
  return {Obstacle::kUnreachable,
          error == ETIMEDOUT ? host + " does not answer: it is off, or a firewall keeps us out"
                             : host + " cannot be reached" + Because(error)};
}

// The peer's greeting (rfc.zeromq.org/spec/23, ZMTP 3): 10 bytes of signature, the version, and 20
// bytes with the mechanism's name. The peer sends it as soon as it has read our version.
constexpr std::string_view kSignature("\xFF\0\0\0\0\0\0\0\x01\x7F\x03\0", 12);
constexpr char kNotZmtp[] = "the program there does not speak ZeroMQ";
constexpr std::size_t kMechanismAt = 12, kMechanismSize = 20, kGreeting = 64;

// The rest of our greeting, with the mechanism NULL.
std::string RestOfGreeting() {
  std::string rest = "NULL";
  rest.resize(kGreeting - kSignature.size(), '\0');
  return rest;
}

// The socket type in the READY command after a greeting; "" if it is incomplete.
std::string SocketType(std::string_view bytes) {
  constexpr std::string_view kName = "Socket-Type";
  const std::size_t at = bytes.find(kName);
  const std::size_t size_at = at + kName.size() + 3;  // the last of four bytes
  if (at == std::string_view::npos || size_at >= bytes.size()) return "";
  const auto size = static_cast<unsigned char>(bytes[size_at]);
  if (size_at + 1 + size > bytes.size()) return "";
  return std::string(bytes.substr(size_at + 1, size));
}

Reach Open(const std::string& endpoint, Connection& connection) {
  if (endpoint.starts_with(kIpc)) return OpenPath(endpoint.substr(kIpc.size()), connection);
  if (endpoint.starts_with(kTcp)) return OpenHost(endpoint.substr(kTcp.size()), connection);
  return {Obstacle::kNobody, "no reply from there"};
}

// Passes the available bytes of `from` on to `to`. Returns their number, 0 if `from` has closed.
std::size_t Relay(int from, int to) {
  std::array<char, 4096> bytes{};
  const ssize_t size = recv(from, bytes.data(), bytes.size(), 0);
  if (size <= 0) return 0;
  (void)send(to, bytes.data(), static_cast<std::size_t>(size), MSG_NOSIGNAL | MSG_DONTWAIT);
  return static_cast<std::size_t>(size);
}

// A listening port on loopback, for one connection.
class Listener {
 public:
  Listener() : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address_;
    auto* const address = reinterpret_cast<sockaddr*>(&address_);
    if (bind(fd_.get(), address, size) != 0 || listen(fd_.get(), 1) != 0 ||
        getsockname(fd_.get(), address, &size) != 0) {
      throw zmq::error_t();
    }
  }
  std::string endpoint() const {
    return "tcp://127.0.0.1:" + std::to_string(ntohs(address_.sin_port));
  }
  int Accept(Clock::time_point deadline) const {
    pollfd waiting{fd_.get(), POLLIN, 0};
    if (poll(&waiting, 1, Left_ms(deadline)) <= 0) return -1;
    return accept4(fd_.get(), nullptr, nullptr, SOCK_CLOEXEC);
  }

 private:
  Descriptor fd_;
  sockaddr_in address_{};
};

// How far ZeroMQ's own CURVE handshake gets with these keys. libzmq does not report which step
// failed, so its bytes are relayed through this process and observed: a server greets, then replies
// to a HELLO that it can decrypt, and only afterwards learns the client's key.
enum class Shake { kDone, kWelcomed, kRefused, kNothing };
Shake TryKeys(const std::string& endpoint, zmq::socket_type type, const Curve& curve,
              Clock::time_point deadline) {
  zmq::context_t context{1};
  zmq::socket_t socket(context, type);
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::reconnect_ivl, -1);
  socket.set(zmq::sockopt::curve_serverkey, curve.server_key);
  socket.set(zmq::sockopt::curve_publickey, curve.public_key);
  socket.set(zmq::sockopt::curve_secretkey, curve.secret_key);
  constexpr const char* kPlace = "inproc://handshake";
  if (zmq_socket_monitor(socket.handle(), kPlace, ZMQ_EVENT_HANDSHAKE_SUCCEEDED) != 0) {
    throw zmq::error_t();
  }
  zmq::socket_t monitor(context, zmq::socket_type::pair);
  monitor.set(zmq::sockopt::linger, 0);
  monitor.connect(kPlace);
  const Listener listener;
  socket.connect(listener.endpoint());
  const Descriptor near(listener.Accept(deadline));
  Connection far(deadline);
  if (near.get() < 0 || Open(endpoint, far).obstacle != Obstacle::kNone) return Shake::kNothing;
  std::size_t heard = 0;
  bool closed = false;
  std::array<zmq::pollitem_t, 3> items{zmq::pollitem_t{monitor.handle(), 0, ZMQ_POLLIN, 0},
                                       zmq::pollitem_t{nullptr, near.get(), ZMQ_POLLIN, 0},
                                       zmq::pollitem_t{nullptr, far.fd(), ZMQ_POLLIN, 0}};
  while (!closed && Left_ms(deadline) > 0 &&
         zmq::poll(items.data(), items.size(), milliseconds(Left_ms(deadline))) > 0) {
    if (items[0].revents != 0) return Shake::kDone;
    if (items[1].revents != 0) closed = Relay(near.get(), far.fd()) == 0;
    if (items[2].revents == 0) continue;
    const std::size_t size = Relay(far.fd(), near.get());
    closed = closed || size == 0;
    heard += size;
    if (heard > kMaxHeard) return Shake::kNothing;
  }
  // More than a greeting: the server could decrypt our HELLO, so its public key is the given one.
  if (heard > kGreeting) return Shake::kWelcomed;
  return closed ? Shake::kRefused : Shake::kNothing;
}

// The type with its article: "an XPUB socket".
std::string Article(const std::string& type) { return type.starts_with('X') ? "an " : "a "; }

std::string Name(Peer peer) { return peer == Peer::kControl ? "control socket" : "publisher"; }

// Both sides use CURVE.
Reach ExamineKeys(const std::string& endpoint, Peer peer, const Curve& curve,
                  Clock::time_point deadline) {
  const auto own = peer == Peer::kControl ? zmq::socket_type::dealer : zmq::socket_type::sub;
  const auto other = peer == Peer::kControl ? zmq::socket_type::sub : zmq::socket_type::dealer;
  // A daemon may ignore a client that it does not accept, without a reply; so half of the time is
  // kept for the second attempt.
  const auto half = Clock::now() + (deadline - Clock::now()) / 2;
  const Shake shake = TryKeys(endpoint, own, curve, half);
  if (shake == Shake::kDone) return {};
  if (shake == Shake::kNothing) {
    return {Obstacle::kNotZeroMq, "the program there does not continue the handshake"};
  }
  if (shake == Shake::kRefused) {
    return {Obstacle::kWrongKeys, "its key differs from the given server key"};
  }
  if (TryKeys(endpoint, other, curve, deadline) == Shake::kDone) {
    return {Obstacle::kOtherSocket, "this is a socket of the daemon, but not its " + Name(peer)};
  }
  return {Obstacle::kNotLetIn,
          "the server's key is correct, but it does not accept this client's key (" +
              curve.public_key + ")"};
}

// Examines the greeting of the peer on `connection`.
Reach Greet(const std::string& endpoint, Peer peer, const std::optional<Curve>& curve,
            Connection& connection, Clock::time_point deadline) {
  connection.Send(kSignature);
  const std::string& read = connection.read();
  while (read.size() < kGreeting && connection.ReadMore()) {
    if (read.front() != '\xFF') break;
  }
  if (read.empty() && connection.closed() && endpoint.starts_with(kIpc)) {
    return {
        Obstacle::kTurnedAway,
        "it closes the connection at once: ipc_users there may not name " + UserName(geteuid())};
  }
  if (read.size() < kGreeting) {
    return {Obstacle::kNotZeroMq,
            read.empty() && !connection.closed()
                ? "the program there sends nothing: it does not speak ZeroMQ, or hangs"
                : kNotZmtp};
  }
  const std::string_view mechanism(read.data() + kMechanismAt, kMechanismSize);
  const bool asks = mechanism.starts_with("CURVE");
  if (asks && !curve) return {Obstacle::kAsksForKeys, "it requires keys, and none were given"};
  if (!asks && curve) {
    return {Obstacle::kAsksForNone, "it uses no keys, and some were given"};
  }
  if (asks) return ExamineKeys(endpoint, peer, *curve, deadline);
  connection.Send(RestOfGreeting());
  std::string type;
  const auto rest = [&read] { return std::string_view(read).substr(kGreeting); };
  while ((type = SocketType(rest())).empty() && connection.ReadMore()) {
  }
  if (connection.TooMuch()) return {Obstacle::kNotZeroMq, kNotZmtp};
  const bool right = peer == Peer::kControl ? type == "ROUTER" : type == "XPUB" || type == "PUB";
  if (right || type.empty()) return {};
  return {Obstacle::kOtherSocket,
          "this is " + Article(type) + type + " socket of ZeroMQ, not the daemon's " + Name(peer)};
}

}  // namespace

const Reach& Lookout::Look() {
  if (under_way_.valid() && under_way_.wait_for(milliseconds(0)) == std::future_status::ready) {
    found_ = under_way_.get();
  }
  if (!under_way_.valid() && Clock::now() >= next_) {
    next_ = Clock::now() + kAgain;
    under_way_ =
        std::async(std::launch::async, [endpoint = endpoint_, peer = peer_, curve = curve_] {
          return Examine(endpoint, peer, curve);
        });
  }
  return found_;
}

void Lookout::Rest() {
  found_ = {};
  next_ = Clock::now() + kPatience;
}

std::vector<std::string> SplitEndpoints(const std::string& endpoints) {
  std::vector<std::string> list;
  std::istringstream text(endpoints);
  for (std::string one; std::getline(text, one, ',');) list.push_back(one);
  if (list.empty()) list.emplace_back();
  return list;
}

Status CheckEndpoint(const std::string& endpoint) {
  if (!endpoint.starts_with(kTcp)) return Status::Ok();
  const auto wrong = [&endpoint](const std::string& what) {
    return Status::Error("'" + endpoint + "': " + what);
  };
  // ZeroMQ's tcp://OWN_HOST:OWN_PORT;HOST:PORT also contains the local address.
  std::string text = endpoint.substr(kTcp.size());
  text.erase(0, text.rfind(';') + 1);  // npos + 1 is 0
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == text.size()) {
    return wrong("expected tcp://HOST:PORT");
  }
  const std::string port = text.substr(colon + 1);
  int number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (error != std::errc() || end != port.data() + port.size() || number < 1 || number > 65535) {
    return wrong("port " + port + ": expected 1 to 65535");
  }
  return Status::Ok();
}

Reach Examine(const std::string& endpoint, Peer peer, const std::optional<Curve>& curve,
              milliseconds timeout) {
  if (const Status status = CheckEndpoint(endpoint); !status.ok()) {
    return {Obstacle::kBadEndpoint, status.message()};
  }
  const auto deadline = Clock::now() + timeout;
  std::optional<Curve> complete;
  if (curve) {
    auto checked = Complete(*curve);
    if (!checked.ok()) return {Obstacle::kWrongKeys, checked.status().message()};
    complete = std::move(checked.value());
  }
  Connection connection(deadline);
  Reach opened = Open(endpoint, connection);
  if (opened.obstacle != Obstacle::kNone) return opened;
  try {
    return Greet(endpoint, peer, complete, connection, deadline);
  } catch (const zmq::error_t&) {  // out of descriptors, or interrupted by a signal
    return {Obstacle::kNobody, "no reply from there"};
  }
}

}  // namespace styled::client

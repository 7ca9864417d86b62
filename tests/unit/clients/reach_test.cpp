#include "clients/cpp/reach.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>
#include <zmq.hpp>

#include "clients/cpp/control.h"
#include "clients/cpp/key_options.h"
#include "clients/cpp/subscriber.h"
#include "tests/support/temporary_folder.h"

namespace styled::client {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

// Generous: a machine that is busy must not change what is found. Ends early in all cases but one.
constexpr auto kPatience = 5s;

struct Pair {
  std::string public_key, secret_key;
  Pair() {
    std::array<char, 41> open{}, secret{};
    EXPECT_EQ(zmq_curve_keypair(open.data(), secret.data()), 0);
    public_key = open.data();
    secret_key = secret.data();
  }
};

class ReachTest : public testing::Test {
 protected:
  // Binds a socket of ZeroMQ, with CURVE if there are `keys`.
  std::string Bind(zmq::socket_type type, const Pair* keys = nullptr,
                   const std::string& address = "tcp://127.0.0.1:*") {
    socket_ = zmq::socket_t(context_, type);
    socket_.set(zmq::sockopt::linger, 0);
    if (keys != nullptr) {
      socket_.set(zmq::sockopt::curve_server, true);
      socket_.set(zmq::sockopt::curve_secretkey, keys->secret_key);
    }
    socket_.bind(address);
    return socket_.get(zmq::sockopt::last_endpoint);
  }
  static Obstacle At(const std::string& endpoint, const std::optional<Curve>& curve = {},
                     std::chrono::milliseconds patience = kPatience) {
    const Reach reach = Examine(endpoint, Peer::kControl, curve, patience);
    EXPECT_EQ(reach.text.empty(), reach.obstacle == Obstacle::kNone);
    return reach.obstacle;
  }

  support::TemporaryFolder folder_;
  zmq::context_t context_;
  zmq::socket_t socket_;
};

TEST_F(ReachTest, ADaemonThatIsThereIsNoObstacle) {
  EXPECT_EQ(At(Bind(zmq::socket_type::router)), Obstacle::kNone);
  EXPECT_EQ(At(Bind(zmq::socket_type::router, nullptr, "ipc://" + (folder_ / "control"))),
            Obstacle::kNone);
  EXPECT_EQ(Examine(Bind(zmq::socket_type::xpub), Peer::kPublisher, {}, kPatience).obstacle,
            Obstacle::kNone);
}

TEST_F(ReachTest, APortWhereNobodyListens) {
  const std::string endpoint = Bind(zmq::socket_type::router);
  socket_.close();
  for (int i = 0; i < 500 && At(endpoint) == Obstacle::kNone; ++i) {  // it is closed in a while
    std::this_thread::sleep_for(10ms);
  }
  const Reach reach = Examine(endpoint, Peer::kControl, {}, kPatience);
  EXPECT_EQ(reach.obstacle, Obstacle::kNobody);
  EXPECT_EQ(reach.text, "no program listens there (Connection refused)");
}

TEST_F(ReachTest, KeysThatAreMissingNeedlessOrWrong) {
  const Pair server, other;
  const std::string guarded = Bind(zmq::socket_type::router, &server);
  EXPECT_EQ(At(guarded), Obstacle::kAsksForKeys);
  EXPECT_EQ(At(guarded, Curve{server.public_key, "", ""}), Obstacle::kNone);
  EXPECT_EQ(At(guarded, Curve{other.public_key, "", ""}), Obstacle::kWrongKeys);
  EXPECT_EQ(At(Bind(zmq::socket_type::router), Curve{server.public_key, "", ""}),
            Obstacle::kAsksForNone);
}

TEST_F(ReachTest, APortWhereSomethingElseListens) {
  const Reach publisher = Examine(Bind(zmq::socket_type::xpub), Peer::kControl, {}, kPatience);
  EXPECT_EQ(publisher.obstacle, Obstacle::kOtherSocket);
  EXPECT_THAT(publisher.text, HasSubstr("is an XPUB socket of ZeroMQ, not the daemon's control"));
  const Reach reach = Examine(Bind(zmq::socket_type::router), Peer::kPublisher, {}, kPatience);
  EXPECT_EQ(reach.obstacle, Obstacle::kOtherSocket);
  EXPECT_THAT(reach.text, HasSubstr("a ROUTER socket of ZeroMQ, not the daemon's publisher"));
  // A program that waits for its client to speak in its own way.
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(fd, 8), 0);
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  EXPECT_EQ(At("tcp://127.0.0.1:" + std::to_string(ntohs(address.sin_port)), {}, 300ms),
            Obstacle::kNotZeroMq);
  close(fd);
}

// A program at a port that says `first` to each client, and then the same byte without end.
class Flood {
 public:
  explicit Flood(std::string first, char byte)
      : first_(std::move(first)), more_(65536, byte), fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(fd_, 8), 0);
    getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    endpoint_ = "tcp://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::thread([this] { Run(); });
  }
  ~Flood() {
    done_ = true;
    shutdown(fd_, SHUT_RDWR);  // ends accept()
    thread_.join();
    close(fd_);
    for (std::thread& talk : talks_) talk.join();
  }
  const std::string& endpoint() const { return endpoint_; }

 private:
  void Run() {
    while (!done_) {
      const int client = accept(fd_, nullptr, nullptr);
      if (client < 0) return;
      talks_.emplace_back([this, client] { Talk(client); });
    }
  }
  void Talk(int client) {
    // Ends after this long in any case: so a client that reads for ever fails its test.
    const auto end = std::chrono::steady_clock::now() + kLongest;
    const timeval wait{0, 100'000};
    setsockopt(client, SOL_SOCKET, SO_SNDTIMEO, &wait, sizeof wait);
    (void)send(client, first_.data(), first_.size(), MSG_NOSIGNAL);
    while (!done_ && std::chrono::steady_clock::now() < end) {
      if (send(client, more_.data(), more_.size(), MSG_NOSIGNAL) < 0 && errno != EAGAIN) break;
    }
    close(client);
  }

 public:
  static constexpr auto kLongest = 10s;

 private:
  std::string first_, more_, endpoint_;
  int fd_;
  std::atomic<bool> done_ = false;
  std::thread thread_;
  std::vector<std::thread> talks_;
};

std::string Greeting(const std::string& mechanism) {
  std::string greeting("\xFF\0\0\0\0\0\0\0\x01\x7F\x03\0", 12);
  greeting += mechanism;
  greeting.resize(64, '\0');
  return greeting;
}

// They were read for ever, the deadline unasked: there was always more.
TEST_F(ReachTest, WhoNeverStopsTalkingIsNoDaemon) {
  const Pair server;
  const Curve curve{server.public_key, "", ""};
  for (const auto& [first, byte] : std::vector<std::pair<std::string, char>>{
           {"", '\xFF'}, {"", 'x'}, {Greeting("NULL"), '\xFF'}, {Greeting("NULL"), '\0'}}) {
    const Flood flood(first, byte);
    const auto start = std::chrono::steady_clock::now();
    const Reach reach = Examine(flood.endpoint(), Peer::kControl, {}, kPatience);
    EXPECT_LT(std::chrono::steady_clock::now() - start, Flood::kLongest - 1s);
    EXPECT_EQ(reach.obstacle, Obstacle::kNotZeroMq) << reach.text;
    EXPECT_THAT(reach.text, HasSubstr("does not speak ZeroMQ"));
  }
  const Flood flood(Greeting("CURVE"), '\0');
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(At(flood.endpoint(), curve), Obstacle::kNotZeroMq);
  EXPECT_LT(std::chrono::steady_clock::now() - start, Flood::kLongest - 1s);
}

TEST_F(ReachTest, ACallToWhoNeverStopsTalkingEnds) {
  const Flood flood("", '\xFF');
  const auto control = Control::Connect({.endpoint = flood.endpoint(), .timeout = 100ms});
  ASSERT_TRUE(control.ok());
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(control.value()->Panic().obstacle(), Obstacle::kNotZeroMq);
  EXPECT_LT(std::chrono::steady_clock::now() - start, Flood::kLongest - 1s);
}

TEST_F(ReachTest, PathsThatAreMissingNoSocketOrLeftBehind) {
  const std::string path = folder_ / "control", endpoint = "ipc://" + path;
  Reach reach = Examine(endpoint, Peer::kControl, {}, kPatience);
  EXPECT_EQ(reach.obstacle, Obstacle::kNoFile);
  EXPECT_EQ(reach.text, "there is no " + path + " (No such file or directory)");
  std::ofstream(path) << "a file";
  reach = Examine(endpoint, Peer::kControl, {}, kPatience);
  EXPECT_EQ(reach.obstacle, Obstacle::kNoSocket);
  EXPECT_EQ(reach.text, path + " is not a socket");
  unlink(path.c_str());
  const int fd = socket(AF_UNIX, SOCK_STREAM, 0);  // as of a daemon that was killed
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  close(fd);
  EXPECT_EQ(At(endpoint), Obstacle::kLeftBehind);
}

TEST_F(ReachTest, APathWithoutPermissionSaysWhoseItIs) {
  if (geteuid() != 0) GTEST_SKIP() << "skipped, only root can be somebody else";
  ASSERT_EQ(chmod(folder_.path().c_str(), 0755), 0);
  const std::string path = folder_ / "control";
  const std::string endpoint = Bind(zmq::socket_type::router, nullptr, "ipc://" + path);
  ASSERT_EQ(chmod(path.c_str(), 0600), 0);
  ASSERT_EQ(seteuid(65534), 0);
  const Reach reach = Examine(endpoint, Peer::kControl, {}, kPatience);
  ASSERT_EQ(seteuid(0), 0);
  EXPECT_EQ(reach.obstacle, Obstacle::kForbidden);
  EXPECT_THAT(reach.text, HasSubstr("user nobody may not connect to " + path +
                                    ", which belongs to root, mode 0600 (Permission denied)"));
}

// As where the packaged unit's RuntimeDirectoryMode is 0750: the socket's own mode says nothing.
TEST_F(ReachTest, AFolderWithoutPermissionIsToldAsOne) {
  if (geteuid() != 0) GTEST_SKIP() << "skipped, only root can be somebody else";
  const std::string home = folder_ / "run", path = home + "/control";
  ASSERT_EQ(chmod(folder_.path().c_str(), 0755), 0);
  for (const auto& [mode, why] : std::vector<std::pair<mode_t, std::string>>{
           {0750, " (0750, group root): join that group"},
           {0700, " (0700, owner root): only its owner may"}}) {
    std::filesystem::create_directory(home);
    const std::string endpoint = Bind(zmq::socket_type::router, nullptr, "ipc://" + path);
    ASSERT_EQ(chmod(home.c_str(), mode), 0);
    ASSERT_EQ(setegid(65534), 0);
    ASSERT_EQ(seteuid(65534), 0);
    const Reach reach = Examine(endpoint, Peer::kControl, {}, kPatience);
    ASSERT_EQ(seteuid(0), 0);
    ASSERT_EQ(setegid(0), 0);
    EXPECT_EQ(reach.text, "user nobody may not enter " + home + why);
    EXPECT_THAT(Advice(reach.obstacle, Peer::kControl), testing::Not(HasSubstr("ipc_mode")));
  }
}

TEST_F(ReachTest, AnEndpointThatCannotBeIsRefused) {
  for (const auto& [endpoint, why] : std::vector<std::pair<std::string, std::string>>{
           {"tcp://127.0.0.1:99999", "port 99999: expected 1 to 65535"},
           {"tcp://127.0.0.1:7000000000000", "port 7000000000000: expected 1 to 65535"},
           {"tcp://127.0.0.1:22002x", "port 22002x: expected 1 to 65535"},
           {"tcp://127.0.0.1:0", "port 0: expected 1 to 65535"},
           {"tcp://[::1]:-1", "port -1: expected 1 to 65535"},
           {"tcp://127.0.0.1:", "expected tcp://HOST:PORT"},
           {"tcp://:22002", "expected tcp://HOST:PORT"},
           {"tcp://", "expected tcp://HOST:PORT"},
           {"tcp://localhost", "expected tcp://HOST:PORT"}}) {
    const std::string whole = "'" + endpoint + "': " + why;
    EXPECT_EQ(Examine(endpoint, Peer::kControl, {}, 100ms).text, whole);
    const auto control = Control::Connect({.endpoint = endpoint});
    EXPECT_FALSE(control.ok()) << endpoint;
    EXPECT_EQ(control.status().message(), "control: " + whole);
    SubscriberOptions options;
    options.endpoints = {endpoint};
    const auto subscriber = Subscriber::Connect(options);
    EXPECT_FALSE(subscriber.ok()) << endpoint;
    EXPECT_EQ(subscriber.status().message(), "subscriber: " + whole);
  }
  for (const char* good : {"tcp://127.0.0.1:1", "tcp://[::1]:65535", "tcp://a.example:22002",
                           "tcp://127.0.0.1:0;127.0.0.1:22002", "ipc:///a:b", "inproc://a"}) {
    EXPECT_TRUE(CheckEndpoint(good).ok()) << good;
  }
}

TEST_F(ReachTest, TheControlClientSaysWhy) {
  const Pair server;
  const auto control =
      Control::Connect({.endpoint = Bind(zmq::socket_type::router, &server), .timeout = 100ms});
  ASSERT_TRUE(control.ok());
  const CallStatus status = control.value()->Panic();
  EXPECT_EQ(status.kind(), CallStatus::Kind::kNoAnswer);
  EXPECT_EQ(status.obstacle(), Obstacle::kAsksForKeys);
  EXPECT_THAT(status.reason(), HasSubstr("within 100 ms: it requires keys, and none were given"));
}

TEST_F(ReachTest, EveryObstacleHasItsAdvice) {
  EXPECT_THAT(Advice(Obstacle::kAsksForKeys, Peer::kControl), HasSubstr("--server-key"));
  EXPECT_THAT(Advice(Obstacle::kForbidden, Peer::kPublisher), HasSubstr("publish.ipc_mode"));
  EXPECT_THAT(Advice(Obstacle::kWrongKeys, Peer::kControl), HasSubstr("server.pub"));
  EXPECT_THAT(Advice(Obstacle::kNotLetIn, Peer::kControl), HasSubstr("--role operator"));
  EXPECT_THAT(Advice(Obstacle::kNobody, Peer::kControl), HasSubstr("control.address"));
  EXPECT_EQ(Advice(Obstacle::kNone, Peer::kControl), "");
}

TEST_F(ReachTest, TheLookoutFindsOutBesides) {
  Lookout lookout("ipc://" + (folder_ / "none"), Peer::kPublisher, {});
  for (int i = 0; i < 2000 && lookout.Look().obstacle == Obstacle::kNone; ++i) {
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_EQ(lookout.found().obstacle, Obstacle::kNoFile);
  lookout.Rest();
  EXPECT_EQ(lookout.found().obstacle, Obstacle::kNone);
}

}  // namespace
}  // namespace styled::client

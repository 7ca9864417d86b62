#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include "daemon/runtime/sockets.h"
#include "daemon/source/natnet.h"
#include "sim/rigs/natnet.h"
#include "tests/unit/natnet/bytes.h"
#include "tests/unit/natnet/multicast.h"
#include "tests/unit/natnet/performer.h"

namespace styled::source {
namespace {

using natnet::testing::Bytes;
using runtime::BindSocket;
using runtime::BoundAddress;

class HandClock final : public runtime::Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
  std::int64_t now_ns = 1'000'000'000;
};

struct Pipeline final : Receiver {
  void OnFrames(int source, std::span<const SourceFrame> received, bool) override {
    EXPECT_EQ(source, 3);
    for (const SourceFrame& frame : received) (frame.is_body ? bodies : frames) += 1;
  }
  void OnArrival(const Arrival& arrival) noexcept override {
    EXPECT_EQ(arrival.source, 3);
    EXPECT_FALSE(arrival.bytes.empty());
    EXPECT_NE(arrival.peer, nullptr);
    ++arrivals;
  }
  void OnNote(int, const std::string& text) override { notes.push_back(text); }
  int bodies = 0, frames = 0, arrivals = 0;
  std::vector<std::string> notes;
};

config::Source Config() {
  config::Source config;
  config.type = "natnet";
  config.listen = "127.0.0.1:0";
  config.server = "127.0.0.1";
  return config;
}

TEST(NatNetTransport, IsRefusedWithWhatWasExpected) {
  HandClock clock;
  runtime::Counters counters;
  const auto refused = [&](const std::function<void(config::Source&)>& change) {
    config::Source config = Config();
    change(config);
    const auto made = MakeNatNetTransport(config, 0, clock, counters);
    return made.ok() ? "" : made.status().message();
  };
  EXPECT_EQ(refused([](auto&) {}), "");
  for (const char* server : {"", "motive.local", "1.2.3", "127.0.0.1:", "127.0.0.1:0",
                             "127.0.0.1:70000", "[::1]:1510"}) {
    EXPECT_EQ(
        refused([server](auto& config) { config.server = server; }),
        "server: \"" + std::string(server) +
            "\"; expected an IPv4 address, or an address and a port, e.g. \"192.168.1.10:1510\"");
  }
  EXPECT_EQ(refused([](auto& config) { config.group = "10.0.0.1"; }),
            "group: \"10.0.0.1\"; expected an IPv4 multicast address, e.g. \"239.255.42.99\"");
  EXPECT_EQ(refused([](auto& config) { config.interface = "no-such-0"; }),
            "interface: \"no-such-0\"; expected an IPv4 address of this machine or an interface's "
            "name");
  EXPECT_EQ(refused([](auto& config) { config.listen = "[::1]:0"; }),
            "udp [::1]:0: expected an IPv4 address, like the server's");
}

// The simulator's server behind a real socket, and the transport that talks to it.
class Session {
 public:
  explicit Session(const std::vector<std::string>& quirks, const std::string& interface) {
    auto socket = BindSocket(SOCK_DGRAM, "127.0.0.1:0", 1 << 20);
    server_ = std::move(socket.value());
    auto rig = rigs::MakeNatNet({{"Anna"}, 100, 1, quirks});
    if (!rig.ok()) {
      ADD_FAILURE() << rig.status().message();
      return;
    }
    rig_ = std::move(rig.value());
    config::Source config = Config();
    config.server = BoundAddress(server_.get());
    config.interface = interface;
    server = config.server;
    auto made = MakeNatNetTransport(config, 3, clock, counters);
    if (!made.ok()) {
      ADD_FAILURE() << made.status().message();
      return;
    }
    transport = std::move(made.value());
  }

  // Waits until what was sent is there, then does the transport's work; false: nothing came.
  bool Work() {
    pollfd waiting{transport->fd(), POLLIN, 0};
    if (poll(&waiting, 1, 5000) != 1) return false;
    transport->DoWork(pipeline);
    return true;
  }
  // Answers all requests to the server.
  int Answer() {
    int answered = 0;
    Bytes buffer(2000);
    sockaddr_storage client{};
    socklen_t size = sizeof client;
    for (ssize_t got = 0; (got = recvfrom(server_.get(), buffer.data(), buffer.size(), 0,
                                          reinterpret_cast<sockaddr*>(&client), &size)) >= 0;
         ++answered) {
      client_ = client;
      rig_->Receive(std::span(buffer).first(static_cast<std::size_t>(got)),
                    [this](std::span<const std::byte> bytes) { SendToClient(bytes); });
    }
    return answered;
  }
  void SendToClient(std::span<const std::byte> bytes) {
    sendto(server_.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&client_),
           sizeof(sockaddr_in));
  }
  void SendFrame(std::uint64_t index) {
    const std::vector<body::Pose> poses{natnet::testing::BentPose()};
    rig_->Encode({index, static_cast<double>(index) / 100, poses},
                 [this](std::span<const std::byte> bytes) { SendToClient(bytes); });
  }
  // Up to the point from which on frames become poses.
  void Connect() {
    transport->DoWork(pipeline);
    EXPECT_EQ(Answer(), 1);  // CONNECT
    EXPECT_TRUE(Work());
    EXPECT_EQ(Answer(), 1);  // REQUEST MODELDEF
    EXPECT_TRUE(Work());
  }

  HandClock clock;
  runtime::Counters counters;
  Pipeline pipeline;
  std::string server;
  std::unique_ptr<Transport> transport;

 private:
  Descriptor server_;
  sockaddr_storage client_{};
  std::unique_ptr<rigs::Rig> rig_;
};

// stylectl's status prints it as "asking HOST:PORT".
TEST(NatNetTransport, IsKnownByTheServerThatItAsks) {
  HandClock clock;
  runtime::Counters counters;
  const auto made = MakeNatNetTransport(Config(), 0, clock, counters);
  ASSERT_TRUE(made.ok());
  EXPECT_EQ(made.value()->endpoint(), "127.0.0.1:1510") << "the usual port";
  const Session session({}, "");
  EXPECT_EQ(session.transport->endpoint(), session.server);
}

TEST(NatNetTransport, AsksAtOnceAndThenOnceASecond) {
  Session session({}, "");
  EXPECT_LE(session.transport->NextDeadline_ns(), session.clock.now_ns);
  EXPECT_GT(session.transport->DoWork(session.pipeline), 0);
  EXPECT_EQ(session.transport->DoWork(session.pipeline), 0);
  EXPECT_EQ(session.transport->NextDeadline_ns(), session.clock.now_ns + 1'000'000'000);
  session.clock.now_ns += 1'000'000'000;
  EXPECT_GT(session.transport->DoWork(session.pipeline), 0);
  EXPECT_EQ(session.Answer(), 2);
}

TEST(NatNetTransport, TakesFramesThatComeToItsOwnSocketAndKeepsThemComing) {
  Session session({"4.1"}, "");
  session.Connect();
  for (std::uint64_t i = 0; i < 3; ++i) {
    session.SendFrame(i);
    ASSERT_TRUE(session.Work());
  }
  EXPECT_EQ(session.pipeline.frames, 3);
  EXPECT_EQ(session.pipeline.bodies, 1);
  EXPECT_EQ(session.pipeline.arrivals, 5) << "and what it answered";
  session.clock.now_ns += 1'000'000'000;
  session.transport->DoWork(session.pipeline);
  EXPECT_EQ(session.Answer(), 2) << "a keep-alive; the model, since the first frame told";
}

class NatNetGroup : public ::testing::Test {
 protected:
  void SetUp() override {
    static int index = 0;
    group_ = natnet::testing::OwnGroup(++index);
    if (!natnet::testing::CanMulticast(group_)) GTEST_SKIP() << "no multicast on loopback here";
  }
  std::vector<std::string> Quirks() const { return {"multicast=" + group_ + "@127.0.0.1"}; }
  std::string group_;
};

TEST_F(NatNetGroup, ThatTheServerNamesBringsFrames) {
  Session session(Quirks(), "127.0.0.1");
  session.Connect();
  EXPECT_TRUE(session.pipeline.notes.empty()) << session.pipeline.notes.front();
  for (std::uint64_t i = 0; i < 3; ++i) {
    session.SendFrame(i);
    ASSERT_TRUE(session.Work());
  }
  EXPECT_EQ(session.pipeline.frames, 3);
  EXPECT_EQ(static_cast<std::uint64_t>(session.pipeline.arrivals), session.transport->received());
}

TEST_F(NatNetGroup, IsJoinedOnAnInterfaceByName) {
  Session session(Quirks(), "lo");
  session.Connect();
  session.SendFrame(0);
  ASSERT_TRUE(session.Work());
  EXPECT_EQ(session.pipeline.frames, 1);
}

TEST_F(NatNetGroup, ThatCannotBeJoinedIsSaidOnceAndTriedAgain) {
  Session session(Quirks(), "192.0.2.1");  // no machine has it
  session.Connect();
  ASSERT_EQ(session.pipeline.notes.size(), 1U);
  EXPECT_TRUE(session.pipeline.notes[0].starts_with("group " + group_ + ":1511: "))
      << session.pipeline.notes[0];
  EXPECT_LE(session.transport->NextDeadline_ns(), session.clock.now_ns + 5'000'000'000);
  session.clock.now_ns += 5'000'000'000;
  session.transport->DoWork(session.pipeline);
  EXPECT_EQ(session.pipeline.notes.size(), 1U);
}

}  // namespace
}  // namespace styled::source

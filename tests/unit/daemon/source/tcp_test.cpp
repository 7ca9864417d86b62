// The TCP source with real sockets and a clock that is set by hand: who may stay connected.
#include "daemon/source/tcp.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "daemon/source/note_limit.h"
#include "daemon/source/rigs/mvn.h"
#include "proto/rigs/mvn/mvn.h"
#include "tests/support/rig.h"

namespace styled::source {
namespace {

using runtime::Counter;
using runtime::kMillisecond_ns;
using runtime::kSecond_ns;
using support::Bytes;
using support::Rig;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct FakeClock final : runtime::Clock {
  std::int64_t now_ns = 100 * kSecond_ns;
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
};

// A rig's end, or a stranger's.
class Client {
 public:
  explicit Client(const std::string& endpoint) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const auto port = std::stoi(endpoint.substr(endpoint.rfind(':') + 1));
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    EXPECT_EQ(connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~Client() { close(fd_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void Send(std::span<const std::byte> bytes) const {
    EXPECT_EQ(send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  bool Closed() const {
    std::byte byte{};
    const auto size = recv(fd_, &byte, 1, MSG_DONTWAIT);
    return size == 0 || (size < 0 && errno != EAGAIN);
  }

 private:
  int fd_;
};

class TcpTest : public testing::Test, public Receiver {
 protected:
  void Start(int max_connections = 64, const std::string& type = "tcp") {
    config::Source config;
    config.name = "rig";
    config.type = type;
    config.listen = "127.0.0.1:0";
    config.max_connections = max_connections;
    auto made = MakeTcp(config, 0, clock_, counters_, type == "tcp" ? nullptr : MakeMvn(config));
    ASSERT_TRUE(made.ok()) << made.status().message();
    transport_ = std::move(made.value());
  }
  // Until nothing is left to do; loopback delivers at once, except for segments that a busy kernel
  // delays.
  void Work() {
    for (int idle = 0; idle < 2;) {
      pollfd ready{transport_->fd(), POLLIN, 0};
      poll(&ready, 1, idle == 0 ? 2 : 0);
      idle = transport_->DoWork(*this) > 0 ? 0 : idle + 1;
    }
  }
  void Pass(std::int64_t ms) {
    clock_.now_ns += ms * kMillisecond_ns;
    Work();
  }
  const Client& Connect() {
    clients_.push_back(std::make_unique<Client>(transport_->endpoint()));
    Work();
    return *clients_.back();
  }
  std::uint64_t Count(Counter counter) const { return counters_.Get(counter); }
  static Bytes Record(const std::string& performer = "a") { return Rig(performer).Body(); }

  void OnFrames(int, std::span<const SourceFrame> frames, bool) override {
    records_ += frames.size();
  }
  void OnNote(int, const std::string& text) override { notes_.push_back(text); }

  FakeClock clock_;
  runtime::Counters counters_;
  std::unique_ptr<Transport> transport_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::size_t records_ = 0;
  std::vector<std::string> notes_;
};

TEST_F(TcpTest, AConnectionThatBringsNoRecordIsClosedAfterFiveSeconds) {
  Start();
  EXPECT_EQ(transport_->NextDeadline_ns(), std::numeric_limits<std::int64_t>::max());
  const Client& idle = Connect();
  EXPECT_EQ(transport_->NextDeadline_ns(), clock_.now_ns + 5 * kSecond_ns);
  Pass(4999);
  EXPECT_FALSE(idle.Closed());
  Pass(1);
  EXPECT_TRUE(idle.Closed());
  EXPECT_EQ(Count(Counter::kSourceTcpSilent), 1U);
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("no whole record arrived in 5 s")));
  EXPECT_EQ(transport_->NextDeadline_ns(), std::numeric_limits<std::int64_t>::max());
}

TEST_F(TcpTest, HalfARecordAndBytesThatDripDoNotKeepAConnection) {
  Start();
  const Bytes record = Record();
  const Client& half = Connect();
  const Client& dripping = Connect();
  half.Send(std::span(record).first(record.size() / 2));
  for (std::size_t i = 0; i < 10; ++i) {
    dripping.Send(std::span(record).subspan(i, 1));
    Pass(500);
  }
  EXPECT_TRUE(half.Closed());
  EXPECT_TRUE(dripping.Closed());
  EXPECT_EQ(Count(Counter::kSourceTcpSilent), 2U);
  EXPECT_EQ(records_, 0U);
}

TEST_F(TcpTest, ASenderOfARecordMayBeSilentWhileThereIsRoom) {
  Start();
  const Client& rig = Connect();
  rig.Send(Record());
  Work();
  Pass(3'600'000);
  EXPECT_FALSE(rig.Closed());
  rig.Send(Record());
  Work();
  EXPECT_EQ(records_, 2U);
}

TEST_F(TcpTest, TheOldestOfSixtyFourIdleConnectionsIsReplacedByARigAtOnce) {
  Start();
  for (int i = 0; i < 64; ++i) Connect();
  const Client& rig = Connect();
  rig.Send(Record());
  Work();
  EXPECT_EQ(records_, 1U);
  EXPECT_TRUE(clients_[0]->Closed());
  EXPECT_FALSE(clients_[1]->Closed());
  EXPECT_EQ(Count(Counter::kSourceTcpGaveWay), 1U);
  EXPECT_EQ(Count(Counter::kSourceTcpRefused), 0U);
  ASSERT_EQ(notes_.size(), 1U);
  EXPECT_THAT(notes_[0], HasSubstr("all 64 connections (max_connections)"));
  EXPECT_THAT(notes_[0], HasSubstr("never sent a record"));
  // Hundreds more come, and the rig stays.
  for (int i = 0; i < 300; ++i) Connect();
  rig.Send(Record());
  Work();
  EXPECT_EQ(records_, 2U);
  EXPECT_EQ(notes_.size(), 1U) << "once a second";
  clock_.now_ns += kSecond_ns;
  Connect();
  ASSERT_EQ(notes_.size(), 2U);
  EXPECT_THAT(notes_[1], HasSubstr("(301 times)"));
}

TEST_F(TcpTest, TheLongestSilentConnectionIsReplacedAndNoActiveOne) {
  Start(3);
  for (int i = 0; i < 3; ++i) {
    Connect().Send(Record());
    Work();
  }
  for (int ms = 0; ms < 5000; ms += 500) {  // the first two at 2 Hz, the third not at all
    clients_[0]->Send(Record());
    clients_[1]->Send(Record());
    Pass(500);
  }
  EXPECT_TRUE(Connect().Closed()) << "5 s is not beyond 5 s";
  EXPECT_EQ(Count(Counter::kSourceTcpRefused), 1U);
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("are sending")));
  Pass(1);
  const Client& rig = Connect();
  EXPECT_FALSE(rig.Closed());
  EXPECT_TRUE(clients_[2]->Closed());
  rig.Send(Record());
  for (std::size_t i : {0U, 1U}) clients_[i]->Send(Record());
  Work();
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(Connect().Closed());
  EXPECT_FALSE(clients_[0]->Closed());
  EXPECT_FALSE(clients_[1]->Closed());
  EXPECT_FALSE(rig.Closed());
  EXPECT_EQ(Count(Counter::kSourceTcpRefused), 21U);
}

TEST_F(TcpTest, OneConnectionIsEnoughForARigThatLostItsLastOne) {
  Start(1);
  Connect().Send(Record());
  Work();
  Pass(5001);
  const Client& again = Connect();  // the first one's machine is gone, without a word
  again.Send(Record());
  Work();
  EXPECT_EQ(records_, 2U);
}

// More is waiting than one call takes: who is closed by one event may be named by another.
TEST_F(TcpTest, ConnectionsThatEndWithUnreadBytesHaveNoEffect) {
  Start(8);
  for (int i = 0; i < 8; ++i) Connect();
  for (const auto& client : clients_) client->Send(Record());
  for (int i = 0; i < 30; ++i) {
    clients_.push_back(std::make_unique<Client>(transport_->endpoint()));
  }
  Work();
  EXPECT_LE(records_, 8U);
  EXPECT_EQ(Count(Counter::kSourceTcpAccepted) + Count(Counter::kSourceTcpRefused), 38U);
}

TEST_F(TcpTest, WaitingDataOfADelayedDaemonIsReadBeforeAConnectionIsClosed) {
  Start();
  for (int i = 0; i < 40; ++i) Connect();
  for (const auto& client : clients_) client->Send(Record());
  clock_.now_ns += 60 * kSecond_ns;
  Work();
  EXPECT_EQ(records_, 40U);
  EXPECT_EQ(Count(Counter::kSourceTcpSilent), 0U);
}

// Ten connections bring thousands of records at once; the other sources have their turn between.
TEST_F(TcpTest, ACycleReadsABoundedShareOfTheWaitingBytes) {
  Start();
  for (int i = 0; i < 10; ++i) (void)Connect();
  Bytes many;
  Rig rig("a");
  many = rig.Body();
  for (int i = 0; i < 300; ++i) {
    const Bytes frame = rig.Frame();
    many.insert(many.end(), frame.begin(), frame.end());
  }
  for (const auto& client : clients_) client->Send(many);
  std::size_t most = 0;
  for (int cycle = 0; cycle < 1000 && records_ < 10 * 301; ++cycle) {
    const std::size_t before = records_;
    pollfd ready{transport_->fd(), POLLIN, 0};
    poll(&ready, 1, 100);
    (void)transport_->DoWork(*this);
    most = std::max(most, records_ - before);
  }
  EXPECT_EQ(records_, 10U * 301);
  EXPECT_LE(most, 8 * 16384 / 380U);
  EXPECT_GT(most, 32U);
}

TEST_F(TcpTest, MvnsConnectionsMeetTheSameRules) {
  Start(2, "mvn-tcp");
  const Client& idle = Connect();
  const Client& suit = Connect();
  Bytes name(100);
  name.resize(mvn::EncodeName({}, "Anna", name));
  suit.Send(name);
  Work();
  EXPECT_FALSE(Connect().Closed());
  EXPECT_TRUE(idle.Closed());
  EXPECT_FALSE(suit.Closed());
  Pass(5000);
  EXPECT_TRUE(clients_[2]->Closed()) << "said nothing";
  EXPECT_FALSE(suit.Closed());
}

TEST(NoteLimit, ABurstPassesThenOneASecondWithTheNumberOfSkippedOnes) {
  NoteLimit limit(3);
  std::int64_t now_ns = 7 * kSecond_ns;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(limit.Count(now_ns), 1U);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(limit.Count(now_ns), 0U);
  now_ns += kSecond_ns - 1;
  EXPECT_EQ(limit.Count(now_ns), 0U);
  now_ns += 1;
  EXPECT_EQ(limit.Count(now_ns), 12U);
  EXPECT_EQ(limit.Count(now_ns), 0U);
  now_ns += 100 * kSecond_ns;
  EXPECT_EQ(limit.Count(now_ns), 2U);
  EXPECT_EQ(limit.Count(now_ns), 1U);
  EXPECT_EQ(Times(1), "");
  EXPECT_EQ(Times(12), " (12 times)");
}

}  // namespace
}  // namespace styled::source

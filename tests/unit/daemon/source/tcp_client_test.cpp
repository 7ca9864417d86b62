// The transport that connects to a rig's server, with real sockets and a clock that is set by hand.
#include "daemon/source/tcp_client.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "daemon/runtime/sockets.h"

namespace styled::source {
namespace {

using runtime::Counter;
using runtime::kSecond_ns;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct ClientClock final : runtime::Clock {
  std::int64_t now_ns = 100 * kSecond_ns;
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
};

// Records are a byte with the record's size and that many bytes less one; 0 is none. It answers
// every record with "ok", is ready after one, and gives up after "bad".
struct Letters final : ServerTranslator {
  STYLED_REALTIME static rigs::Cut Cut(std::span<const std::byte> received,
                                       std::size_t& size) noexcept {
    if (received.empty()) return rigs::Cut::kNeedMore;
    const auto stated = std::to_integer<std::size_t>(received[0]);
    if (stated == 0) return rigs::Cut::kBroken;
    if (received.size() < stated) return rigs::Cut::kNeedMore;
    size = stated;
    return rigs::Cut::kRecord;
  }
  CutReader::Cutter cutter() const override { return Cut; }
  std::size_t max_record() const override { return 255; }
  std::string WhyBroken(std::span<const std::byte> received) const override {
    return std::to_string(received.size()) + " bytes that are no record";
  }
  void Connected(std::int64_t) override {
    ++connections;
    is_ready = false;
  }
  bool ready() const override { return is_ready; }
  std::string NextFault() override { return std::exchange(fault, {}); }
  void Handle(std::span<const std::byte> record, const Peer& peer, std::int64_t,
              Outbox& out) override {
    const std::string text(reinterpret_cast<const char*>(record.data()) + 1, record.size() - 1);
    taken.push_back(text);
    is_ready = true;
    if (text == "bad") fault = "says bad";
    out.Reply(peer, std::as_bytes(std::span("ok", 2)));
  }
  std::vector<std::string> taken;
  std::string fault;
  int connections = 0;
  bool is_ready = false;
};

struct Notes final : Receiver {
  void OnFrames(int, std::span<const SourceFrame>, bool) override {}
  void OnArrival(const Arrival& arrival) noexcept override {
    arrived.emplace_back(arrival.bytes.begin(), arrival.bytes.end());
  }
  void OnNote(int source, const std::string& text) override {
    EXPECT_EQ(source, 3);
    notes.push_back(text);
  }
  std::vector<std::string> notes;
  std::vector<std::vector<std::byte>> arrived;
};

class TcpClientTest : public testing::Test {
 protected:
  void SetUp() override {
    listener_ = Listening("127.0.0.1:0");
    place_ = runtime::BoundAddress(listener_.get());
    config_.type = "qtm";
    config_.listen = "127.0.0.1:0";
    config_.server = place_;
    auto letters = std::make_unique<Letters>();
    letters_ = letters.get();
    auto made = MakeTcpClient(config_, 3, clock_, counters_, std::move(letters));
    ASSERT_TRUE(made.ok()) << made.status().message();
    client_ = std::move(made.value());
  }
  static Descriptor Listening(const std::string& address) {
    auto bound = runtime::BindSocket(SOCK_STREAM, address, 1 << 16);
    EXPECT_TRUE(bound.ok());
    EXPECT_EQ(listen(bound.value().get(), 8), 0);
    return std::move(bound.value());
  }
  // Works until `done`, for at most 5 s of real time.
  template <typename Done>
  void WorkUntil(const Done& done) {
    for (int i = 0; i < 500 && !done(); ++i) {
      client_->DoWork(pipeline_);
      pollfd waiting{client_->fd(), POLLIN, 0};
      if (!done()) (void)poll(&waiting, 1, 10);
    }
    EXPECT_TRUE(done());
  }
  void Connect() {
    const int before = letters_->connections;
    WorkUntil([&] { return letters_->connections > before; });
    pollfd waiting{listener_.get(), POLLIN, 0};
    ASSERT_EQ(poll(&waiting, 1, 5000), 1);
    server_ = Descriptor(accept(listener_.get(), nullptr, nullptr));
    ASSERT_GE(server_.get(), 0);
  }
  void Serve(const std::string& bytes) {
    ASSERT_EQ(send(server_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  static std::string Record(const std::string& text) {
    return std::string(1, static_cast<char>(text.size() + 1)) + text;
  }
  std::uint64_t Count(Counter counter) const { return counters_.Get(counter); }

  ClientClock clock_;
  runtime::Counters counters_;
  Notes pipeline_;
  config::Source config_;
  Descriptor listener_, server_;
  std::string place_;
  Letters* letters_ = nullptr;
  std::unique_ptr<Transport> client_;
};

TEST_F(TcpClientTest, IsRefusedWithWhatWasExpected) {
  const auto refused = [this](const std::string& server, const std::string& listen) {
    config_.server = server;
    config_.listen = listen;
    const auto made = MakeTcpClient(config_, 3, clock_, counters_, std::make_unique<Letters>());
    return made.ok() ? "" : made.status().message();
  };
  EXPECT_EQ(refused("127.0.0.1", "0.0.0.0:0"), "");
  EXPECT_EQ(refused("qtm.local", "0.0.0.0:0"),
            "server: \"qtm.local\"; expected an IPv4 address, or an address and a port, e.g. "
            "\"192.168.1.10:22223\"");
  EXPECT_EQ(refused("127.0.0.1", "[::1]:0"),
            "tcp [::1]:0: expected an IPv4 address, like the server's");
}

TEST_F(TcpClientTest, TakesRecordsWhereverTheirSegmentsEndAndAnswers) {
  Connect();
  EXPECT_EQ(client_->endpoint(), place_);
  const std::string stream = Record("one") + Record("") + Record("three");
  for (const char c : stream) {
    Serve(std::string(1, c));
    client_->DoWork(pipeline_);
  }
  WorkUntil([&] { return letters_->taken.size() == 3; });
  EXPECT_THAT(letters_->taken, ElementsAre("one", "", "three"));
  EXPECT_EQ(client_->received(), 3U);
  ASSERT_EQ(pipeline_.arrived.size(), 3U) << "whole records";
  EXPECT_EQ(pipeline_.arrived[2].size(), 6U);
  std::array<char, 16> answers{};
  ASSERT_EQ(recv(server_.get(), answers.data(), answers.size(), 0), 6);
  EXPECT_EQ(std::string(answers.data(), 6), "okokok");
  EXPECT_THAT(pipeline_.notes, IsEmpty());
}

TEST_F(TcpClientTest, TheClientReconnectsAfterASecondThenLessOften) {
  listener_ = Descriptor();  // no program listens there
  const auto attempts = [this](double seconds) {
    int made = 0;
    for (int i = 0; i < static_cast<int>(seconds * 10); ++i) {
      clock_.now_ns += kSecond_ns / 10;
      if (clock_.now_ns >= client_->NextDeadline_ns() && client_->DoWork(pipeline_) > 0) ++made;
    }
    return made;
  };
  EXPECT_EQ(client_->DoWork(pipeline_) > 0, true) << "at once";
  EXPECT_EQ(attempts(0.95), 0);
  EXPECT_EQ(attempts(0.2), 1) << "after 1 s";
  EXPECT_EQ(attempts(1.8), 0);
  EXPECT_EQ(attempts(0.2), 1) << "2 s";
  EXPECT_EQ(attempts(4.2), 1) << "4 s";
  EXPECT_EQ(attempts(20.5), 4) << "and every 5 s";
  EXPECT_THAT(pipeline_.notes,
              ElementsAre("server " + place_ + ": Connection refused; trying again every 5 s"))
      << "once";
  listener_ = Listening(place_);
  clock_.now_ns += 5 * kSecond_ns;
  Connect();
  Serve(Record("a"));
  WorkUntil([&] { return letters_->is_ready; });
  client_->DoWork(pipeline_);
  ASSERT_EQ(pipeline_.notes.size(), 2U);
  EXPECT_EQ(pipeline_.notes[1], "server " + place_ + ": connected again");
  EXPECT_EQ(Count(Counter::kSourceTcpAccepted), 1U);
}

TEST_F(TcpClientTest, AReasonToCloseIsLoggedAndTheConnectionIsMadeAgain) {
  Connect();
  Serve(Record("bad"));
  WorkUntil([&] { return !pipeline_.notes.empty(); });
  EXPECT_EQ(pipeline_.notes[0], "server " + place_ + ": says bad; trying again every 5 s");
  clock_.now_ns += kSecond_ns;
  Connect();
  Serve(Record("a"));
  WorkUntil([&] { return letters_->is_ready; });
  Serve(std::string(5, '\0'));
  WorkUntil([&] { return pipeline_.notes.size() == 3; });
  EXPECT_EQ(pipeline_.notes[2],
            "server " + place_ + ": sent 5 bytes that are no record; trying again every 5 s");
  EXPECT_EQ(Count(Counter::kSourceMalformed), 1U);
  EXPECT_EQ(Count(Counter::kSourceTcpBroken), 1U);
  clock_.now_ns += 2 * kSecond_ns;
  Connect();
  Serve("\x09half");
  WorkUntil([&] { return client_->DoWork(pipeline_) == 0; });
  server_ = Descriptor();
  WorkUntil([&] { return Count(Counter::kSourceTcpCutShort) == 1; });
  clock_.now_ns += 5 * kSecond_ns;
  Connect();
  Serve(Record("whole"));
  WorkUntil([&] { return letters_->taken.back() == "whole"; });
  EXPECT_THAT(letters_->taken, ElementsAre("bad", "a", "whole"))
      << "nothing of the half one is left";
}

TEST_F(TcpClientTest, AServerThatComesAndGoesFillsNoLog) {
  for (int i = 0; i < 50; ++i) {
    Connect();
    Serve(Record("a"));
    WorkUntil([&] { return letters_->is_ready; });
    client_->DoWork(pipeline_);
    server_ = Descriptor();
    const std::uint64_t connected = Count(Counter::kSourceTcpAccepted);
    EXPECT_EQ(connected, static_cast<std::uint64_t>(i) + 1);
    WorkUntil([&] { return client_->NextDeadline_ns() != Translator::kNever; });
    clock_.now_ns += kSecond_ns;
  }
  EXPECT_LE(pipeline_.notes.size(), 101U) << "two lines a second at most";
}

}  // namespace
}  // namespace styled::source

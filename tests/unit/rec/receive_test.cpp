#include "clients/rec/receive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "tests/unit/rec/fakes.h"

namespace styled::rec {
namespace {

using ::testing::HasSubstr;
using testing::Listener;

int PortOf(const std::string& endpoint) {
  return std::stoi(endpoint.substr(endpoint.rfind(':') + 1));
}

class ReceiveTest : public ::testing::Test {
 protected:
  void Open(std::vector<Port> ports) {
    auto receiver = Receiver::Open(std::move(ports));
    ASSERT_TRUE(receiver.ok()) << receiver.status().message();
    receiver_ = std::move(receiver.value());
    auto writer = recording::FileWriter::Create(folder_ / "x.styrec", {});
    ASSERT_TRUE(writer.ok());
    writer_ = std::move(writer.value());
    thread_ = std::jthread([this] { status_ = receiver_->Run(*writer_, 0, stop_); });
  }
  std::vector<recording::Record> Close() {
    stop_ = true;
    thread_.join();
    EXPECT_TRUE(status_.ok());
    const auto reader = recording::Reader::Open(folder_ / "x.styrec");
    std::vector<recording::Record> records;
    recording::Record record;
    while (reader.value()->Next(record)) records.push_back(record);
    return records;
  }
  int port(std::size_t index = 0) const { return PortOf(receiver_->endpoints()[index]); }

  testing::TemporaryFolder folder_;
  std::unique_ptr<Receiver> receiver_;
  std::unique_ptr<recording::FileWriter> writer_;
  std::atomic<bool> stop_{false};
  Status status_ = Status::Ok();
  std::jthread thread_;
};

TEST(Receiver, AddressesThatMakeNoSenseAreRefusedByNameOneByOne) {
  const auto error = [](const std::string& listen, const std::string& forward = "") {
    return Receiver::Open({{.listen = listen, .forward = forward}}).status().message();
  };
  EXPECT_THAT(error("7000"), HasSubstr("--listen 7000: no host or no port"));
  EXPECT_THAT(error("127.0.0.1:"), HasSubstr("port ''"));
  EXPECT_THAT(error("127.0.0.1:x"), HasSubstr("port 'x'"));
  EXPECT_THAT(error("127.0.0.1:65536"), HasSubstr("port '65536'"));
  EXPECT_THAT(error("stage.example:7000"), HasSubstr("expected HOST:PORT"));
  EXPECT_THAT(error("192.0.2.1:7000"), HasSubstr("Cannot assign requested address"));
  EXPECT_THAT(error("127.0.0.1:0", "127.0.0.1"), HasSubstr("--forward 127.0.0.1"));
  const Listener taken;
  EXPECT_THAT(error(taken.address()), HasSubstr("Address already in use"));
}

TEST_F(ReceiveTest, EveryDatagramIsRecordedAsItCame) {
  Open({{.name = "suit", .type = "mvn", .listen = "127.0.0.1:0", .forward = ""},
        {.listen = "127.0.0.1:0", .forward = ""}});
  Listener rig, sink;
  const std::vector<std::string> sent{"MXTP02", "", std::string(65507, 'x'),
                                      std::string("\0\xFF", 2)};
  for (const std::string& bytes : sent) rig.Send(port(), bytes);
  rig.Send(port(1), "other");
  for (int i = 0; i < 1000 && receiver_->counts().datagrams < 5; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const auto records = Close();
  ASSERT_EQ(records.size(), 5U);
  std::vector<std::string> found;
  for (const auto& record : records) {
    const auto& arrival = record.arrival();
    EXPECT_EQ(arrival.peer(), rig.address());
    EXPECT_GT(record.time_ns(), 0);
    if (arrival.source() == "suit") {
      EXPECT_EQ(arrival.type(), "mvn");
      EXPECT_EQ(arrival.listen(), receiver_->endpoints()[0]);
      found.push_back(arrival.datagram());
    } else {
      EXPECT_EQ(arrival.source(), "rig");
      EXPECT_EQ(arrival.datagram(), "other");
    }
  }
  EXPECT_EQ(found, sent);
}

TEST_F(ReceiveTest, ForwardingTellsSendersApartAndPassesAnswersBack) {
  Listener daemon, first, second;
  Open({{.listen = "127.0.0.1:0", .forward = daemon.address()}});
  first.Send(port(), "one");
  ASSERT_EQ(daemon.Receive(), "one");
  const int first_port = daemon.from_port;
  second.Send(port(), "two");
  ASSERT_EQ(daemon.Receive(), "two");
  EXPECT_NE(daemon.from_port, first_port);
  daemon.Send(daemon.from_port, "answer two");
  daemon.Send(first_port, "answer one");
  EXPECT_EQ(second.Receive(), "answer two");
  EXPECT_EQ(second.from_port, port()) << "from where the rig sends to";
  EXPECT_EQ(first.Receive(), "answer one");
  first.Send(port(), "three");
  ASSERT_EQ(daemon.Receive(), "three");
  EXPECT_EQ(daemon.from_port, first_port) << "the same socket";
  const auto records = Close();
  EXPECT_EQ(records.size(), 3U) << "answers are not recorded";
  EXPECT_EQ(receiver_->counts().forwarded, 3U);
  EXPECT_EQ(receiver_->counts().answered, 2U);
}

TEST_F(ReceiveTest, ADaemonThatComesLaterGetsWhatIsSentThen) {
  Listener rig;
  int daemon_port = 0;
  {
    const Listener gone;
    daemon_port = gone.port();
  }
  Open({{.listen = "127.0.0.1:0", .forward = "127.0.0.1:" + std::to_string(daemon_port)}});
  for (int i = 0; i < 5; ++i) rig.Send(port(), "lost");
  for (int i = 0; i < 1000 && receiver_->counts().datagrams < 5; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_EQ(Close().size(), 5U) << "recorded all the same";
}

}  // namespace
}  // namespace styled::rec

#include "proto/recording/recording_thread.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <filesystem>

#include "proto/recording/reader.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/recording/samples.h"

namespace styled::recording {
namespace {

class RecordingThreadTest : public ::testing::Test {
 protected:
  std::vector<Record> ReadAll() const {
    std::vector<Record> records;
    const auto reader = Reader::Open(folder_ / "x.styrec");
    EXPECT_TRUE(reader.ok()) << reader.status().message();
    Record record;
    while (reader.ok() && reader.value()->Next(record)) records.push_back(record);
    return records;
  }
  std::unique_ptr<RecordingThread> Start(std::size_t ring_bytes = 1U << 20U) const {
    auto made = RecordingThread::Start(
        folder_ / "x.styrec", testing::MakeHeader(),
        {{"rig", "udp", "udp://0.0.0.0:7000"}, {"suit", "mvn", "udp://0.0.0.0:9763"}},
        {.ring_bytes = ring_bytes, .writer = {}});
    EXPECT_TRUE(made.ok()) << made.status().message();
    return std::move(made.value());
  }

  support::TemporaryFolder temporary_;
  const std::filesystem::path& folder_ = temporary_.path();
};

sockaddr_in V4(const char* address, std::uint16_t port) {
  sockaddr_in v4{};
  v4.sin_family = AF_INET;
  v4.sin_port = htons(port);
  inet_pton(AF_INET, address, &v4.sin_addr);
  return v4;
}

std::span<const std::byte> BytesOf(std::string_view text) { return std::as_bytes(std::span(text)); }

TEST_F(RecordingThreadTest, AFileThatExistsIsRefused) {
  (void)Start();
  EXPECT_FALSE(RecordingThread::Start(folder_ / "x.styrec", {}, {}).ok());
}

TEST_F(RecordingThreadTest, EverythingThatIsPushedIsRecordedInOrder) {
  const sockaddr_in peer = V4("10.0.0.7", 50123);
  Command command;
  command.mutable_request()->set_performer("rig.a");
  command.add_applied()->set_first_sequence(42);
  {
    const auto thread = Start();
    EXPECT_TRUE(thread->PushArrival(1, 1, reinterpret_cast<const sockaddr*>(&peer), sizeof peer,
                                    BytesOf("MXTP")));
    EXPECT_TRUE(thread->PushArrival(2, 0, nullptr, 0, BytesOf("STYD")));
    EXPECT_TRUE(thread->PushPublished(3, "styled/rig.a/rig/", BytesOf("frame")));
    EXPECT_TRUE(thread->PushCommand(4, command));
    EXPECT_TRUE(thread->PushNote(5, "config reloaded"));
    EXPECT_TRUE(thread->PushArrival(6, 9, nullptr, 0, {}));
    EXPECT_TRUE(thread->PushTransfer(7, 0, 3, BytesOf("report")));
  }
  const auto records = ReadAll();
  ASSERT_EQ(records.size(), 7U);
  for (int i = 0; i < 7; ++i) EXPECT_EQ(records[i].time_ns(), i + 1);
  EXPECT_EQ(records[0].arrival().source(), "suit");
  EXPECT_EQ(records[0].arrival().type(), "mvn");
  EXPECT_EQ(records[0].arrival().listen(), "udp://0.0.0.0:9763");
  EXPECT_EQ(records[0].arrival().peer(), "10.0.0.7:50123");
  EXPECT_EQ(records[0].arrival().datagram(), "MXTP");
  EXPECT_EQ(records[1].arrival().source(), "rig");
  EXPECT_EQ(records[1].arrival().peer(), "");
  EXPECT_EQ(records[2].published().topic(), "styled/rig.a/rig/");
  EXPECT_EQ(records[2].published().payload(), "frame");
  EXPECT_EQ(records[3].command().SerializeAsString(), command.SerializeAsString());
  EXPECT_EQ(records[4].note().text(), "config reloaded");
  EXPECT_EQ(records[5].arrival().source(), "") << "a source that nobody named";
  EXPECT_EQ(records[6].arrival().peer(), "device 3");
  EXPECT_EQ(records[6].arrival().datagram(), "report");
}

TEST_F(RecordingThreadTest, WithoutMoreToComeWhatWasPushedIsWrittenSoon) {
  const auto thread = Start();
  ASSERT_TRUE(thread->PushNote(1, "alone"));
  for (int i = 0; i < 1000 && ReadAll().empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(ReadAll().size(), 1U);
  EXPECT_TRUE(thread->error().ok());
}

TEST_F(RecordingThreadTest, AFullRingDropsCountsAndGoesOn) {
  const std::string large(3000, 'x');
  std::uint64_t dropped = 0;
  constexpr int kCount = 2000;
  {
    const auto thread = Start(4096);
    for (int i = 0; i < kCount; ++i) dropped += thread->PushNote(i, large) ? 0 : 1;
    EXPECT_EQ(thread->dropped(), dropped);
    EXPECT_FALSE(thread->PushNote(0, std::string(5000, 'y'))) << "larger than the ring";
  }
  EXPECT_GT(dropped, 0U) << "one at a time fits in";
  EXPECT_EQ(ReadAll().size(), kCount - dropped);
}

TEST_F(RecordingThreadTest, AnOversizedRecordIsCountedAndUsesNoRoom) {
  {
    const auto thread = Start(8U << 20U);
    EXPECT_FALSE(thread->PushNote(1, std::string(kMaxRecordSize, 'x')));
    EXPECT_EQ(thread->dropped(), 1U);
    EXPECT_TRUE(thread->PushNote(2, std::string(kMaxRecordSize - 100, 'x')));
  }
  EXPECT_EQ(ReadAll().size(), 1U);
}

TEST_F(RecordingThreadTest, AddressesAreWrittenAsText) {
  const sockaddr_in v4 = V4("192.168.1.20", 9763);
  EXPECT_EQ(AddressText(reinterpret_cast<const sockaddr*>(&v4), sizeof v4), "192.168.1.20:9763");
  sockaddr_in6 v6{};
  v6.sin6_family = AF_INET6;
  v6.sin6_port = htons(7000);
  inet_pton(AF_INET6, "fe80::1", &v6.sin6_addr);
  EXPECT_EQ(AddressText(reinterpret_cast<const sockaddr*>(&v6), sizeof v6), "[fe80::1]:7000");
  EXPECT_EQ(AddressText(reinterpret_cast<const sockaddr*>(&v6), 8), "") << "cut short";
  EXPECT_EQ(AddressText(nullptr, 0), "");
}

}  // namespace
}  // namespace styled::recording

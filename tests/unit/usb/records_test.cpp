#include "daemon/source/usb/records.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "proto/rigs/native/datagram.h"
#include "tests/support/rig.h"

namespace styled::source::usb {
namespace {

using runtime::Counter;
using support::Bytes;

// The records, whole.
class Collector final : public Receiver {
 public:
  void OnFrames(int, std::span<const SourceFrame> frames, bool) override {
    for (const SourceFrame& frame : frames) sequences.push_back(frame.sequence);
  }
  std::vector<std::uint64_t> sequences;
};

class RecordsTest : public testing::Test {
 protected:
  void Decode(std::span<const std::byte> bytes, std::uint32_t device = 1) {
    records_.Decode({false, device, ++now_ns_, bytes}, out_);
  }
  std::uint64_t Count(Counter counter) const { return counters_.Get(counter); }

  runtime::Counters counters_;
  Records records_{0, counters_};
  Collector out_;
  std::int64_t now_ns_ = 0;
};

TEST_F(RecordsTest, WhatIsNoRecordIsCountedAndTheNextTransferBeginsAnew) {
  support::Rig rig("a");
  Bytes transfer(100, std::byte{0});
  Decode(transfer);
  EXPECT_EQ(Count(Counter::kUsbBadReports), 1U);
  EXPECT_EQ(Count(Counter::kSourceBadMagic), 1U);
  Decode(rig.Frame());
  EXPECT_EQ(out_.sequences, (std::vector<std::uint64_t>{0}));
}

TEST_F(RecordsTest, AVersionOrALengthThatCannotBeIsCountedByItsReason) {
  support::Rig rig("a");
  Bytes version = rig.Frame(), length = rig.Frame();
  version[4] = std::byte{9};
  length[11] = std::byte{0xFF};
  Decode(version);
  Decode(length);
  EXPECT_EQ(Count(Counter::kSourceBadVersion), 1U);
  EXPECT_EQ(Count(Counter::kSourceTooLong), 1U);
  EXPECT_EQ(Count(Counter::kUsbBadReports), 2U);
  EXPECT_EQ(records_.received(), 2U);
}

TEST_F(RecordsTest, RecordsBeforeABrokenOneInTheSameTransferComeOutThoseBehindItDoNot) {
  support::Rig rig("a");
  Bytes transfer = rig.Frame();
  transfer.resize(transfer.size() + 50);
  const Bytes behind = rig.Frame();
  transfer.insert(transfer.end(), behind.begin(), behind.end());
  Decode(transfer);
  Decode(rig.Frame());
  EXPECT_EQ(out_.sequences, (std::vector<std::uint64_t>{0, 2}));
}

TEST_F(RecordsTest, ARecordMayBeCutAnywhere) {
  support::Rig rig("a");
  const Bytes record = rig.Frame();
  for (std::size_t cut = 1; cut < record.size(); ++cut) {
    Decode(std::span(record).first(cut));
    EXPECT_EQ(out_.sequences.size(), cut - 1);
    Decode(std::span(record).subspan(cut));
    ASSERT_EQ(out_.sequences.size(), cut);
  }
  EXPECT_EQ(Count(Counter::kUsbBadReports), 0U);
}

TEST_F(RecordsTest, ATransferMayHoldMoreRecordsThanABatch) {
  support::Rig rig("a");
  Bytes transfer;
  const std::string payload =
      "\x0A\x01"
      "a";  // field 1, the performer's name
  for (int i = 0; i < 300; ++i) {
    const Bytes record = rig.Datagram(native::Kind::kBody, payload);
    transfer.insert(transfer.end(), record.begin(), record.end());
  }
  ASSERT_LE(transfer.size(), Reports::kMaxSize);
  Decode(transfer);
  EXPECT_EQ(out_.sequences.size(), 300U);
  EXPECT_EQ(records_.received(), 300U);
}

TEST_F(RecordsTest, TheLongestRecordCrossesManyTransfers) {
  support::Rig rig("a");
  std::string payload =
      "\x0A\x01"
      "a";  // field 1, the performer's name
  payload.resize(native::kMaxPayloadSize, 'x');
  for (int i = 0; i < 3; ++i) {
    const Bytes record = rig.Datagram(native::Kind::kBody, payload);
    for (std::size_t at = 0; at < record.size(); at += Reports::kMaxSize) {
      Decode(std::span(record).subspan(at, std::min(Reports::kMaxSize, record.size() - at)));
    }
  }
  EXPECT_EQ(out_.sequences, (std::vector<std::uint64_t>{0, 1, 2}));
}

TEST_F(RecordsTest, DevicesDoNotMixAndWhatOneBeganBeforeItWasUnpluggedIsForgotten) {
  support::Rig a("a"), b("b");
  const Bytes first = a.Frame(), second = b.Frame();
  Decode(std::span(first).first(40), 1);
  Decode(second, 2);
  Decode(std::span(first).subspan(40), 1);
  EXPECT_EQ(out_.sequences.size(), 2U);
  Decode(std::span(first).first(40), 1);
  Decode(a.Frame(), 3);  // plugged in again
  EXPECT_EQ(out_.sequences.size(), 3U);
  EXPECT_EQ(Count(Counter::kUsbBadReports), 0U);
}

TEST_F(RecordsTest, OfMoreThan16DevicesTheLongestSilentIsForgotten) {
  support::Rig rig("a");
  const Bytes record = rig.Frame();
  for (std::uint32_t device = 1; device <= 17; ++device) {
    Decode(std::span(record).first(40), device);
  }
  Decode(std::span(record).subspan(40), 2);
  EXPECT_EQ(out_.sequences.size(), 1U) << "2 was kept";
  Decode(std::span(record).subspan(40), 1);
  EXPECT_EQ(out_.sequences.size(), 1U);
  EXPECT_EQ(Count(Counter::kUsbBadReports), 1U) << "1 begins in the middle";
}

}  // namespace
}  // namespace styled::source::usb

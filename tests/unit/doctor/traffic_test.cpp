#include "clients/doctor/traffic.h"

#include <gtest/gtest.h>

namespace styled::doctor {
namespace {

Sniffed Poses() { return {Format::kMvn, Verdict::kPose, "quaternions (02)"}; }
Sniffed Names() { return {Format::kMvn, Verdict::kTalk, "names (12)"}; }
Sniffed Bytes(int i) { return {Format::kUnknown, Verdict::kForeign, "bytes " + std::to_string(i)}; }

Arrival From(const std::string& host, double time_s, std::size_t size = 100) {
  return {false, {"192.0.2.1", 9763}, {host, 50000}, "eth0", time_s, size};
}

TEST(TrafficTest, DatagramsAreCountedByWhatTheyAre) {
  Tally tally;
  for (int i = 0; i < 180; ++i) tally.Add(Poses());
  tally.Add(Names(), 3);
  tally.Add(Bytes(1), 5);
  EXPECT_EQ(tally.Count(), 188U);
  EXPECT_EQ(tally.Count(Format::kMvn), 183U);
  EXPECT_EQ(tally.Count(Format::kMvn, Verdict::kTalk), 3U);
  EXPECT_EQ(tally.MainFormat(), Format::kMvn);
  EXPECT_EQ(tally.Kinds(Format::kMvn), "quaternions (02) 180, names (12) 3");
  EXPECT_EQ(tally.Kinds(Format::kMvn, Verdict::kTalk), "names (12) 3");
  EXPECT_EQ(Tally().MainFormat(), Format::kUnknown);
}

TEST(TrafficTest, ASenderOfManyKindsFillsNoMemory) {
  Tally tally;
  for (int i = 0; i < 10000; ++i) tally.Add(Bytes(i));
  EXPECT_EQ(tally.kinds.size(), Tally::kMaxKinds + 1);
  EXPECT_EQ(tally.Count(), 10000U);
  EXPECT_NE(tally.Kinds(Format::kUnknown).find("others 9988"), std::string::npos);
}

TEST(TrafficTest, FlowsAreToldApartBySenderTargetAndProtocol) {
  Traffic traffic;
  traffic.Add(From("192.0.2.9", 0), Poses());
  traffic.Add(From("192.0.2.9", 0.5, 300), Poses());
  traffic.Add(From("192.0.2.9", 1.0), Poses());
  traffic.Add(From("192.0.2.8", 1.0), Poses());
  Arrival stream = From("192.0.2.9", 1.0);
  stream.stream = true;
  traffic.Add(stream, Poses());
  ASSERT_EQ(traffic.flows().size(), 3U);
  const Flow& first = traffic.flows().front();
  EXPECT_EQ(first.datagrams, 3U);
  EXPECT_EQ(first.bytes, 500U);
  EXPECT_EQ(first.smallest, 100U);
  EXPECT_EQ(first.largest, 300U);
  EXPECT_DOUBLE_EQ(first.rate_hz(), 2.0);
  EXPECT_DOUBLE_EQ(traffic.flows()[1].rate_hz(), 0) << "one datagram has no rate";
}

TEST(TrafficTest, MoreSendersThanThereIsRoomForAreCounted) {
  Traffic traffic;
  for (int i = 0; i < 1000; ++i) traffic.Add(From("host" + std::to_string(i), 0), Poses());
  EXPECT_EQ(traffic.flows().size(), Traffic::kMaxFlows);
  EXPECT_EQ(traffic.left_out(), 1000 - Traffic::kMaxFlows);
}

}  // namespace
}  // namespace styled::doctor

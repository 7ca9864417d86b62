#include "daemon/log/frame_history.h"

#include <gtest/gtest.h>

#include <limits>

#include "proto/styled/v1/frame.pb.h"

namespace styled::log {
namespace {

using decide::FrameInTransit;
using runtime::Counter;

FrameInTransit Published(std::uint64_t sequence) {
  FrameInTransit frame;
  frame.decision.fate = v1::FATE_STYLED;
  frame.decision.sequence = sequence;
  frame.source_sequence = sequence + 10;
  frame.arrival_ns = static_cast<std::int64_t>(sequence) * 1'000'000;
  frame.sent_ns = frame.arrival_ns + 250'000;
  frame.limb_weights = {1, 0.25F, 1, 1, 0.5F};
  frame.limb_errors_m = {0.01F, 0.123F, 0, 0, 0};
  return frame;
}

v1::FrameFate Newest(const FrameHistory& history) {
  v1::FrameFate fate;
  history.Fill(history.size() - 1, fate);
  return fate;
}

TEST(FrameHistoryTest, AnEmptyHistoryHasNoFrames) { EXPECT_EQ(FrameHistory().size(), 0U); }

// A cache line stores some fields; a recording gets the others from the frame itself.
TEST(FrameHistoryTest, AFrameIsKeptAsItIsRecorded) {
  source::SourceFrame given;
  given.is_body = true;
  for (FrameInTransit frame : {Published(7), FrameInTransit()}) {
    frame.given = &given;
    frame.decision.lost = 3;
    frame.decision.lateness_ns = 12'500'000;
    frame.decision.restart = v1::RESTART_RECOUNT;
    frame.decision.relieved = true;
    frame.decision.reason = Counter::kPipelineReordered;
    frame.flags = v1::FLAG_LATE | v1::FLAG_HELD;
    frame.failure = v1::FAILURE_RIG;
    frame.held_joints = 2;
    FrameHistory history;
    history.Add(frame);
    v1::FrameFate kept = Newest(history), recorded;
    FillFate(frame, recorded);
    ASSERT_EQ(kept.limb_errors_m_size(), recorded.limb_errors_m_size());
    for (int limb = 0; limb < kept.limb_errors_m_size(); ++limb) {
      EXPECT_NEAR(kept.limb_errors_m(limb), recorded.limb_errors_m(limb), 0.0005F);
      EXPECT_NEAR(kept.limb_weights(limb), recorded.limb_weights(limb), 0.005F);
    }
    kept.clear_limb_errors_m();
    recorded.clear_limb_errors_m();
    kept.clear_limb_weights();
    recorded.clear_limb_weights();
    EXPECT_EQ(kept.SerializeAsString(), recorded.SerializeAsString());
  }
}

TEST(FrameHistoryTest, TheOldestFramesGiveWay) {
  FrameHistory history;
  for (std::uint64_t i = 1; i <= FrameHistory::kKept + 5; ++i) history.Add(Published(i));
  ASSERT_EQ(history.size(), FrameHistory::kKept);
  EXPECT_EQ(history.SequenceOf(0), 6U);
  EXPECT_EQ(Newest(history).sequence(), FrameHistory::kKept + 5);
}

TEST(FrameHistoryTest, OfABundleTheLastMessageCounts) {
  FrameHistory history;
  history.Add(Published(1));
  history.Add(Published(2));
  EXPECT_FLOAT_EQ(Newest(history).latency_ms(), 0.25F);
  history.NoteSent(1, 3'000'000);
  v1::FrameFate first;
  history.Fill(0, first);
  EXPECT_FLOAT_EQ(first.latency_ms(), 3);
  EXPECT_FLOAT_EQ(Newest(history).latency_ms(), 0.25F);
}

TEST(FrameHistoryTest, NumbersOutOfRangeAreTheLargestThatFit) {
  FrameInTransit frame = Published(1);
  frame.decision.lost = std::numeric_limits<std::uint64_t>::max();
  frame.decision.lateness_ns = std::numeric_limits<std::int64_t>::max();
  frame.limb_errors_m[0] = std::numeric_limits<float>::infinity();
  frame.limb_errors_m[1] = std::numeric_limits<float>::quiet_NaN();
  frame.held_joints = 1000;
  FrameHistory history;
  history.Add(frame);
  const v1::FrameFate fate = Newest(history);
  EXPECT_EQ(fate.lost(), 65535U);
  EXPECT_GT(fate.lateness_ms(), 2e6F);
  EXPECT_FLOAT_EQ(fate.limb_errors_m(0), 65.535F);
  EXPECT_EQ(fate.limb_errors_m(1), 0);
  EXPECT_EQ(fate.held_joints(), 255U);
}

TEST(FrameHistoryTest, OfARefusedFrameThereAreNoLimbs) {
  FrameInTransit frame;
  frame.decision.reason = Counter::kPipelineDuplicate;
  FrameHistory history;
  history.Add(frame);
  EXPECT_EQ(Newest(history).reason(), "pipeline.duplicate");
  EXPECT_EQ(Newest(history).limb_weights_size(), 0);
  EXPECT_EQ(Newest(history).sequence(), 0U);
}

}  // namespace
}  // namespace styled::log

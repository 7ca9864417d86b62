#include "daemon/decide/decider.h"

#include <gtest/gtest.h>

#include "daemon/runtime/clock.h"

namespace styled::decide {
namespace {

using runtime::Counter;
using runtime::kMillisecond_ns;

constexpr std::int64_t kPeriod_ns = 8 * kMillisecond_ns;
constexpr std::int64_t kStart_ns = 1'000'000 * kMillisecond_ns;

// A sender whose frames have numbers and times that follow each other, on a machine that reads each
// as it comes.
class DeciderTest : public testing::Test {
 protected:
  // The next frame, read and decided `late_ns` after it was due.
  Decision Next(std::int64_t late_ns = 0) {
    ++frame_.sequence;
    frame_.source_time_ns += kPeriod_ns;
    return Decide(late_ns);
  }
  Decision Decide(std::int64_t late_ns = 0) {
    const std::int64_t now_ns =
        kStart_ns + static_cast<std::int64_t>(frame_.source_time_ns - kFirst_ns) + late_ns;
    return decider_.OfFrame(admission_, Ask(now_ns));
  }
  Question Ask(std::int64_t now_ns) const {
    return {.frame = frame_,
            .has_body = has_body_,
            .body_crc = 7,
            .receive_ns = now_ns,
            .now_ns = now_ns,
            .newest = newest_,
            .more_waiting = more_waiting_,
            .keep_all = keep_all_,
            .last_send_ns = last_send_ns_};
  }
  // The session's body, and a first frame on time.
  void Begin() {
    source::SourceFrame body = frame_;
    body.is_body = true;
    body.sequence = 1;
    EXPECT_EQ(decider_.OfBody(admission_, body, kStart_ns).reason, Decision::kNoReason);
    admission_.session_has_body = true;
    frame_.sequence = 1;
    EXPECT_EQ(Next().fate, v1::FATE_STYLED);
  }

  static constexpr std::uint64_t kFirst_ns = 50'000 * kMillisecond_ns;
  Decider decider_{
      Limits{.rules = {}, .late_ns = 20 * kMillisecond_ns, .backlog_ns = 100 * kMillisecond_ns}};
  Admission admission_;
  source::SourceFrame frame_ = [] {
    source::SourceFrame frame;
    frame.session = 3;
    frame.source_time_ns = kFirst_ns;
    return frame;
  }();
  bool has_body_ = true, newest_ = true, more_waiting_ = false, keep_all_ = false;
  std::int64_t last_send_ns_ = 0;
};

TEST_F(DeciderTest, FramesBeforeTheirBodyAreRefused) {
  has_body_ = false;
  EXPECT_EQ(Next().reason, Counter::kPipelineBeforeBody);
  has_body_ = true;  // the last session's: this one must have sent its own, or name it
  EXPECT_EQ(Next().reason, Counter::kPipelineBeforeBody);
  frame_.body_crc = 7;
  EXPECT_EQ(Next().fate, v1::FATE_STYLED);
}

TEST_F(DeciderTest, FramesOfAnotherBodyAreRefused) {
  Begin();
  frame_.body_crc = 8;
  EXPECT_EQ(Next().reason, Counter::kPipelineWrongBody);
}

TEST_F(DeciderTest, DuplicatesAndOldFramesAreRefusedWithTheirReason) {
  Begin();
  EXPECT_EQ(Next().fate, v1::FATE_STYLED);
  EXPECT_EQ(Decide().reason, Counter::kPipelineDuplicate);
  EXPECT_EQ(Decide().fate, v1::FATE_REFUSED);
  frame_.sequence += 2;
  EXPECT_EQ(Decide().reason, Counter::kPipelineOldTime) << "a new number at an old time";
  --frame_.sequence;
  EXPECT_EQ(Decide().reason, Counter::kPipelineReordered);
  frame_.sequence += 100'000;
  EXPECT_EQ(Decide().reason, Counter::kPipelineFarAhead);
}

TEST_F(DeciderTest, SkippedNumbersAreReportedOnce) {
  Begin();
  frame_.sequence += 3;
  frame_.source_time_ns += 3 * kPeriod_ns;
  EXPECT_EQ(Next().lost, 3U);
  EXPECT_EQ(Next().lost, 0U);
}

TEST_F(DeciderTest, ASecondSenderIsRefusedUntilTheFirstIsSilent) {
  Begin();
  frame_.machine[0] = 9;
  EXPECT_EQ(Next().reason, Counter::kPipelineSecondSender);
  frame_.source_time_ns += 500 * kMillisecond_ns;
  const Decision decision = Next();
  EXPECT_EQ(decision.restart, v1::RESTART_SESSION);
  EXPECT_EQ(decision.reason, Counter::kPipelineBeforeBody) << "the new session has sent no body";
}

TEST_F(DeciderTest, AJumpOfTheSendersClockBeginsASessionWithTheSameBody) {
  Begin();
  frame_.source_time_ns += std::uint64_t{7200} * 1000 * kMillisecond_ns;
  ++frame_.sequence;
  const Decision decision = decider_.OfFrame(admission_, Ask(kStart_ns + 2 * kPeriod_ns));
  EXPECT_EQ(decision.restart, v1::RESTART_CLOCK_JUMP);
  EXPECT_EQ(decision.fate, v1::FATE_STYLED);
}

TEST_F(DeciderTest, LateFramesAreFlaggedAndPublished) {
  Begin();
  for (int i = 0; i < 50; ++i) EXPECT_FALSE(Next().late);
  const Decision decision = Next(30 * kMillisecond_ns);
  EXPECT_TRUE(decision.late);
  EXPECT_EQ(decision.fate, v1::FATE_STYLED);
  EXPECT_NEAR(static_cast<double>(decision.lateness_ns), 30e6, 1e5);
}

TEST_F(DeciderTest, OfABacklogOnlyTheNewestFrameIsPublished) {
  Begin();
  for (int i = 0; i < 50; ++i) (void)Next();
  newest_ = false;
  Decision decision = Next(150 * kMillisecond_ns);
  EXPECT_EQ(decision.fate, v1::FATE_PASSED_OVER);
  EXPECT_EQ(decision.reason, Counter::kPipelineBacklogDropped);
  keep_all_ = true;
  EXPECT_EQ(Next(150 * kMillisecond_ns).fate, v1::FATE_STYLED) << "as where a standby takes over";
  keep_all_ = false;
  newest_ = true;
  EXPECT_EQ(Next(150 * kMillisecond_ns).fate, v1::FATE_STYLED);
}

TEST_F(DeciderTest, WhereNewerFramesWaitOneAPeriodOfTheBacklogIsPublished) {
  Begin();
  for (int i = 0; i < 50; ++i) (void)Next();
  more_waiting_ = true;
  last_send_ns_ = kStart_ns + 52 * kPeriod_ns + 100 * kMillisecond_ns;
  EXPECT_EQ(Next(150 * kMillisecond_ns).fate, v1::FATE_PASSED_OVER);
  last_send_ns_ = 0;
  EXPECT_EQ(Next(150 * kMillisecond_ns).fate, v1::FATE_STYLED);
}

TEST_F(DeciderTest, AStandbyDecidesAsItsLeaderDid) {
  Begin();
  Decision leaders{.fate = v1::FATE_PASSED_OVER};
  ++frame_.sequence;
  frame_.source_time_ns += kPeriod_ns;
  const auto follow = [&] {
    return decider_.OfFrame(admission_, Ask(kStart_ns + kPeriod_ns), leaders);
  };
  EXPECT_EQ(follow().fate, v1::FATE_PASSED_OVER);
  ++frame_.sequence;
  frame_.source_time_ns += kPeriod_ns;
  leaders = {.fate = v1::FATE_STYLED, .late = true, .relieved = true, .sequence = 42};
  const Decision decision = follow();
  EXPECT_EQ(decision.fate, v1::FATE_STYLED);
  EXPECT_TRUE(decision.late);
  EXPECT_TRUE(decision.relieved);
  EXPECT_EQ(decision.sequence, 42U);
  EXPECT_EQ(follow().reason, Counter::kPipelineDuplicate) << "whatever the leader made of it";
}

TEST_F(DeciderTest, ASessionsFirstBodyCountsEvenIfFramesOvertookIt) {
  frame_.body_crc = 7;
  frame_.sequence = 5;
  EXPECT_EQ(Next().fate, v1::FATE_STYLED);
  source::SourceFrame body = frame_;
  body.is_body = true;
  body.sequence = 4;
  EXPECT_EQ(decider_.OfBody(admission_, body, kStart_ns).reason, Decision::kNoReason);
  admission_.session_has_body = true;
  body.sequence = 3;
  EXPECT_EQ(decider_.OfBody(admission_, body, kStart_ns).reason, Counter::kPipelineReordered);
}

}  // namespace
}  // namespace styled::decide

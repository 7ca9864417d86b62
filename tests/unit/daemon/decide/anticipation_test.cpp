#include "daemon/decide/anticipation.h"

#include <gtest/gtest.h>

#include "daemon/runtime/schedule.h"

namespace styled::decide {
namespace {

constexpr std::int64_t kDue_ns = 50'000'000;
constexpr std::int64_t kLead_ns = Anticipation::kLead_ns;
constexpr std::int64_t kPatience_ns = Anticipation::kPatience_ns;

TEST(Anticipation, NeitherPreparesNorExpectsBeforeAFrameIsAwaited) {
  Anticipation anticipation;
  EXPECT_EQ(anticipation.prepare_ns(), Anticipation::kNever);
  EXPECT_FALSE(anticipation.Prepare(kDue_ns));
  EXPECT_FALSE(anticipation.Expects(kDue_ns));
  anticipation.Await(Anticipation::kNever);
  EXPECT_EQ(anticipation.prepare_ns(), Anticipation::kNever);
  EXPECT_FALSE(anticipation.Expects(kDue_ns));
}

TEST(Anticipation, PreparesOnceAndExpectsUntilTheFrameIsOverdue) {
  Anticipation anticipation;
  anticipation.Await(kDue_ns);
  EXPECT_EQ(anticipation.prepare_ns(), kDue_ns - kLead_ns);
  EXPECT_FALSE(anticipation.Prepare(kDue_ns - kLead_ns - 1));
  EXPECT_FALSE(anticipation.Expects(kDue_ns - kLead_ns - 1));
  EXPECT_TRUE(anticipation.Prepare(kDue_ns - kLead_ns));
  EXPECT_FALSE(anticipation.Prepare(kDue_ns - kLead_ns)) << "twice";
  EXPECT_EQ(anticipation.prepare_ns(), Anticipation::kNever);
  EXPECT_TRUE(anticipation.Expects(kDue_ns + kPatience_ns - 1));
  EXPECT_FALSE(anticipation.Expects(kDue_ns + kPatience_ns));
}

TEST(Anticipation, DoesNotPrepareForAFrameThatIsOverdue) {
  Anticipation anticipation;
  anticipation.Await(kDue_ns);
  EXPECT_FALSE(anticipation.Prepare(kDue_ns + kPatience_ns));
  EXPECT_EQ(anticipation.prepare_ns(), Anticipation::kNever);
  EXPECT_FALSE(anticipation.Expects(kDue_ns + kPatience_ns));
}

TEST(Anticipation, PreparationRestartsWithEachFrame) {
  Anticipation anticipation;
  anticipation.Await(kDue_ns);
  EXPECT_TRUE(anticipation.Prepare(kDue_ns));
  anticipation.Await(2 * kDue_ns);
  EXPECT_FALSE(anticipation.Expects(kDue_ns));
  EXPECT_EQ(anticipation.prepare_ns(), 2 * kDue_ns - kLead_ns);
}

TEST(Schedule, AFramesDueTimeFollowsTheShortestDelay) {
  runtime::Schedule schedule;
  EXPECT_EQ(schedule.Lateness_ns(0, 1'000'300), 0);
  EXPECT_EQ(schedule.Due_ns(10), 1'000'310);
  EXPECT_EQ(schedule.Lateness_ns(10, 1'000'110), 0);  // this one came faster
  EXPECT_EQ(schedule.Due_ns(20), 1'000'120);
  EXPECT_EQ(schedule.Lateness_ns(20, 1'000'520), 400);
  EXPECT_EQ(schedule.Due_ns(30), 1'000'130) << "late ones do not count";
}

}  // namespace
}  // namespace styled::decide

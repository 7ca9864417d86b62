#include "model/train/measure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace styled::train {
namespace {

using std::chrono::milliseconds;

TEST(MeasureTest, ThePaceIsThatAfterTheFirstIterationsAndSaidOnce) {
  PaceMeter meter;
  PaceMeter::Clock::time_point now{};
  int said = 0;
  for (int i = 1; i <= 100; ++i) {
    now += milliseconds(i <= PaceMeter::kSkipped ? 5000 : 100);
    said += meter.AfterIteration(now) ? 1 : 0;
    EXPECT_EQ(said > 0, i >= PaceMeter::kSkipped + 30) << i << ": 3 s of 0.1 s each";
  }
  EXPECT_EQ(said, 1);
  EXPECT_NEAR(meter.per_minute(), 600, 1e-6);
}

TEST(MeasureTest, SlowIterationsAreAtLeastTen) {
  PaceMeter meter;
  PaceMeter::Clock::time_point now{};
  int count = 0;
  do {
    now += milliseconds(6000);
    ++count;
  } while (!meter.AfterIteration(now));
  EXPECT_EQ(count, PaceMeter::kSkipped + PaceMeter::kFewest);
  EXPECT_NEAR(meter.per_minute(), 10, 1e-6);
}

TEST(MeasureTest, ThePaceIsSaidForTheLengthThatIsGiven) {
  RunConfig run;
  run.minutes = 20;
  EXPECT_EQ(PaceText(run, false, 1020.4, 412),
            "1020 iterations a minute, 412 MB of memory; 20 minutes are some 20408 iterations");
  run.minutes = 0;
  run.iterations = 510;
  run.validate_minutes = 5;
  EXPECT_EQ(
      PaceText(run, true, 1020, 412),
      "1020 iterations a minute, 412 MB of memory; 510 iterations take some 0.5 minutes; the "
      "first validation is after 5 minutes; before the run judges are trained, once for these "
      "clips, with their own time");
}

TEST(MeasureTest, TheProcessHasSomeMemory) { EXPECT_GT(PeakMemory_mb(), 1); }

}  // namespace
}  // namespace styled::train

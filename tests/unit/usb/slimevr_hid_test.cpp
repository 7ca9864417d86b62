#include "daemon/source/rigs/slimevr_hid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <initializer_list>

#include "daemon/source/rigs/make.h"
#include "model/body/humanoid.h"
#include "tests/support/translated.h"
#include "tests/support/translation.h"

namespace styled::source {
namespace {

using runtime::Counter;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int64_t kMs = 1'000'000;

config::Source Config() {
  config::Source config;
  config.name = "dongle";
  config.type = "slimevr-usb";
  config.trackers = {{"010203040506", "hips"}, {"010203040507", "head"}};
  return config;
}

// A record of 16 bytes as the receiver's firmware lays it out, by hand.
using Record = std::array<std::uint8_t, 16>;
Record Registers(std::uint8_t number, std::uint8_t last_of_address) {
  return {255, number, last_of_address, 0x05, 0x04, 0x03, 0x02, 0x01};
}
// Orientation x, y, z, w in Q15: a quarter turn about x, worn upright and looking ahead.
Record Upright(std::uint8_t number) { return {1, number, 0x82, 0x5A, 0, 0, 0, 0, 0x82, 0x5A}; }
constexpr Record kUnknown{0x55, 1};

std::vector<std::byte> Report(std::initializer_list<Record> records) {
  std::vector<std::byte> bytes;
  for (const Record& record : records) {
    const auto part = std::as_bytes(std::span(record));
    bytes.insert(bytes.end(), part.begin(), part.end());
  }
  return bytes;
}

class SlimeVrHidTest : public testing::Test {
 protected:
  // Both trackers' records for this long, a report every 5 ms.
  void Wear(std::int64_t for_ns) {
    for (std::int64_t t = 0; t < for_ns; t += 5 * kMs) {
      out.now_ns += 5 * kMs;
      out.Handle(Report({Upright(0), Upright(1), Registers(0, 0x06), Registers(1, 0x07)}));
    }
  }

  support::Translated out{MakeSlimeVrHid(Config())};
};

TEST_F(SlimeVrHidTest, AReportThatIsNoneIsCountedAsBad) {
  const auto good = Report({Registers(0, 0x06), Registers(1, 0x07), Upright(0), Upright(1)});
  std::uint64_t bad = 0;
  for (const std::size_t size : {0, 1, 15, 17, 63}) {
    out.Handle(std::span(good).first(size));
    EXPECT_EQ(out.Count(Counter::kUsbBadReports), ++bad) << size;
  }
  auto long_one = good;
  long_one.resize(80);
  out.Handle(long_one);
  EXPECT_EQ(out.Count(Counter::kUsbBadReports), ++bad);
  out.Handle(Report({kUnknown, kUnknown, kUnknown, kUnknown}));
  EXPECT_EQ(out.Count(Counter::kUsbBadReports), ++bad);
  EXPECT_THAT(out.notes, IsEmpty()) << "none of them was read";
}

TEST_F(SlimeVrHidTest, ARecordOfAnUnknownTypeIsPassedOverAndTheRestIsRead) {
  out.Handle(Report({kUnknown, Registers(0, 0x06)}));
  EXPECT_EQ(out.Count(Counter::kUsbBadReports), 0U);
  EXPECT_EQ(out.Count(Counter::kSourceIgnored), 1U);
  ASSERT_FALSE(out.notes.empty());
  EXPECT_THAT(out.notes[0], HasSubstr("010203040506/0 is worn on hips"));
}

TEST_F(SlimeVrHidTest, AnOrientationBeforeItsTrackerIsRegisteredIsIgnored) {
  out.Handle(Report({Upright(0)}));
  EXPECT_EQ(out.Count(Counter::kSourceIgnored), 1U);
  EXPECT_FALSE(out.translator().Calibrate(Calibration::kFull, out.now_ns).ok());
  out.Handle(Report({Registers(0, 0x06), Upright(0)}));
  EXPECT_EQ(out.Count(Counter::kSourceIgnored), 1U);
  EXPECT_TRUE(out.translator().Calibrate(Calibration::kFull, out.now_ns).ok());
}

TEST_F(SlimeVrHidTest, ATrackerThatNobodyAssignedIsToldOnceAndIgnored) {
  for (int i = 0; i < 3; ++i) out.Handle(Report({Registers(0, 0x99), Upright(0)}));
  EXPECT_THAT(out.notes, ElementsAre(HasSubstr("010203040599/0 is assigned to no joint")));
  EXPECT_EQ(out.Count(Counter::kSourceIgnored), 3U);
}

TEST_F(SlimeVrHidTest, ANumberBelongsToWhomItWasRegisteredLastAtThatReceiverAlone) {
  out.Handle(Report({Registers(0, 0x06), Upright(0)}), 1);
  out.Handle(Report({Upright(0)}), 2);
  EXPECT_EQ(out.Count(Counter::kSourceIgnored), 1U) << "another receiver's number 0";
  out.Handle(Report({Registers(0, 0x99), Upright(0)}), 1);
  EXPECT_EQ(out.Count(Counter::kSourceIgnored), 2U) << "another tracker has the number now";
}

TEST_F(SlimeVrHidTest, AfterAFullResetPosesComeAtTheRateOfTheSource) {
  Wear(100 * kMs);
  out.items.clear();
  ASSERT_TRUE(out.translator().Calibrate(Calibration::kFull, out.now_ns).ok());
  Wear(1000 * kMs);
  const auto frames = out.Frames();
  EXPECT_NEAR(static_cast<double>(frames.size()), 100, 2);
  ASSERT_FALSE(frames.empty());
  EXPECT_EQ(frames[0].performer(), "dongle");
  ASSERT_FALSE(out.Bodies().empty());
  EXPECT_EQ(out.Bodies()[0].names_size(), body::kJointCount);
  for (int j = 0; j < body::kJointCount; ++j) {
    EXPECT_NEAR(std::abs(frames.back().rotations(4 * j + 3)), 1, 1e-3) << "he stands in a T-pose";
  }
}

TEST_F(SlimeVrHidTest, AsksForNoMemoryOnceTheFirstPosesWereSent) {
  Wear(100 * kMs);
  ASSERT_TRUE(out.translator().Calibrate(Calibration::kFull, out.now_ns).ok());
  Wear(100 * kMs);
  ASSERT_FALSE(out.Frames().empty());
  const auto report = Report({Upright(0), Upright(1), Registers(0, 0x06), Registers(1, 0x07)});
  int calls = 0;
  for (int i = 0; i < 100; ++i) {
    out.now_ns += 10 * kMs;
    calls += support::Allocations(out.translator(), report, out.now_ns);
  }
  EXPECT_EQ(calls, 0);
}

TEST_F(SlimeVrHidTest, IsMadeForItsTypeAndHasSensors) {
  const auto made = MakeTranslator(Config());
  ASSERT_NE(made, nullptr);
  EXPECT_TRUE(made->has_sensors());
}

}  // namespace
}  // namespace styled::source

// What a standby keeps of its rigs' data, and where a performer's own frames continue behind the
// leader's last one.
#include "daemon/standby/input_buffer.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace styled::standby {
namespace {

constexpr std::int64_t kMilli = 1'000'000;
const std::vector<std::string> kSources{"suit", "stage"};

class InputBufferTest : public testing::Test {
 protected:
  // A frame whose pose is `pose` in every number.
  void Add(std::int64_t now_ns, std::uint64_t session, std::uint64_t sequence, float pose,
           int source = 0, const std::string& performer = "a") {
    source::SourceFrame frame = Frame(pose);
    frame.performer = performer;
    frame.session = session;
    frame.sequence = sequence;
    held.Add(source, {&frame, 1}, now_ns);
  }
  source::SourceFrame Frame(float pose) {
    numbers.fill(pose);
    source::SourceFrame frame;
    frame.root_position = std::as_bytes(std::span(numbers)).first(12);
    frame.rotations = std::as_bytes(std::span(numbers)).subspan(12);
    return frame;
  }
  LastHandled Last(std::uint64_t session, std::uint64_t sequence, float pose, std::int64_t at_ns) {
    LastHandled last;
    last.session = session;
    last.sequence = sequence;
    last.pose_crc = PoseCrc(Frame(pose));
    last.at_ns = at_ns;
    return last;
  }
  std::array<float, 23> numbers{};
  InputBuffer held;
};

TEST_F(InputBufferTest, FramesAreFoundByTheirNumbers) {
  for (int i = 0; i < 10; ++i) Add(i * 8 * kMilli, 7, 100 + static_cast<std::uint64_t>(i), 1);
  const auto place = held.Find(kSources, "suit.a", Last(7, 104, 1, 900 * kMilli));
  ASSERT_NE(place.same, nullptr);
  EXPECT_EQ(place.same->frame.sequence, 104U);
  EXPECT_EQ(place.after, 5U);
}

TEST_F(InputBufferTest, ALastFrameThatNeverReachedTheStandbyLeavesThoseBehindIt) {
  for (const std::uint64_t sequence : {100U, 101U, 103U, 104U}) Add(0, 7, sequence, 1);
  const auto place = held.Find(kSources, "suit.a", Last(7, 102, 1, 0));
  EXPECT_EQ(place.same, nullptr);
  EXPECT_EQ(place.after, 2U);
  EXPECT_EQ(held.Find(kSources, "suit.a", Last(7, 90, 1, 0)).after, 0U);
  EXPECT_EQ(held.Find(kSources, "suit.a", Last(7, 200, 1, 0)).after, 4U);
}

TEST_F(InputBufferTest, WithOtherNumbersTheyAreFoundByThePose) {
  for (int i = 0; i < 10; ++i) {
    Add(i * 8 * kMilli, 9, 500 + static_cast<std::uint64_t>(i), static_cast<float>(i));
  }
  const auto place = held.Find(kSources, "suit.a", Last(7, 3, 6, 0));
  ASSERT_NE(place.same, nullptr);
  EXPECT_EQ(place.same->frame.sequence, 506U);
  EXPECT_EQ(place.after, 7U);
}

TEST_F(InputBufferTest, OfAPerformerWhoStandsStillTheNearestInTimeCounts) {
  for (int i = 0; i < 10; ++i) Add(i * 8 * kMilli, 9, 500 + static_cast<std::uint64_t>(i), 1);
  EXPECT_EQ(held.Find(kSources, "suit.a", Last(7, 3, 1, 33 * kMilli)).after, 5U);
}

TEST_F(InputBufferTest, APoseThatIsNotThereIsPlacedByItsTime) {
  for (int i = 0; i < 10; ++i) {
    Add(i * 8 * kMilli, 9, 500 + static_cast<std::uint64_t>(i), static_cast<float>(i));
  }
  EXPECT_EQ(held.Find(kSources, "suit.a", Last(7, 3, 77, 41 * kMilli)).after, 6U);
}

TEST_F(InputBufferTest, NobodyElsesFramesCount) {
  Add(0, 7, 1, 1, 0, "ab");
  Add(0, 7, 2, 1, 1, "a");
  Add(0, 7, 3, 1, 0, "a");
  EXPECT_EQ(held.Find(kSources, "suit.a", Last(7, 3, 1, 0)).after, 3U);
  EXPECT_EQ(held.Find(kSources, "stage.a", Last(7, 2, 1, 0)).after, 2U);
  EXPECT_EQ(held.Find(kSources, "stage.b", Last(7, 2, 1, 0)).after, 0U);
  EXPECT_EQ(held.LastOf(kSources, "stage.a"), 0);
  EXPECT_EQ(held.LastOf(kSources, "stage.b"), std::numeric_limits<std::int64_t>::min());
}

TEST_F(InputBufferTest, ItKeepsASecondAndNoMoreThanItsBound) {
  for (int i = 0; i < 300; ++i) Add(i * 8 * kMilli, 7, static_cast<std::uint64_t>(i), 1);
  EXPECT_LE(held.frames().size(), 127U);
  EXPECT_EQ(held.frames().back()->frame.sequence, 299U);
  for (int i = 0; i < 20'000; ++i) Add(2'400 * kMilli, 7, static_cast<std::uint64_t>(i), 1);
  EXPECT_EQ(held.frames().size(), InputBuffer::kMost);
}

TEST_F(InputBufferTest, TheNewestBodyOfEachPerformerStays) {
  const std::array<std::byte, 3> bytes{std::byte{1}, std::byte{2}, std::byte{3}};
  for (int i = 0; i < 2000; ++i) {
    source::SourceFrame body;
    const std::string name = "p" + std::to_string(i % 1500);
    body.is_body = true;
    body.performer = name;
    body.sequence = static_cast<std::uint64_t>(i);
    body.body_bytes = bytes;
    held.Add(0, {&body, 1}, i * 100 * kMilli);
  }
  EXPECT_EQ(held.bodies().size(), 1024U);
  EXPECT_EQ(held.bodies().at({0, "p3"})->frame.sequence, 1503U);
  EXPECT_EQ(held.bodies().at({0, "p3"})->frame.body_bytes.size(), 3U);
}

}  // namespace
}  // namespace styled::standby

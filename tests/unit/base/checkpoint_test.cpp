#include "model/base/checkpoint.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "model/base/checkpoint_bytes.h"

namespace styled {
namespace {

// One of everything that a state is made of.
struct Everything {
  bool flag = false;
  int count = 0;
  std::int64_t time_ns = 0;
  double seconds = 0;
  std::array<float, 3> floats{};
  std::vector<Eigen::Vector3f> vectors{2, Eigen::Vector3f::Zero()};
  Eigen::Quaternionf turn = Eigen::Quaternionf::Identity();
  std::bitset<11> bits;
  std::array<bool, 2> flags{};

  void Carry(Checkpoint& c) noexcept {
    c(flag);
    c.Within(count, 0, 9);
    c.Time(time_ns);
    c(seconds, floats, vectors, turn, bits, flags);
  }
};

Everything Filled() {
  Everything filled;
  filled.flag = true;
  filled.count = 7;
  filled.time_ns = -5;
  filled.seconds = 0.1;
  filled.floats = {1, -2, std::numeric_limits<float>::infinity()};
  filled.vectors = {{1, 2, 3}, {4, 5, 6}};
  filled.turn = {0.5F, -0.5F, 0.5F, 0.5F};
  filled.bits = 0b10110000101;
  filled.flags = {false, true};
  return filled;
}

std::vector<std::byte> Written(Everything of) {
  return CheckpointBytes([&of](Checkpoint& c) { of.Carry(c); });
}

TEST(Checkpoint, EveryValueComesBack) {
  const std::vector<std::byte> bytes = Written(Filled());
  Everything read;
  Checkpoint c = Checkpoint::From(bytes);
  read.Carry(c);
  EXPECT_TRUE(c.complete());
  const Everything expected = Filled();
  EXPECT_EQ(read.flag, expected.flag);
  EXPECT_EQ(read.count, expected.count);
  EXPECT_EQ(read.time_ns, expected.time_ns);
  EXPECT_EQ(read.seconds, expected.seconds);
  EXPECT_EQ(read.floats, expected.floats);
  EXPECT_EQ(read.vectors, expected.vectors);
  EXPECT_EQ(read.turn.coeffs(), expected.turn.coeffs());
  EXPECT_EQ(read.bits, expected.bits);
  EXPECT_EQ(read.flags, expected.flags);
}

TEST(Checkpoint, TheBytesAreTheValuesInOrderWithoutPadding) {
  struct Two {
    bool flag = true;
    std::uint32_t number = 0x04030201;
    void Carry(Checkpoint& c) noexcept { c(flag, number); }
  } two;
  std::array<std::byte, 5> bytes{};
  Checkpoint c = Checkpoint::Into(bytes);
  two.Carry(c);
  EXPECT_TRUE(c.complete());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_EQ(std::to_integer<std::size_t>(bytes[i]), i == 0 ? 1 : i) << i;
  }
}

TEST(Checkpoint, IsCompleteWhereTheRoomIsThatWhichWasCounted) {
  Everything of = Filled();
  for (const std::size_t more : {0U, 1U}) {
    std::vector<std::byte> room(Written(of).size() + more);
    Checkpoint c = Checkpoint::Into(room);
    of.Carry(c);
    EXPECT_EQ(c.complete(), more == 0);
    c = Checkpoint::Into(std::span(room).first(room.size() - more - 1));
    of.Carry(c);
    EXPECT_FALSE(c.ok());
  }
}

TEST(Checkpoint, AWrongLengthIsNotComplete) {
  std::vector<std::byte> bytes = Written(Filled());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    Everything read;
    Checkpoint c = Checkpoint::From(std::span(bytes).first(size));
    read.Carry(c);
    EXPECT_FALSE(c.complete()) << size;
  }
  bytes.push_back({});
  Everything read;
  Checkpoint c = Checkpoint::From(bytes);
  read.Carry(c);
  EXPECT_TRUE(c.ok());
  EXPECT_FALSE(c.complete());
}

TEST(Checkpoint, RefusesWhatIsOutOfBoundsAndReadsNothingBehindIt) {
  Everything wild = Filled();
  wild.count = 10;
  const std::vector<std::byte> bytes = [&] {
    std::vector<std::byte> room(Written(Filled()).size());
    std::memcpy(room.data(), Written(Filled()).data(), room.size());
    std::memcpy(room.data() + 1, &wild.count, sizeof wild.count);  // behind the flag
    return room;
  }();
  Everything read;
  read.count = 3;
  Checkpoint c = Checkpoint::From(bytes);
  read.Carry(c);
  EXPECT_FALSE(c.ok());
  EXPECT_EQ(read.count, 3);
  EXPECT_EQ(read.seconds, 0);
}

TEST(Checkpoint, RefusesAVectorOfAnotherSizeAndABoolThatIsNone) {
  Everything three = Filled();
  three.vectors.emplace_back(7, 8, 9);
  const std::vector<std::byte> bytes = Written(three);
  Everything read;
  Checkpoint c = Checkpoint::From(bytes);
  read.Carry(c);
  EXPECT_FALSE(c.ok());
  EXPECT_EQ(read.vectors.size(), 2U);

  const std::array<std::byte, 1> two{std::byte{2}};
  bool flag = false;
  Checkpoint other = Checkpoint::From(two);
  other(flag);
  EXPECT_FALSE(other.ok());
}

}  // namespace
}  // namespace styled

#include "proto/recording/byte_ring.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

namespace styled::recording {
namespace {

std::span<const std::byte> BytesOf(const std::string& text) {
  return std::as_bytes(std::span(text));
}

std::string Pop(ByteRing& ring) {
  std::vector<std::byte> out;
  if (!ring.Pop(out)) return "none";
  return {reinterpret_cast<const char*>(out.data()), out.size()};
}

TEST(ByteRingTest, AnEmptyRingHasNothing) {
  ByteRing ring(64);
  EXPECT_EQ(Pop(ring), "none");
}

TEST(ByteRingTest, ARecordWithoutRoomIsRefusedWholeAndTheOthersStay) {
  ByteRing ring(64);
  ASSERT_TRUE(ring.Push({BytesOf(std::string(40, 'a'))}));  // 44 of 64
  EXPECT_FALSE(ring.Push({BytesOf(std::string(17, 'b'))}));
  EXPECT_TRUE(ring.Push({BytesOf(std::string(16, 'c'))}));  // exactly full
  EXPECT_FALSE(ring.Push({}));
  EXPECT_FALSE(ring.Push({BytesOf(std::string(1000, 'd'))}));
  EXPECT_EQ(Pop(ring), std::string(40, 'a'));
  EXPECT_TRUE(ring.Push({BytesOf("e")}));
  EXPECT_EQ(Pop(ring), std::string(16, 'c'));
  EXPECT_EQ(Pop(ring), "e");
  EXPECT_EQ(Pop(ring), "none");
}

TEST(ByteRingTest, PartsBecomeOneMessageWhereverTheRingEnds) {
  ByteRing ring(64);
  for (int i = 0; i < 200; ++i) {
    const std::string a(static_cast<std::size_t>(i % 23), 'a'),
        b(static_cast<std::size_t>(i % 7), 'b');
    ASSERT_TRUE(ring.Push({BytesOf(a), BytesOf(""), BytesOf(b)})) << i;
    ASSERT_EQ(Pop(ring), a + b) << i;
  }
}

TEST(ByteRingTest, TwoThreadsLoseNothingAndKeepTheOrder) {
  ByteRing ring(256);
  constexpr int kCount = 20'000;
  std::jthread producer([&ring] {
    for (int i = 0; i < kCount; ++i) {
      const std::string text =
          std::to_string(i) + std::string(static_cast<std::size_t>(i % 50), '.');
      while (!ring.Push({BytesOf(text)})) std::this_thread::yield();
    }
  });
  for (int i = 0; i < kCount; ++i) {
    std::string text = Pop(ring);
    while (text == "none") {
      std::this_thread::yield();
      text = Pop(ring);
    }
    ASSERT_EQ(text, std::to_string(i) + std::string(static_cast<std::size_t>(i % 50), '.'));
  }
}

}  // namespace
}  // namespace styled::recording

#include "model/base/hash.h"

#include <gtest/gtest.h>

#include <cstring>

#include "model/base/random_id.h"

namespace styled {
namespace {

// Values of the algorithm's published test suite.
TEST(Fnv1aTest, IsTheOneThatOthersCompute) {
  EXPECT_EQ(HashOf(""), 0xcbf29ce484222325ULL);
  EXPECT_EQ(HashOf("a"), 0xaf63dc4c8601ec8cULL);
  EXPECT_EQ(HashOf("foobar"), 0x85944171f73967e8ULL);
}

TEST(Fnv1aTest, TextBytesAndNumbersAreTheSameBytes) {
  Fnv1a text, bytes, number;
  text.Text("abcd");
  bytes.Bytes("abcd", 4);
  number.Number('a' | 'b' << 8 | 'c' << 16 | 'd' << 24);
  EXPECT_EQ(text.value(), bytes.value());
  EXPECT_EQ(text.value(), number.value());
  number.Number(-1);
  text.Text("\xff\xff\xff\xff");
  EXPECT_EQ(text.value(), number.value());
}

TEST(RandomIdTest, IsNeverZeroNorTwiceTheSame) {
  const std::uint64_t first = RandomId(), second = RandomId();
  EXPECT_NE(first, 0U);
  EXPECT_NE(second, 0U);
  EXPECT_NE(first, second);
}

}  // namespace
}  // namespace styled

#include "model/base/text.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace styled {
namespace {

TEST(NumberTextTest, ANumberIsAsPeopleWriteIt) {
  EXPECT_EQ(NumberText(2.0F), "2");
  EXPECT_EQ(NumberText(0.8F), "0.8");
  EXPECT_EQ(NumberText(-0.05), "-0.05");
  EXPECT_EQ(NumberText(1.5000001F), "1.5000001") << "not 1.5, where 1.5 is the most";
  EXPECT_EQ(NumberText(100000.0), "100000");
  EXPECT_EQ(NumberText(60000.0F), "60000");
  EXPECT_EQ(NumberText(0.0), "0");
  EXPECT_EQ(NumberText(1e30F), "1e+30");
  EXPECT_EQ(NumberText(1e-7), "1e-07");
  EXPECT_EQ(NumberText(std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(NumberText(-std::numeric_limits<float>::infinity()), "-inf");
  EXPECT_EQ(NumberText(std::numeric_limits<double>::max()), "1.7976931348623157e+308");
  EXPECT_EQ(NumberText(12.300000001, 3), "12.3");
  EXPECT_EQ(NumberText(2.0 / 3, 3), "0.667");
}

TEST(PrintableTest, TextStaysAsItIs) {
  for (const char* const text :
       {"", "rig.anna: bound", "Jos\xC3\xA9 \xE5\xA7\x93 \xF0\x9F\x98\x80"}) {
    EXPECT_EQ(Printable(text, 100), text);
    EXPECT_TRUE(IsUtf8(text));
  }
}

TEST(PrintableTest, ControlCharactersAreWrittenOut) {
  EXPECT_EQ(Printable("a\nb\tc\r\x1b[31m\x7f", 100), "a\\nb\\tc\\x0d\\x1b[31m\\x7f");
  EXPECT_EQ(Printable(std::string_view("a\0b", 3), 100), "a\\x00b");
  EXPECT_EQ(Printable("\xC2\x9B"
                      "31m",
                      100),
            "\\x9b31m")
      << "the same escape in one character";
  EXPECT_EQ(Printable("\xE2\x80\xAE"
                      "evil",
                      100),
            "\\u202eevil")
      << "turns the line around";
  EXPECT_EQ(Printable("\xE2\x80\xA8", 100), "\\u2028");
}

TEST(PrintableTest, InvalidUtf8IsReplaced) {
  const std::string replacement = "\xEF\xBF\xBD";
  for (const char* const text : {"\xFF", "\x80", "\xC3", "\xC0\x80", "\xE0\x80\x80", "\xED\xA0\x80",
                                 "\xF4\x90\x80\x80", "\xF8\x88\x80\x80\x80", "\xE5\xA7"}) {
    EXPECT_FALSE(IsUtf8(text));
    EXPECT_TRUE(Printable(text, 100).starts_with(replacement)) << text;
    EXPECT_TRUE(IsUtf8(Printable(text, 100)));
  }
  EXPECT_EQ(Printable("a\xFFz", 100), "a" + replacement + "z");
}

TEST(PrintableTest, TheRestIsCutOffBetweenCharacters) {
  EXPECT_EQ(Printable("abcdef", 6), "abcdef");
  EXPECT_EQ(Printable("abcdefg", 6), "abcdef...");
  EXPECT_EQ(Printable("abc\xE5\xA7\x93", 5), "abc...");
  EXPECT_EQ(Printable("abc\n", 4), "abc...");
}

TEST(PrintableTest, AnyBytesBecomeOneLineOfUtf8) {
  std::mt19937 random(1);
  for (int run = 0; run < 20000; ++run) {
    std::string bytes(random() % 24, '\0');
    for (char& byte : bytes)
      byte = static_cast<char>(random() % 4 == 0 ? 0x80 | random() : random());
    const std::string shown = Printable(bytes, 40);
    EXPECT_TRUE(IsUtf8(shown));
    EXPECT_LE(shown.size(), 43U);
    EXPECT_EQ(Printable(shown, 100), shown);
  }
}

}  // namespace
}  // namespace styled

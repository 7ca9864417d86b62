// The file of a style: what is read of it and written again, and what a client's file may cost.
#include "daemon/styles/style_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/support/count_new.h"

namespace styled::pipeline {
namespace {

using testing::HasSubstr;

constexpr std::size_t kMemoryPerByte = 8, kFixed = std::size_t{1} << 20;

RuntimeConfig Config() {
  RuntimeConfig config;
  config.weights_hash = "crc32c:00000001";
  return config;
}
// A style's file of which `more` are fields.
std::string With(const std::string& more, const std::string& code = "[0.1,-2,3e-7]") {
  return R"({"format":"styled style 1","name":"a","weights":"crc32c:00000001","licence":"MIT",)"
         R"("source":"s","seconds":1.5,"example":"e",)" +
         (more.empty() ? "" : more + ",") + R"("code":)" + code + "}";
}
std::string Repeated(std::size_t count, const std::string& text) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}
std::string Refusal(const std::string& text) {
  const auto style = ParseStyleFile(text, "x.json", Config());
  return style.ok() ? "" : style.status().message();
}

TEST(StyleFile, AFileIsReadAndWrittenAsItWas) {
  const auto style = ParseStyleFile(With(""), "x.json", Config());
  ASSERT_TRUE(style.ok()) << style.status().message();
  EXPECT_EQ(style.value().name, "a");
  EXPECT_EQ(style.value().licence, "MIT");
  EXPECT_EQ(style.value().source, "s");
  EXPECT_EQ(style.value().seconds, 1.5F);
  EXPECT_EQ(style.value().example, "e");
  EXPECT_THAT(style.value().code, testing::ElementsAre(0.1F, -2.0F, 3e-7F));
  const std::string text = FormatStyleFile(style.value(), Config());
  const auto again = ParseStyleFile(text, "x.json", Config());
  ASSERT_TRUE(again.ok()) << again.status().message();
  EXPECT_EQ(again.value().code, style.value().code);
  EXPECT_EQ(FormatStyleFile(again.value(), Config()), text);
}

TEST(StyleFile, OnlyKnownFieldsAreKept) {
  const auto style = ParseStyleFile(
      With(R"("notes":{"code":[7],"name":"b","deep":[[[[1]]]]},"name":7,"name":"c")"), "x.json",
      Config());
  ASSERT_TRUE(style.ok()) << style.status().message();
  EXPECT_EQ(style.value().name, "c") << "the last of two";
  EXPECT_EQ(style.value().code.size(), 3U);
  EXPECT_THAT(FormatStyleFile(style.value(), Config()), testing::Not(HasSubstr("notes")));
}

TEST(StyleFile, AnInvalidStyleIsRefused) {
  const std::string format = "x.json: expected a JSON object with \"format\": \"styled style 1\"";
  for (const std::string& text : {std::string(), std::string("7"), "[" + With("") + "]",
                                  With("").substr(0, 90), With("\"format\":\"other\""),
                                  With("\"x\":" + std::string(16, '[') + std::string(16, ']'))}) {
    EXPECT_EQ(Refusal(text), format) << text;
  }
  EXPECT_EQ(Refusal(With("\"x\":" + std::string(15, '[') + std::string(15, ']'))), "");
  const std::string code = "x.json: expected \"name\", and \"code\" with numbers";
  for (const char* const wrong : {"7", "\"all\"", "[1,\"b\"]", "[1,[2]]", "[1,{}]", "[null]"}) {
    EXPECT_EQ(Refusal(With("", wrong)), code) << wrong;
  }
  EXPECT_EQ(Refusal(With("\"name\":7")), code);
  EXPECT_THAT(Refusal(With("\"weights\":7")), HasSubstr("other weights, unnamed; expected crc32c"));
  EXPECT_THAT(Refusal(With("\"x\":\"" + std::string(kMaxStyleFileBytes, 'x') + "\"")),
              HasSubstr("bytes, expected at most 1048576"));
}

// Each takes 30 s, or hundreds of megabytes of memory or disk, in a reader that keeps all fields
// and writes them with indents.
TEST(StyleFile, AHostileFileTakesMemoryTimeAndDiskInProportion) {
  const std::size_t most = kMaxStyleFileBytes - 1000;
  const std::string deep = "\"x\":" + std::string(20'000, '[') + std::string(20'000, ']');
  for (const std::string& text :
       {With(deep), With("\"x\":" + std::string(most / 2, '[') + std::string(most / 2, ']')),
        With("\"x\":" + std::string(most, '[')), With("\"x\":[" + Repeated(most / 3, "[],") + "1]"),
        With("\"x\":[" + Repeated(most / 3, "{},") + "1]"),
        With("\"" + std::string(most, 'k') + "\":1"),
        With("\"source\":\"" + std::string(most, 's') + "\""),
        With("\"source\":\"" + Repeated(most / 6, "\\u0001") + "\""),
        With("\"name\":\"" + Repeated(most / 2, "\\n") + "\""),
        With(Repeated(most / 9, "\"kk\":11,") + "\"k\":1"),
        With("", "[" + Repeated(most / 2, "0,") + "1]"),
        With("", "[" + Repeated(most / 5, "-7e9,") + "1]")}) {
    SCOPED_TRACE(text.substr(0, 200));
    const auto begin = std::chrono::steady_clock::now();
    std::size_t peak_bytes = 0;
    std::string written;
    {
      const support::CountNew count;
      const auto style = ParseStyleFile(text, "x.json", Config());
      peak_bytes = count.peak_bytes();
      if (style.ok()) written = FormatStyleFile(style.value(), Config());
    }
    EXPECT_LE(peak_bytes, kMemoryPerByte * text.size() + kFixed);
    EXPECT_LE(written.size(), 2 * text.size() + 1024);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
    if (written.empty()) continue;
    // A file that this daemon wrote can be read again, for any network's code.
    if (written.size() > kMaxStyleFileBytes) continue;
    EXPECT_EQ(Refusal(written), "");
  }
}

TEST(StyleFile, TheLargestFileThatIsWrittenIsReadAgain) {
  constexpr std::size_t kLongestCode = 8192;  // more than of any network
  MadeStyle style;
  style.name = std::string(32, 'n');
  style.source = style.licence = Repeated(100, "\x01\x02");
  style.code.assign(kLongestCode, -1.17549435e-38F);
  const std::string text = FormatStyleFile(style, Config());
  EXPECT_LE(text.size(), kMaxStyleFileBytes);
  EXPECT_EQ(Refusal(text), "");
}

}  // namespace
}  // namespace styled::pipeline

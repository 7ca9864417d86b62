#include "proto/rigs/rokoko/json_reader.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>

#include "tests/unit/rokoko/texts.h"

// The oracle is nlohmann::json: the same values of the same text, and the same texts refused.
namespace styled::rokoko {
namespace {

using Json = nlohmann::json;
using Type = JsonReader::Type;

// The next value as nlohmann's, put together with the reader's functions alone.
Json Build(JsonReader& json) {
  switch (json.Peek()) {
    case Type::kObject: {
      Json object = Json::object();
      json.BeginObject();
      std::string_view key;
      while (json.NextMember(key)) {
        const std::string name(key);
        object[name] = Build(json);
      }
      return object;
    }
    case Type::kArray: {
      Json array = Json::array();
      json.BeginArray();
      while (json.NextElement()) array.push_back(Build(json));
      return array;
    }
    case Type::kString: {
      std::string text(4096, '\0');
      std::size_t size = 0;
      json.ReadString(text, size);
      return text.substr(0, size);
    }
    case Type::kNumber: {
      double value = 0;
      json.ReadNumber(value);
      return value;
    }
    case Type::kTrue:
    case Type::kFalse: {
      bool value = false;
      json.ReadBool(value);
      return value;
    }
    case Type::kNull:
    case Type::kNothing:
      json.Skip();
      return nullptr;
  }
  return nullptr;
}

std::optional<Json> Parse(std::string_view text) {
  JsonReader json(text);
  Json value = Build(json);
  if (!json.AtEnd()) return {};
  return value;
}
bool Skipped(std::string_view text) {
  JsonReader json(text);
  return json.Skip() && json.AtEnd();
}

void ExpectAgreement(const std::string& text) {
  const bool good = Json::accept(text);
  const auto ours = Parse(text);
  ASSERT_EQ(ours.has_value(), good) << text;
  ASSERT_EQ(Skipped(text), good) << text;
  if (good) {
    ASSERT_EQ(*ours, Json::parse(text)) << text;
  }
}

TEST(JsonReader, RefusesTheMalformedTextsThatTheOracleRefuses) {
  for (const char* text : {
           "",
           " ",
           "{",
           "}",
           "[",
           "]",
           "{]",
           "[}",
           "{\"a\"",
           "{\"a\":",
           "{\"a\":1",
           "{\"a\":1,",
           "{\"a\":1,}",
           "{,}",
           "{\"a\" 1}",
           "{a:1}",
           "{'a':1}",
           "{1:1}",
           "{\"a\":1 \"b\":2}",
           "[1,]",
           "[,1]",
           "[1 2]",
           "[1,,2]",
           "1 2",
           "{}{}",
           "tru",
           "True",
           "nul",
           "falsee",
           "nan",
           "NaN",
           "Infinity",
           "-",
           "+1",
           "01",
           "-01",
           "1.",
           ".5",
           "1.e5",
           "1e",
           "1e+",
           "0x10",
           "1_000",
           "1e999",
           "-1e999",
           "[1e400]",
           "\"",
           "\"abc",
           "\"\\",
           "\"\\\"",
           "\"\\x\"",
           "\"\\u12\"",
           "\"\\u12g4\"",
           "\"\\ud800\"",
           "\"\\udc00\"",
           "\"\\ud800\\n\"",
           "\"\\ud800\\ud800\"",
           "\"\\ud800x\"",
           "\"a\nb\"",
           "\"a\tb\"",
           "\"\x01\"",
           "\"\x80\"",
           "\"\xC3\"",
           "\"\xC0\x80\"",
           "\"\xC1\xBF\"",
           "\"\xE0\x80\x80\"",
           "\"\xED\xA0\x80\"",
           "\"\xF0\x80\x80\x80\"",
           "\"\xF4\x90\x80\x80\"",
           "\"\xF5\x80\x80\x80\"",
           "\"\xFF\"",
           "\"\xE2\x82\"",
           "// c\n1",
           "/* c */ 1",
           "[1]]",
           "{\"a\":{}]",
           "\v1",
           "{\"\xFF\":1}",
           "{\"\\u12\":1}",
       }) {
    EXPECT_FALSE(Json::accept(text)) << text;  // the case is one
    ExpectAgreement(text);
  }
}

TEST(JsonReader, ReadsTheTextsThatTheOracleReadsToTheSameValues) {
  for (const char* text : {
           "0",
           "-0",
           "1",
           "-1",
           "0.5",
           "1e5",
           "1E+5",
           "1e-5",
           "123456789012345678901234567890",
           "1e308",
           "1.7976931348623157e308",
           "5e-324",
           "1e-400",
           "-1e-400",
           "0e999",
           "0.0e-999",
           "0.1",
           "3.141592653589793238462643383279",
           "true",
           "false",
           "null",
           "\"\"",
           "\"abc\"",
           "\"\\\"\\\\\\/\\b\\f\\n\\r\\t\"",
           "\"\\u0041\\u00e9\\u20AC\\ud83d\\ude00\\u0000\"",
           "\"\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80\xEF\xBF\xBF\"",
           "\"\x7F\"",
           "[]",
           "{}",
           "[[],{}]",
           "{\"a\":1,\"b\":[true,false,null],\"c\":{\"d\":\"e\"}}",
           " [ 1 , 2 ] ",
           "{\"\":1}",
           "{\"\\u0061\\n\":1,\"\\\"\":2}",
           "{\"a\":1,\"a\":2}",
       }) {
    EXPECT_TRUE(Json::accept(text)) << text;
    ExpectAgreement(text);
  }
  ExpectAgreement(std::string(testing::kLayout3));
  ExpectAgreement(std::string(testing::kLayout2));
}

TEST(JsonReader, AgreesWithTheOracleOnTextsDamagedAtRandom) {
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  const std::vector<std::string> seeds{
      std::string(testing::kLayout3), std::string(testing::kLayout2),
      R"({"a":[1,-2.5e3,"x\u00e9\n",{"b":null,"c":[true,false]}],"\ud83d\ude00":"é€😀"})",
      R"([0,-0.0,1e10,"",[],{},[[[]]],"\\\"\/"])"};
  constexpr std::string_view kTelling = "{}[]:,\"\\/uDd8Cc0019.eE+-tfn \x80\xC3\xE2\xF0\xBF";
  int good = 0;
  for (int run = 0; run < 20000; ++run) {
    std::string text = seeds[run % seeds.size()];
    for (std::size_t changes = 1 + below(3); changes > 0 && !text.empty(); --changes) {
      const std::size_t at = below(text.size());
      switch (below(4)) {
        case 0:
          text[at] = kTelling[below(kTelling.size())];
          break;
        case 1:
          text.insert(at, 1, kTelling[below(kTelling.size())]);
          break;
        case 2:
          text.erase(at, 1 + below(4));
          break;
        default:
          text[at] = static_cast<char>(1 + below(255));  // NUL ends the oracle's text
          break;
      }
    }
    good += Json::accept(text) ? 1 : 0;
    ExpectAgreement(text);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(good, 500);  // damage that is none: both ways were tried
}

TEST(JsonReader, ReadsNumbersOfAnySizeToTheBit) {
  std::mt19937_64 random(3);
  for (int run = 0; run < 20000; ++run) {
    double value = 0;
    do {
      value = std::bit_cast<double>(random());
    } while (!std::isfinite(value));
    ExpectAgreement(Json(value).dump());
    if (HasFatalFailure()) return;
  }
}

TEST(JsonReader, KeepsWhatFitsOfAStringAtAWholeCharacter) {
  std::array<char, 5> out{};
  std::size_t size = 99;
  JsonReader json(
      "\"abc\xE2\x82\xAC"
      "d\"");
  ASSERT_TRUE(json.ReadString(out, size));
  EXPECT_EQ(size, 3U);
  EXPECT_TRUE(json.AtEnd());
}

TEST(JsonReader, AnotherTypeThanWasAskedForIsNoMistakeOfSyntax) {
  double number = 0;
  bool flag = false;
  std::array<char, 8> text{};
  std::size_t size = 0;
  const auto expect_other = [](std::string_view given, auto read) {
    JsonReader json(given);
    EXPECT_FALSE(read(json)) << given;
    EXPECT_EQ(json.error(), JsonReader::Error::kOther) << given;
    EXPECT_FALSE(json.Skip()) << "and nothing works afterwards";
  };
  expect_other("\"1\"", [&](JsonReader& json) { return json.ReadNumber(number); });
  expect_other("1", [&](JsonReader& json) { return json.ReadBool(flag); });
  expect_other("null", [&](JsonReader& json) { return json.ReadString(text, size); });
  expect_other("[]", [&](JsonReader& json) { return json.BeginObject(); });
  expect_other("{}", [&](JsonReader& json) { return json.BeginArray(); });
}

TEST(JsonReader, GoesAsDeepAsItSaysAndNoDeeper) {
  const auto nested = [](int depth) {
    return std::string(static_cast<std::size_t>(depth), '[') +
           std::string(static_cast<std::size_t>(depth), ']');
  };
  EXPECT_TRUE(Skipped(nested(JsonReader::kMaxDepth)));
  const std::string deep = nested(JsonReader::kMaxDepth + 1);
  JsonReader deeper(deep);
  EXPECT_FALSE(deeper.Skip());
  EXPECT_EQ(deeper.error(), JsonReader::Error::kTooDeep);
  const std::string endless(1U << 20U, '[');
  JsonReader never(endless);
  EXPECT_FALSE(never.Skip());
  EXPECT_EQ(never.error(), JsonReader::Error::kTooDeep);
}

}  // namespace
}  // namespace styled::rokoko

#include "proto/rigs/rokoko/json_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
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
using Value = JsonReader::Value;

constexpr std::size_t kMaxBytes = 1U << 20U;

// The value as nlohmann's, put together with the reader's functions alone.
bool Build(JsonReader& json, Value& value, Json& out) {
  Type type{};
  if (value.type().get(type) != simdjson::SUCCESS) return json.Skip(value);
  switch (type) {
    case Type::object:
      out = Json::object();
      return json.Members(value, [&](std::string_view key, Value& inner) {
        return Build(json, inner, out[std::string(key)]);
      });
    case Type::array:
      out = Json::array();
      return json.Elements(value, [&](Value& inner) {
        out.push_back(nullptr);
        return Build(json, inner, out.back());
      });
    case Type::string: {
      std::string text(4096, '\0');
      std::size_t size = 0;
      const bool good = json.String(value, text, size);
      out = text.substr(0, size);
      return good;
    }
    case Type::number: {
      double number = 0;
      const bool good = json.Number(value, number);
      out = number;
      return good;
    }
    case Type::boolean: {
      bool flag = false;
      const bool good = json.Bool(value, flag);
      out = flag;
      return good;
    }
    case Type::null:
      out = nullptr;
      return json.Skip(value);
  }
  return false;
}

template <typename ReadMember>
bool Read(JsonReader& json, std::string_view text, const ReadMember& read) {
  std::copy(text.begin(), text.end(), json.buffer().begin());
  return json.Text(text.size(), read);
}
std::optional<Json> Parse(JsonReader& json, std::string_view text) {
  Json out = Json::object();
  const auto build = [&](std::string_view key, Value& value) {
    return Build(json, value, out[std::string(key)]);
  };
  if (!Read(json, text, build)) return {};
  return out;
}
bool Skipped(JsonReader& json, std::string_view text) {
  return Read(json, text, [&](std::string_view, Value& value) { return json.Skip(value); });
}

void ExpectSame(JsonReader& json, const std::string& text) {
  const bool good = Json::accept(text);
  const auto ours = Parse(json, text);
  ASSERT_EQ(ours.has_value(), good) << text;
  ASSERT_EQ(json.ok(), good) << text;
  ASSERT_EQ(Skipped(json, text), good) << text;
  if (good) {
    ASSERT_EQ(*ours, Json::parse(text)) << text;
  }
}
// By itself where it is an object, and as a member of one.
void ExpectAgreement(const std::string& text) {
  static JsonReader json(kMaxBytes);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '{') {
    ExpectSame(json, text);
  } else {
    ASSERT_FALSE(Skipped(json, text)) << text;
  }
  ExpectSame(json, "{\"a\":" + text + "}");
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
  EXPECT_GT(good, 500);  // valid after all: both ways were tried
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

// The one limit that the oracle does not have.
TEST(JsonReader, AnExponentOfTwentyDigitsIsRefused) {
  JsonReader json(kMaxBytes);
  EXPECT_TRUE(Skipped(json, R"({"a":1e-0000000000000000005})"));
  EXPECT_FALSE(Skipped(json, R"({"a":1e-00000000000000000005})"));
  EXPECT_EQ(json.error(), JsonReader::Error::kSyntax);
}

TEST(JsonReader, KeepsWhatFitsOfAStringAtAWholeCharacter) {
  JsonReader json(kMaxBytes);
  for (const auto& [text, expected] :
       {std::pair{"{\"a\":\"abc\xE2\x82\xAC\x64\"}", "abc"},
        std::pair{"{\"a\":\"ab\xE2\x82\xAC\"}", "ab\xE2\x82\xAC"},
        std::pair{"{\"a\":\"abcdef\"}", "abcde"}, std::pair{"{\"a\":\"\"}", ""}}) {
    std::array<char, 5> out{};
    std::size_t size = 99;
    ASSERT_TRUE(Read(
        json, text, [&](std::string_view, Value& value) { return json.String(value, out, size); }));
    EXPECT_EQ(std::string(out.data(), size), expected);
  }
}

TEST(JsonReader, AnotherTypeThanWasAskedForIsNoMistakeOfSyntax) {
  double number = 0;
  bool flag = false;
  std::array<char, 8> text{};
  std::size_t size = 0;
  JsonReader json(kMaxBytes);
  const auto expect_other = [&](const std::string& given, auto read) {
    EXPECT_FALSE(Read(json, "{\"a\":" + given + "}", [&](std::string_view, Value& value) {
      EXPECT_FALSE(read(value)) << given;
      EXPECT_EQ(json.error(), JsonReader::Error::kOther) << given;
      EXPECT_FALSE(json.Skip(value)) << "and nothing works afterwards";
      return false;
    }));
    EXPECT_EQ(json.error(), JsonReader::Error::kOther) << given;
  };
  const auto any_member = [](std::string_view, Value&) { return true; };
  expect_other("\"1\"", [&](Value& value) { return json.Number(value, number); });
  expect_other("1", [&](Value& value) { return json.Bool(value, flag); });
  expect_other("null", [&](Value& value) { return json.String(value, text, size); });
  expect_other("[]", [&](Value& value) { return json.Members(value, any_member); });
  expect_other("{}",
               [&](Value& value) { return json.Elements(value, [](Value&) { return true; }); });
  for (const char* const root : {"1", "\"a\"", "null", " true ", "[]"}) {
    EXPECT_FALSE(Skipped(json, root));
    EXPECT_EQ(json.error(), JsonReader::Error::kOther) << root;
  }
  EXPECT_TRUE(Skipped(json, "{}")) << "the next text is read as if nothing had been";
}

TEST(JsonReader, GoesAsDeepAsItSaysAndNoDeeper) {
  JsonReader json(kMaxBytes);
  // The root is the first level.
  const auto nested = [](std::size_t depth) {
    return "{\"a\":" + std::string(depth - 1, '[') + std::string(depth - 1, ']') + "}";
  };
  EXPECT_TRUE(Skipped(json, nested(JsonReader::kMaxDepth)));
  for (const std::size_t depth : {std::size_t{JsonReader::kMaxDepth + 1}, kMaxBytes / 2 - 2}) {
    EXPECT_FALSE(Skipped(json, nested(depth)));
    EXPECT_EQ(json.error(), JsonReader::Error::kTooDeep);
  }
  EXPECT_FALSE(Skipped(json, "{\"a\":" + std::string(kMaxBytes - 5, '['))) << "never closed";
  EXPECT_EQ(json.error(), JsonReader::Error::kSyntax);
}

// The parser's buffers hold a text of the greatest size, whatever it is made of, and no more.
TEST(JsonReader, ATextMayFillTheBuffer) {
  JsonReader json(kMaxBytes);
  const auto filled = [](const std::string& begin, const std::string& unit,
                         const std::string& end) {
    std::string text = "{\"a\":" + begin;
    while (text.size() + unit.size() + end.size() + 1 <= kMaxBytes) text += unit;
    text += end + "}";
    return std::string(kMaxBytes - text.size(), ' ') + text;
  };
  for (const std::string& text :
       {filled("[", "0,", "0]"), filled("\"", "x", "\""), filled("[", "\"\",", "0]"),
        filled("[", "[],", "[]]"), filled("[", "{\"\":0},", "0]"), filled("\"", "\\u00fc", "\"")}) {
    ASSERT_EQ(text.size(), kMaxBytes);
    EXPECT_TRUE(Skipped(json, text)) << text.substr(0, 20);
  }
  EXPECT_FALSE(json.Text(kMaxBytes + 1, [](std::string_view, Value&) { return true; }));
}

}  // namespace
}  // namespace styled::rokoko

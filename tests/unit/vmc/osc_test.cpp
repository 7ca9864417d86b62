#include "proto/rigs/vmc/osc.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/vmc/osc_cases.h"

namespace styled::vmc::osc {
namespace {

using testing::Bundle;
using testing::Bytes;
using testing::F;
using testing::I;
using testing::S;

std::vector<std::string> Addresses(const Bytes& datagram) {
  std::vector<std::string> addresses;
  Reader reader(datagram);
  Message message;
  while (reader.Next(message) == Reader::Step::kMessage) addresses.emplace_back(message.address);
  return addresses;
}

TEST(Osc, EveryCaseOfTheTableGivesItsReason) {
  for (const auto& c : testing::OscCases()) {
    EXPECT_EQ(Name(Check(c.bytes)), Name(c.expected)) << c.name;
  }
}

TEST(Osc, EveryReasonIsReachedByTheTable) {
  const auto cases = testing::OscCases();
  for (int reason = 0; reason < static_cast<int>(Result::kCount); ++reason) {
    EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), [reason](const auto& c) {
      return static_cast<int>(c.expected) == reason;
    })) << Name(Result(reason));
  }
}

TEST(Osc, AReaderThatBrokeStaysBroken) {
  for (const auto& c : testing::OscCases()) {
    if (c.expected == Result::kOk) continue;
    Reader reader(c.bytes);
    Message message;
    while (reader.Next(message) == Reader::Step::kMessage) {
    }
    EXPECT_EQ(reader.Next(message), Reader::Step::kBroken) << c.name;
    EXPECT_EQ(Name(reader.result()), Name(c.expected)) << c.name;
  }
}

// Every prefix of a datagram is refused, and none of it is read beyond its end (see the sanitizer).
TEST(Osc, CutShortAnywhereItIsRefused) {
  const Bytes whole = Bundle({testing::TimeMessage(1), Bundle({testing::BoneMessage("Hips")})});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    // Between the bundle's elements it is a shorter bundle.
    const bool between = size == 16 || size == 16 + 4 + 20;
    EXPECT_EQ(Check(part) == Result::kOk, between) << size;
  }
}

TEST(Osc, MessagesComeInTheOrderOfTheWireOutOfNestedBundles) {
  const auto message = [](std::string_view address) { return S(address) + S(","); };
  EXPECT_THAT(Addresses(Bundle({message("/a"),
                                Bundle({message("/b"), Bundle({message("/c")}), message("/d")}),
                                Bundle({}), message("/e")})),
              ::testing::ElementsAre("/a", "/b", "/c", "/d", "/e"));
  EXPECT_THAT(Addresses(message("/alone")), ::testing::ElementsAre("/alone"));
}

TEST(Osc, ArgumentsAreTakenByTheirTypesAlone) {
  const Bytes bytes = S("/a") + S(",ifs") + I(0xFFFFFFF9U) + F(2.5F) + S("Hips");
  Reader reader(bytes);
  Message message;
  ASSERT_EQ(reader.Next(message), Reader::Step::kMessage);
  EXPECT_EQ(message.types, "ifs");
  EXPECT_EQ(message.bytes.size(), bytes.size());
  Arguments arguments(message);
  std::int32_t number = 0;
  float real = 0;
  std::string_view text = "untouched";
  EXPECT_FALSE(arguments.Float(real));
  EXPECT_FALSE(arguments.Text(text));
  EXPECT_EQ(text, "untouched");
  EXPECT_TRUE(arguments.Int(number));
  EXPECT_EQ(number, -7);
  EXPECT_FALSE(arguments.Int(number));
  EXPECT_TRUE(arguments.Float(real));
  EXPECT_EQ(real, 2.5F);
  EXPECT_FALSE(arguments.AtEnd());
  EXPECT_TRUE(arguments.Text(text));
  EXPECT_EQ(text, "Hips");
  EXPECT_TRUE(arguments.AtEnd());
  EXPECT_FALSE(arguments.Int(number));
  EXPECT_FALSE(arguments.Float(real));
  EXPECT_FALSE(arguments.Text(text));
}

TEST(OscWriter, WritesWhatTheSpecificationSays) {
  Bytes out(256);
  Writer writer(out);
  writer.BeginBundle();
  writer.BeginMessage("/a", "if");
  writer.Int(-2);
  writer.Float(0.5F);
  writer.EndMessage();
  writer.BeginBundle();
  writer.BeginMessage("/four", "s");
  writer.Text("Hips");
  writer.EndMessage();
  writer.Raw(testing::TimeMessage(3));
  writer.EndBundle();
  writer.BeginMessage("/b", "");
  writer.EndMessage();
  writer.EndBundle();
  ASSERT_TRUE(writer.ok());
  out.resize(writer.size());
  EXPECT_EQ(out, Bundle({S("/a") + S(",if") + I(0xFFFFFFFEU) + I(0x3F000000U),
                         Bundle({S("/four") + S(",s") + S("Hips"), testing::TimeMessage(3)}),
                         S("/b") + S(",")}));
}

TEST(OscWriter, EndsATextAtItsFirstNul) {
  Bytes out(64);
  Writer writer(out);
  writer.BeginMessage("/a", "s");
  writer.Text({"ab\0cd", 5});
  writer.EndMessage();
  out.resize(writer.size());
  EXPECT_EQ(out, S("/a") + S(",s") + S("ab"));
}

TEST(OscWriter, AnOverflowIsReportedAndNothingWrittenBeyond) {
  const auto write = [](Writer& writer) {
    writer.BeginBundle();
    writer.BeginMessage("/VMC", "sf");
    writer.Text("Hips");
    writer.Float(1);
    writer.EndMessage();
    writer.EndBundle();
  };
  Bytes large(256);
  Writer whole(large);
  write(whole);
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    Bytes out(size);  // on the heap: a sanitizer sees its end
    Writer writer(out);
    write(writer);
    EXPECT_EQ(writer.ok(), size == whole.size()) << size;
  }
}

TEST(OscWriter, RefusesMoreBundlesThanItsReaderTakes) {
  Bytes out(1024);
  for (int depth = 1; depth <= kMaxDepth + 1; ++depth) {
    Writer writer(out);
    for (int i = 0; i < depth; ++i) writer.BeginBundle();
    writer.BeginMessage("/a", "");
    writer.EndMessage();
    for (int i = 0; i < depth; ++i) writer.EndBundle();
    EXPECT_EQ(writer.ok(), depth <= kMaxDepth) << depth;
    if (writer.ok()) {
      EXPECT_EQ(Check(std::span(out).first(writer.size())), Result::kOk) << depth;
    }
  }
}

}  // namespace
}  // namespace styled::vmc::osc

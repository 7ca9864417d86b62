#include "proto/styled/look.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

#include "daemon/config/look_keys.h"

namespace styled {
namespace {

using testing::HasSubstr;

std::string TextOf(const char* file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

// No field at its initial value.
v1::Look Changed() {
  v1::Look look = InitialLook();
  auto& entry = *look.add_mix();
  entry.set_style("old");
  entry.set_weight(0.5F);
  look.set_strength(0.8F);
  look.set_transition_ms(500);
  look.set_absolute(true);
  SetParts(*body::FindParts("head,left-arm"), look);
  look.set_input_style("tired");
  look.set_preset("scene");
  look.set_root(v1::ROOT_STRIDE);
  look.set_vary(7);
  look.set_vary_each(true);
  look.set_vary_amount(0.5F);
  look.set_drift_s(5);
  look.set_mirror(true);
  look.set_idle(0.5F);
  return look;
}

TEST(LookTest, EveryFieldOfTheMessageHasARowAndALineInTheManual) {
  const std::string proto = TextOf(STYLED_LOOK_PROTO);
  const std::string message = proto.substr(proto.find("message Look {"));
  const std::regex field(R"((?:\n  (?:optional |repeated )?\w+ )(\w+) = \d+;)");
  std::set<std::string> declared;
  for (std::sregex_iterator found(message.begin(), message.end(), field), end; found != end;
       ++found) {
    declared.insert((*found)[1]);
  }
  EXPECT_EQ(declared.erase("clear"), 1U) << "a word of changes, no part of a look";
  const std::string manual = TextOf(STYLED_MANUAL);
  std::set<std::string> rows;
  for (const LookField& row : kLookFields) {
    rows.emplace(row.name);
    EXPECT_THAT(manual.substr(manual.find("# [[cue]]")), HasSubstr(std::string(row.name) + " = "));
  }
  EXPECT_EQ(rows, declared);
}

TEST(LookTest, AFieldIsFoundByNameWordAndFormerSpelling) {
  for (const LookField& field : kLookFields) {
    EXPECT_EQ(FindLookField(field.name), &field);
    EXPECT_EQ(FindLookField(field.word), &field);
    if (!field.former.empty()) EXPECT_EQ(FindLookField(field.former), &field);
  }
  EXPECT_EQ(FindLookField("only"), FindLookField("parts"));
  EXPECT_EQ(FindLookField(""), nullptr);
  EXPECT_EQ(FindLookField("clear"), nullptr);
}

TEST(LookTest, TomlKeepsEveryField) {
  const v1::Look look = Changed();
  toml::table table = config::LookTable(look);
  EXPECT_EQ(table.size(), kLookFields.size());
  v1::Look read = InitialLook();
  for (const LookField& field : kLookFields) {
    const toml::node* const node = table.get(field.name);
    ASSERT_NE(node, nullptr) << field.name;
    const Status status = config::ReadLookField(field, *node, read);
    EXPECT_TRUE(status.ok()) << field.name << ": " << status.message();
    table.insert_or_assign(field.name, toml::array{7, "x"});
    EXPECT_FALSE(config::ReadLookField(field, *table.get(field.name), read).ok()) << field.name;
  }
  EXPECT_TRUE(Equal(read, look)) << "and what is refused changes nothing";
}

TEST(LookTest, AChangeAppliesWhatItNames) {
  v1::Look look = Changed();
  v1::Look change;
  EXPECT_TRUE(IsEmpty(change));
  Apply(change, look);
  EXPECT_TRUE(Equal(look, Changed()));
  change.set_strength(0.25F);
  EXPECT_FALSE(IsEmpty(change));
  Apply(change, look);
  EXPECT_EQ(look.strength(), 0.25F);
  EXPECT_EQ(look.preset(), "scene");
  change.Clear();
  change.add_mix()->set_style("proud");
  Apply(change, look);
  ASSERT_EQ(look.mix_size(), 1) << "replaced, not added to";
  EXPECT_EQ(look.mix(0).style(), "proud");
  EXPECT_EQ(look.preset(), "") << "the mix is the preset's no more";
  change.Clear();
  change.set_clear(true);
  Apply(change, look);
  EXPECT_EQ(look.mix_size(), 0);
  EXPECT_EQ(PartsOf(look), PartsOf(Changed()));
  EXPECT_FALSE(look.clear());
}

TEST(LookTest, AValueOutOfRangeIsNamed) {
  EXPECT_EQ(CheckLook(Changed()).message(), "");
  v1::Look change;
  change.set_strength(std::numeric_limits<float>::quiet_NaN());
  EXPECT_THAT(CheckLook(change).message(), HasSubstr("strength is "));
  change.set_strength(1.5F);
  EXPECT_EQ(CheckLook(change).message(), "");
  change.set_transition_ms(-1);
  EXPECT_EQ(CheckLook(change).message(), "transition_ms is -1, expected 0 to 60000");
  change.Clear();
  change.add_parts(static_cast<v1::BodyPart>(7));
  EXPECT_EQ(CheckLook(change).message(), "parts has 7, expected a BodyPart, 0 to 6");
  change.Clear();
  change.set_root(static_cast<v1::Root>(7));
  EXPECT_EQ(CheckLook(change).message(), "root is 7, expected follow or stride");
  change.set_root(static_cast<v1::Root>(-1));
  EXPECT_EQ(CheckLook(change).message(), "root is -1, expected follow or stride");
  change.Clear();
  for (const float bad : {-1.0F, 100.0F, 2.5F, std::numeric_limits<float>::quiet_NaN()}) {
    change.set_vary(bad);
    EXPECT_THAT(CheckLook(change).message(), HasSubstr(", expected a whole number from 0 to 99"))
        << bad;
  }
  change.set_vary(99);
  EXPECT_EQ(CheckLook(change).message(), "");
  change.set_vary_amount(1.6F);
  EXPECT_EQ(CheckLook(change).message(), "vary_amount is 1.6, expected 0 to 1.5");
  change.set_vary_amount(1.5F);
  change.set_drift_s(601);
  EXPECT_EQ(CheckLook(change).message(), "drift_s is 601, expected 0 to 600");
  change.set_drift_s(-1);
  EXPECT_EQ(CheckLook(change).message(), "drift_s is -1, expected 0 to 600");
  change.set_drift_s(600);
  change.set_idle(1.6F);
  EXPECT_EQ(CheckLook(change).message(), "idle is 1.6, expected 0 to 1.5");
  change.Clear();
  for (int i = 0; i < 5; ++i) change.add_mix();
  EXPECT_EQ(CheckLook(change).message(), "mix has 5 styles, expected at most 4");
}

TEST(LookTest, ALookAsksForVariationsByNumberByIdOrByDrift) {
  EXPECT_FALSE(RequestsVariations(InitialLook()));
  v1::Look look = InitialLook();
  look.set_vary(1);
  EXPECT_TRUE(RequestsVariations(look));
  look.set_vary_amount(0);
  EXPECT_FALSE(RequestsVariations(look)) << "the style itself";
  look = InitialLook();
  look.set_vary_each(true);
  EXPECT_TRUE(RequestsVariations(look));
  look = InitialLook();
  look.set_drift_s(5);
  EXPECT_TRUE(RequestsVariations(look));
}

// A `Set` of a client of version 0.1: mix old 0.5, strength 0.8, 500 ms, absolute, only
// head and left arm, own_style tired; and its request to clear.
TEST(LookTest, TheBytesOfEarlierClientsMeanTheSame) {
  using namespace std::string_literals;
  v1::Look look;
  ASSERT_TRUE(look.ParseFromString(
      "\x0A\x0A\x0A\x03old\x15\x00\x00\x00\x3F\x15\xCD\xCC\x4C\x3F\x1D\x00\x00\xFA\x43\x20\x01"
      "\x32\x02\x01\x03\x3A\x05tired"s));
  v1::Look expected = Changed();
  expected.clear_preset();
  expected.clear_root();
  expected.clear_vary();
  expected.clear_vary_each();
  expected.clear_vary_amount();
  expected.clear_drift_s();
  expected.clear_mirror();
  expected.clear_idle();
  EXPECT_TRUE(Equal(look, expected));
  ASSERT_TRUE(look.ParseFromString("\x28\x01"s));
  EXPECT_TRUE(look.clear());
}

}  // namespace
}  // namespace styled

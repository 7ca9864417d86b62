#include "daemon/looks/cues.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/styled/look.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using testing::HasSubstr;

TEST(Timecode, IsReadStrictlyAndGrowsWithTime) {
  const auto label = [](const char* text) { return TimecodeLabel(ParseTimecode(text).value()); };
  EXPECT_LT(label("01:00:10:29"), label("01:00:11:00"));
  EXPECT_LT(label("00:59:59:59"), label("01:00:00:00"));
  EXPECT_EQ(label("01:02:03;04"), label("01:02:03:04"));
  EXPECT_TRUE(ParseTimecode("01:02:03;04")->drop_frame);
  EXPECT_EQ(TimecodeText(label("01:02:03:04")), "01:02:03:04");
  for (const char* text :
       {"", "1:2:3:4", "01:02:03", "24:00:00:00", "01:60:00:00", "01:00:60:00", "01:02:03:04x",
        "01-02-03-04", "01:02:03:", "-1:02:03:04", "01:02;03:04", "01:02:03:240"}) {
    EXPECT_FALSE(ParseTimecode(text)) << text;
  }
}

TEST(Timecode, ACueFiresOnceAndNotByWinding) {
  EXPECT_TRUE(Passes(100, 99, 100));
  EXPECT_TRUE(Passes(100, 60, 140));
  EXPECT_FALSE(Passes(100, 100, 101)) << "it was fired at 100";
  EXPECT_FALSE(Passes(100, 140, 60));
  EXPECT_TRUE(Passes(3000, 2000, 4000)) << "two seconds may be lost";
  EXPECT_FALSE(Passes(3000, 2000, 4001));
  EXPECT_TRUE(Passes(100, std::nullopt, 100)) << "the show begins with it";
  EXPECT_FALSE(Passes(100, std::nullopt, 101)) << "who comes late has missed it";
}

class MakeCueTest : public testing::Test {
 protected:
  Result<Cue> Make(const std::function<void(config::Cue&)>& say) {
    config::Cue cue;
    cue.name = "entrance";
    cue.place = "show.toml:7";
    say(cue);
    config::Preset mixed{"mixed", {}, ""};
    for (const char* style : {"style1", "style2"}) {
      auto& entry = *mixed.look.add_mix();
      entry.set_style(style);
      entry.set_weight(0.5F);
    }
    return MakeCue(cue, {mixed}, network_->model().styles);
  }
  std::string Complaint(const std::function<void(config::Cue&)>& say) {
    const auto made = Make(say);
    return made.ok() ? "none" : made.status().message();
  }
  std::shared_ptr<const net::Stylizer> network_ = erd::RandomStylizer(5, 1);
};

TEST_F(MakeCueTest, ACueBecomesItsRequests) {
  const auto style = Make([](config::Cue& cue) {
    cue.at = "01:00:10:00";
    cue.style = "style1";
    cue.look.set_strength(0.5F);
    cue.look.set_transition_ms(1500);
    SetParts(*body::FindParts("arms"), cue.look);
  });
  ASSERT_TRUE(style.ok()) << style.status().message();
  EXPECT_EQ(style.value().at, std::int64_t{3610} * 1000);
  const v1::Look& set = style.value().request.set();
  EXPECT_EQ(set.mix(0).style(), "style1");
  EXPECT_EQ(set.strength(), 0.5F);
  EXPECT_EQ(set.transition_ms(), 1500);
  EXPECT_EQ(set.parts_size(), 2);

  const auto preset = Make([](config::Cue& cue) {
    cue.look.set_preset("mixed");
    cue.look.set_transition_ms(2000);
  });
  ASSERT_TRUE(preset.ok()) << preset.status().message();
  EXPECT_EQ(preset.value().request.set().transition_ms(), 2000) << "the fade is of this change";
  EXPECT_EQ(preset.value().request.set().mix_size(), 0) << "the preset as it is when fired";
  EXPECT_EQ(preset.value().request.set().preset(), "mixed");

  EXPECT_TRUE(
      Make([](config::Cue& cue) { cue.look.set_clear(true); }).value().request.set().clear());
  EXPECT_TRUE(Make([](config::Cue& cue) { cue.panic = true; }).value().request.has_panic());
}

TEST_F(MakeCueTest, AnInvalidCueIsRefusedWithItsPlace) {
  const std::string place = "show.toml:7: cue \"entrance\": ";
  EXPECT_EQ(Complaint([](config::Cue& cue) {
              cue.style = "style1";
              cue.at = "10:00";
            }),
            place + "at: \"10:00\"; expected HH:MM:SS:FF");
  EXPECT_THAT(Complaint([](config::Cue&) {}), HasSubstr(place + "expected an action"));
  EXPECT_THAT(Complaint([](config::Cue& cue) {
                cue.panic = true;
                cue.look.set_strength(1);
              }),
              HasSubstr("panic alone"));
  EXPECT_THAT(Complaint([](config::Cue& cue) {
                cue.style = "style1";
                cue.look.set_clear(true);
              }),
              HasSubstr("one of style, preset, mix and clear"));
  EXPECT_THAT(Complaint([](config::Cue& cue) { cue.style = "pirate"; }), HasSubstr("pirate"));
  EXPECT_THAT(Complaint([](config::Cue& cue) { cue.look.set_preset("none"); }),
              HasSubstr("no preset \"none\""));
  EXPECT_THAT(Complaint([](config::Cue& cue) { cue.look.set_strength(2); }),
              HasSubstr("strength is 2, expected 0 to 1.5"));
  EXPECT_THAT(Complaint([](config::Cue& cue) { cue.look.set_input_style("pirate"); }),
              HasSubstr("pirate"));
}

}  // namespace
}  // namespace styled::pipeline

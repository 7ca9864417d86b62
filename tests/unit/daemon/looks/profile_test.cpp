#include "daemon/looks/profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace styled::pipeline {
namespace {

using stylist::SettingsError;
using testing::HasSubstr;

// Two networks: the first without variations, the second with, "elderly" in both.
net::Styles Both() {
  net::Styles styles;
  for (const char* const name : {"neutral", "elderly", "proud"}) {
    net::StyleInfo style;
    style.name = name;
    style.model = "v2";
    style.original = name;
    styles.push_back(style);
  }
  for (const char* const name : {"graph-elderly", "masculine"}) {
    net::StyleInfo style;
    style.name = name;
    style.model = "graph";
    style.original = style.name == "graph-elderly" ? "elderly" : name;
    style.varies = true;
    styles.push_back(style);
  }
  return styles;
}

v1::Look Looking(std::initializer_list<std::pair<const char*, float>> mix, float vary) {
  v1::Look look = InitialLook();
  for (const auto& [style, weight] : mix) {
    auto& entry = *look.add_mix();
    entry.set_style(style);
    entry.set_weight(weight);
  }
  look.set_vary(vary);
  return look;
}

stylist::Settings Resolved(const v1::Look& look, const net::Styles& styles,
                           std::string_view performer = "rig.a") {
  std::vector<std::string> unknown;
  return Resolve(look, styles, unknown, performer);
}

TEST(ProfileTest, AStyleWithoutVariationsIsNamedWhereTheLookAsksForThem) {
  const net::Styles styles = Both();
  EXPECT_EQ(NotVaried(Looking({{"masculine", 1}, {"proud", 0.5F}}, 7), styles), "proud");
  EXPECT_EQ(NotVaried(Looking({{"proud", 1}}, 0), styles), "");
  EXPECT_EQ(NotVaried(Looking({}, 7), styles), "");
  EXPECT_EQ(NotVaried(Looking({{"neutral", 1}}, 7), styles), "");
  EXPECT_EQ(NotVaried(Looking({{"elderly", 1}, {"masculine", 0.5F}}, 7), styles), "");
  v1::Look drifts = Looking({{"proud", 1}}, 0);
  drifts.set_drift_s(5);
  EXPECT_EQ(NotVaried(drifts, styles), "proud");
  drifts.set_vary_amount(0);
  EXPECT_EQ(NotVaried(drifts, styles), "") << "the style itself";
  v1::Look each = Looking({{"proud", 1}}, 0);
  each.set_vary_each(true);
  EXPECT_EQ(NotVaried(each, styles), "proud");
}

TEST(ProfileTest, AStyleOfTheSameNameThatVariesReplacesIt) {
  const net::Styles styles = Both();
  EXPECT_EQ(Resolved(Looking({{"elderly", 0.5F}}, 0), styles).mix[0].style, 1);
  const auto varied = Resolved(Looking({{"elderly", 0.5F}, {"masculine", 0.25F}}, 7), styles);
  EXPECT_EQ(varied.mix[0].style, 3);
  EXPECT_EQ(varied.mix[0].weight, 0.5F);
  EXPECT_EQ(varied.mix[1].style, 4);
  EXPECT_EQ(varied.variation, 7);
  EXPECT_EQ(Resolved(Looking({{"proud", 1}}, 7), styles).mix[0].style, 2) << "itself, if none does";
  // The same style by both names, in either order, is one of both weights.
  for (const v1::Look& look : {Looking({{"elderly", 0.5F}, {"graph-elderly", 0.25F}}, 7),
                               Looking({{"graph-elderly", 0.25F}, {"elderly", 0.5F}}, 7)}) {
    const auto both = Resolved(look, styles);
    EXPECT_EQ(both.mix[0].style, 3);
    EXPECT_EQ(both.mix[0].weight, 0.75F);
    EXPECT_EQ(both.mix[1].style, -1);
    EXPECT_EQ(Validate(both, 5), SettingsError::kNone);
  }
  EXPECT_EQ(Validate(Resolved(Looking({{"elderly", 0.5F}, {"elderly", 0.5F}}, 7), styles), 5),
            SettingsError::kDuplicateStyle);
  net::Styles gone = styles;
  gone[3].retired = true;
  EXPECT_EQ(Resolved(Looking({{"elderly", 1}}, 7), gone).mix[0].style, 1);
  EXPECT_EQ(NotVaried(Looking({{"elderly", 1}}, 7), gone), "elderly");
}

TEST(ProfileTest, EachPerformersVariationIsItsOwnAndShifts) {
  const net::Styles styles = Both();
  v1::Look look = Looking({{"masculine", 1}}, 0);
  look.set_vary_each(true);
  std::set<int> seen, here;
  for (int i = 0; i < 500; ++i) {
    const std::string id = "rig.p" + std::to_string(i);
    look.set_vary(0);
    const int own = Resolved(look, styles, id).variation;
    EXPECT_GE(own, 1);
    EXPECT_LE(own, 99);
    EXPECT_EQ(Resolved(look, styles, id).variation, own);
    seen.insert(own);
    look.set_vary(1);
    EXPECT_EQ(Resolved(look, styles, id).variation, own % 99 + 1) << "added, and wrapped";
    look.set_vary(99);
    EXPECT_EQ(Resolved(look, styles, id).variation, own);
    if (i < 16) here.insert(own);
  }
  EXPECT_GT(seen.size(), 90U) << "spread over all of them";
  EXPECT_GE(here.size(), 12U) << "of sixteen on a stage hardly two are alike";
}

}  // namespace
}  // namespace styled::pipeline

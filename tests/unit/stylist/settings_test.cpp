#include "model/stylist/settings.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "tests/support/units.h"

namespace styled::stylist {
namespace {

using support::kNaN;
constexpr int kStyleCount = 5;

Settings Style(int style, float weight = 1, float transition_s = 0) {
  Settings settings;
  settings.mix[0] = {style, weight};
  settings.transition_s = transition_s;
  return settings;
}

SettingsError Error(const Settings& settings) { return Validate(settings, kStyleCount); }

TEST(SettingsTest, EachBrokenRuleIsNamed) {
  EXPECT_EQ(Error(Style(1)), SettingsError::kNone);
  EXPECT_EQ(Error(Style(0)), SettingsError::kNeutralStyle);
  EXPECT_EQ(Error(Style(kStyleCount)), SettingsError::kUnknownStyle);
  EXPECT_EQ(Error(Style(1, kNaN)), SettingsError::kWeight);
  EXPECT_EQ(Error(Style(1, -0.1F)), SettingsError::kWeight);
  EXPECT_EQ(Error(Style(1, 1.6F)), SettingsError::kWeight);
  EXPECT_EQ(Error(Style(1, 1, kNaN)), SettingsError::kTransition);
  EXPECT_EQ(Error(Style(1, 1, 61)), SettingsError::kTransition);
  Settings settings = Style(1);
  settings.mix[1] = {1, 0.1F};
  EXPECT_EQ(Error(settings), SettingsError::kDuplicateStyle);
  settings.mix[1] = {2, 0.6F};
  EXPECT_EQ(Error(settings), SettingsError::kSum);
  settings = Style(1);
  settings.strength = kNaN;
  EXPECT_EQ(Error(settings), SettingsError::kStrength);
  settings.strength = 1.6F;
  EXPECT_EQ(Error(settings), SettingsError::kStrength);
  settings = Style(1);
  settings.parts = 0;
  EXPECT_EQ(Error(settings), SettingsError::kNoParts);
  for (const int variation : {-1, 100}) {
    settings = Style(1);
    settings.variation = variation;
    EXPECT_EQ(Error(settings), SettingsError::kVariation);
  }
  for (const float bad : {kNaN, -0.1F, 601.0F}) {
    settings = Style(1);
    settings.vary_amount = bad;
    EXPECT_EQ(Error(settings), SettingsError::kVaryAmount);
    settings = Style(1);
    settings.drift_s = bad;
    EXPECT_EQ(Error(settings), SettingsError::kDrift);
  }
  settings.drift_s = 600;
  settings.vary_amount = 1.5F;
  settings.variation = 99;
  EXPECT_EQ(Error(settings), SettingsError::kNone);
}

TEST(SettingsTest, NeutralIsATargetOfStyledInputAlone) {
  Settings settings = Style(0);
  settings.input_style = 3;
  EXPECT_EQ(Error(settings), SettingsError::kNone);
  for (const int style : {-1, kStyleCount}) {
    settings.input_style = style;
    EXPECT_EQ(Error(settings), SettingsError::kUnknownInputStyle);
  }
}

TEST(SettingsTest, AContentIsOneOfTheNetworks) {
  Settings settings = Style(1);
  const auto error = [&settings](int contents) {
    return Validate(settings, kStyleCount, contents);
  };
  EXPECT_EQ(error(0), SettingsError::kNone);  // recognized
  EXPECT_EQ(error(3), SettingsError::kNone);
  for (const int content : {net::kContentUnknown, 0, 2}) {
    settings.input_content = content;
    EXPECT_EQ(error(3), SettingsError::kNone) << content;
    EXPECT_EQ(error(0), SettingsError::kUnknownContent) << content;
  }
  for (const int content : {3, -3}) {
    settings.input_content = content;
    EXPECT_EQ(error(3), SettingsError::kUnknownContent) << content;
  }
}

TEST(OptionsTest, DefaultsAreValid) { EXPECT_TRUE(Options().Validate().ok()); }

// The field that the refusal names; "" where there is none.
std::string Broken(const Options& options) {
  const std::string message = options.Validate().message();
  return message.substr(0, message.find(": expected "));
}

TEST(OptionsTest, EachBrokenRuleIsNamed) {
  struct Case {
    float Options::*field;
    std::vector<float> bad;
    const char* key;
  };
  const Case cases[] = {
      {&Options::change_tau_s, {kNaN, -0.1F, 1.1F}, "change_tau"},
      {&Options::gap_reset_s, {kNaN, 0, 11}, "gap_reset"},
      {&Options::restart_fade_s, {kNaN, -1, 6}, "restart_fade"},
      {&Options::jump_m, {kNaN, 0, 101}, "jump_m"},
      {&Options::out_of_domain_begin_rad, {kNaN, -0.1F, 1.1F}, "out_of_domain_begin_rad"},
      {&Options::out_of_domain_end_rad, {kNaN, 0.7F}, "out_of_domain_begin_rad"},
      {&Options::out_of_domain_fade_s, {kNaN, -1, 11}, "out_of_domain_fade"},
      {&Options::tilt_begin_rad, {kNaN, -0.1F, 1.3F}, "tilt_begin_rad"},
      {&Options::tilt_end_rad, {kNaN, 0.9F}, "tilt_begin_rad"},
      {&Options::ground_tau_s, {kNaN, -0.1F, 1.1F}, "ground_tau"},
  };
  for (const Case& c : cases) {
    for (const float value : c.bad) {
      Options options;
      options.*c.field = value;
      EXPECT_EQ(Broken(options), c.key) << value;
    }
  }
  Options options;
  for (const int frames : {0, 1001}) {
    options.jump_accept_frames = frames;
    EXPECT_EQ(Broken(options), "jump_accept_frames") << frames;
  }
  options = Options();
  options.feet_options.stretch = 0;
  EXPECT_EQ(Broken(options), "feet");
}

}  // namespace
}  // namespace styled::stylist

#include "model/feet/options.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace styled::feet {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(FeetOptionsTest, DefaultsAreValid) { EXPECT_EQ(Validate({}), OptionsError::kNone); }

TEST(FeetOptionsTest, EachBrokenRuleIsNamed) {
  struct Case {
    float Options::*field;
    std::vector<float> bad;
    OptionsError error;
  };
  const Case cases[] = {
      {&Options::contact_low_m, {kNaN, -0.01F, 0.06F}, OptionsError::kContactHeight},
      {&Options::contact_high_m, {kNaN, 0.03F, 1.1F}, OptionsError::kContactHeight},
      {&Options::contact_slow_mps, {kNaN, -0.1F, 0.9F}, OptionsError::kContactSpeed},
      {&Options::contact_fast_mps, {kNaN, 0.4F, 21}, OptionsError::kContactSpeed},
      {&Options::blend_in_s, {kNaN, -0.01F, 1.1F}, OptionsError::kBlend},
      {&Options::blend_out_s, {kNaN, -0.01F, 1.1F}, OptionsError::kBlend},
      {&Options::reach_m, {kNaN, 0, 1.1F}, OptionsError::kReach},
      {&Options::return_s, {kNaN, 0, 11}, OptionsError::kReturn},
      {&Options::centre_s, {kNaN, 0, 61}, OptionsError::kCentre},
      {&Options::centre, {kNaN, -0.1F, 1.1F}, OptionsError::kCentre},
      {&Options::stretch, {kNaN, 0.4F, 1.1F}, OptionsError::kStretch},
      {&Options::hips_drop_m, {kNaN, -0.1F, 1.1F}, OptionsError::kHipsDrop},
      {&Options::hips_tau_s, {kNaN, -0.1F, 11}, OptionsError::kHipsDrop},
  };
  for (std::size_t i = 0; i < std::size(cases); ++i) {
    for (const float value : cases[i].bad) {
      Options options;
      options.*cases[i].field = value;
      EXPECT_EQ(Validate(options), cases[i].error) << "case " << i << ": " << value;
    }
  }
}

}  // namespace
}  // namespace styled::feet

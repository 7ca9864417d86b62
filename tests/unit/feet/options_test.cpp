#include "model/feet/options.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace styled::feet {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(FeetOptionsTest, DefaultsAreValid) { EXPECT_TRUE(IsValid({})); }

TEST(FeetOptionsTest, EachBrokenRuleIsRefused) {
  struct Case {
    float Options::*field;
    std::vector<float> bad;
  };
  const Case cases[] = {
      {&Options::contact_low_m, {kNaN, -0.01F, 0.06F}},
      {&Options::contact_high_m, {kNaN, 0.03F, 1.1F}},
      {&Options::contact_slow_mps, {kNaN, -0.1F, 0.9F}},
      {&Options::contact_fast_mps, {kNaN, 0.4F, 21}},
      {&Options::blend_in_s, {kNaN, -0.01F, 1.1F}},
      {&Options::blend_out_s, {kNaN, -0.01F, 1.1F}},
      {&Options::reach_m, {kNaN, 0, 1.1F}},
      {&Options::return_s, {kNaN, 0, 11}},
      {&Options::centre_s, {kNaN, 0, 61}},
      {&Options::centre, {kNaN, -0.1F, 1.1F}},
      {&Options::stretch, {kNaN, 0.4F, 1.1F}},
      {&Options::hips_drop_m, {kNaN, -0.1F, 1.1F}},
      {&Options::hips_tau_s, {kNaN, -0.1F, 11}},
  };
  for (std::size_t i = 0; i < std::size(cases); ++i) {
    for (const float value : cases[i].bad) {
      Options options;
      options.*cases[i].field = value;
      EXPECT_FALSE(IsValid(options)) << "case " << i << ": " << value;
    }
  }
}

}  // namespace
}  // namespace styled::feet

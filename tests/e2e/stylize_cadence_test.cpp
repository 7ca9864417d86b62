// stylize --cadence as a user runs it.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "model/clip/clip.h"
#include "tests/e2e/tools.h"
#include "tests/unit/net/offset/weights.h"

namespace styled::support {
namespace {

using testing::HasSubstr;

constexpr float kFaster = 1.25F;  // steps of "bent" over those of neutral

class StylizeCadence : public ToolsTest {
 protected:
  StylizeCadence() {
    net::Styles& styles = model_.styles;  // neutral, bent, raised
    styles[0].walk_mps = 1.2F;
    styles[0].run_mps = 3;
    styles[0].walk_spm = 110;
    styles[0].run_spm = 155;
    styles[1].walk_mps = 1;
    styles[1].run_mps = 2.5F;
    styles[1].walk_spm = kFaster * 110;
    styles[1].run_spm = kFaster * 155;
    Write();
  }
  void Write() { ASSERT_TRUE(offset::Write(weights_, model_, offset::TestOffsets()).ok()); }
  // The clip styled with these arguments.
  clip::Clip Stylize(std::vector<std::string> arguments, const std::string& in) {
    arguments.insert(arguments.begin(), {STYLIZE_BINARY, "--weights", weights_, "--overwrite"});
    arguments.insert(arguments.end(), {in, out_});
    EXPECT_EQ(Run(arguments), 0) << output_;
    return clip::ReadBvh(out_).value();
  }
  // The output of stylize, which ends with `code`.
  std::string Refusal(int code, std::vector<std::string> arguments, const std::string& in) {
    arguments.insert(arguments.begin(), {STYLIZE_BINARY, "--weights", weights_, "--cadence"});
    arguments.insert(arguments.end(), {in, out_});
    EXPECT_EQ(Run(arguments), code);
    return output_;
  }

  net::Model model_ = offset::TestModel();
  const std::string weights_ = folder_ / "weights", out_ = folder_ / "out.bvh";
};

double Length_s(const clip::Clip& clip) {
  return static_cast<double>(clip.frames.size() - 1) / clip.rate_hz;
}
double Way_m(const clip::Clip& clip) {
  const rig::Vec3 way = clip.frames.back().translations[0] - clip.frames.front().translations[0];
  return std::hypot(way.x(), way.z());
}

TEST_F(StylizeCadence, TimePassesAsTheStylesStepsAndTheLengthIsSaid) {
  for (const char* const rate_hz : {"30", "20"}) {  // the slower has frames in between
    const std::string in = Walk(rate_hz, "8");
    const clip::Clip plain = Stylize({"--style", "bent"}, in);
    EXPECT_EQ(output_, "");
    const clip::Clip warped = Stylize({"--style", "bent", "--cadence"}, in);
    EXPECT_NEAR(Length_s(plain) / Length_s(warped), kFaster, 0.05) << rate_hz;
    EXPECT_EQ(warped.rate_hz, plain.rate_hz);
    char said[100];
    std::snprintf(said, sizeof(said), ": %.2f s of motion, %.2f s at the style's cadence\n",
                  Length_s(plain), Length_s(warped));
    EXPECT_EQ(output_, "stylize: " + out_ + said);
    EXPECT_NEAR(Way_m(warped), Way_m(plain), 1e-3 * Way_m(plain)) << "the floor is the performer's";
    for (std::size_t joint = 0; joint < plain.frames[0].rotations.size(); ++joint) {
      EXPECT_LT(warped.frames.back().rotations[joint].angularDistance(
                    plain.frames.back().rotations[joint]),
                1e-3F)
          << "all of the motion is there";
    }
    const clip::Clip half = Stylize({"--style", "bent=0.5", "--cadence"}, in);
    EXPECT_NEAR(Length_s(plain) / Length_s(half), std::sqrt(kFaster), 0.05) << rate_hz;
  }
}

// Steps come more often and go less far each: the speed is that of a stride in the performer's
// time.
TEST_F(StylizeCadence, WithAStrideTheSpeedIsTheStyles) {
  const std::string in = Walk("30", "8");
  const clip::Clip follow = Stylize({"--style", "bent"}, in);
  const clip::Clip stride = Stylize({"--style", "bent", "--root", "stride"}, in);
  const clip::Clip both = Stylize({"--style", "bent", "--root", "stride", "--cadence"}, in);
  const double factor = Way_m(stride) / Way_m(follow);
  EXPECT_LT(factor, 0.95) << "the control: a stride changes the speed";
  EXPECT_NEAR(Way_m(both) / Length_s(both), Way_m(stride) / Length_s(stride),
              0.02 * Way_m(stride) / Length_s(stride));
  EXPECT_NEAR(Way_m(both) / Way_m(follow), factor / kFaster, 0.03) << "the length of steps";
}

TEST_F(StylizeCadence, StandingKeepsItsTime) {
  const std::string in = folder_ / "stand.bvh";
  ASSERT_EQ(Run({STYLESIM_BINARY, "--script", "stand:60", "--write", in, "--seconds", "2"}), 0);
  const clip::Clip plain = Stylize({"--style", "bent"}, in);
  const clip::Clip warped = Stylize({"--style", "bent", "--cadence"}, in);
  ASSERT_EQ(warped.frames.size(), plain.frames.size());
  for (std::size_t i = 0; i < plain.frames.size(); ++i) {
    EXPECT_TRUE(warped.frames[i].translations[0].isApprox(plain.frames[i].translations[0], 1e-5F));
  }
}

TEST_F(StylizeCadence, IsRefusedWithoutAStyleAndWithoutCadences) {
  const std::string in = Walk();
  EXPECT_THAT(Refusal(2, {}, in), HasSubstr("--cadence: expected a style, whose steps it takes"));
  EXPECT_THAT(Refusal(2, {"--style", "raised"}, in),
              HasSubstr("--cadence: the weights have no cadence of 'raised', expected weights with "
                        "cadences (styletrain --write-speeds)"));
  EXPECT_THAT(Refusal(2, {"--style", "bent=0.5", "--mix", "raised=0.5"}, in),
              HasSubstr("no cadence of 'raised'"));
  EXPECT_THAT(Refusal(2, {"--input-style", "raised", "--style", "bent"}, in),
              HasSubstr("no cadence of 'raised'"));
  model_.styles[0].run_mps = 0;
  Write();
  EXPECT_THAT(Refusal(2, {"--style", "bent"}, in),
              HasSubstr("--cadence: the weights have no speed of 'neutral', expected weights with "
                        "speeds"));
  model_.styles[0].walk_spm = 0;
  Write();
  EXPECT_THAT(Refusal(2, {"--style", "bent"}, in),
              HasSubstr("--cadence: the weights have no cadence of 'neutral'"));
  EXPECT_FALSE(std::filesystem::exists(out_)) << "nothing is written";
}

}  // namespace
}  // namespace styled::support

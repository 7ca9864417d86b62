#include "model/train/curve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/temporary_folder.h"

namespace styled::train {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string Draw(const std::string& csv) {
  const support::TemporaryFolder folder;
  const std::string table = folder / "a.csv";
  const std::string picture = folder / "a.svg";
  std::ofstream(table) << csv;
  const Status drawn = DrawCurve(table, picture);
  EXPECT_TRUE(drawn.ok()) << drawn.message();
  std::ifstream svg(picture);
  return {std::istreambuf_iterator<char>(svg), {}};
}

TEST(Curve, HasAxesWithMinutesAndTheRangeOfTheValues) {
  const std::string svg =
      Draw("iteration,elapsed_s,score\n10,600,0.25\n20,1200,0.75\n40,2400,0.5\n");
  EXPECT_THAT(svg, HasSubstr(">score 0.500</text>"));
  for (const char* minute : {">0<", ">10<", ">20<", ">30<", ">40<"}) {
    EXPECT_THAT(svg, HasSubstr(minute));
  }
  EXPECT_THAT(svg, Not(HasSubstr(">50<")));
  EXPECT_THAT(svg, HasSubstr(">0.25<"));
  EXPECT_THAT(svg, HasSubstr(">0.75<"));
  EXPECT_THAT(svg, HasSubstr("minutes; 40.0 of them, 40 iterations"));
}

TEST(Curve, ASingleRowIsDrawn) {
  EXPECT_THAT(Draw("iteration,elapsed_s,score\n0,0,1\n"), Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace styled::train

#include "model/train/judge/strips.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "model/body/heading.h"

namespace styled::judge {
namespace {

using testing::HasSubstr;

// The points of all figures in one colour.
std::vector<std::pair<float, float>> Points(const std::string& svg, const std::string& colour) {
  std::vector<std::pair<float, float>> points;
  std::size_t at = svg.find("d=\"", svg.find(colour)) + 3;
  const std::size_t end = svg.find('"', at);
  while (at < end) {
    float x = 0;
    float y = 0;
    std::sscanf(svg.c_str() + at + 1, "%f,%f", &x, &y);
    points.emplace_back(x, y);
    at = std::min(end, svg.find_first_of("ML\"", at + 1));
  }
  return points;
}

TEST(Strips, ShowWhatWalksToTheRightFromItsRightSideOnTheGround) {
  Poses poses(5);
  for (body::Pose& pose : poses) {
    pose.rotations[body::kHips] = body::Yaw(1.2F);  // the view turns with the performer
    pose.rotations[body::kRightUpperLeg] = body::Exp(body::Vec3(-0.5F, 0, 0));  // forward
  }
  const std::string svg =
      RenderPicture({.title = "", .strips = {{"a<b", poses, 1}}, .step = 2, .figures = 12});
  const auto right = Points(svg, "#cd4632");
  const auto left = Points(svg, "#246abe");
  ASSERT_EQ(right.size(), 2U * 8U) << "frames 1 and 3 alone";
  EXPECT_GT(right[2].first, left[2].first + 20) << "the foot in front is to the right, in cm";
  EXPECT_NEAR(right[8].first - right[0].first, 110, 0.2) << "one column further";
  EXPECT_NEAR(left[3].second, 222, 0.2) << "the lowest toes are on the ground";
  EXPECT_THAT(svg, HasSubstr("a&lt;b"));
}

TEST(Strips, OutputsAreSeenAsTheirSource) {
  const Poses source(3);
  Poses output = source;
  for (body::Pose& pose : output) pose.hips_position_m.y() -= 0.1F;  // through the floor
  const auto toes = [&](const Poses& seen_as) {
    return Points(RenderPicture({.title = "", .strips = {{"", output, 0, seen_as}}}), "#246abe")[3];
  };
  EXPECT_NEAR(toes(source).second, 232, 0.2);
  EXPECT_NEAR(toes({}).second, 222, 0.2);
}

}  // namespace
}  // namespace styled::judge

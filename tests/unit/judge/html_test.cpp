#include "model/train/judge/html.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace styled::judge {
namespace {

using testing::HasSubstr;
using testing::Not;

// The value of "key" in the page's data.
std::string Text(const std::string& page, const std::string& key) {
  const auto at = page.find("\"" + key + "\":\"");
  EXPECT_NE(at, std::string::npos) << key;
  const auto begin = at + key.size() + 4;
  return page.substr(begin, page.find('"', begin) - begin);
}

std::vector<std::int16_t> Decode(const std::string& base64) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : base64) {
    if (c == '=') break;
    word = word << 6 | static_cast<std::uint32_t>(digits.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<std::uint8_t>(word >> bits & 0xFF));
  }
  std::vector<std::int16_t> out;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    out.push_back(static_cast<std::int16_t>(bytes[i] | bytes[i + 1] << 8));
  }
  return out;
}

TEST(JudgeHtml, HoldsEveryFrameInMillimetresAndNothingFromOutside) {
  Scene scene{
      .content = "walk", .style = "elderly", .input = Poses(3), .offset = {}, .styled = Poses(3)};
  scene.styled[2].hips_position_m = body::Vec3(-1.5F, 0.9F, 40.0F);  // 40 m: clamped
  const std::string page =
      RenderReport({.weights = "v0", .manifest = "set", .figures = {}, .scenes = {scene}});
  for (const char* from_outside : {"src=", "href=", "@import", "url(", "fetch(", "https:"}) {
    EXPECT_THAT(page, Not(HasSubstr(from_outside)));
  }
  EXPECT_THAT(page, Not(HasSubstr("/*DATA*/null")));
  EXPECT_EQ(Text(page, "offset"), "");
  const auto styled = Decode(Text(page, "styled"));
  ASSERT_EQ(styled.size(), 3U * 63U);
  EXPECT_EQ(styled[126], -1500);
  EXPECT_EQ(styled[127], 900);
  EXPECT_EQ(styled[128], 32767);
  body::WorldPose world;
  body::ForwardKinematics(scene.input[0], world);
  const auto input = Decode(Text(page, "input"));
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    EXPECT_NEAR(input[3 * joint + 1], 1000 * world.positions_m[joint].y(), 0.51);
  }
}

TEST(JudgeHtml, ANameCannotEndTheScript) {
  const std::string page =
      RenderReport({.weights = "</script><b>", .manifest = "set", .figures = {}, .scenes = {}});
  EXPECT_THAT(page, Not(HasSubstr("</script><b>")));
}

}  // namespace
}  // namespace styled::judge

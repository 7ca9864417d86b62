#include "clients/stylemon/canvas.h"

#include <gtest/gtest.h>

#include <limits>

namespace styled::stylemon {
namespace {

constexpr DotRect kAll{0, 0, 1000, 1000};

TEST(Canvas, ADotIsTheBrailleBitOfItsPlace) {
  constexpr std::array<std::array<const char*, 2>, 4> kGlyphs{
      {{"⠁", "⠈"}, {"⠂", "⠐"}, {"⠄", "⠠"}, {"⡀", "⢀"}}};
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 2; ++x) {
      Canvas canvas(1, 1, true);
      canvas.Line(static_cast<float>(x), static_cast<float>(y), static_cast<float>(x),
                  static_cast<float>(y), Ink::kLeft, kAll);
      EXPECT_EQ(canvas.RowText(0), kGlyphs[y][x]);
      EXPECT_EQ(canvas.At(0, 0).ink, Ink::kLeft);
    }
  }
}

TEST(Canvas, LinesOfEveryDirectionAreWhole) {
  Canvas canvas(4, 2, true);
  canvas.Line(0, 0, 7, 0, Ink::kPlain, kAll);
  canvas.Line(0, 7, 0, 0, Ink::kPlain, kAll);
  EXPECT_EQ(canvas.RowText(0), "⡏⠉⠉⠉");
  EXPECT_EQ(canvas.RowText(1), "⡇");
  Canvas diagonal(2, 1, true);
  diagonal.Line(3, 3, 0, 0, Ink::kPlain, kAll);
  EXPECT_EQ(diagonal.RowText(0), "⠑⢄");
}

TEST(Canvas, WithoutUtf8StrokesFollowTheSlope) {
  const auto draw = [](float x0, float y0, float x1, float y1) {
    Canvas canvas(3, 2, false);
    canvas.Line(x0, y0, x1, y1, Ink::kPlain, kAll);
    return canvas.RowText(0) + "\n" + canvas.RowText(1);
  };
  EXPECT_EQ(draw(0, 1, 5, 1), "---\n");
  EXPECT_EQ(draw(2, 0, 2, 7), " |\n |");
  EXPECT_EQ(draw(0, 2, 4, 6), "\\\n \\\\") << "one stroke per column";
  EXPECT_EQ(draw(4, 2, 0, 6), "  /\n//");
}

TEST(Canvas, NothingIsDrawnOutsideTheClipOrTheCanvas) {
  Canvas canvas(4, 2, true);
  canvas.Line(-50, -50, 50, 50, Ink::kPlain, {2, 0, 2, 8});
  EXPECT_EQ(canvas.At(0, 0).glyph, U' ');
  EXPECT_EQ(canvas.RowText(0), " ⢄");
  canvas.Line(1e30F, 3, -1e30F, 3, Ink::kPlain, kAll);  // must end, and soon
  const float nan = std::numeric_limits<float>::quiet_NaN();
  canvas.Line(nan, 0, 3, 3, Ink::kPlain, kAll);
  canvas.Line(0, 0, std::numeric_limits<float>::infinity(), 3, Ink::kPlain, kAll);
  canvas.Circle(nan, 0, 3, Ink::kPlain, kAll);
  canvas.Circle(0, 0, 1e9F, Ink::kPlain, kAll);
  Canvas none(-3, 0, true);
  none.Line(0, 0, 5, 5, Ink::kPlain, kAll);
  none.Text(0, 0, "x");
}

TEST(Canvas, TextIsClippedAndWinsOverLines) {
  Canvas canvas(5, 1, true);
  canvas.Text(3, 0, "abc");
  canvas.Text(-1, 0, "xé");
  canvas.Line(0, 0, 9, 0, Ink::kPlain, kAll);
  EXPECT_EQ(canvas.RowText(0), "é⠉⠉ab");
  canvas.Text(0, 0, "12345", Ink::kPlain, 2);
  EXPECT_EQ(canvas.RowText(0), "12⠉ab");
  canvas.Text(0, 7, "below");
}

TEST(Canvas, HostileTextCannotSteerTheTerminal) {
  Canvas canvas(8, 1, true);
  canvas.Text(0, 0, "a\x1b[2J\xff\xe2\x82");
  EXPECT_EQ(canvas.RowText(0), "a [2J���");
  Canvas ascii(3, 1, false);
  ascii.Text(0, 0, "aé▸");
  EXPECT_EQ(ascii.RowText(0), "a??");
}

TEST(Canvas, Utf8RoundTrip) {
  for (const char32_t glyph : {U'a', U'é', U'⣿', U'\U0001F600'}) {
    EXPECT_EQ(Width(Utf8(glyph)), 1);
    Canvas canvas(1, 1, true);
    canvas.Text(0, 0, Utf8(glyph));
    EXPECT_EQ(canvas.At(0, 0).glyph, glyph);
  }
}

}  // namespace
}  // namespace styled::stylemon

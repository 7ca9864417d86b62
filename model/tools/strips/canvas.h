#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "model/base/status.h"

namespace styled::strips {

struct Color {
  std::uint8_t red = 0, green = 0, blue = 0;
};

// A white picture for drawing strips. Units are pixels, origin top left, y down; drawing outside is
// clipped.
class Canvas {
 public:
  Canvas(int width, int height);

  // A line with round ends, anti-aliased.
  void Line(float x0, float y0, float x1, float y1, float width, Color color);
  // Lower-case letters, digits, '-', '.' and spaces, `scale` pixels per dot, 7 dots high; other
  // characters are left blank. (x, y) is the top left corner.
  void Text(float x, float y, std::string_view text, int scale, Color color);

  Status WritePng(const std::filesystem::path& file) const;
  // Row by row from the top, red, green, blue.
  const std::vector<std::uint8_t>& pixels() const { return pixels_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  void Blend(int x, int y, float share, Color color);

  int width_, height_;
  std::vector<std::uint8_t> pixels_;  // RGB
};

}  // namespace styled::strips

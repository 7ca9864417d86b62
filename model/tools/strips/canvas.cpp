#include "model/tools/strips/canvas.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace styled::strips {
namespace {

// Five columns of seven dots; the lowest bit is the top dot.
using Glyph = std::array<std::uint8_t, 5>;
constexpr std::array<Glyph, 26> kLetters = {{
    {0x20, 0x54, 0x54, 0x54, 0x78}, {0x7F, 0x48, 0x44, 0x44, 0x38}, {0x38, 0x44, 0x44, 0x44, 0x20},
    {0x38, 0x44, 0x44, 0x48, 0x7F}, {0x38, 0x54, 0x54, 0x54, 0x18}, {0x08, 0x7E, 0x09, 0x01, 0x02},
    {0x0C, 0x52, 0x52, 0x52, 0x3E}, {0x7F, 0x08, 0x04, 0x04, 0x78}, {0x00, 0x44, 0x7D, 0x40, 0x00},
    {0x20, 0x40, 0x44, 0x3D, 0x00}, {0x7F, 0x10, 0x28, 0x44, 0x00}, {0x00, 0x41, 0x7F, 0x40, 0x00},
    {0x7C, 0x04, 0x18, 0x04, 0x78}, {0x7C, 0x08, 0x04, 0x04, 0x78}, {0x38, 0x44, 0x44, 0x44, 0x38},
    {0x7C, 0x14, 0x14, 0x14, 0x08}, {0x08, 0x14, 0x14, 0x18, 0x7C}, {0x7C, 0x08, 0x04, 0x04, 0x08},
    {0x48, 0x54, 0x54, 0x54, 0x20}, {0x04, 0x3F, 0x44, 0x40, 0x20}, {0x3C, 0x40, 0x40, 0x20, 0x7C},
    {0x1C, 0x20, 0x40, 0x20, 0x1C}, {0x3C, 0x40, 0x30, 0x40, 0x3C}, {0x44, 0x28, 0x10, 0x28, 0x44},
    {0x0C, 0x50, 0x50, 0x50, 0x3C}, {0x44, 0x64, 0x54, 0x4C, 0x44},
}};
constexpr std::array<Glyph, 10> kDigits = {{
    {0x3E, 0x51, 0x49, 0x45, 0x3E},
    {0x00, 0x42, 0x7F, 0x40, 0x00},
    {0x42, 0x61, 0x51, 0x49, 0x46},
    {0x21, 0x41, 0x45, 0x4B, 0x31},
    {0x18, 0x14, 0x12, 0x7F, 0x10},
    {0x27, 0x45, 0x45, 0x45, 0x39},
    {0x3C, 0x4A, 0x49, 0x49, 0x30},
    {0x01, 0x71, 0x09, 0x05, 0x03},
    {0x36, 0x49, 0x49, 0x49, 0x36},
    {0x06, 0x49, 0x49, 0x29, 0x1E},
}};

Glyph GlyphOf(char c) {
  if (c >= 'a' && c <= 'z') return kLetters[c - 'a'];
  if (c >= '0' && c <= '9') return kDigits[c - '0'];
  if (c == '-') return {0x08, 0x08, 0x08, 0x08, 0x08};
  if (c == '.') return {0x00, 0x60, 0x60, 0x00, 0x00};
  return {};
}

}  // namespace

Canvas::Canvas(int width, int height)
    : width_(width),
      height_(height),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 255) {}

void Canvas::Blend(int x, int y, float share, Color color) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  std::uint8_t* pixel =
      &pixels_[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + x) * 3];
  const auto mix = [share](std::uint8_t& to, std::uint8_t from) {
    to = static_cast<std::uint8_t>(std::lround(to + share * (from - to)));
  };
  mix(pixel[0], color.red);
  mix(pixel[1], color.green);
  mix(pixel[2], color.blue);
}

void Canvas::Line(float x0, float y0, float x1, float y1, float width, Color color) {
  const float reach = 0.5F * width + 1;
  const int left = static_cast<int>(std::floor(std::min(x0, x1) - reach));
  const int right = static_cast<int>(std::ceil(std::max(x0, x1) + reach));
  const int top = static_cast<int>(std::floor(std::min(y0, y1) - reach));
  const int bottom = static_cast<int>(std::ceil(std::max(y0, y1) + reach));
  const float dx = x1 - x0;
  const float dy = y1 - y0;
  const float length2 = std::max(1e-6F, dx * dx + dy * dy);
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const float px = static_cast<float>(x) + 0.5F - x0;
      const float py = static_cast<float>(y) + 0.5F - y0;
      const float along = std::clamp((px * dx + py * dy) / length2, 0.0F, 1.0F);
      // The distance to the segment gives the pixel's coverage, with an edge of one pixel.
      const float distance = std::hypot(px - along * dx, py - along * dy);
      const float share = std::clamp(0.5F * width - distance + 0.5F, 0.0F, 1.0F);
      if (share > 0) Blend(x, y, share, color);
    }
  }
}

void Canvas::Text(float x, float y, std::string_view text, int scale, Color color) {
  int left = static_cast<int>(x);
  for (const char c : text) {
    const Glyph glyph = GlyphOf(c);
    for (int column = 0; column < 5 * scale; ++column) {
      for (int row = 0; row < 7 * scale; ++row) {
        if ((glyph[column / scale] >> (row / scale)) & 1) {
          Blend(left + column, static_cast<int>(y) + row, 1, color);
        }
      }
    }
    left += 6 * scale;
  }
}

Status Canvas::WritePng(const std::filesystem::path& file) const {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_);
  image.height = static_cast<png_uint_32>(height_);
  image.format = PNG_FORMAT_RGB;
  if (png_image_write_to_file(&image, file.c_str(), 0, pixels_.data(), 0, nullptr) == 0) {
    return Status::Error(file.string() + ": " + image.message);
  }
  return Status::Ok();
}

}  // namespace styled::strips

#include "clients/stylemon/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace styled::stylemon {
namespace {

// Braille bits by dot column and row (Unicode 2800 block).
constexpr std::array<std::array<std::uint8_t, 4>, 2> kBraille{
    {{0x01, 0x02, 0x04, 0x40}, {0x08, 0x10, 0x20, 0x80}}};

// The character whose stroke is nearest to the direction (dx, dy), in dots (dots are square).
char Stroke(float dx, float dy) {
  const float flat = std::abs(dx), steep = std::abs(dy);
  if (flat > 2.0F * steep) return '-';
  if (steep > 2.0F * flat) return '|';
  return (dx > 0) == (dy > 0) ? '\\' : '/';
}

// Reads one code point and advances. Invalid UTF-8 yields U+FFFD and consumes one byte.
char32_t Next(std::string_view text, std::size_t& at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(at);
  const int more = first < 0x80    ? 0
                   : first >= 0xF0 ? 3
                   : first >= 0xE0 ? 2
                   : first >= 0xC0 ? 1
                                   : -1;
  if (more < 0 || at + static_cast<std::size_t>(more) >= text.size()) return ++at, U'\uFFFD';
  char32_t glyph = more == 0 ? first : first & (0x3FU >> static_cast<unsigned>(more));
  for (int i = 1; i <= more; ++i) {
    const unsigned next = byte(at + static_cast<std::size_t>(i));
    if ((next & 0xC0U) != 0x80U) return ++at, U'\uFFFD';
    glyph = (glyph << 6U) | (next & 0x3FU);
  }
  at += static_cast<std::size_t>(more) + 1;
  return glyph;
}

// Clips the parameter interval of a line at one border (Liang and Barsky).
bool Cut(float p, float q, float& begin, float& end) {
  if (p == 0) return q >= 0;
  const float t = q / p;
  if (p < 0) begin = std::max(begin, t);
  if (p > 0) end = std::min(end, t);
  return begin <= end;
}

}  // namespace

Canvas::Canvas(int columns, int rows, bool utf8)
    : columns_(std::max(columns, 0)),
      rows_(std::max(rows, 0)),
      utf8_(utf8),
      spots_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

void Canvas::Text(int column, int row, std::string_view text, Ink ink, int width) {
  if (row < 0 || row >= rows_) return;
  const int end = width < 0 ? columns_ : std::min(columns_, column + width);
  for (std::size_t at = 0; at < text.size() && column < end; ++column) {
    char32_t glyph = Next(text, at);
    // Names come from the network: no control characters.
    if (glyph < 32 || glyph == 127) glyph = U' ';
    if (!utf8_ && glyph > 126) glyph = U'?';
    if (column < 0) continue;
    Spot& spot = spots_[Index(column, row)];
    spot.text = glyph;
    spot.ink = ink;
  }
}

void Canvas::Dot(int x, int y, char stroke, Ink ink, const DotRect& clip) {
  if (x < clip.left || y < clip.top || x >= clip.left + clip.width || y >= clip.top + clip.height) {
    return;
  }
  if (x < 0 || y < 0 || x >= 2 * columns_ || y >= 4 * rows_) return;
  Spot& spot = spots_[Index(x / 2, y / 4)];
  if (spot.text != 0) return;
  spot.dots |= kBraille[static_cast<std::size_t>(x % 2)][static_cast<std::size_t>(y % 4)];
  spot.stroke = stroke;
  spot.ink = ink;
}

void Canvas::Line(float x0, float y0, float x1, float y1, Ink ink, const DotRect& clip) {
  const float dx = x1 - x0, dy = y1 - y0;
  if (!std::isfinite(dx) || !std::isfinite(dy) || !std::isfinite(x0) || !std::isfinite(y0)) return;
  const auto left = static_cast<float>(clip.left - 1), top = static_cast<float>(clip.top - 1);
  const auto right = static_cast<float>(clip.left + clip.width);
  const auto bottom = static_cast<float>(clip.top + clip.height);
  float begin = 0, end = 1;
  if (!Cut(-dx, x0 - left, begin, end) || !Cut(dx, right - x0, begin, end) ||
      !Cut(-dy, y0 - top, begin, end) || !Cut(dy, bottom - y0, begin, end)) {
    return;
  }
  // Without braille, one character per row or column is enough: more would look like two lines.
  const float cell_x = utf8_ ? 1 : 2, cell_y = utf8_ ? 1 : 4;
  const float length = std::max(std::abs(dx) / cell_x, std::abs(dy) / cell_y) * (end - begin);
  const int steps = std::max(1, static_cast<int>(std::ceil(length)));
  const char stroke = std::abs(dx) + std::abs(dy) < 1 ? '*' : Stroke(dx, dy);
  for (int step = 0; step <= steps; ++step) {
    const float share =
        begin + (end - begin) * static_cast<float>(step) / static_cast<float>(steps);
    Dot(static_cast<int>(std::floor(x0 + share * dx + 0.5F)),
        static_cast<int>(std::floor(y0 + share * dy + 0.5F)), stroke, ink, clip);
  }
}

void Canvas::Circle(float x, float y, float radius, Ink ink, const DotRect& clip) {
  if (!std::isfinite(x + y + radius) || radius < 0) return;
  if (!utf8_) {  // cells are too coarse for a circle
    Dot(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)), 'O', ink, clip);
    return;
  }
  const int steps = std::clamp(static_cast<int>(radius * 8), 8, 720);
  for (int step = 0; step < steps; ++step) {
    const float angle =
        2.0F * std::numbers::pi_v<float> * static_cast<float>(step) / static_cast<float>(steps);
    Dot(static_cast<int>(std::lround(x + radius * std::cos(angle))),
        static_cast<int>(std::lround(y + radius * std::sin(angle))), 'O', ink, clip);
  }
}

Cell Canvas::At(int column, int row) const {
  const Spot& spot = spots_[Index(column, row)];
  if (spot.text != 0) return {spot.text, spot.ink};
  if (spot.dots == 0) return {U' ', Ink::kPlain};
  const auto braille = static_cast<char32_t>(0x2800U + spot.dots);
  return {utf8_ ? braille : static_cast<char32_t>(spot.stroke), spot.ink};
}

std::string Canvas::RowText(int row) const {
  std::string out;
  for (int column = 0; column < columns_; ++column) out += Utf8(At(column, row).glyph);
  out.erase(out.find_last_not_of(' ') + 1);
  return out;
}

std::string Utf8(char32_t glyph) {
  const auto byte = [](unsigned value) { return static_cast<char>(value); };
  const auto code = static_cast<unsigned>(glyph);
  if (code < 0x80) return {byte(code)};
  if (code < 0x800) return {byte(0xC0U | (code >> 6U)), byte(0x80U | (code & 0x3FU))};
  if (code < 0x10000) {
    return {byte(0xE0U | (code >> 12U)), byte(0x80U | ((code >> 6U) & 0x3FU)),
            byte(0x80U | (code & 0x3FU))};
  }
  return {byte(0xF0U | (code >> 18U)), byte(0x80U | ((code >> 12U) & 0x3FU)),
          byte(0x80U | ((code >> 6U) & 0x3FU)), byte(0x80U | (code & 0x3FU))};
}

int Width(std::string_view text) {
  int width = 0;
  for (std::size_t at = 0; at < text.size(); ++width) Next(text, at);
  return width;
}

}  // namespace styled::stylemon

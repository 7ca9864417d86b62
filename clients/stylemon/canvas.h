#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace styled::stylemon {

// The meaning of a cell; the terminal maps it to a colour.
enum class Ink : std::uint8_t {
  kPlain,
  kDim,
  kTitle,
  kCentre,  // spine and head
  kLeft,    // the body's left limbs
  kRight,   // the body's right limbs
  kFloor,
  kContact,  // a planted foot
  kGood,
  kWarn,
  kBad,
  kInkCount
};

struct Cell {
  char32_t glyph = U' ';
  Ink ink = Ink::kPlain;
};

// A rectangle in dots. Each cell is two dots wide and four high, so that dots are about square. (0,
// 0) is the upper left corner, y grows downwards.
struct DotRect {
  int left = 0, top = 0, width = 0, height = 0;
};

// A picture of character cells with text and lines. Lines are drawn in braille dots, or in ASCII
// strokes if the terminal does not support UTF-8. Everything outside is clipped. One thread;
// allocates at construction. Pinned by tests/unit/clients/canvas_test.cpp.
class Canvas {
 public:
  // Negative sizes count as 0.
  Canvas(int columns, int rows, bool utf8);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  bool utf8() const { return utf8_; }

  // Writes UTF-8 `text` from (column, row), one cell per code point, at most `width` cells
  // (negative: up to the edge). Without UTF-8, non-ASCII characters become '?'.
  void Text(int column, int row, std::string_view text, Ink ink = Ink::kPlain, int width = -1);

  // A line between two dots, both ends included, clipped to `clip`. In a cell, the last ink wins,
  // and text covers lines. A line with a non-finite end is not drawn.
  void Line(float x0, float y0, float x1, float y1, Ink ink, const DotRect& clip);
  void Circle(float x, float y, float radius, Ink ink, const DotRect& clip);

  // The content of a cell, which must be inside the canvas.
  Cell At(int column, int row) const;
  // One row as UTF-8, without trailing blanks.
  std::string RowText(int row) const;

 private:
  struct Spot {
    char32_t text = 0;      // 0: none
    std::uint8_t dots = 0;  // braille bits
    char stroke = ' ';      // the same for terminals without UTF-8
    Ink ink = Ink::kPlain;
  };
  // Index into spots_ of a cell, which must be inside the canvas.
  std::size_t Index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  void Dot(int x, int y, char stroke, Ink ink, const DotRect& clip);

  int columns_, rows_;
  bool utf8_;
  std::vector<Spot> spots_;
};

// The UTF-8 encoding of one code point, and the number of code points in `text`.
std::string Utf8(char32_t glyph);
int Width(std::string_view text);

}  // namespace styled::stylemon

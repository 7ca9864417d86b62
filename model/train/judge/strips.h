#pragma once

#include <string>
#include <vector>

#include "model/train/judge/stream.h"

namespace styled::judge {

// A row of stick figures. Poses are at one rate, metres.
struct Strip {
  std::string caption;
  Poses poses;
  std::size_t first = 0;  // frame of the first figure
  // Figures are seen as the source's at the same frames would be: its heading, its floor. Empty: as
  // the clip's own.
  Poses source = {};
};
struct Picture {
  std::string title;
  std::vector<Strip> strips;
  std::size_t step = 4;  // frames between figures
  int figures = 12;      // of each strip, fewer where the clip ends
};

// One self-contained SVG element: a strip per row with its caption above, the ground as a line, the
// performer seen from the right, turned a little to the front. Left limbs blue, right ones red.
std::string RenderPicture(const Picture& picture);

}  // namespace styled::judge

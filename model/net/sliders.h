#pragma once

#include <string>
#include <vector>

// A style by hand: a number per aspect of a posture or a gait (StyleSpace::Design).
namespace styled::net {

struct Slider {
  const char* name;   // as users type it: "stoop"
  const char* title;  // as a page shows it: "Stoop"
  const char* group;  // "Posture", "Arms", "Legs", "Walk", "Character"
  const char* unit;   // "degrees", "s", "" for a factor
  float least, most, usual;
  const char* what;  // one sentence
};

struct SliderValue {
  std::string name;
  float value = 0;
};
using SliderValues = std::vector<SliderValue>;

// A design to begin with.
struct Preset {
  const char* name;
  SliderValues values;
};

}  // namespace styled::net

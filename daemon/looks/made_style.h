#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "model/net/style_space.h"

namespace styled::pipeline {

// The daemon's data about a style that was made from an example or imported, besides its place in
// the network. Immutable once it is in a configuration.
struct MadeStyle {
  std::string name;
  net::StyleCode code;
  std::string source;         // the file or performer that it came from; "" if unknown
  float seconds = 0;          // length of the example; 0: none
  std::string nearest;        // the nearest style of the weights
  float distance = 0;         // distance to `nearest`, as in LikeReply
  std::string example;        // hash of the example that the library keeps (library.h); "": none
  std::string licence;        // of the weights that it was made with; "" if it owes them nothing
  net::SliderValues sliders;  // that are not at their usual value (net::StyleSpace::SlidersOf)
  // HashOf the text of its file in the library; 0: none. A file with the same hash is not read
  // again.
  std::uint64_t file_hash = 0;
};

using MadeStyles = std::map<std::string, std::shared_ptr<const MadeStyle>, std::less<>>;

}  // namespace styled::pipeline

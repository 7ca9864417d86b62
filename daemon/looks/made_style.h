#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "model/net/style_space.h"

namespace styled::pipeline {

// A style that was made of an example, or imported: what the daemon knows of it beside its place in
// the network. Immutable once it is in a configuration.
struct MadeStyle {
  std::string name;
  net::StyleCode code;
  std::string source;   // the file or performer it came from; "" unknown
  float seconds = 0;    // of the example; 0: none
  std::string nearest;  // of the weights' styles
  float distance = 0;   // to it, as in LikeReply
  std::string example;  // hash of the example that the library keeps (library.h); "" none
  std::string licence;  // of the weights that it was made with
  // HashOf the text of its file in the library; 0: none. A file that is still the same is not read
  // anew.
  std::uint64_t file_hash = 0;
};

using MadeStyles = std::map<std::string, std::shared_ptr<const MadeStyle>, std::less<>>;

}  // namespace styled::pipeline

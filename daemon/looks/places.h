#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "daemon/looks/made_style.h"
#include "model/net/styles.h"

namespace styled::pipeline {

// Places of retired styles beyond net::kMaxAdded, in which they fade out.
inline constexpr int kSpare = 64;
inline constexpr std::size_t kMostPlaces = std::size_t{net::kMaxAdded} + std::size_t{kSpare};

// The list of added styles, in the order of their places after the styles of the weights.
struct Places {
  struct Entry {
    std::string name;
    bool retired = false;  // the style was removed, or has another place now
    friend bool operator==(const Entry&, const Entry&) = default;
  };
  std::vector<Entry> entries;
  int last = 0;  // RuntimeConfig::last_place
  // By index of `entries`: the former codes of retired styles that performers still fade out from.
  std::map<std::size_t, std::shared_ptr<const MadeStyle>> fading;
};

}  // namespace styled::pipeline

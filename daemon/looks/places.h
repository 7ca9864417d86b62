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

// The list of styles behind those of the weights.
struct Places {
  struct Entry {
    std::string name;
    bool retired = false;  // the style was removed, or has another place by now
    friend bool operator==(const Entry&, const Entry&) = default;
  };
  std::vector<Entry> entries;
  int last = 0;  // RuntimeConfig::last_place
  // By index of `entries`, what retired ones were from which performers still fade out.
  std::map<std::size_t, std::shared_ptr<const MadeStyle>> fading;
};

}  // namespace styled::pipeline

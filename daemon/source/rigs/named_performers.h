#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/source/performer_stream.h"

namespace styled::source {

// For rigs whose server lists its skeletons by name. Adds a performer named after a skeleton to
// `performers`: the performer of that name from `before`, which becomes null there, so that its
// stream continues; otherwise a new one. A name that `performers` already has gets a number:
// "anna-2". Either vector may hold nulls. A Performer is constructed from its name and has
// `stream`, a PerformerStream. Allocates. Pinned by the translators' tests, tests/unit/natnet and
// tests/unit/qtm.
template <typename Performer>
Performer& AdoptNamed(std::string_view skeleton, std::vector<std::unique_ptr<Performer>>& before,
                      std::vector<std::unique_ptr<Performer>>& performers) {
  const auto called = [](const std::string& name) {
    return [&name](const auto& performer) {
      return performer != nullptr && performer->stream.performer() == name;
    };
  };
  constexpr std::size_t kStem = 29;  // of a name's 32 bytes; the others are for the number
  std::string name = MakeName(skeleton);
  const std::string stem = name.substr(0, kStem);
  for (int i = 2; std::ranges::any_of(performers, called(name)); ++i) {
    name = stem + "-" + std::to_string(i);
  }
  const auto known = std::ranges::find_if(before, called(name));
  performers.push_back(known != before.end() ? std::move(*known)
                                             : std::make_unique<Performer>(name));
  return *performers.back();
}

}  // namespace styled::source

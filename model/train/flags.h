#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "model/base/status.h"

// The flags of a network family as rows, one for each member of its Config: styletrain makes its
// options of them (model/tools/train_family.h), and CheckRanges refuses what is out of range.
namespace styled::train {

enum class Range { kAny, kAtLeast0, kAtLeast1, k0To1 };

struct Flag {
  const char* name;  // "--rate"
  std::variant<double*, int*, bool*, std::string*, std::filesystem::path*,
               std::vector<std::string>*>
      value;            // where it is kept; what is there is the default
  Range range;          // of a number
  const char* meaning;  // as --help says it
  std::vector<std::string> choices = {};
};
// Of --help.
struct FlagGroup {
  const char* name;
  std::vector<Flag> flags;
};

// Numbers must be finite and in their ranges. The error names the flag, what was found and what was
// expected.
Status CheckRanges(const std::vector<FlagGroup>& groups);

// "FLAG: found NUMBER, expected WHAT".
Status RefuseNumber(const std::string& flag, double found, const std::string& expected);

}  // namespace styled::train

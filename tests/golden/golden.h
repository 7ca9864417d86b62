#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "tests/golden/replay.h"

namespace styled::golden {

// A line of recordings.txt.
struct Entry {
  std::string name;
  std::string type;     // of source "suit"
  std::string as;       // the stand-in, as of stylesim --as
  double rate_hz = 60;  // and what else stylesim is told:
  double seconds = 2;
  std::string quirks, faults;
  int performers = 1;
};
inline void PrintTo(const Entry& entry, std::ostream* out) { *out << entry.name; }
std::vector<Entry> ReadList(const std::string& file);

// What stylesim is told to do in all of them (record.sh).
inline constexpr const char* kScript = "walk:1,wave-left:1,turn-left:1,run:2";

// What is kept of what a recording gives: every 10th frame of each topic and its last one, the
// bodies, and the counters as lines of a note.
Status WriteExpected(const Played& played, const std::string& file);
Result<Played> ReadExpected(const std::string& file);

}  // namespace styled::golden

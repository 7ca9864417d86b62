#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "tests/golden/replay.h"

namespace styled::golden {

// A line of recordings.txt.
struct Entry {
  std::string name;
  std::string type;     // the type of source "suit"
  std::string as;       // the stand-in, as in stylesim --as
  double rate_hz = 60;  // and other options of stylesim:
  double seconds = 2;
  std::string quirks, faults;
  int performers = 1;
};
inline void PrintTo(const Entry& entry, std::ostream* out) { *out << entry.name; }
std::vector<Entry> ReadList(const std::string& file);

// stylesim's script in all recordings (record.sh).
inline constexpr const char* kScript = "walk:1,wave-left:1,turn-left:1,run:2";

// Keeps a part of a replay's output: every 10th frame of each topic and its last one, the bodies,
// and the counters as lines of a note.
Status WriteExpected(const Played& played, const std::string& file);
Result<Played> ReadExpected(const std::string& file);

}  // namespace styled::golden

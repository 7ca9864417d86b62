#pragma once

#include <string>
#include <vector>

namespace styled::faults {

// How hard: 1 is what the goals ask for; CI takes less.
struct Effort {
  double share = 1;
  int Times(int count) const { return count * share < 1 ? 1 : static_cast<int>(count * share); }
  double Seconds(double seconds) const { return seconds * share < 2 ? 2 : seconds * share; }
};

struct Outcome {
  bool right = false;    // what happened is what ought to
  bool in_time = false;  // and when it ought to
  std::string measured;
};
inline Outcome Failed(std::string why) { return {false, false, std::move(why)}; }

struct Fault {
  std::string name, what, goal;
  Outcome (*run)(const Effort&);
};

// The faults: in the process, in its peers, and in its input.
std::vector<Fault> ProcessFaults();
std::vector<Fault> PeerFaults();
std::vector<Fault> InputFaults();

std::string Format(const char* format, ...) __attribute__((format(printf, 1, 2)));

}  // namespace styled::faults

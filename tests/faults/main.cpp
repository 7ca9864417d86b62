// styled_faults_run: exposes the real daemon to the faults of a week beside a show, and prints each
// result beside its goal. Exits with 1 where a goal was not reached.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <iostream>

#include "tests/faults/faults.h"

namespace styled::faults {

std::string Format(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

}  // namespace styled::faults

int main(int argc, char** argv) {
  using namespace styled::faults;
  std::vector<Fault> faults;
  for (const auto& some : {ProcessFaults(), PeerFaults(), InputFaults()}) {
    faults.insert(faults.end(), some.begin(), some.end());
  }
  std::vector<std::string> names;
  Effort effort;
  bool list = false, any_time = false;
  CLI::App app{"What the daemon does when things go wrong, beside what it ought to do"};
  app.add_option("name", names, "which; all where none is named");
  app.add_option("--effort", effort.share, "share of the goals' counts and times")
      ->check(CLI::Range(0.001, 100.0));
  app.add_flag("--any-time", any_time, "judge what happens, not when: for a busy machine");
  app.add_flag("--list", list, "only name them");
  CLI11_PARSE(app, argc, argv);
  bool all_reached = true;
  for (const std::string& name : names) {
    if (std::ranges::find(faults, name, &Fault::name) != faults.end()) continue;
    std::cerr << "no fault \"" << name << "\"; --list names them\n";
    return 2;
  }
  for (const Fault& fault : faults) {
    if (!names.empty() && std::ranges::find(names, fault.name) == names.end()) continue;
    std::cout << fault.name << ": " << fault.what << "\n  goal: " << fault.goal << std::endl;
    if (list) continue;
    const Outcome outcome = fault.run(effort);
    const bool reached = outcome.right && (outcome.in_time || any_time);
    std::cout << "  " << (reached ? "reached: " : "NOT REACHED: ") << outcome.measured << std::endl;
    all_reached = all_reached && reached;
  }
  return all_reached ? 0 : 1;
}

#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace styled::stylectl {

enum ExitCode : int {
  kExitOk = 0,
  kExitRefused = 1,   // the daemon refused; the reason and what was expected go to `err`
  kExitUsage = 2,     // the command line is invalid
  kExitNoDaemon = 3,  // no reply in time
};

// Runs stylectl inside the calling process; `arguments` are those after argv[0]. Results go to
// `out` (one JSON object with --json, also on failure), errors and notes to `err`. Blocks for at
// most three times the timeout of a call; `status --watch` blocks until the process is killed or
// `out` fails. Without an endpoint in `arguments`, STYLED_CONTROL of the environment is used.
// Pinned by tests/unit/clients/stylectl_test.cpp.
int Run(std::vector<std::string> arguments, std::ostream& out, std::ostream& err);

}  // namespace styled::stylectl

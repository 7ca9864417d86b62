#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace styled::stylectl {

enum ExitCode : int {
  kExitOk = 0,
  kExitRefused = 1,   // the daemon said no; reason and what was expected on `err`
  kExitUsage = 2,     // the command line makes no sense
  kExitNoDaemon = 3,  // nobody answered in time
};

// stylectl without its process: `arguments` as after argv[0]. What a command yields goes to `out`
// (one JSON object with --json, on failures too), errors and notes to `err`. Blocks for at most
// three calls' timeout; `status --watch` until it is killed or `out` fails. STYLED_CONTROL in the
// environment is the endpoint where none is given. Pinned by tests/unit/clients/stylectl_test.cpp.
int Run(std::vector<std::string> arguments, std::ostream& out, std::ostream& err);

}  // namespace styled::stylectl

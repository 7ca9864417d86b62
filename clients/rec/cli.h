#pragma once

#include <atomic>
#include <ostream>
#include <string>
#include <vector>

namespace styled::rec {

enum ExitCode : int {
  kExitOk = 0,      // an error of a file, an address or a daemon; the reason on `err`
  kExitFailed = 1,  // the command line is invalid
  kExitUsage = 2,   // the command line is invalid
};

// Runs stylerec inside the calling process; `arguments` are those after argv[0]. Returns when the
// command is done or `stop` is set, with a summary line on `out`. Errors and bound addresses go to
// `err`. Pinned by tests/unit/rec and tests/e2e/recordings.
int Run(std::vector<std::string> arguments, const std::atomic<bool>& stop, std::ostream& out,
        std::ostream& err);

}  // namespace styled::rec

#pragma once

#include <atomic>
#include <ostream>
#include <string>
#include <vector>

namespace styled::rec {

enum ExitCode : int {
  kExitOk = 0,
  kExitFailed = 1,  // a file, an address, a daemon; the reason on `err`
  kExitUsage = 2,   // the command line makes no sense
};

// stylerec without its process: `arguments` as after argv[0]. Ends when the command is done or
// `stop` is set, with a summary line on `out`; errors, and the addresses that were bound, go to
// `err`. Pinned by tests/unit/rec and tests/e2e/recordings.
int Run(std::vector<std::string> arguments, const std::atomic<bool>& stop, std::ostream& out,
        std::ostream& err);

}  // namespace styled::rec
